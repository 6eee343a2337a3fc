#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace firn::test {

// A new temporary folder. The destructor removes it.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name, const std::filesystem::path& parent =
                                                      std::filesystem::temp_directory_path()) {
    std::string path = (parent / ("firn-" + name + "-XXXXXX")).string();
    if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("cannot create " + path);
    path_ = path;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The path of a file or folder NAME in a temporary folder of this process. Tests run in parallel
// processes, so a fixed path in the system's temporary folder would be shared between them.
inline std::string scratch_path(const std::string& name) {
  static const ScratchFolder folder("test");
  return folder / name;
}

}  // namespace firn::test
