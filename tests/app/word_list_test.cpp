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

const fs::path source_dir = FIRN_SOURCE_DIR;
// Pages in the root folder.
constexpr const char* kPages = "pages";
const std::vector<std::string> areas = {"app",    "calibrate",   "cases", "cmake",      "data",
                                        "docs",   "experiments", "photo", "reports",    "scripts",
                                        "solver", "tests",       "tools", "validation", kPages};

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

// Sources, scripts, shipped TOML files and pages of an area. The glossary and the table of old
// names contain avoided words.
std::vector<fs::path> files_of(const std::string& area) {
  static const std::set<std::string> extensions = {".h",  ".cpp", ".js", ".css", ".cmake",
                                                   ".md", ".py",  ".sh", ".toml"};
  std::vector<fs::path> files;
  const auto take = [&](const fs::path& file) {
    const bool fuzzed = file.string().find("/tests/fuzz/") != std::string::npos &&
                        file.extension() != ".h" && file.extension() != ".cpp";
    const bool lists = file == source_dir / "docs/glossary.md" ||
                       file == source_dir / "experiments/text/toml_aliases.cpp" ||
                       file == source_dir / "tests/app/word_list_test.cpp";
    if (!fuzzed && !lists &&
        (extensions.contains(file.extension()) || file.filename() == "CMakeLists.txt"))
      files.push_back(file);
  };
  if (area == kPages) {
    for (const auto& entry : fs::directory_iterator(source_dir))
      if (entry.path().extension() == ".md") take(entry.path());
  } else {
    for (const auto& entry : fs::recursive_directory_iterator(source_dir / area))
      if (entry.is_regular_file()) take(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

TEST(WordList, AvoidedWordsOnlyDecrease) {
  std::ifstream file(source_dir / "tests/app/word_list.txt");
  const auto list = read_list(file);
  ASSERT_GT(list.size(), 30u);
  std::map<std::string, std::map<std::string, int>> found;  // word, area
  std::string lower;
  std::size_t read = 0;
  for (const std::string& area : areas) {
    std::map<std::string, std::string> where;
    for (const fs::path& path : files_of(area)) {
      ++read;
      const std::vector<std::string> text = words_of(read_text(path));
      const std::set<std::string> distinct(text.begin(), text.end());
      for (const auto& [phrase, word] : list) {
        if (!distinct.contains(word.words.front())) continue;
        const int count = occurrences(text, word.words);
        if (count == 0) continue;
        found[phrase][area] += count;
        where[phrase] += "\n  " + fs::relative(path, source_dir).string();
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
  EXPECT_GT(read, 700u);
  if (lower.empty()) return;
  std::cout << "word_list.txt may be lowered:" << lower << "\n";
  for (const auto& [phrase, counts] : found) {
    std::cout << phrase << ":";
    for (const auto& [area, count] : counts)
      if (count > 0) std::cout << " " << area << " " << count;
    std::cout << "\n";
  }
}

// A phrase is found across lines and case, and not inside of longer identifiers.
TEST(WordList, CountsPhrases) {
  const std::vector<std::string> text =
      words_of("// It GOES\n// on and goes on.\nint goes_on = kTold; untold told(told);");
  EXPECT_EQ(occurrences(text, {"goes", "on"}), 2);
  EXPECT_EQ(occurrences(text, {"told"}), 2);
  EXPECT_EQ(occurrences(text, {"ktold"}), 1);
  EXPECT_EQ(occurrences(text, {"goes_on"}), 1);
}

}  // namespace
}  // namespace firn::cli
