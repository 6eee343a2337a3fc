// Dependencies point one way: solver <- experiments <- calibrate, validation <- reports.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "tests/cli/program.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

// What the sources of a folder may include, beside their own folder's headers.
const std::map<std::string, std::set<std::string>> may_use = {
    {"solver", {}},
    {"experiments", {"solver"}},
    {"calibrate", {"solver", "experiments"}},
    {"validation", {"solver", "experiments"}},
    {"reports", {"solver", "experiments", "calibrate", "validation"}},
    {"app", {"solver", "experiments", "calibrate", "validation", "reports"}},
};

// Folders of the project that a source file includes from.
std::set<std::string> used_by(const std::string& text) {
  static const std::regex include(
      R"re(#\s*include\s*["<](?:firn/)?(solver|experiments|calibrate|validation|reports|app|tests)/)re");
  std::set<std::string> folders;
  for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end; ++match) {
    folders.insert((*match)[1]);
  }
  return folders;
}

TEST(Layers, IncludesPointOneWay) {
  int files = 0;
  for (const auto& [folder, allowed] : may_use) {
    const fs::path root = fs::path(FIRN_SOURCE_DIR) / folder;
    if (!fs::exists(root)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      for (const std::string& used : used_by(read_text(entry.path()))) {
        EXPECT_TRUE(used == folder || allowed.contains(used))
            << entry.path().string() << " includes from " << used << "/";
      }
    }
  }
  EXPECT_GT(files, 50);
}

// The check itself sees what it looks for.
TEST(Layers, IncludesAreRecognised) {
  EXPECT_EQ(used_by("#include <vector>\n#include \"solver/types.h\"\n# include \"app/x.h\"\n"
                    "#include <firn/reports/page.h>\n#include \"calibrate/a/b.h\"\n"),
            (std::set<std::string>{"app", "calibrate", "reports", "solver"}));
}

// Files, formats and processes are no business of the solver.
TEST(Layers, SolverKnowsNoFiles) {
  static const std::regex foreign(
      R"(#\s*include\s*<(toml\+\+|hdf5|H5|fstream|filesystem|sqlite3))");
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / "solver")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_FALSE(std::regex_search(read_text(entry.path()), foreign)) << entry.path().string();
  }
  EXPECT_GT(files, 50);
}

}  // namespace
}  // namespace firn::cli
