// Every shipped case, study, suite, sweep, optimization, measurement and list of bench tests can be
// read, with all files that it names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "calibrate/optimization/optimization_study.h"
#include "calibrate/study/study_file.h"
#include "experiments/batch/sweep/sweep.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/measurements/bench_tests.h"
#include "experiments/measurements/measurement.h"
#include "photo/photo_setup.h"
#include "tests/app/program.h"
#include "validation/suite/suite_file.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::set<fs::path> shipped_files() {
  std::set<fs::path> files;
  for (const char* folder : {"experiments", "cases"}) {
    const fs::path root = fs::path(FIRN_SOURCE_DIR) / folder;
    if (!fs::exists(root)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.path().extension() == ".toml" &&
          entry.path().string().find("/templates/") == std::string::npos)
        files.insert(entry.path());
  }
  return files;
}

// Files that others include: no cases by themselves.
std::set<fs::path> fragments(const std::set<fs::path>& files) {
  static const std::regex list(R"re(\ninclude\s*=\s*\[([^\]]*)\])re"), name(R"re("([^"]+)")re");
  std::set<fs::path> found;
  for (const fs::path& file : files) {
    const std::string text = "\n" + read_text(file);
    std::smatch match;
    if (!std::regex_search(text, match, list)) continue;
    const std::string names = match[1];
    for (std::sregex_iterator m(names.begin(), names.end(), name), end; m != end; ++m)
      found.insert(file.parent_path() / (*m)[1].str());
  }
  return found;
}

TEST(ShippedFiles, AllCanBeRead) {
  const std::set<fs::path> files = shipped_files(), parts = fragments(files);
  for (const fs::path& part : parts) EXPECT_TRUE(files.contains(part)) << part;
  int cases = 0, others = 0, forms = 0;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.string());
    if (parts.contains(file)) continue;
    const std::string text = "\n" + read_text(file), path = file.string();
    const auto has = [&](const char* table) { return text.find(table) != std::string::npos; };
    ++others;
    try {
      if (has("\n[suite]")) {
        read_suite(path);
      } else if (has("\n[study]")) {
        read_study(path, Programs::allowed);
      } else if (has("\n[sweep]")) {
        read_sweep(path);
      } else if (has("\n[optimization]")) {
        read_optimization(path);
      } else if (has("\n[[tests]]")) {
        read_bench_tests(path);
      } else if (has("\n[[slopes]]")) {
        read_photo_setup(path);
      } else if (has("\n[case]")) {
        ++cases;
        read_case(path);
      } else {
        EXPECT_EQ(file.parent_path().filename(), "measurements");
        read_measurement(path);
      }
    } catch (const InputError& error) {
      if (has("\n[initial_state]")) {  // from the results of a run that has not been made
        EXPECT_THAT(error.what(), HasSubstr(".h5"));
      } else {  // a form to be filled in
        ++forms;
        EXPECT_THAT(error.what(), HasSubstr("values: has fewer than two entries"));
      }
    }
  }
  EXPECT_GT(cases, 15);
  EXPECT_GT(others - cases - forms, 10);
}

}  // namespace
}  // namespace firn::cli
