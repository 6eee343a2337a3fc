#include "experiments/system/terminal.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace firn {
namespace {

TEST(ProgressBar, IsFilledForItsShare) {
  EXPECT_EQ(progress_bar(0, 4), "[    ]");
  EXPECT_EQ(progress_bar(0.5, 4), "[==  ]");
  EXPECT_EQ(progress_bar(1, 4), "[====]");
  EXPECT_EQ(progress_bar(7, 4), "[====]");
  EXPECT_EQ(progress_bar(-7, 4), "[    ]");
}

TEST(FitColumns, NeverExceedsThemAndKeepsCharacters) {
  EXPECT_EQ(fit_columns("short", 79), "short");
  EXPECT_EQ(fit_columns("12345", 5), "12345");
  EXPECT_EQ(fit_columns("123456", 5), "1234…");
  EXPECT_EQ(fit_columns("äöüäöü", 4), "äöü…");
  EXPECT_EQ(fit_columns("漢字漢字", 5), "漢字…");
  EXPECT_EQ(fit_columns("abc", 0), "");
  std::mt19937 random(5);
  const std::vector<std::string> letters = {"a", "é", "漢", "😀", " "};
  for (int i = 0; i < 2000; ++i) {
    std::string text;
    std::vector<int> widths;
    for (std::size_t n = random() % 12; n > 0; --n) {
      const std::size_t k = random() % letters.size();
      text += letters[k];
      widths.push_back(k == 2 || k == 3 ? 2 : 1);
    }
    const std::size_t columns = random() % 14;
    const std::string cut = fit_columns(text, columns);
    if (cut == text) continue;
    if (columns == 0) {
      EXPECT_EQ(cut, "");
      continue;
    }
    ASSERT_TRUE(cut.ends_with("…")) << text;
    const std::string kept = cut.substr(0, cut.size() - 3);
    EXPECT_TRUE(text.starts_with(kept));
    std::size_t used = 1, at = 0;
    for (const int w : widths) {
      const std::size_t lead = static_cast<unsigned char>(text[at]);
      if (at >= kept.size()) break;
      at += lead < 0x80 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
      used += static_cast<std::size_t>(w);
    }
    EXPECT_EQ(at, kept.size()) << "a character is cut";
    EXPECT_LE(used, columns) << text;
  }
}

}  // namespace
}  // namespace firn
