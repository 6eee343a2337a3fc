// Lines of values in JSON texts, and in messages about them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "experiments/text/json_aliases.h"
#include "experiments/text/json_fields.h"
#include "experiments/text/json_parser.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

using JsonPath = std::vector<std::string>;

// A random text, and the line of each value in it.
class RandomJson {
 public:
  explicit RandomJson(unsigned seed) : random_(seed) { value({}, 0); }

  std::string text;
  std::vector<std::pair<JsonPath, std::size_t>> lines;

 private:
  std::size_t below(std::size_t n) { return random_() % n; }

  void blanks() {
    for (std::size_t n = below(3); n > 0; --n) {
      const char blank = " \t\n\r"[below(4)];
      text += blank;
      line_ += blank == '\n' ? 1 : 0;
    }
  }

  // A key that the object does not have: its name in the text and its current name.
  std::pair<std::string, std::string> key(std::set<std::string>& used) {
    static const std::vector<std::string> words = {"a",         "b/c", "~0",   "0",    "1",
                                                   "two words", "ä",   "\\\\", "\\\"", ""};
    static const std::vector<std::string> plain = {"a",         "b/c", "~0", "0",  "1",
                                                   "two words", "ä",   "\\", "\"", ""};
    while (true) {
      const std::size_t word = below(words.size());
      const JsonAlias& alias = renamed_json_keys()[below(renamed_json_keys().size())];
      const bool old = below(3) == 0;
      const std::string written = old ? std::string(alias.old_name) : words[word];
      const std::string current = old ? std::string(alias.name) : plain[word];
      if (used.contains(written) || used.contains(current)) continue;
      used.insert({written, current});
      return {written, current};
    }
  }

  void value(const JsonPath& path, std::size_t depth) {
    blanks();
    lines.emplace_back(path, line_);
    const std::size_t kind = below(depth == 0 ? 2 : depth > 3 ? 3 : 7);
    if (depth > 3 || kind > 3) {
      static const std::vector<std::string> scalars = {
          "1", "-2.5e3", "\"a\\n{[\"", "true", "null", "\"\"", "18446744073709551615"};
      text += scalars[below(scalars.size())];
    } else if (kind % 2 == 0) {
      list(path, depth);
    } else {
      object(path, depth);
    }
    blanks();
  }

  void list(JsonPath path, std::size_t depth) {
    text += '[';
    blanks();
    path.emplace_back();
    const std::size_t count = below(5);
    for (std::size_t i = 0; i < count; ++i) {
      path.back() = std::to_string(i);
      value(path, depth + 1);
      if (i + 1 < count) text += ',';
    }
    text += ']';
  }

  void object(JsonPath path, std::size_t depth) {
    text += '{';
    blanks();
    path.emplace_back();
    std::set<std::string> used;
    const std::size_t count = below(5);
    for (std::size_t i = 0; i < count; ++i) {
      blanks();
      const auto [written, current] = key(used);
      text += '"' + written + "\"";
      blanks();
      text += ':';
      path.back() = current;
      value(path, depth + 1);
      if (i + 1 < count) text += ',';
    }
    text += '}';
  }

  std::mt19937 random_;
  std::size_t line_ = 1;
};

TEST(JsonPlace, IsTheLineOfEveryValueOfRandomTexts) {
  std::size_t values = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const RandomJson random(seed);
    ASSERT_TRUE(nlohmann::ordered_json::accept(random.text)) << random.text;
    for (const auto& [path, line] : random.lines) {
      const std::string place = "x.json:" + std::to_string(line);
      EXPECT_EQ(json_place("x.json", random.text, path), place)
          << testing::PrintToString(path) << " in " << random.text;
      JsonPath lacking = path;
      lacking.insert(lacking.end(), {"absent", "0"});
      EXPECT_EQ(json_place("x.json", random.text, lacking), place)
          << testing::PrintToString(lacking) << " in " << random.text;
    }
    values += random.lines.size();
  }
  EXPECT_GT(values, 1000u);
  EXPECT_EQ(json_place("x.json", "", {"a"}), "x.json");
}

struct Weighing {
  std::string name;
  std::vector<std::pair<double, double>> ranges;
  template <class Fields>
  void fields(Fields& f) {
    f.required("name", name);
    f.added("ranges", ranges);
  }
};
struct Weighings {
  std::vector<Weighing> weighings;
  template <class Fields>
  void fields(Fields& f) {
    f.required("weighings", weighings);
  }
};

// A list of weighings on separate lines, one of them wrong.
TEST(JsonPlace, OfAMistakeIsInTheMessage) {
  struct Mistake {
    std::string weighing;    // without braces
    std::size_t line;        // within it, from 0
    std::string key, words;  // behind the path of the weighing
  };
  const std::vector<Mistake> mistakes = {
      {"\n\"name\": 3\n", 1, ".name", "is 3; expected a text"},
      {"\n\n\"ranges\": [\n]", 0, ".name", "missing; expected this key"},
      {"\"name\": \"a\",\n\n\"rnges\": 1", 2, "",
       "unknown key \"rnges\"; did you mean \"ranges\"?"},
      {"\"name\": \"a\",\n\"ranges\":\n[[1, 2],\n[1,\nnull]]", 4, ".ranges.1.1",
       "is null; expected a number"},
      {"\"name\": \"a\",\n\"ranges\": [[1, 2],\n\n[1, 2, 3]]", 3, ".ranges.1",
       "is a list of 3; expected a list of 2"}};
  std::mt19937 random(3);
  for (int member = 0; member < 50; ++member) {
    const Mistake& mistake = mistakes[random() % mistakes.size()];
    const std::size_t count = 1 + random() % 6, wrong = random() % count;
    std::string text = "{\"weighings\": [";
    std::size_t line = 1, expected = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string gap(random() % 3, '\n');
      if (i == wrong) expected = line + gap.size() + mistake.line;
      const std::string weighing =
          gap + "{" + (i == wrong ? mistake.weighing : "\"name\": \"a\"") + "}";
      line += static_cast<std::size_t>(std::ranges::count(weighing, '\n'));
      text += weighing + (i + 1 < count ? "," : "]}");
    }
    const std::string message = test::error_of([&] {
      document_from_json<Weighings>(parse_json(text, "x.json"), "x.json", JsonReading::strict,
                                    text);
    });
    EXPECT_EQ(message, "x.json:" + std::to_string(expected) + ": weighings." +
                           std::to_string(wrong) + mistake.key + ": " + mistake.words)
        << text;
  }
}

}  // namespace
}  // namespace firn
