// Properties of the source tree that no compiler checks: each of them fails silently when files
// move.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/support/scratch_folder.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

const fs::path source_dir = FIRN_SOURCE_DIR;
const std::array<std::string, 8> libraries = {"solver",     "experiments", "calibrate", "photo",
                                              "validation", "reports",     "app",       "library"};

// Files with one of `extensions` anywhere below `folder`.
std::vector<fs::path> files_below(const fs::path& folder, const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (extensions.contains(entry.path().extension().string())) files.push_back(entry.path());
  }
  return files;
}

struct CommandOutcome {
  int status;
  std::string text;  // standard output and standard error
};

CommandOutcome run_shell(const std::string& command) {
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {-1, ""};
  std::string text;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    text.append(buffer.data(), n);
  return {::pclose(pipe), text};
}

TEST(SourceTree, EverySourceIsCompiled) {
  std::set<fs::path> compiled;
  const auto commands =
      nlohmann::json::parse(read_text(fs::path(FIRN_BINARY_DIR) / "compile_commands.json"));
  const std::regex included("#include \"([^\"]+)\"");
  for (const auto& command : commands) {
    const fs::path file = command.at("file").get<std::string>();
    compiled.insert(fs::weakly_canonical(file));
    if (file.parent_path().filename() != "Unity") continue;
    const std::string unit = read_text(file);
    for (std::sregex_iterator one(unit.begin(), unit.end(), included), end; one != end; ++one)
      compiled.insert(fs::weakly_canonical((*one)[1].str()));
  }
  std::vector<fs::path> folders;
  folders.reserve(libraries.size());
  for (const std::string& library : libraries) folders.push_back(source_dir / library);
  for (const char* area : {"solver", "experiments", "calibrate", "photo", "validation", "reports",
                           "app", "calibration_proof"})
    folders.push_back(source_dir / "tests" / area);
  int count = 0;
  for (const fs::path& folder : folders) {
    for (const fs::path& file : files_below(folder, {".cpp"})) {
      ++count;
      EXPECT_TRUE(compiled.contains(fs::weakly_canonical(file))) << file << " is not compiled";
    }
  }
  EXPECT_GT(count, 250);
}

TEST(SourceTree, ClangTidyReadsEveryHeader) {
  const std::string settings = read_text(source_dir / ".clang-tidy");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(settings, match, std::regex("HeaderFilterRegex: '([^']+)'")));
  const std::regex filter(match[1].str());
  int count = 0;
  for (const std::string& library : libraries) {
    for (const fs::path& file : files_below(source_dir / library, {".h"})) {
      ++count;
      EXPECT_TRUE(std::regex_search(file.string(), filter)) << file;
    }
  }
  EXPECT_GT(count, 100);
  EXPECT_TRUE(std::regex_search("/x/solver/contact/law/friction.h", filter));
}

// The identity of the program, computed for a copy of the sources that a test alters.
class ProgramIdentity : public testing::Test {
 protected:
  ProgramIdentity() : scratch_("identity") {
    for (const char* library : {"solver", "experiments"}) {
      for (const fs::path& file : files_below(source_dir / library, {".cpp", ".h"})) {
        copy(file);
      }
    }
    copy(source_dir / "solver/CMakeLists.txt");
    std::ofstream(scratch_ / "facts.txt") << "compiler\n";
  }

  fs::path path(const std::string& name) const { return scratch_.path() / name; }

  CommandOutcome run() const {
    return run_shell("'" FIRN_CMAKE "' -DSOURCE_DIR='" + scratch_.path().string() +
                     "' -DVERSION=1 -DBUILD_FACTS='" + (scratch_ / "facts.txt") + "' -DOUTPUT='" +
                     (scratch_ / "version.txt") + "' -DLIST='" + (scratch_ / "list.txt") +
                     "' -P '" + source_dir.string() + "/cmake/write_version.cmake'");
  }
  std::string identity() const {
    const CommandOutcome outcome = run();
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    const std::string text = read_text(path("version.txt"));
    std::smatch match;
    EXPECT_TRUE(
        std::regex_search(text, match, std::regex("program_identity\\(\\) .*\"([0-9a-f]{16})\"")));
    return match[1];
  }
  // Paths of the copied sources below `folder`, relative to the copy.
  std::vector<std::string> sources(const std::string& folder) const {
    std::vector<std::string> names;
    for (const fs::path& file : files_below(path(folder), {".cpp", ".h"}))
      names.push_back(fs::relative(file, scratch_.path()).string());
    std::sort(names.begin(), names.end());
    return names;
  }
  void append(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::app) << text;
  }
  void rewrite(const std::string& name, const std::regex& what, const std::string& by) const {
    const std::string text = std::regex_replace(read_text(path(name)), what, by);
    std::ofstream(path(name)) << text;
  }

 private:
  void copy(const fs::path& file) const {
    const fs::path target = scratch_.path() / fs::relative(file, source_dir);
    fs::create_directories(target.parent_path());
    fs::copy_file(file, target);
  }

  test::ScratchFolder scratch_;
};

// Every folder of the two libraries that decide numbers takes part.
TEST_F(ProgramIdentity, ChangesWithEveryFolder) {
  std::map<fs::path, std::vector<std::string>> by_folder;
  for (const char* library : {"solver", "experiments"}) {
    for (const std::string& name : sources(library)) {
      if (name.find("experiments/batch/") == std::string::npos)
        by_folder[fs::path(name).parent_path()].push_back(name);
    }
  }
  ASSERT_GE(by_folder.size(), 3u);
  std::set<std::string> seen = {identity()};
  for (const auto& [folder, names] : by_folder) {
    append(names.back(), "int one_more;\n");
    EXPECT_TRUE(seen.insert(identity()).second) << names.back() << " plays no part";
  }
}

// Every file of the two libraries takes part but these: they start runs, and evaluate or display
// what runs have given.
TEST_F(ProgramIdentity, CoversEveryFileButThose) {
  const std::regex others(
      "experiments/(batch/.*|(system/process|responses/response_(expression|order)|"
      "analysis/(power_law|elementary_effects))[.](cpp|h))");
  std::set<std::string> expected;
  for (const char* library : {"solver", "experiments"})
    for (const std::string& name : sources(library))
      if (!std::regex_match(name, others)) expected.insert(path(name).string());
  ASSERT_EQ(run().status, 0);
  std::set<std::string> found;
  std::istringstream list(read_text(path("list.txt")));
  for (std::string name; std::getline(list, name, ';');) found.insert(name);
  EXPECT_EQ(found, expected);
}

// All files of the solver move, and all sources and the build include them from there.
TEST_F(ProgramIdentity, IsKeptByAMove) {
  const std::string before = identity();
  for (const std::string& name : sources("solver")) {
    const fs::path to = path("solver/elsewhere/" + name.substr(name.find('/') + 1));
    fs::create_directories(to.parent_path());
    fs::rename(path(name), to);
  }
  static const std::regex include("(#include \")solver/");
  static const std::regex header("(#include \")firn/");
  static const std::regex source("([ (])([a-z0-9_/]+\\.cpp)");
  for (const char* library : {"solver", "experiments"}) {
    for (const std::string& name : sources(library)) {
      rewrite(name, include, "$1solver/elsewhere/");
      rewrite(name, header, "$1solver/elsewhere/include/firn/");
    }
  }
  rewrite("solver/CMakeLists.txt", source, "$1elsewhere/$2");
  rewrite("solver/CMakeLists.txt", std::regex("/include\\)"), "/elsewhere/include)");
  EXPECT_EQ(identity(), before);
}

TEST_F(ProgramIdentity, IgnoresCommentsAndLayout) {
  const std::string before = identity();
  append(sources("solver").front(), "\n\n// one more line\n\n  // and another\n");
  EXPECT_EQ(identity(), before);
}

// Code behind a string with two slashes is no comment.
TEST_F(ProgramIdentity, ChangesWithCodeBehindSlashes) {
  append(sources("solver").front(), "const char* a = \" // \"; int b = 1;\n");
  const std::string before = identity();
  rewrite(sources("solver").front(), std::regex("int b = 1"), "int b = 2");
  EXPECT_NE(identity(), before);
}

TEST_F(ProgramIdentity, ChangesWithAnInclude) {
  const std::string before = identity();
  std::string other;
  for (const std::string& name : sources("solver"))
    if (name.ends_with(".h")) other = name;
  append(sources("solver").front(), "#include \"" + other + "\"\n");
  EXPECT_NE(identity(), before);
}

TEST_F(ProgramIdentity, ChangesWithOptionsOfTheCompiler) {
  const std::string before = identity();
  append("solver/CMakeLists.txt", "target_compile_options(firn_solver PRIVATE -ffast-math)\n");
  EXPECT_NE(identity(), before);
}

TEST_F(ProgramIdentity, RefusesAnIncludeThatIsMissed) {
  append(sources("solver").front(), "#include \"solver/not_there.h\"\n");
  const CommandOutcome outcome = run();
  EXPECT_NE(outcome.status, 0);
  EXPECT_NE(outcome.text.find("solver/not_there.h"), std::string::npos) << outcome.text;
}

TEST_F(ProgramIdentity, IgnoresHowRunsAreStarted) {
  const std::string before = identity();
  ASSERT_FALSE(sources("experiments/batch").empty());
  append(sources("experiments/batch").front(), "int one_more;\n");
  EXPECT_EQ(identity(), before);
}

TEST_F(ProgramIdentity, RefusesATreeWithoutSources) {
  fs::rename(path("solver"), path("elsewhere"));
  fs::rename(path("experiments"), path("elsewhere2"));
  const CommandOutcome outcome = run();
  EXPECT_NE(outcome.status, 0);
  EXPECT_NE(outcome.text.find("found 0 sources"), std::string::npos) << outcome.text;
}

// A phase of the step that is missing in the list of AVX2 sources would link to the plain one.
TEST(SourceTree, Avx2KernelsAreComplete) {
  const fs::path object = fs::path(FIRN_BINARY_DIR) / "solver/avx2_kernels.o";
  if (!fs::exists(object)) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // those builds have none
    EXPECT_EQ(read_text(fs::path(FIRN_BINARY_DIR) / "CMakeCache.txt").find("FIRN_AVX2:BOOL=ON"),
              std::string::npos)
        << "no " << object;
#endif
    return;
  }
  const CommandOutcome names = run_shell("'" FIRN_NM "' -C -u '" + object.string() + "'");
  ASSERT_EQ(names.status, 0) << names.text;
  // Parts of a step that gain nothing from wide registers.
  const std::set<std::string> shared = {"firn::name_of_body", "firn::build_pair_blocks",
                                        "firn::add_bond_loads", "firn::parallel_for_blocks",
                                        "firn::sort_by_key"};
  std::istringstream lines(names.text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto at = line.find("firn::");
    if (at == std::string::npos) continue;
    const std::string name = line.substr(at, line.find_first_of("[(", at) - at);
    EXPECT_TRUE(shared.contains(name)) << name << " is not among the AVX2 sources";
  }
  EXPECT_GT(count, 5);
}

// Two types of one qualified name in different files break the one-definition rule without a
// message.
TEST(SourceTree, EveryTypeIsDefinedOnce) {
  static const std::regex opens(R"(^(?:inline )?namespace\s*([\w:]*)\s*\{.*)");
  static const std::regex closes(R"(^\}\s*// namespace.*)");
  static const std::regex type(
      R"(^(?:struct|class|union|enum|enum class)\s+(?:alignas\([^)]*\)\s*)?(\w+)\s*(?:final\s*)?(?::[^:;]*)?\{.*)");
  // An alias may be repeated, but not with another meaning.
  static const std::regex alias(R"(^using\s+(\w+)\s*(?:__attribute__.*)?=\s*(.*))");
  std::map<std::string, fs::path> defined;
  std::map<std::string, std::string> meaning;
  for (const std::string& library : libraries) {
    for (const fs::path& file : files_below(source_dir / library, {".h", ".cpp"})) {
      std::vector<std::string> spaces;
      std::istringstream lines(read_text(file));
      for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (std::regex_match(line, match, opens)) {
          spaces.push_back(match[1].str().empty() ? file.string() : match[1].str());
        } else if (std::regex_match(line, closes) && !spaces.empty()) {
          spaces.pop_back();
        } else if (std::regex_match(line, match, type)) {
          std::string name;
          for (const std::string& space : spaces) name += space + "::";
          name += match[1];
          const auto [known, first] = defined.emplace(name, file);
          EXPECT_TRUE(first) << name << " is defined in " << file << " and in " << known->second;
        } else if (std::regex_match(line, match, alias)) {
          std::string name;
          for (const std::string& space : spaces) name += space + "::";
          name += match[1];
          const auto [known, first] = meaning.emplace(name, match[2]);
          EXPECT_EQ(known->second, match[2]) << name << " in " << file;
          EXPECT_FALSE(defined.contains(name)) << name << " in " << file;
        }
      }
    }
  }
  EXPECT_GT(defined.size(), 300u);
}

// What is shipped with the program: cases, studies, suites, measurements and material records.
TEST(SourceTree, ShippedFilesAreInstalled) {
  const auto names_below = [](const fs::path& folder) {
    std::multiset<std::string> names;
    for (const fs::path& file : files_below(folder, {".toml", ".json"}))
      if (file.string().find("/cases/templates/") == std::string::npos)
        names.insert(file.filename().string());
    return names;
  };
  std::multiset<std::string> shipped;
  for (const char* folder : {"experiments", "cases", "data"})
    if (fs::exists(source_dir / folder)) shipped.merge(names_below(source_dir / folder));
  const test::ScratchFolder prefix("install");
  const CommandOutcome outcome = run_shell(
      "'" FIRN_CMAKE "' --install '" FIRN_BINARY_DIR "' --prefix '" + prefix.path().string() + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_EQ(names_below(prefix.path() / "share/firn"), shipped);
  EXPECT_GT(shipped.size(), 50u);
}

// `./firn` installs the packages [run] and [build] of scripts/packages.txt only. CMake finds what
// the other sections hold by these names.
TEST(SourceTree, ProgramConfiguresWithoutPackagesOfTests) {
  const test::ScratchFolder build("configure");
  std::string command = "'" FIRN_CMAKE "' --preset release -S '" + source_dir.string() + "' -B '" +
                        build.path().string() + "'";
  for (const char* package : {"GTest", "benchmark", "pybind11", "Python3"})
    command += std::string(" -DCMAKE_DISABLE_FIND_PACKAGE_") + package + "=ON";
  const CommandOutcome outcome = run_shell("cd '" + source_dir.string() + "' && " + command);
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(fs::exists(build.path() / "build.ninja"));
}

// Eigen leaves the numbers of a vector without an initializer undefined. In headers, only classes
// whose constructors set all of their members declare such vectors.
TEST(SourceTree, MembersOfEigenTypesHaveInitializers) {
  static const std::regex member(
      R"(^ +(Vec2|Vec3|Quat|Mat3|Eigen::(Vector[234][di]|Matrix[34]d|Quaterniond)) [a-z]\w*(\[\w+\])?(, [a-z]\w*(\[\w+\])?)*;)");
  const std::set<std::string> set_by_constructors = {"contact_region.h"};
  int count = 0;
  for (const std::string& library : libraries)
    for (const fs::path& file : files_below(source_dir / library, {".h"})) {
      if (set_by_constructors.contains(file.filename().string())) continue;
      ++count;
      std::istringstream text(read_text(file));
      for (std::string line; std::getline(text, line);)
        EXPECT_FALSE(std::regex_search(line, member)) << file << ": " << line;
    }
  EXPECT_GT(count, 200);
}

// Links of the pages, and paths of files in code style, name files that exist.
TEST(SourceTree, DocumentationNamesFilesThatExist) {
  static const std::regex link(R"(\]\(([^)\s#]+)[^)\s]*\))");
  static const std::regex outside(R"(^[a-z]+:.*)");
  static const std::regex path(
      R"(`((?:solver|experiments|calibrate|photo|validation|reports|app|tests|docs|scripts|cmake|cases|data|tools)/[\w./-]+\.\w+)`)");
  std::vector<fs::path> pages = {source_dir / "README.md", source_dir / "CHANGELOG.md"};
  for (const fs::path& file : files_below(source_dir / "docs", {".md"})) pages.push_back(file);
  int count = 0;
  for (const fs::path& page : pages) {
    const std::string text = read_text(page);
    for (std::sregex_iterator m(text.begin(), text.end(), link), end; m != end; ++m) {
      const std::string target = (*m)[1];
      if (std::regex_match(target, outside)) continue;
      ++count;
      EXPECT_TRUE(fs::exists(page.parent_path() / target)) << page << ": " << target;
    }
    for (std::sregex_iterator m(text.begin(), text.end(), path), end; m != end; ++m) {
      ++count;
      EXPECT_TRUE(fs::exists(source_dir / (*m)[1].str())) << page << ": " << (*m)[1];
    }
  }
  EXPECT_GT(count, 200);
}

// Tests run in parallel processes: a fixed path in the temporary folder is shared between them.
TEST(SourceTree, TestsShareNoTemporaryFile) {
  const std::set<std::string> owners = {"scratch_folder.h", "program.h", "fuzz_target.h",
                                        "crash_test.cpp"};
  static const std::regex shared("TempDir|temp_directory_path|\"/tmp");
  int count = 0;
  for (const fs::path& file : files_below(source_dir / "tests", {".cpp", ".h"})) {
    if (owners.contains(file.filename().string()) || file.filename() == "source_tree_test.cpp")
      continue;
    ++count;
    EXPECT_FALSE(std::regex_search(read_text(file), shared)) << file << ": use scratch_path()";
  }
  EXPECT_GT(count, 100);
}

}  // namespace
}  // namespace firn::cli
