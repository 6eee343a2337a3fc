// Writes the frames of a run to its results file in a background thread.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/results/results_lock.h"
#include "experiments/storage/hdf5_file.h"
#include "firn/math.h"

namespace firn {

// A dataset with one row per frame.
struct Column {
  std::string path;
  std::string unit;
  hdf5::Shape row;  // shape of a row; empty: a scalar
};

// Restores the file from the copy of its last checkpoint. Returns false without a complete copy.
// Throws WriteError.
bool recover_results(const ResultsLock& lock);

// Renames an existing results file, RUN.h5 to RUN.1.h5 (.2, ...), and returns its new name; empty
// without such a file. For a killed run, the copy of its last checkpoint is renamed. Throws
// InputError when `file` is not HDF5 (an empty file is replaced) or is being written by a run.
std::string rename_earlier_results(const std::string& file);

// The only writer of a results file; the constructor of a second one throws InputError. A failed
// write (disk full) throws WriteError in this or in the next call.
class Recorder {
 public:
  using Lock = std::shared_ptr<const ResultsLock>;
  // Creates a file.
  static Recorder create(const Lock& lock, const std::vector<Column>& columns);
  static Recorder create(const std::string& file, const std::vector<Column>& columns);
  // Opens an existing file to append.
  static Recorder reopen(const Lock& lock, const std::vector<Column>& columns);
  static Recorder reopen(const std::string& file, const std::vector<Column>& columns);
  ~Recorder();
  Recorder(Recorder&&) noexcept;

  // Queues one frame: the concatenated rows of all columns. The background thread writes it. Blocks
  // only while the queue is full.
  void push(std::vector<double> frame);

  // Writes all queued frames, then calls `use` with the file, e.g. for a checkpoint.
  void with_file(const std::function<void(hdf5::File&)>& use);

  const ResultsLock& lock() const;

  // Truncates all columns to their first `frames` rows and flushes. Throws RunError when a column
  // has fewer rows, and WriteError.
  void truncate(std::size_t frames);

  // Writes all queued frames and closes the file.
  void close();

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
