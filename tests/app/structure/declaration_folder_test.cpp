// A header declares only what sources of the same folder define: a reader finds the definition
// there, and a folder does not call functions of folders that include it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/structure/source_code.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

// Public headers are kept apart from the sources: solver/include/ is exempt, and library/ is not
// listed.
const std::array<std::string, 7> checked_libraries = {
    "solver", "experiments", "calibrate", "photo", "validation", "reports", "app"};

// Functions whose sources are generated when the project is built, or named by a macro.
const std::set<std::string> generated = {
    "embedded_materials", "embedded_assets",  "embedded_templates", "firn_version",
    "firn_git_commit",    "program_identity", "baseline_kernels",   "avx2_kernels"};

// Name of the free function that a declaration or the head of a definition is about; empty: it is
// about something else, or the function is inline or static.
std::string function_name(std::string_view statement) {
  static const std::regex other_first(
      R"re(^\s*(template|using|typedef|static_assert|friend|class|struct|enum|union|namespace|inline|static|constexpr|extern|public|private)\b)re");
  static const std::regex attribute(R"re(\[\[[^\]]*\]\])re");
  const std::string head = std::regex_replace(std::string(statement), attribute, "");
  if (std::regex_search(head, other_first) || head.find("operator") != head.npos) return {};
  int depth = 0;  // of template arguments
  std::size_t paren = 0;
  for (; paren < head.size(); ++paren) {
    if (head[paren] == '<') ++depth;
    if (head[paren] == '>') --depth;
    if (depth == 0 && head[paren] == '=') return {};  // a variable
    if (depth == 0 && head[paren] == '(') break;
  }
  if (paren == head.size()) return {};
  const auto is_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == ':';
  };
  std::size_t end = paren;
  while (end > 0 && std::isspace(static_cast<unsigned char>(head[end - 1])) != 0) --end;
  std::size_t begin = end;
  while (begin > 0 && is_name(head[begin - 1])) --begin;
  const std::size_t type = head.find_first_not_of(" \n\t");
  if (type == begin || !is_name(head[type])) return {};  // no result type
  const std::string name = head.substr(begin, end - begin);
  const std::size_t scope = name.rfind("::");
  if (scope == name.npos) return name;
  // Members belong to their classes, whose names begin with a capital letter.
  const std::size_t outer = name.rfind("::", scope - 1);
  const std::size_t first = outer == name.npos ? 0 : outer + 2;
  return std::isupper(static_cast<unsigned char>(name[first])) != 0 ? "" : name.substr(scope + 2);
}

struct FreeFunctions {
  std::set<std::string> declared;  // without a definition in the same text
  std::set<std::string> defined;   // outside of anonymous namespaces
};

FreeFunctions free_functions(const std::string& text) {
  static const std::regex scope(R"re(^\s*(inline\s+)?namespace\b\s*([\w:]*)\s*$)re");
  FreeFunctions found;
  std::vector<bool> scopes;  // namespaces around; true: anonymous
  std::string statement;
  const std::string code = code_of(text);
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char c = code[i];
    if (c == ';') {
      if (const std::string name = function_name(statement); !name.empty())
        found.declared.insert(name);
      statement.clear();
    } else if (c == '}') {
      if (!scopes.empty()) scopes.pop_back();
      statement.clear();
    } else if (c != '{') {
      statement += c;
    } else if (std::smatch match; std::regex_match(statement, match, scope)) {
      scopes.push_back(match[2].length() == 0);
      statement.clear();
    } else {
      // Braces between parentheses belong to an argument, others to a body or an initial value.
      const bool is_argument = std::count(statement.begin(), statement.end(), '(') >
                               std::count(statement.begin(), statement.end(), ')');
      const bool is_hidden = std::find(scopes.begin(), scopes.end(), true) != scopes.end();
      if (const std::string name = function_name(statement);
          !name.empty() && !is_argument && !is_hidden)
        found.defined.insert(name);
      for (int depth = 1; depth > 0 && i + 1 < code.size();) {
        ++i;
        depth += code[i] == '{' ? 1 : code[i] == '}' ? -1 : 0;
      }
      if (!is_argument) statement.clear();
    }
  }
  for (const std::string& name : found.defined) found.declared.erase(name);
  return found;
}

TEST(Declarations, AreInTheFolderOfTheDefinition) {
  std::map<std::string, std::set<std::string>> folders;   // [function] that define it
  std::map<std::string, std::set<std::string>> declared;  // [header] functions
  for (const std::string& library : checked_libraries) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / library)) {
      const fs::path file = fs::relative(entry.path(), FIRN_SOURCE_DIR);
      const bool is_header = file.extension() == ".h";
      if (!is_header && file.extension() != ".cpp") continue;
      const FreeFunctions found = free_functions(read_text(entry.path()));
      for (const std::string& name : found.defined)
        folders[name].insert(file.parent_path().string());
      if (is_header && file.string().rfind("solver/include/", 0) != 0)
        declared[file.string()] = found.declared;
    }
  }
  std::size_t functions = 0;
  for (const auto& [header, names] : declared) {
    const std::string folder = fs::path(header).parent_path().string();
    for (const std::string& name : names) {
      if (generated.contains(name)) continue;
      ++functions;
      const auto at = folders.find(name);
      if (at == folders.end()) {
        ADD_FAILURE() << header << " declares " << name << "(), which no source defines";
      } else {
        EXPECT_TRUE(at->second.contains(folder))
            << header << " declares " << name << "(), which " << *at->second.begin() << " defines";
      }
    }
  }
  EXPECT_GT(functions, 600u);
}

// The check itself sees what it looks for.
TEST(Declarations, AreRecognized) {
  const FreeFunctions header = free_functions(R"(
#pragma once
#include "x.h"
#define MACRO(x) \
  int in_macro(x);
namespace firn {
// int in_comment();
struct Point;
class Shape { int member(); void other() const; };
[[nodiscard]] std::vector<std::pair<int, int>> first(const Point& p,
                                                     int n);
std::function<void(int)> second(double x = 1, std::vector<int> y = {});
inline int third() { return 3; }
template <class T> T fourth(T t);
constexpr int fifth = index(2);
extern template int fourth(int);
const char* sixth(Kind kind) noexcept;
namespace inner { void seventh(); }
}  // namespace firn
)");
  EXPECT_EQ(header.declared, (std::set<std::string>{"first", "second", "sixth", "seventh"}));
  EXPECT_TRUE(header.defined.empty());
  const FreeFunctions source = free_functions(R"(
namespace firn {
namespace {
int hidden() { return 1; }
const std::map<int, int> table = {{1, 2}};
}  // namespace
std::vector<std::pair<int, int>> first(const Point& p, int n) { if (n) { return {}; } return {}; }
Shape::Shape(int n) : n_{n}, m_(2) {}
int Shape::member() { return 'a' == '}' ? 1 : 2; }
const char* sixth(Kind kind) noexcept { return "}{ not code"; }
void inner::seventh() {}
static int local() { return 2; }
}  // namespace firn
)");
  EXPECT_EQ(source.defined, (std::set<std::string>{"first", "seventh", "sixth"}));
}

}  // namespace
}  // namespace firn::cli
