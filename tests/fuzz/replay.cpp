// Gives every file of a corpus to a fuzz target once: what was found stays fixed, with any
// compiler.
//
// Usage: fuzz_TARGET FILE_OR_FOLDER...
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_target.h"

namespace {

// Generous: under sanitizers, on a busy machine. An input that takes longer is a way to hang.
constexpr double kLongest = 20;               // s of processor time each
constexpr double kLargest = 2.0 * (1 << 20);  // kB of memory over all

std::vector<std::string> files_of(int argc, char** argv) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) {
      files.emplace_back(argv[i]);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(argv[i])) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> files = files_of(argc, argv);
  if (files.empty()) {
    std::fprintf(stderr, "nothing to replay; expected files or folders that hold some\n");
    return 2;
  }
  for (const std::string& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);  // the last name is the one that crashed
    const std::clock_t start = std::clock();
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    firn::fuzz::require(seconds < kLongest, file + " is read in time");
  }
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  firn::fuzz::require(static_cast<double>(used.ru_maxrss) < kLargest, "memory stays bounded");
  std::printf("%zu inputs, nothing broken\n", files.size());
  return 0;
}
