// Which folder may include headers of which other folders. docs/architecture.md says what each
// holds.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/program.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

// Every folder with sources, in the direction of the data flow, and the folders that it includes.
// What those include is allowed, too.
const std::vector<std::pair<std::string, std::set<std::string>>> folders = {
    {"solver/include/firn", {}},
    {"solver/core", {"solver/include/firn"}},
    {"solver/geometry", {"solver/include/firn"}},
    {"solver/collision", {"solver/core"}},
    {"solver/shapes", {"solver/collision", "solver/geometry"}},
    {"solver/contact", {"solver/collision"}},
    {"solver/dynamics", {"solver/core"}},
    {"solver/model", {"solver/dynamics"}},
    {"solver/state", {"solver/contact", "solver/dynamics", "solver/geometry"}},
    {"solver/contact_detection", {"solver/state"}},
    {"solver/statistics", {"solver/state"}},
    {"solver/step", {"solver/contact_detection"}},
    {"solver", {"solver/step", "solver/statistics"}},

    {"experiments/system", {"solver/include/firn"}},
    {"experiments/text", {"experiments/system"}},
    {"experiments/text/csv", {"experiments/text"}},
    {"experiments/storage", {"experiments/system"}},
    {"experiments/analysis", {"solver/include/firn"}},
    {"experiments/machine", {"solver/include/firn"}},
    {"experiments/meshes", {"experiments/storage", "experiments/text"}},
    {"experiments/material_records",
     {"experiments/analysis", "experiments/storage", "experiments/text"}},
    {"experiments/measurements", {"experiments/analysis", "experiments/text/csv"}},
    {"experiments/case", {"solver/include/firn"}},
    {"experiments/results",
     {"experiments/analysis", "experiments/case", "experiments/storage", "experiments/text"}},
    {"experiments/case_reader/model",
     {"experiments/machine", "experiments/meshes", "experiments/text/csv"}},
    {"experiments/case_reader/process",
     {"experiments/analysis", "experiments/case", "experiments/case_reader/model"}},
    {"experiments/case_reader",
     {"experiments/case_reader/process", "experiments/material_records", "experiments/results"}},
    {"experiments/responses", {"experiments/case_reader"}},
    {"experiments/run", {"experiments/responses"}},
    {"experiments/inspection", {"experiments/case_reader"}},
    {"experiments/export", {"experiments/case_reader"}},
    {"experiments/batch/execution", {"experiments/case_reader"}},
    {"experiments/batch/journal", {"experiments/batch/execution"}},
    {"experiments/batch/slurm", {"experiments/batch/journal"}},
    {"experiments/batch", {"experiments/batch/slurm"}},
    {"experiments/batch/sweep", {"experiments/batch", "experiments/responses"}},

    {"calibrate/numerics", {"experiments/analysis"}},
    {"calibrate/study",
     {"calibrate/numerics", "experiments/batch", "experiments/material_records",
      "experiments/measurements"}},
    {"calibrate/inference", {"calibrate/study"}},
    {"calibrate/output", {"calibrate/inference"}},
    {"calibrate", {"calibrate/output"}},
    {"calibrate/optimization", {"calibrate/output"}},

    {"photo", {"experiments/responses", "experiments/text"}},

    {"validation/statistics", {"experiments/material_records", "experiments/measurements"}},
    {"validation/suite",
     {"experiments/batch/execution", "experiments/measurements", "experiments/responses"}},
    {"validation/comparison", {"validation/statistics", "validation/suite"}},
    {"validation", {"experiments/batch", "validation/comparison"}},
    {"validation/verification/fixtures", {"experiments/analysis", "experiments/meshes"}},
    {"validation/verification/single_body", {"validation/verification/fixtures"}},
    {"validation/verification/assemblies", {"validation/verification/fixtures"}},
    {"validation/verification/robustness",
     {"experiments/machine", "validation/verification/fixtures"}},
    {"validation/verification",
     {"validation/verification/single_body", "validation/verification/assemblies",
      "validation/verification/robustness"}},

    {"reports/html", {"experiments/storage", "experiments/text"}},
    {"reports/plots", {"experiments/text"}},
    {"reports/rendering", {"experiments/inspection", "experiments/responses", "experiments/run"}},
    {"reports/replay", {"reports/html", "reports/rendering"}},
    {"reports/documents",
     {"calibrate/optimization", "experiments/batch/sweep", "reports/plots", "reports/replay",
      "validation", "validation/verification"}},

    {"app/support", {"experiments/batch", "experiments/material_records", "reports/documents"}},
    {"app/output", {"app/support"}},
    {"app/commands", {"app/output", "experiments/export", "photo"}},
    {"app/batch_commands",
     {"app/commands", "calibrate", "calibrate/optimization", "experiments/batch/sweep",
      "validation"}},
    {"app", {"app/batch_commands"}},

    // The public library: its headers need those of the solver alone.
    {"library/include/firn/experiments", {"solver/include/firn"}},
    {"library/include/firn/calibrate", {}},
    {"library/experiments",
     {"library/include/firn/experiments", "experiments/case_reader", "experiments/run"}},
    {"library/calibrate", {"library/include/firn/calibrate", "calibrate"}},
    {"python/src", {"library/include/firn/experiments", "library/include/firn/calibrate"}},
};

// A unit is a header, a source, or both of one name.
constexpr std::size_t kMostUnits = 16;

const std::set<std::string> project_folders = {"solver", "experiments", "calibrate",
                                               "photo",  "validation",  "reports",
                                               "app",    "library",     "python"};

// Folders that each folder may include from: those of its row and of the rows of these. A row may
// name folders of earlier rows alone, so that no cycle is possible.
std::map<std::string, std::set<std::string>> reachable() {
  std::map<std::string, std::set<std::string>> all;
  for (const auto& [folder, named] : folders) {
    std::set<std::string> reached = named;
    for (const std::string& other : named) {
      const auto row = all.find(other);
      EXPECT_NE(row, all.end()) << folder << " names " << other
                                << ", which is not in an earlier row";
      if (row != all.end()) reached.insert(row->second.begin(), row->second.end());
    }
    EXPECT_TRUE(all.emplace(folder, reached).second) << folder << " has two rows";
  }
  return all;
}

// Headers of the project that a source includes, relative to the project.
std::set<std::string> included_by(const std::string& text) {
  static const std::regex include(
      R"re(#\s*include\s*["<]((firn|solver|experiments|calibrate|photo|validation|reports|app|library|python|tests)/[^">]+)[">])re");
  std::set<std::string> headers;
  for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end; ++match) {
    const std::string header = (*match)[1];
    const bool is_public = (*match)[2] == "firn";
    // Headers of the solver lie in firn/ itself, those of the public library in folders of it.
    const bool of_library = is_public && header.find('/', 5) != header.npos;
    headers.insert((of_library ? "library/include/" : is_public ? "solver/include/" : "") + header);
  }
  return headers;
}

// Sources of a library by folder.
std::map<std::string, std::set<fs::path>> sources_of(const std::string& library) {
  std::map<std::string, std::set<fs::path>> sources;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / library)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    sources[fs::relative(entry.path().parent_path(), FIRN_SOURCE_DIR).string()].insert(
        entry.path());
  }
  return sources;
}

TEST(Layers, EveryFolderHasARow) {
  std::set<std::string> rows, found;
  for (const auto& [folder, named] : folders) rows.insert(folder);
  for (const std::string& library : project_folders) {
    for (const auto& [folder, files] : sources_of(library)) {
      found.insert(folder);
      std::set<std::string> units;
      for (const fs::path& file : files) units.insert(file.stem().string());
      EXPECT_LE(units.size(), kMostUnits) << folder << " holds too much to be found by name";
    }
  }
  EXPECT_EQ(rows, found);
}

TEST(Layers, IncludesPointOneWay) {
  const std::map<std::string, std::set<std::string>> allowed = reachable();
  std::size_t includes = 0;
  for (const std::string& library : project_folders) {
    for (const auto& [folder, files] : sources_of(library)) {
      const auto row = allowed.find(folder);
      ASSERT_NE(row, allowed.end()) << folder;
      for (const fs::path& file : files) {
        for (const std::string& header : included_by(read_text(file))) {
          ++includes;
          const std::string from = fs::path(header).parent_path().string();
          EXPECT_TRUE(from == folder || row->second.contains(from))
              << file.string() << " includes " << header;
        }
      }
    }
  }
  EXPECT_GT(includes, 1000u);
}

// The check itself sees what it looks for.
TEST(Layers, IncludesAreRecognized) {
  EXPECT_EQ(
      included_by("#include <vector>\n#include \"solver/core/simd.h\"\n# include \"app/x.h\"\n"
                  "#include <reports/html/page.h>\n#include \"firn/model.h\"\n"
                  "#include \"firn/experiments/run.h\"\n"),
      (std::set<std::string>{"app/x.h", "library/include/firn/experiments/run.h",
                             "reports/html/page.h", "solver/core/simd.h",
                             "solver/include/firn/model.h"}));
}

// A program on the public library compiles with Eigen and the standard library alone.
TEST(Layers, PublicHeadersIncludeNoPrivateLibrary) {
  static const std::regex foreign(R"(#\s*include\s*[<"](?!firn/|Eigen/)[^">]*[/.])");
  int files = 0;
  for (const char* folder : {"solver/include", "library/include"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / folder)) {
      if (!entry.is_regular_file()) continue;
      ++files;
      EXPECT_FALSE(std::regex_search(read_text(entry.path()), foreign)) << entry.path().string();
    }
  }
  EXPECT_GT(files, 15);
}

// The solver reads and writes no files and starts no processes.
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
