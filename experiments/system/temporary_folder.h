// A folder for intermediate files of one task.
#pragma once

#include <filesystem>
#include <string>

#include "experiments/system/interruption.h"

namespace firn {

// A new folder in the temporary folder of the system (absolute path). The destructor removes it,
// and so does an immediate exit of the program (interruption.h). Throws RunError when it cannot be
// created.
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
