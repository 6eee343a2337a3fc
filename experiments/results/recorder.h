// Streams the frames of a run into its results file from a background thread.
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

// A dataset with one row a frame.
struct Column {
  std::string path;
  std::string unit;
  hdf5::Shape row;  // empty: one value
};

// Restores the file from the copy that a killed run left. Returns false without a complete copy.
// Throws WriteError.
bool recover_results(const ResultsLock& lock);

// Moves an earlier results file out of the way, RUN.h5 to RUN.1.h5 (.2, ...), and returns its new
// name; empty when there was none. For a run that was killed, the copy of its last checkpoint is
// moved. Throws InputError when `file` is something else than HDF5 (an empty file is replaced) or a
// run is still writing it.
std::string keep_earlier_results(const std::string& file);

// The only writer of a results file; a second one is refused with an InputError.
// A write that fails (disk full) is a WriteError, at the latest at the next call.
class Recorder {
 public:
  using Lock = std::shared_ptr<const ResultsLock>;
  // A new file.
  static Recorder create(const Lock& lock, const std::vector<Column>& columns);
  static Recorder create(const std::string& file, const std::vector<Column>& columns);
  // An existing one, to continue.
  static Recorder reopen(const Lock& lock, const std::vector<Column>& columns);
  static Recorder reopen(const std::string& file, const std::vector<Column>& columns);
  ~Recorder();
  Recorder(Recorder&&) noexcept;

  // Queues one frame: the rows of all columns, one after another. Copies nothing to disk itself;
  // waits only when the writer is far behind.
  void push(std::vector<double> frame);

  // Runs `use` on the file after everything queued has been written, e.g. for a checkpoint.
  void with_file(const std::function<void(hdf5::File&)>& use);

  const ResultsLock& lock() const;

  // Cuts the columns back to their first `frames` rows, and flushes. Throws RunError when a column
  // has fewer, and WriteError.
  void truncate(std::size_t frames);

  // Writes the rest, and closes the file.
  void close();

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
