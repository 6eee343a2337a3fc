// Names of helpers in anonymous namespaces. A call in an anonymous namespace finds a helper there
// before a shared function of the same name, and a unity build puts the helpers of a folder into
// one unit. The compiler is silent about both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/structure/source_code.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

// A function that is declared or defined at namespace scope.
struct FunctionName {
  std::string space;  // "firn", "firn::page"
  std::string name;
  std::vector<std::string> parameters;  // types that convert to each other are spelled the same
  std::size_t required = 0;             // parameters without a default
  bool internal = false;                // in an anonymous namespace or static
};

// The parts of a list of parameters or arguments, between commas outside brackets.
std::vector<std::string> list_items(const std::string& list) {
  std::vector<std::string> items;
  std::string item;
  int depth = 0;
  for (const char c : list) {
    if (std::string("<([{").find(c) != std::string::npos) ++depth;
    if (std::string(">)]}").find(c) != std::string::npos) --depth;
    if (c == ',' && depth == 0) {
      items.push_back(std::exchange(item, ""));
    } else {
      item += c;
    }
  }
  if (item.find_first_not_of(" \n\t") != item.npos) items.push_back(item);
  return items;
}

// The type of a parameter without its name, const, references and namespaces; one word for all
// numbers and one for all texts.
std::string type_of(std::string parameter) {
  static const std::set<std::string> numbers = {
      "int",   "double", "float",    "bool",    "size_t",   "char",    "unsigned", "long",
      "short", "auto",   "uint64_t", "int64_t", "uint32_t", "int32_t", "ptrdiff_t"};
  static const std::regex word(R"(\w+|::|[^\s\w])");
  parameter = parameter.substr(0, parameter.find('='));
  parameter = std::regex_replace(parameter, std::regex(R"(\b(std|firn)::)"), "");
  std::vector<std::string> words;
  for (std::sregex_iterator m(parameter.begin(), parameter.end(), word), end; m != end; ++m)
    words.push_back(m->str());
  const auto is_name = [](const std::string& w) { return std::isalnum(w[0]) || w[0] == '_'; };
  if (words.size() > 1 && is_name(words.back()) && !numbers.contains(words.back()) &&
      words.back() != "const" && words[words.size() - 2] != "::" &&
      words[words.size() - 2] != "const")
    words.pop_back();
  std::string type;
  for (const std::string& w : words)
    if (w != "const" && w != "&") type += (type.empty() ? "" : " ") + w;
  if (type == "string" || type == "string_view" || type == "char *") return "text";
  return numbers.contains(type) ? "number" : type;
}

// The function of a declaration without its body; nothing for other declarations.
std::optional<FunctionName> function_of(std::string head) {
  static const std::regex other(
      R"(^\s*(using|typedef|struct|class|enum|union|static_assert|friend|extern)\b[^]*)");
  static const std::regex name_before(R"((\S[^]*?[\s&*>])(\w+)\s*\()");
  static const std::regex attribute(R"(\[\[[^\]]*\]\])");
  head = std::regex_replace(head, attribute, "");
  std::smatch match;
  if (std::regex_match(head, other)) return {};
  if (!std::regex_search(head, match, name_before)) return {};
  const std::string before = match[1];
  if (before.find_first_of("=(") != before.npos || before.find("operator") != before.npos)
    return {};
  FunctionName function;
  function.name = match[2];
  function.internal = before.starts_with("static ");
  const auto begin = static_cast<std::size_t>(match.position(0) + match.length(0));
  std::size_t end = begin;
  for (int depth = 1; end < head.size(); ++end) {
    depth += head[end] == '(' ? 1 : head[end] == ')' ? -1 : 0;
    if (depth == 0) break;
  }
  for (const std::string& item : list_items(head.substr(begin, end - begin))) {
    function.parameters.push_back(type_of(item));
    function.required += item.find('=') == item.npos ? 1 : 0;
  }
  return function;
}

std::vector<FunctionName> functions_of(const std::string& text) {
  static const std::regex opens(R"(^\s*(?:inline\s+)?namespace\s*([\w:]*)\s*$)");
  const std::string code = code_of(text);
  std::vector<FunctionName> functions;
  std::vector<std::string> spaces;
  std::string head;
  int parentheses = 0;
  const auto note = [&] {
    std::optional<FunctionName> function =
        function_of(head.substr(std::min(head.find_first_not_of(" \n\t"), head.size())));
    head.clear();
    if (!function) return;
    for (const std::string& space : spaces) {
      if (space.empty()) function->internal = true;
      if (!space.empty()) function->space += (function->space.empty() ? "" : "::") + space;
    }
    functions.push_back(*function);
  };
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char c = code[i];
    std::smatch match;
    parentheses += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (parentheses > 0 || (c != '{' && c != '}' && c != ';')) {
      head += c;
    } else if (c == '{' && std::regex_match(head, match, opens)) {
      spaces.push_back(match[1]);
      head.clear();
    } else if (c == '{') {
      for (int depth = 1; depth > 0 && ++i < code.size();)
        depth += code[i] == '{' ? 1 : code[i] == '}' ? -1 : 0;
      note();
    } else if (c == '}') {
      if (!spaces.empty()) spaces.pop_back();
      head.clear();
    } else {
      note();
    }
  }
  return functions;
}

struct SourceFile {
  std::string folder, name, text;
};

// Helpers that a call can find in place of a shared function with the same arguments.
std::vector<std::string> hidden_functions(const std::vector<SourceFile>& files) {
  std::multimap<std::string, FunctionName> shared;  // by name
  for (const SourceFile& file : files) {
    if (!file.name.ends_with(".h")) continue;
    for (const FunctionName& f : functions_of(file.text))
      if (!f.internal) shared.emplace(f.name, f);
  }
  std::vector<std::string> found;
  for (const SourceFile& file : files) {
    for (const FunctionName& helper : functions_of(file.text)) {
      if (!helper.internal) continue;
      const auto [first, last] = shared.equal_range(helper.name);
      const bool hides = std::any_of(first, last, [&](const auto& one) {
        const FunctionName& f = one.second;
        const std::size_t n = helper.parameters.size();
        return (helper.space + "::").starts_with(f.space + "::") && f.required <= n &&
               n <= f.parameters.size() &&
               std::equal(helper.parameters.begin(), helper.parameters.end(), f.parameters.begin());
      });
      if (hides)
        found.push_back(file.folder + "/" + file.name + ": " + helper.name +
                        " hides a function of "
                        "a header");
    }
  }
  return found;
}

// Helpers of two files of a folder with one name and one number of parameters. Overloads of
// fields() (experiments/text/json_fields.h) differ in the type whose keys they list.
std::vector<std::string> names_shared_in_a_folder(const std::vector<SourceFile>& files) {
  std::map<std::string, std::string> owner;
  std::vector<std::string> found;
  for (const SourceFile& file : files) {
    for (const FunctionName& helper : functions_of(file.text)) {
      if (!helper.internal || !file.name.ends_with(".cpp")) continue;
      const std::string type = helper.name == "fields" ? helper.parameters.back() : "";
      for (std::size_t n = helper.required; n <= helper.parameters.size(); ++n) {
        const std::string key =
            file.folder + " " + helper.space + "::" + helper.name + type + " " + std::to_string(n);
        const auto [known, first] = owner.emplace(key, file.name);
        if (!first && known->second != file.name)
          found.push_back(file.folder + ": " + helper.name + " in " + known->second + " and " +
                          file.name);
      }
    }
  }
  return found;
}

std::vector<SourceFile> sources() {
  std::vector<SourceFile> files;
  for (const char* library : {"solver", "experiments", "calibrate", "validation", "reports", "app",
                              "library", "python/src"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / library)) {
      const fs::path& path = entry.path();
      if (path.extension() != ".h" && path.extension() != ".cpp") continue;
      files.push_back({fs::relative(path.parent_path(), FIRN_SOURCE_DIR).string(),
                       path.filename().string(), read_text(path)});
    }
  }
  std::ranges::sort(files, {}, [](const SourceFile& f) { return f.folder + "/" + f.name; });
  return files;
}

// The libraries of cmake/unity.cmake.
bool is_unity(const std::string& folder) {
  static const std::set<std::string> libraries = {"solver",     "experiments", "calibrate",
                                                  "validation", "reports",     "app"};
  return libraries.contains(folder.substr(0, folder.find('/')));
}

// Folders after JOIN in the call of firn_unity of a library; "." is the library's own.
const std::set<std::string>& joined_folders(const std::string& library) {
  static std::map<std::string, std::set<std::string>> known;
  const auto [entry, is_new] = known.try_emplace(library);
  std::set<std::string>& folders = entry->second;
  if (!is_new) return folders;
  const std::string text = read_text(fs::path(FIRN_SOURCE_DIR) / library / "CMakeLists.txt");
  static const std::regex call(R"(firn_unity\(firn(?:_\w+)?[^)]*\bJOIN\s+([^)]*)\))");
  std::smatch found;
  if (!std::regex_search(text, found, call)) return folders;
  std::istringstream words(found[1]);
  for (std::string word; words >> word;)
    folders.insert(word == "." ? library : library + "/" + word);
  return folders;
}

// The folder whose unit has the sources of a folder: of experiments with all folders in it, and one
// for all joined folders.
std::string unit_folder(std::string folder) {
  const std::string top = "experiments/";
  if (folder.starts_with(top)) folder = folder.substr(0, folder.find('/', top.size()));
  const std::string library = folder.substr(0, folder.find('/'));
  return joined_folders(library).contains(folder) ? library + " joined" : folder;
}

TEST(HelperNames, FunctionsAreRead) {
  const std::vector<FunctionName> f = functions_of(R"(
#include "a.h"
namespace firn {
// int commented(int);
double one(const std::vector<std::pair<int, double>>& values, std::string_view = "a,b");
struct Type { int member(int x); };
namespace {
constexpr int kMost = index(4);
template <class T>
std::string two(T value, const char* text) { if (value) { return "{"; } return text; }
}  // namespace
namespace page {
static void three() {}
}  // namespace page
}  // namespace firn
)");
  ASSERT_EQ(f.size(), 3u);
  EXPECT_EQ(f[0].space + " " + f[0].name, "firn one");
  EXPECT_EQ(f[0].parameters,
            (std::vector<std::string>{"vector < pair < int , double > >", "text"}));
  EXPECT_EQ(f[0].required, 1u);
  EXPECT_FALSE(f[0].internal);
  EXPECT_EQ(f[1].name, "two");
  EXPECT_EQ(f[1].parameters, (std::vector<std::string>{"T", "text"}));
  EXPECT_TRUE(f[1].internal);
  EXPECT_EQ(f[2].space + " " + f[2].name, "firn::page three");
  EXPECT_TRUE(f[2].internal);
}

// The helper of a shared function's name that the test is for, put into a random source.
TEST(HelperNames, AHelperThatHidesAFunctionIsFound) {
  std::vector<SourceFile> files = sources();
  int tried = 0;
  for (std::size_t k = 3; k < files.size(); k += 37) {
    const std::string header = "namespace firn {\ndouble planted(const Vec3& at, int n = 4);\n}\n";
    std::vector<SourceFile> altered = {files[k], {"experiments/text", "planted.h", header}};
    EXPECT_EQ(hidden_functions(altered).size(), 0u);
    for (const char* parameters : {"Vec3 x", "const Vec3& position, double n", "const Vec3&"}) {
      altered[0].text = files[k].text + "\nnamespace firn {\nnamespace {\ndouble planted(" +
                        std::string(parameters) + ") { return 0; }\n}\n}\n";
      EXPECT_EQ(hidden_functions(altered).size(), 1u) << files[k].name << " " << parameters;
      ++tried;
    }
  }
  EXPECT_GT(tried, 20);
}

TEST(HelperNames, NoneHidesAFunctionOfAHeader) {
  const std::vector<SourceFile> files = sources();
  std::size_t shared = 0, helpers = 0;
  for (const SourceFile& file : files)
    for (const FunctionName& f : functions_of(file.text)) ++(f.internal ? helpers : shared);
  EXPECT_GT(shared, 1000u);
  EXPECT_GT(helpers, 1500u);
  for (const std::string& one : hidden_functions(files)) ADD_FAILURE() << one;
}

// Which helper a call finds is then the same in a build of single sources and in a unity build.
TEST(HelperNames, AreUniqueInAFolder) {
  std::vector<SourceFile> files = sources();
  std::erase_if(files, [](const SourceFile& f) { return !is_unity(f.folder); });
  for (SourceFile& file : files) file.folder = unit_folder(file.folder);
  EXPECT_EQ(unit_folder("solver/state"), unit_folder("solver"));
  EXPECT_EQ(unit_folder("experiments/run"), unit_folder("experiments/analysis"));
  EXPECT_EQ(unit_folder("solver/step"), "solver/step");
  EXPECT_GT(files.size(), 300u);
  for (const std::string& one : names_shared_in_a_folder(files)) ADD_FAILURE() << one;
  std::vector<SourceFile> two = {{"app", "a.cpp", "namespace { int f(int a, int b = 2) {} }"},
                                 {"app", "b.cpp", "namespace { int f(const Json& a) {} }"}};
  EXPECT_EQ(names_shared_in_a_folder(two).size(), 1u);
}

}  // namespace
}  // namespace firn::cli
