#include "experiments/meshes/length_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firn/math.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kMillimeter = 1e-3, kInch = 25.4e-3;

TEST(LengthUnit, UsualSizesNeedNoAdvice) {
  for (const double edge : {4e-3, 0.03, 0.2})
    for (const double unit : {kMillimeter, kInch, 1.0})
      EXPECT_EQ(length_unit_warning(edge, unit, MeshUse::particle), "");
  for (const double edge : {0.01, 0.3, 5.0})
    EXPECT_EQ(length_unit_warning(edge, kMillimeter, MeshUse::boundary), "");
}

TEST(LengthUnit, ALumpOfAnotherUnitIsNamed) {
  // 1.24 in, read in mm.
  EXPECT_EQ(
      length_unit_warning(1.24e-3, kMillimeter, MeshUse::particle),
      "the longest edge is 1.24 mm in this unit, 12.4 mm in \"cm\", 31.5 mm in \"in\": check the "
      "unit");
  // 56 mm, read in in and in m.
  const std::string mm = ", 56 mm in \"mm\": check the unit";
  EXPECT_THAT(length_unit_warning(56 * kInch, kInch, MeshUse::particle),
              HasSubstr("is 1422 mm in this unit" + mm));
  EXPECT_THAT(length_unit_warning(56, 1, MeshUse::particle), HasSubstr(mm));
  EXPECT_THAT(length_unit_warning(0.3e-3, kMillimeter, MeshUse::boundary),
              HasSubstr("300 mm in \"m\""));
  // The unit that is given is not proposed, nor is one that fits no better.
  EXPECT_THAT(length_unit_warning(56, 1, MeshUse::particle), Not(HasSubstr("in \"m\"")));
  EXPECT_EQ(length_unit_warning(1e-9, kMillimeter, MeshUse::particle), "");
}

TEST(LengthUnit, NamesThatAreNoneAreRefused) {
  EXPECT_DOUBLE_EQ(parse_length_unit("mm"), kMillimeter);
  EXPECT_DOUBLE_EQ(parse_length_unit("inch"), kInch);
  for (const char* name : {"milimeter", "kg", "", "2 mm", "s"})
    EXPECT_THROW(parse_length_unit(name), InputError) << name;
}

}  // namespace
}  // namespace firn
