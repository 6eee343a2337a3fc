// Cases of the drained angle of repose.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/experiments/case_reader/two_cubes_case.h"
#include "tests/support/read_text.h"

namespace firn {
namespace {

using two_cubes::error_of;
using two_cubes::read;

class DrainedReposeCase : public testing::Test {
 protected:
  static std::string shipped() {
    return test::read_text(FIRN_SOURCE_DIR "/cases/drained_repose/case.toml");
  }
  static std::string error_of_set(const std::string& text) {
    return error_of(shipped(), {parse_override(text)});
  }
};

TEST_F(DrainedReposeCase, BuildsTheBox) {
  const Case c = read(shipped());
  ASSERT_TRUE(c.drained_repose);
  const double length = 23.5 * 0.0254, depth = 5.5 * 0.0254, door = 5.75 * 0.0254;
  EXPECT_TRUE(c.drained_repose->box.isApprox(Vec3(length, depth, 12.4 * 0.0254)));
  EXPECT_DOUBLE_EQ(c.drained_repose->door_width, door);
  EXPECT_EQ(c.model.particles.size(), 880u);
  EXPECT_NEAR(c.model.shapes[0].mass, 13.7e-3, 1e-9);
  std::vector<std::string> names;
  for (const Boundary& b : c.model.boundaries) names.push_back(b.name);
  EXPECT_EQ(names, (std::vector<std::string>{"wall left", "wall right", "wall front", "wall back",
                                             "floor left", "floor right", "door"}));
  // Walls face inwards at the sides of the box.
  const Boundary& left = c.model.boundaries[0];
  EXPECT_TRUE(left.origin.isApprox(Vec3(-length / 2, 0, 0)));
  EXPECT_TRUE((left.orientation * Vec3::UnitZ()).isApprox(Vec3::UnitX()));
  // Floor and door are flush at z = 0 and meet at the lips.
  double floor_end = -1, door_start = 1;
  for (const std::size_t i : {4u, 6u}) {
    const Boundary& b = c.model.boundaries[i];
    double top = -1;
    for (const Vec3& v : b.mesh.vertices) {
      top = std::max(top, (b.origin + v).z());
      if (i == 4) floor_end = std::max(floor_end, (b.origin + v).x());
      if (i == 6) door_start = std::min(door_start, (b.origin + v).x());
    }
    EXPECT_NEAR(top, 0, 1e-15);
  }
  EXPECT_NEAR(floor_end, -door / 2, 1e-15);
  EXPECT_NEAR(door_start, -door / 2, 1e-15);
  ASSERT_EQ(c.stages.size(), 2u);
  EXPECT_EQ(c.stages[0].name, "fill");
  EXPECT_EQ(c.stages[1].name, "drain");
  EXPECT_EQ(c.stages[1].remove, std::vector<std::string>{"door"});
  ASSERT_EQ(c.outlets.size(), 1u);
  EXPECT_LT(c.outlets[0].point.z(), -c.drained_repose->floor_thickness);
  ASSERT_EQ(c.fills.size(), 1u);
  EXPECT_EQ(c.fills[0].velocity, Vec3(0, 0, -0.5));
  EXPECT_EQ(read(c.resolved).resolved, c.resolved);
}

TEST_F(DrainedReposeCase, DoorsThatMove) {
  const auto opened = [](const std::string& opening) {
    return read(shipped(),
                {{"experiment.door_opening", opening}, {"experiment.door_speed", "2 m/s"}});
  };
  const Case dropped = opened("drop");
  const Stage drop = dropped.stages.at(1), slide = opened("slide").stages.at(1);
  EXPECT_TRUE(drop.remove.empty());
  EXPECT_EQ(dropped.model.boundaries.at(drop.motions.at(0).boundary).name, "door");
  EXPECT_EQ(drop.motions.at(0).motion.velocity, Vec3(0, 0, -2));
  // A sliding door stops once it is out of the box: depth and overhangs of the floor at 2 m/s.
  EXPECT_EQ(slide.motions.at(0).motion.velocity, Vec3(0, 2, 0));
  EXPECT_NEAR(slide.motions.at(0).motion.stop, (5.5 * 0.0254 + 0.02) / 2, 1e-12);
  EXPECT_EQ(error_of_set("experiment.door_speed=1 m/s"),
            "--set experiment.door_speed=1 m/s: experiment.door_speed: has no meaning for a door "
            "that vanishes; expected door_opening = \"drop\" or \"slide\" with it");
}

TEST_F(DrainedReposeCase, ImpossibleSetupsNameTheirNumbers) {
  EXPECT_EQ(error_of_set("experiment.door_width=24 in"),
            "--set experiment.door_width=24 in: experiment.door_width: is 0.6096 m, not narrower "
            "than the box of 0.5969 m; expected a door with a ledge on both sides");
  EXPECT_EQ(error_of_set("experiment.fill.count=0"),
            "--set experiment.fill.count=0: experiment.fill.count: is the bare number 0; expected "
            "a whole number of at least 1");
  EXPECT_EQ(error_of_set("experiment.fill.count=1200"),
            "--set experiment.fill.count=1200: experiment.fill.count: is 1200: 17.93 L of \"cube\" "
            "do not fit a box of 26.26 L, of which a bed can fill 64 % at most; expected at most "
            "1124");
  const std::string text = shipped();
  const auto line = 1 + std::count(text.begin(), text.begin() + text.find("count = 880"), '\n');
  EXPECT_EQ(error_of_set("experiment.fill.pour_height=0.3 m"),
            fmt::format("c.toml:{}: experiment.fill.count: 880 of \"cube\" at once (60.96 x 20.57 "
                        "x 17.81 mm, 13.15 L in all) do not "
                        "fit a region of 0.5969 x 0.1397 x 0.3 m, of which random placement fills "
                        "30 % at most (7.505 L); expected fewer or a larger region",
                        line));
  EXPECT_EQ(error_of_set("experiment.end_margin=210 mm"),
            "--set experiment.end_margin=210 mm: experiment.end_margin: leaves nothing to fit a "
            "line to: the margins of 0.21 m and 0.025 m meet on the ledge of 0.2254 m; expected "
            "smaller margins");
  // A window narrower than two cubes has no angle: known before the run.
  EXPECT_EQ(error_of_set("experiment.end_margin=170 mm"),
            "--set experiment.end_margin=170 mm: experiment.end_margin: leaves 0.03042 m of the "
            "ledge of 0.2254 m to fit a line to, less than two particle sizes (0.04115 m, shape "
            "\"cube\"); expected smaller margins, a longer box or a narrower door");
  EXPECT_EQ(error_of_set("experiment.fill.shape=cub"),
            "--set experiment.fill.shape=cub: experiment.fill.shape: unknown shape \"cub\"; did "
            "you mean \"cube\"?");
  EXPECT_EQ(error_of_set("experiment.dor_width=1 in"),
            "--set experiment.dor_width=1 in: experiment.dor_width: unknown key; did you mean "
            "\"door_width\"?");
  EXPECT_EQ(error_of_set("experiment.kind=drained"),
            "--set experiment.kind=drained: experiment.kind: is \"drained\"; expected one of "
            "drained_repose");
}

}  // namespace
}  // namespace firn
