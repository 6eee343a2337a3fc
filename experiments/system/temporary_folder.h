// A folder for intermediate files of one task.
#pragma once

#include <filesystem>
#include <string>

#include "experiments/system/interruption.h"

namespace firn {

// A new folder in the system's temporary folder (absolute path), removed with the object and when
// the program is ended at once. Throws RunError when none can be made.
class TemporaryFolder {
 public:
  // `name`: letters and hyphens, part of the folder's name.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  TemporaryFolder(const std::string& name, const interruption::Uninterrupted&);

  std::filesystem::path path_;
  interruption::Temporary temporary_;
};

}  // namespace firn
