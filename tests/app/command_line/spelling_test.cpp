// Misspelled sub-commands, options and values: one line with the word that was most likely meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "experiments/text/suggestions.h"
#include "tests/app/command_line/help_text.h"
#include "tests/app/program.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

// A letter of the word replaced, inserted, or left out.
std::string with_an_edit(std::string word, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  const char letter = static_cast<char>('a' + below(26));
  switch (below(3)) {
    case 0:
      word[below(word.size())] = letter;
      break;
    case 1:
      word.insert(word.begin() + static_cast<std::ptrdiff_t>(below(word.size() + 1)), letter);
      break;
    default:
      word.erase(below(word.size()), 1);
  }
  return word;
}

// Edits of the word that are no known words themselves.
std::vector<std::string> misspellings(const std::string& word,
                                      const std::vector<std::string>& known, int count,
                                      std::mt19937_64& random) {
  std::vector<std::string> all;
  while (count > 0) {
    const std::string edited = with_an_edit(word, random);
    if (edited.empty() || edited.starts_with('-') || std::ranges::count(known, edited) > 0)
      continue;
    all.push_back(edited);
    --count;
  }
  return all;
}

// The word in `did you mean "WORD"?`; empty: the message has none.
std::string suggested_word(const std::string& message) {
  const std::string before = "did you mean \"";
  const std::size_t from = message.find(before), to = message.find("\"?", from);
  if (from == std::string::npos || to == std::string::npos) return "";
  return message.substr(from + before.size(), to - from - before.size());
}

// One line about `word` that suggests one of `known` at most one edit away.
void expect_suggestion(const Outcome& o, const std::string& word,
                       const std::vector<std::string>& known) {
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr(word));
  const std::string suggested = suggested_word(o.err);
  EXPECT_EQ(std::ranges::count(known, suggested), 1) << o.err;
  EXPECT_LE(edit_distance(suggested, word), 2) << o.err;  // in half steps
}

std::vector<std::string> names_of(const std::vector<HelpEntry>& entries) {
  std::vector<std::string> names;
  names.reserve(entries.size());
  for (const HelpEntry& entry : entries) names.push_back(entry.name);
  return names;
}

TEST(Spelling, OfSubCommands) {
  std::mt19937_64 random(1);
  const Folder folder;
  int tried = 0;
  for (const std::vector<std::string>& command : all_commands(folder)) {
    const std::vector<std::string> subs =
        names_of(help_entries(help_of(folder, command), "Subcommands"));
    for (const std::string& sub : subs)
      for (const std::string& wrong : misspellings(sub, subs, 4, random)) {
        std::vector<std::string> words = command;
        words.push_back(wrong);
        if (tried % 2 == 0) words.insert(words.end(), {"some.toml", "--json"});
        expect_suggestion(folder.firn(words), wrong, subs);
        ++tried;
      }
  }
  EXPECT_GT(tried, 80);
  EXPECT_THAT(folder.firn({"calibarte", "study.toml"}).err,
              HasSubstr("calibarte: no such sub-command; did you mean \"calibrate\"?"));
  EXPECT_THAT(folder.firn({"materials", "lsit"}).err,
              HasSubstr("no such sub-command of firn materials; did you mean \"list\"?"));
  EXPECT_THAT(folder.firn({"materials", "qqqqqqqq"}).err, HasSubstr("expected one of list, show"));
}

TEST(Spelling, OfLongOptions) {
  std::mt19937_64 random(2);
  const Folder folder;
  int tried = 0;
  for (const std::vector<std::string>& command : all_commands(folder)) {
    const std::string help = help_of(folder, command);
    const bool takes_arguments = !help_entries(help, "Positionals").empty();
    std::vector<std::string> options;
    for (const std::string& name : names_of(help_entries(help, "Options")))
      if (name.starts_with("--")) options.push_back(name);
    EXPECT_THAT(options, testing::Contains("--help")) << testing::PrintToString(command);
    std::vector<std::string> known;
    known.reserve(options.size());
    for (const std::string& option : options) known.push_back(option.substr(2));
    for (const std::string& option : known)
      for (const std::string& wrong : misspellings(option, known, 2, random)) {
        std::vector<std::string> words = command;
        if (tried % 2 == 0 && takes_arguments) words.emplace_back("some.toml");
        words.push_back("--" + wrong + (tried % 3 == 0 ? "=5" : ""));
        if (tried % 3 == 1 && takes_arguments) words.emplace_back("5");
        expect_suggestion(folder.firn(words), "--" + wrong, options);
        ++tried;
      }
  }
  EXPECT_GT(tried, 150);
  EXPECT_THAT(folder.firn({"sweep", "a.toml", "--job", "3"}).err,
              HasSubstr("--job: unknown option of firn sweep; did you mean \"--jobs\"?"));
  // The option that is missing for it is not what the message is about.
  EXPECT_THAT(folder.firn({"export", "run.h5", "--too", "csv"}).err, HasSubstr("\"--to\"?"));
  EXPECT_THAT(folder.firn({"calibrate", "a.toml", "--svae", "n", "--note", "x"}).err,
              HasSubstr("\"--save\"?"));
  // A part of a name is enough.
  EXPECT_THAT(folder.firn({"shape", "a.stl", "--unit", "cm"}).err, HasSubstr("\"--length-unit\"?"));
  EXPECT_THAT(folder.firn({"run", "a.toml", "--qqqqqqqqq"}).err,
              HasSubstr("--qqqqqqqqq: unknown option of firn run; see `firn run --help`"));
}

TEST(Spelling, OfValues) {
  std::mt19937_64 random(3);
  const Folder folder;
  int options = 0;
  for (const std::vector<std::string>& command : all_commands(folder))
    for (const HelpEntry& option : help_entries(help_of(folder, command), "Options")) {
      const std::vector<std::string> values = values_of(option);
      if (values.empty()) continue;
      ++options;
      for (const std::string& value : values)
        for (const std::string& wrong : misspellings(value, values, 3, random)) {
          std::vector<std::string> words = command;
          words.insert(words.end(), {"some.toml", option.name, wrong});
          expect_suggestion(folder.firn(words), wrong, values);
        }
      std::vector<std::string> words = command;
      words.insert(words.end(), {"some.toml", option.name, "qqqqqqqq"});
      EXPECT_THAT(folder.firn(words).err, HasSubstr("expected one of " + values[0]));
    }
  EXPECT_GE(options, 10);
}

TEST(Spelling, OfTemplates) {
  std::mt19937_64 random(4);
  const Folder folder;
  std::istringstream list(folder.firn({"new", "--list"}).out);
  std::vector<std::string> templates;
  for (std::string line; std::getline(list, line);)
    templates.push_back(line.substr(0, line.find(' ')));
  ASSERT_GE(templates.size(), 5u);
  for (const std::string& name : templates)
    for (const std::string& wrong : misspellings(name, templates, 4, random))
      expect_suggestion(folder.firn({"new", "fresh", "--from", wrong}), wrong, templates);
  EXPECT_FALSE(folder.contains("fresh"));
}

// A value may look like an option, and behind "--" everything is an argument.
TEST(Spelling, IsThatOfOptionsAlone) {
  const Folder folder;
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"run", "nowhere.toml", "--set", "--sed"},
           {"run", "nowhere.toml", "-o", "--sed", "--threads", "x"},
           {"calibrate", "nowhere.toml", "--save", "n", "--note", "--nota", "--jobs", "x"},
           {"shape", "--", "--boundry"},
           {"materials", "show", "--database", "--databse", "--", "--jsn"}})
    EXPECT_THAT(folder.firn(words).err, Not(HasSubstr("unknown option")))
        << testing::PrintToString(words);
}

TEST(HelpTexts, EveryOptionSaysWhatItDoes) {
  const Folder folder;
  int entries = 0;
  for (const std::vector<std::string>& command : all_commands(folder))
    for (const char* section : {"Options", "Positionals"})
      for (const HelpEntry& entry : help_entries(help_of(folder, command), section)) {
        std::istringstream text(entry.text);
        int words = 0;
        for (std::string word; text >> word;) ++words;
        EXPECT_GE(words, 3) << testing::PrintToString(command) << ' ' << entry.name << ": "
                            << entry.text;
        ++entries;
      }
  EXPECT_GT(entries, 120);
}

}  // namespace
}  // namespace firn::cli
