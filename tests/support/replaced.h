#pragma once

#include <gtest/gtest.h>

#include <string>

namespace firn::test {

// `text` with `to` in place of the first `from`, which the test expects to be there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace firn::test
