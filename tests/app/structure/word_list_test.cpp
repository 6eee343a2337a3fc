// The words of word_list.txt are avoided in code, messages and pages: their number may only
// decrease.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

const fs::path project_dir = FIRN_SOURCE_DIR;
// Files in the root folder.
constexpr const char* kPages = "pages";
const std::vector<std::string> areas = {"app",    "calibrate",  "cases",       "cmake",   "data",
                                        "docs",   "examples",   "experiments", "library", "photo",
                                        "python", "reports",    "scripts",     "solver",  "tests",
                                        "tools",  "validation", kPages};

// A word or phrase, and how often each area may still use it.
struct AvoidedWord {
  std::vector<std::string> words;
  std::map<std::string, int> allowed;
};

// Words as identifiers have them, in lower case.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '_')
      words.back() += static_cast<char>(std::tolower(byte));
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

// Lines "word or phrase: area count area count ..."; an area without a count has none.
std::map<std::string, AvoidedWord> read_list(std::istream& lines) {
  std::map<std::string, AvoidedWord> list;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto colon = line.find(':');
    const std::string phrase = line.substr(0, colon);
    AvoidedWord& word = list[phrase];
    word.words = words_of(phrase);
    EXPECT_FALSE(word.words.empty()) << line;
    if (colon == std::string::npos) {
      ADD_FAILURE() << line << ": no colon";
      continue;
    }
    std::istringstream counts(line.substr(colon + 1));
    std::string area;
    for (int count = 0; counts >> area >> count;) {
      EXPECT_TRUE(std::ranges::count(areas, area)) << line << ": unknown area " << area;
      word.allowed[area] = count;
    }
    EXPECT_TRUE(counts.eof()) << line;
  }
  return list;
}

// Positions in `text` at which the words of `phrase` follow each other.
int occurrences(const std::vector<std::string>& text, const std::vector<std::string>& phrase) {
  int count = 0;
  for (auto at = text.begin();; ++at, ++count) {
    at = std::search(at, text.end(), phrase.begin(), phrase.end());
    if (at == text.end()) return count;
  }
}

// The words of an identifier: k and told of kTold, asked and anew of asked_anew. In lower case.
std::vector<std::string> parts_of(const std::string& identifier) {
  std::vector<std::string> parts(1);
  for (std::size_t i = 0; i < identifier.size(); ++i) {
    const auto is = [&](std::size_t k, int (*kind)(int)) {
      return k < identifier.size() && kind(static_cast<unsigned char>(identifier[k])) != 0;
    };
    const bool follows_capital = i > 0 && is(i - 1, std::isupper);
    const bool begins = is(i, std::isupper) && (!follows_capital || is(i + 1, std::islower));
    if ((begins || identifier[i] == '_') && !parts.back().empty()) parts.emplace_back();
    if (identifier[i] != '_')
      parts.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(identifier[i])));
  }
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

// Uses of the words of the list inside longer identifiers, except those that are on the list.
std::map<std::string, int> uses_in_identifiers(const std::string& text,
                                               const std::map<std::string, AvoidedWord>& list) {
  std::map<std::string, int> uses;
  std::string identifier;
  for (const char c : text + ' ') {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
      identifier += c;
      continue;
    }
    if (identifier.empty()) continue;
    const std::vector<std::string> parts = parts_of(identifier);
    if (parts.size() > 1 && !list.contains(words_of(identifier).front())) {
      for (const std::string& part : parts)
        if (list.contains(part)) ++uses[part];
    }
    identifier.clear();
  }
  return uses;
}

// Files that may use avoided words: the glossary, the list, its test, the table of old names, and a
// recorded page of an earlier version.
bool may_use_avoided_words(const fs::path& file) {
  static const std::set<fs::path> files = {project_dir / "docs/glossary.md",
                                           project_dir / "docs/paper-report.html",
                                           project_dir / "experiments/text/toml_aliases.cpp",
                                           project_dir / "tests/app/structure/word_list.txt",
                                           project_dir / "tests/app/structure/word_list_test.cpp"};
  return files.contains(file);
}

// Hidden files and folders, and what Python makes on installation, are not part of the sources.
bool is_left_out(const fs::path& path) {
  return path.filename().string().starts_with(".") || path.filename() == "__pycache__" ||
         path.extension() == ".egg-info" || path == project_dir / "tests/fuzz/corpus";
}

// Files of an area: sources, scripts, data and pages. Those with a byte 0 are no text.
std::vector<fs::path> files_of(const std::string& area) {
  std::vector<fs::path> files;
  const auto take = [&](const fs::directory_entry& entry) {
    if (entry.is_regular_file() && !is_left_out(entry.path()) &&
        !may_use_avoided_words(entry.path()))
      files.push_back(entry.path());
  };
  if (area == kPages) {
    for (const auto& entry : fs::directory_iterator(project_dir)) take(entry);
  } else {
    fs::recursive_directory_iterator entry(project_dir / area);
    for (; entry != fs::recursive_directory_iterator(); ++entry) {
      if (is_left_out(entry->path())) entry.disable_recursion_pending();
      take(*entry);
    }
  }
  std::ranges::sort(files);
  return files;
}

TEST(WordList, AvoidedWordsOnlyDecrease) {
  std::ifstream file(project_dir / "tests/app/structure/word_list.txt");
  const auto list = read_list(file);
  ASSERT_GT(list.size(), 30u);
  std::map<std::string, std::map<std::string, int>> found;  // word, area
  std::string lower;
  std::size_t read = 0;
  for (const std::string& area : areas) {
    std::map<std::string, std::string> where;
    for (const fs::path& path : files_of(area)) {
      const std::string content = read_text(path);
      if (content.find('\0') != std::string::npos) continue;
      ++read;
      const std::vector<std::string> text = words_of(content);
      const std::set<std::string> distinct(text.begin(), text.end());
      const std::map<std::string, int> inside = uses_in_identifiers(content, list);
      for (const auto& [phrase, word] : list) {
        int count = 0;
        if (distinct.contains(word.words.front())) count = occurrences(text, word.words);
        if (const auto uses = inside.find(phrase); uses != inside.end()) count += uses->second;
        if (count == 0) continue;
        found[phrase][area] += count;
        where[phrase] += "\n  " + fs::relative(path, project_dir).string();
      }
    }
    for (const auto& [phrase, word] : list) {
      const auto allowed = word.allowed.find(area);
      const int limit = allowed == word.allowed.end() ? 0 : allowed->second;
      EXPECT_LE(found[phrase][area], limit)
          << "\"" << phrase << "\" in " << area
          << ": use the term of docs/glossary.md or rewrite the sentence" << where[phrase];
      if (found[phrase][area] < limit) lower += " \"" + phrase + "\" in " + area + ";";
    }
  }
  EXPECT_GT(read, 1000u);
  if (lower.empty()) return;
  std::cout << "word_list.txt may be lowered:" << lower << "\n";
  for (const auto& [phrase, counts] : found) {
    std::cout << phrase << ":";
    for (const auto& [area, count] : counts)
      if (count > 0) std::cout << " " << area << " " << count;
    std::cout << "\n";
  }
}

// A phrase is found across lines and case. Single words are also found in longer identifiers.
TEST(WordList, CountsPhrases) {
  const std::vector<std::string> text =
      words_of("// It GOES\n// on and goes on.\nint goes_on = kTold; untold told(told);");
  EXPECT_EQ(occurrences(text, {"goes", "on"}), 2);
  EXPECT_EQ(occurrences(text, {"told"}), 2);
  EXPECT_EQ(occurrences(text, {"ktold"}), 1);
  EXPECT_EQ(occurrences(text, {"goes_on"}), 1);
  EXPECT_EQ(parts_of("kTold"), (std::vector<std::string>{"k", "told"}));
  EXPECT_EQ(parts_of("readHTMLPage_2"), (std::vector<std::string>{"read", "html", "page", "2"}));
  const std::map<std::string, AvoidedWord> list = {{"told", {}}, {"k_told", {}}, {"tell", {}}};
  EXPECT_EQ(uses_in_identifiers("told kTold k_told WhoTold tell_all retell", list),
            (std::map<std::string, int>{{"tell", 1}, {"told", 2}}));
}

}  // namespace
}  // namespace firn::cli
