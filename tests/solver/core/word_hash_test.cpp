// Stored checkpoints and traces hold these hashes: they may not change.
#include "firn/word_hash.h"

#include <gtest/gtest.h>

#include <string>

namespace firn {
namespace {

TEST(WordHash, KeepsItsValues) {
  EXPECT_EQ(hash_word(kWordHashStart, 1), 0xaf63bc49fd1c5448u);
  const std::string text = "contact history";  // two words, the last one padded
  EXPECT_EQ(hash_words(kWordHashStart, text.data(), text.size()), 0x90da9882a6331f51u);
  EXPECT_EQ(hash_words(kWordHashStart, text.data(), 0), kWordHashStart);
}

TEST(WordHash, PadsWithZeros) {
  const std::string padded("contact history\0", 16);
  EXPECT_EQ(hash_words(kWordHashStart, padded.data(), 15),
            hash_words(kWordHashStart, padded.data(), 16));
}

}  // namespace
}  // namespace firn
