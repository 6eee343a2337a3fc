#include "experiments/text/suggestions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace firn {
namespace {

TEST(Suggestions, EditDistanceCountsCaseHalf) {
  EXPECT_EQ(edit_distance("size", "size"), 0);
  EXPECT_EQ(edit_distance("sise", "size"), 2);
  EXPECT_EQ(edit_distance("Size", "size"), 1);
  EXPECT_EQ(edit_distance("", "abc"), 6);
  EXPECT_EQ(edit_distance("densty", "density"), 2);
}

TEST(Suggestions, NameTheLikelyKey) {
  const std::vector<std::string_view> keys = {"static_friction",  "dynamic_friction",
                                              "restitution",      "rolling_resistance",
                                              "restick_velocity", "shape"};
  for (const auto& [word, wanted] : {std::pair{"friction", "static_friction"},
                                     {"static_frction", "static_friction"},
                                     {"restituton", "restitution"},
                                     {"velocity", "restick_velocity"},
                                     {"rolling", "rolling_resistance"},
                                     {"shapes", "shape"},
                                     {"dynamic_frction", "dynamic_friction"}})
    EXPECT_EQ(nearest(word, keys), wanted) << word;
  // A whole part says more than two edits, one edit more than a part.
  EXPECT_EQ(nearest("unit", {"united", "length_unit"}), "length_unit");
  EXPECT_EQ(nearest("unite", {"unite_unit", "united", "length_unite"}), "united");
  // Words of other programs.
  const std::vector<std::string_view> mesh = {"kind", "material", "mass", "file", "length_unit"};
  EXPECT_EQ(nearest("units", mesh), "length_unit");
  EXPECT_EQ(nearest("mesh", mesh), "file");
  EXPECT_EQ(nearest("mu", keys), "static_friction");
  EXPECT_EQ(nearest("cor", keys), "restitution");
  // Where the key that means it is none of the table, and words without anything in common.
  for (const char* word : {"mu", "budget", "", "x"}) EXPECT_EQ(nearest(word, mesh), std::nullopt);
  EXPECT_EQ(suggestion("budget", mesh), "expected one of kind, material, mass, file, length_unit");
  EXPECT_EQ(suggestion("mas", mesh), "did you mean \"mass\"?");
  EXPECT_EQ(suggestion("budget", std::vector<std::string_view>(50, "key")).substr(0, 26),
            "expected one of key, key, ");
  EXPECT_THAT(suggestion("budget", std::vector<std::string_view>(50, "key")),
              testing::EndsWith(", key, ..."));
}

}  // namespace
}  // namespace firn
