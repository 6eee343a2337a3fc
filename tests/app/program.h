// Runs the real program as its users do, in a separate folder.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn::cli {

struct Outcome {
  int status = -1;  // exit status; 128 + signal when it was killed
  std::string out;  // standard output
  std::string err;  // standard error
  int signal = 0;   // that killed it; 0: none did
};

// A temporary folder in which commands run.
class Folder : public test::ScratchFolder {
 public:
  explicit Folder(const std::filesystem::path& parent = std::filesystem::temp_directory_path())
      : ScratchFolder("cli", parent) {}

  // Writes a file there and returns its name.
  std::string write(const std::string& name, const std::string& text) const;
  bool contains(const std::string& name) const { return std::filesystem::exists(path() / name); }

  // firn ARGUMENTS..., until it ends.
  Outcome firn(const std::vector<std::string>& arguments) const;
  // The same, left running.
  // `prepare` runs in the new process, with the standard streams in place.
  pid_t start(const std::vector<std::string>& arguments,
              const std::function<void()>& prepare = {}) const;
  Outcome wait(pid_t pid) const;
};

using test::read_text;
std::size_t lines(const std::string& text);
std::size_t lines_with(const std::string& text, const std::string& part);

}  // namespace firn::cli
