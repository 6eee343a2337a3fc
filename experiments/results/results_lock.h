// Lock of a results file for its writer, and the copy of its last checkpoint.
//
// A kill while HDF5 writes can destroy the earlier content of a file. Therefore a copy of the file
// as of the last checkpoint, FILE.saved, exists while a run writes. The copy is complete at any
// moment, also after a power failure. A run that continues starts from the copy, if there is one.
// It is removed when the file itself is complete and the device has its bytes.
#pragma once

#include <string>

#include "experiments/system/output_file.h"

namespace firn {

// Name of the copy, and whether it exists. Readers need no lock for it.
std::string saved_copy(const std::string& results_file);
bool has_saved_copy(const std::string& results_file);

// Excludes every other writer of the file as long as it lives, also through the kill of a process:
// the system releases it. Readers and HDF5's own locks are not affected.
class ResultsLock {
 public:
  // An empty file is made where there is none. Throws InputError when another run is writing the
  // file, and as refuse_output().
  explicit ResultsLock(const std::string& file);

  const std::string& file() const { return file_; }
  // Copies the file, which must be flushed, to the copy. The earlier copy stays when this fails.
  // Makes the folder where it was removed. Throws WriteError.
  void save_copy() const;
  // Replaces the file by the copy. The copy stays.
  void restore_copy() const;
  // Renames the copy to the name of the file. The lock is invalid afterwards.
  void replace_by_copy() const;
  // Removes the copy when the device has the file. (Its name came with that of the copy.) A power
  // failure may bring the copy back: then the work since the last checkpoint is repeated.
  void remove_copy() const;
  // Throws WriteError when the name no longer belongs to the locked file.
  void require_in_place() const;

 private:
  bool in_place() const;

  std::string file_;
  Descriptor descriptor_;
};

}  // namespace firn
