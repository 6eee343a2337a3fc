// Lock of a results file for its writer, and the copy of its last checkpoint.
//
// A kill while HDF5 writes can destroy the earlier content of a file. Therefore a copy of the file
// at its last checkpoint, FILE.saved, exists during a run. The copy is complete at any time, also
// after a power failure. A resumed run starts from an existing copy. The copy is removed when the
// file is complete and stored by the device.
#pragma once

#include <string>

#include "experiments/system/output_file.h"

namespace firn {

// Name of the copy, and whether it exists. Readers need no lock for it.
std::string saved_copy(const std::string& results_file);
bool has_saved_copy(const std::string& results_file);

// Excludes other writers of the file during its lifetime. The system releases the lock of a killed
// process. Does not affect readers and the locks of HDF5.
class ResultsLock {
 public:
  // Creates an empty file if it is missing. Throws InputError when another run writes the file, and
  // as refuse_output().
  explicit ResultsLock(const std::string& file);

  const std::string& file() const { return file_; }
  // Replaces the copy by the file, which must be flushed. After a failure, the earlier copy exists.
  // Recreates a removed folder. Throws WriteError.
  void save_copy() const;
  // Replaces the file by the copy, which remains.
  void restore_copy() const;
  // Renames the copy to the name of the file. The lock is invalid afterwards.
  void replace_by_copy() const;
  // Removes the copy after the device has stored the file. (The directory entry of the file was
  // stored with that of the copy.) A power failure can restore the copy; the work since the last
  // checkpoint is then repeated.
  void remove_copy() const;
  // Throws WriteError if the locked file was removed or replaced.
  void require_in_place() const;

 private:
  bool in_place() const;

  std::string file_;
  Descriptor descriptor_;
};

}  // namespace firn
