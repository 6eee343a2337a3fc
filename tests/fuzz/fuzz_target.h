// What all fuzz targets promise of a reader, whatever the bytes: it gives a value, or it throws an
// InputError (a RunError, where a run is concerned) with one line. Anything else ends the program.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "firn/math.h"

namespace firn::fuzz {

[[noreturn]] inline void broken(const std::string& promise) {
  std::fprintf(stderr, "\nbroken promise: %s\n", promise.c_str());
  std::abort();
}

// Not a std::string: one made for each promise that is kept would take most of the time.
inline void require(bool kept, std::string_view promise) {
  if (!kept) broken(std::string(promise));
}

// A sentence that a terminal shows on one line.
inline void require_one_line(std::string_view message) {
  require(!message.empty(), "a message says something");
  for (const unsigned char c : message) {
    if (c < ' ' || c == 0x7f) broken("a message is one line: " + std::string(message));
  }
}

// Runs the reader; false when it refused as it should.
template <class Read>
bool accepts(Read&& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    require_one_line(error.what());
  } catch (const RunError& error) {
    require_one_line(error.what());
  } catch (const std::exception& error) {
    broken(std::string("only InputError and RunError leave a reader; this is neither: ") +
           error.what());
  }
  return false;
}

// A folder of this process for readers that want files; gone when the program ends well.
class Folder {
 public:
  Folder() {
    const char* const memory = "/dev/shm";
    const bool has_memory = ::access(memory, W_OK) == 0;
    std::string name =
        ((has_memory ? std::filesystem::path(memory) : std::filesystem::temp_directory_path()) /
         "firn-fuzz-XXXXXX")
            .string();
    require(::mkdtemp(name.data()) != nullptr, "a scratch folder can be made");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string put(const std::string& name, std::string_view bytes) const {
    std::string file = path(name);
    const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const bool written =
        fd >= 0 && ::write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
    require(written && ::close(fd) == 0, "a scratch file can be written");
    return file;
  }

 private:
  std::filesystem::path path_;
};

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// The same with a case that other files can name: case.toml.
class FolderWithCase : public Folder {
 public:
  FolderWithCase() {
    std::filesystem::copy_file(
        std::filesystem::path(FIRN_SOURCE_DIR) / "cases" / "bounce" / "case.toml",
        path("case.toml"));
  }
};

}  // namespace firn::fuzz

// The one function of a target; libFuzzer calls it, and so does replay.cpp.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
