// Text in other languages: each function against a reader of its language, with random text.
#include "experiments/system/text_encoding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "experiments/system/process.h"
#include "experiments/text/csv/csv_reader.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Text of characters that mean something somewhere, and of random bytes.
std::vector<std::string> random_texts(std::size_t count, unsigned seed) {
  const std::vector<std::string> pieces = {"\"",
                                           "'",
                                           "`",
                                           "\\",
                                           "<",
                                           ">",
                                           "&",
                                           "=",
                                           "+",
                                           "-",
                                           "@",
                                           ",",
                                           ";",
                                           "\n",
                                           "\r",
                                           "\t",
                                           "|",
                                           "$",
                                           "{",
                                           "}",
                                           "%",
                                           "#",
                                           "]]>",
                                           "-->",
                                           "</script>",
                                           "0",
                                           "1",
                                           "e5",
                                           ".",
                                           "..",
                                           "/",
                                           "a",
                                           " ",
                                           "\x1b",
                                           "\xc3\xa4",
                                           "\xe2\x80\xae",
                                           "\x7f",
                                           "\xc2\x85",
                                           "\xff",
                                           "\xed\xa0\x80",
                                           "\xf0\x9f\x98\x80",
                                           "\xef\xbb\xbf",
                                           "```"};
  std::mt19937 random(seed);
  std::vector<std::string> texts = {"", "=1+1", "-1", "+1e5", "-1+2", "@SUM(A1)", "nan", "-inf"};
  while (texts.size() < count) {
    std::string text;
    for (std::size_t n = random() % 9; n > 0; --n)
      text += random() % 8 == 0 ? std::string(1, static_cast<char>(random()))
                                : pieces[random() % pieces.size()];
    texts.push_back(text);
  }
  return texts;
}

TEST(TextEncoding, TerminalShowsWhatCannotBeSeen) {
  EXPECT_EQ(encode::terminal("a\x1b[2J\n\t\r\x07"), "a\\x1b[2J\\n\\t\\r\\x07");
  EXPECT_EQ(encode::terminal("x\xe2\x80\xaey"), "x\\u202ey");  // right-to-left override
  EXPECT_EQ(encode::terminal("\xc2\x9b"), "\\u009b");          // one-byte CSI in UTF-8
  EXPECT_EQ(encode::terminal("\xff\xc0\xaf\xed\xa0\x80"), "\\xff\\xc0\\xaf\\xed\\xa0\\x80");
  EXPECT_EQ(encode::terminal("\xf3\xa0\x81\x81"), "\\udb40\\udc41");  // a tag character
  EXPECT_EQ(encode::terminal("Größe ± 1 µm \xf0\x9f\x98\x80"), "Größe ± 1 µm \xf0\x9f\x98\x80");
  EXPECT_EQ(encode::terminal(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(encode::terminal_lines("a\n\tb\r"), "a\n\tb\\r");
}

TEST(TextEncoding, TerminalIsIdempotentAndPrintable) {
  for (const std::string& text : random_texts(3000, 1)) {
    const std::string shown = encode::terminal(text);
    EXPECT_EQ(encode::terminal(shown), shown);
    EXPECT_EQ(encode::first_unprintable(shown), "");
    EXPECT_EQ(encode::first_unprintable(text).empty(), shown == text);
    EXPECT_EQ(encode::first_control(encode::cleaned(text)), "");
    for (const char c : shown) EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20 || c == 0x7f);
  }
}

TEST(TextEncoding, MarkupHasNoMarkup) {
  EXPECT_EQ(encode::markup("<a b=\"c\" d='e'>&"), "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;");
  EXPECT_EQ(encode::markup("\x1b\xff"), "\xef\xbf\xbd\xef\xbf\xbd");
  for (const std::string& text : random_texts(3000, 2))
    EXPECT_EQ(encode::markup(text).find_first_of("<>\"'"), std::string::npos);
}

TEST(TextEncoding, MarkdownBlocksEndWhereTheyShould) {
  for (const std::string& text : random_texts(2000, 3)) {
    const std::string block = encode::markdown_block(text);
    const std::string fence = block.substr(0, block.find('\n'));
    EXPECT_GE(fence.size(), 3u);
    EXPECT_EQ(fence.find_first_not_of('`'), std::string::npos);
    const std::string inside = block.substr(fence.size(), block.size() - 2 * fence.size() - 1);
    EXPECT_EQ(inside.find(fence), std::string::npos) << block;
    EXPECT_EQ(encode::markdown(text).find_first_of("<>\n"), std::string::npos);
  }
}

TEST(TextEncoding, CsvFieldsAreReadBack) {
  const std::string file = test::scratch_path("encoded.csv");
  for (const std::string& text : random_texts(400, 4)) {
    // The reader takes lines that begin with # for remarks, even inside quotes.
    if (text.find('\0') != std::string::npos || text.find("\n#") != std::string::npos) continue;
    std::ofstream(file, std::ios::binary) << "h1,h2\nfirst," << encode::csv_field(text) << "\n";
    const std::vector<CsvRow> rows = read_csv_rows(file);
    ASSERT_EQ(rows.size(), 2u) << encode::terminal(text);
    ASSERT_EQ(rows[1].fields.size(), 2u) << encode::terminal(text);
  }
}

TEST(TextEncoding, SpreadsheetsSeeNoFormula) {
  EXPECT_EQ(encode::csv_field("=1+1"), "'=1+1");
  EXPECT_EQ(encode::csv_field("-1"), "-1");
  EXPECT_EQ(encode::csv_field("+1e5"), "+1e5");
  EXPECT_EQ(encode::csv_field("-1+cmd|' /C calc'!A0"), "'-1+cmd|' /C calc'!A0");
  EXPECT_EQ(encode::csv_field("@SUM(1,2)"), "\"'@SUM(1,2)\"");
  EXPECT_EQ(encode::csv_field("\t=1"), "\"'\t=1\"");
  EXPECT_EQ(encode::csv_field("\r\n=1"), "\"'\r\n=1\"");
  EXPECT_EQ(encode::csv_field("a\rb"), "\"a\rb\"");
  EXPECT_EQ(encode::csv_field("a;=1"), "\"a;=1\"");
  EXPECT_EQ(encode::csv_field("say \"x\""), "\"say \"\"x\"\"\"");
  for (const std::string& text : random_texts(3000, 5)) {
    std::string field = encode::csv_field(text);
    if (!field.empty() && field[0] == '"') field.erase(0, 1);
    const bool formula = !field.empty() && std::string("=+-@\t\r\n").find(field[0]) < 7;
    char* end = nullptr;
    if (formula) std::strtod(field.c_str(), &end);
    EXPECT_TRUE(!formula || *end == '\0') << encode::terminal(text);
  }
}

TEST(TextEncoding, ShellWordsAreOneWord) {
  std::vector<std::string> texts = random_texts(60, 6);
  texts.insert(texts.end(), {"$(touch MARK)", "`touch MARK`", "'; touch MARK; '", "-n", "*", "~"});
  const fs::path folder = test::scratch_path("shell words");
  fs::create_directories(folder);
  for (const std::string& text : texts) {
    if (text.find('\0') != std::string::npos) continue;
    const CommandResult r =
        run_command({"sh", "-c", "printf %s " + encode::shell_word(text)}, folder.string());
    EXPECT_EQ(r.status, 0);
    EXPECT_EQ(r.out, text) << encode::terminal(text);
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(TextEncoding, FileNamesStayInTheirFolder) {
  EXPECT_EQ(encode::file_name("two boxes"), "two-boxes");
  EXPECT_EQ(encode::file_name("../../etc/passwd"), "etc-passwd");
  EXPECT_EQ(encode::file_name(std::string(1000, 'x')).size(), 100u);
  for (const std::string& text : random_texts(3000, 7)) {
    const std::string name = encode::file_name(text);
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                     "0123456789_-"),
              std::string::npos);
    EXPECT_FALSE(name.starts_with("-"));
  }
}

}  // namespace
}  // namespace firn
