// Bodies that the seed places, [[measure]], and stages that end when everything has left.
#include "experiments/case_reader/process/measures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/case_reader/read_case.h"
#include "tests/support/bench_run.h"
#include "tests/support/error_of.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

constexpr const char* kCase = R"([case]
duration = "0.3 s"
seed = 5
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 50 mm"
grid = [3, 2, 1]
spacing = "100 200 0 mm"
position_jitter = "10 0 2 mm"
rotation_jitter = "30 deg"
tag = 4
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
normal = [0, 0, 1]
[[measure]]
kind = "sliding_onset"
boundary = "floor"
[[measure]]
kind = "rebound"
tag = 4
name = "all"
)";

Case read(const std::vector<Override>& overrides = {}) {
  return read_case_text(kCase, "c.toml", ".", overrides);
}

std::string error_of(const std::vector<Override>& overrides) {
  return test::error_of([&] { read(overrides); });
}

TEST(PlacedGrid, StandsInRowsAndScattersWithinItsHalfWidths) {
  const Case c = read();
  ASSERT_EQ(c.placed.size(), 6u);
  ASSERT_EQ(c.model.particles.size(), 6u);
  double widest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Case::InitialParticle& p = c.placed[static_cast<std::size_t>(2 * i + j)];
      EXPECT_EQ(p.particle, 2 * i + j);
      const Vec3 off = p.position - Vec3(0.1 * i, 0.2 * j, 0.05);
      EXPECT_LE(std::abs(off.x()), 10e-3);
      EXPECT_EQ(off.y(), 0);
      EXPECT_LE(std::abs(off.z()), 2e-3);
      widest = std::max(widest, std::abs(off.x()));
      const Eigen::AngleAxisd turn(p.orientation);
      EXPECT_LE(turn.angle(), 30 * 3.14159265 / 180);
      EXPECT_NEAR(std::abs(turn.axis().z()), 1, 1e-9);
    }
  }
  EXPECT_GT(widest, 2e-3);
}

TEST(PlacedGrid, TheSeedDecidesAndTheResolvedTextRemembers) {
  const Case a = read(), again = read(), b = read({{"case.seed", "6"}});
  const Case resolved = read_case_text(a.resolved, "r.toml", ".");
  EXPECT_EQ(a.placed[3].position, again.placed[3].position);
  EXPECT_EQ(a.placed[3].position, resolved.placed[3].position);
  EXPECT_EQ(a.placed[3].orientation.coeffs(), resolved.placed[3].orientation.coeffs());
  EXPECT_NE(a.placed[3].position, b.placed[3].position);
  EXPECT_EQ(a.resolved, resolved.resolved);
  // Each body draws for itself: what one table asks for leaves the places as they are.
  EXPECT_EQ(read({{"particles.0.random_orientation", "true"}}).placed[3].position,
            a.placed[3].position);
}

TEST(PlacedGrid, AnyOrientationIsUniform) {
  const Case c = read({{"particles.0.grid", "[20, 20, 1]"},
                       {"particles.0.random_orientation", "true"},
                       {"particles.0.turn", "0 deg"}});
  // The mean of 400 unit vectors without a preferred direction is shorter than 0.15 (3 sigma).
  Vec3 mean = Vec3::Zero();
  for (const Case::InitialParticle& p : c.placed) mean += p.orientation * Vec3::UnitZ() / 400;
  EXPECT_LT(mean.norm(), 0.15);
}

TEST(PlacedGrid, MistakesAreNamed) {
  EXPECT_THAT(error_of({{"particles.0.grid", "[2, 0, 1]"}}), HasSubstr("holds 0; expected three"));
  EXPECT_THAT(error_of({{"particles.0.grid", "[2, 1.5, 1]"}}), HasSubstr("whole numbers"));
  EXPECT_THAT(error_of({{"particles.0.grid", "[5000, 5000, 5000]"}}), HasSubstr("at most"));
  EXPECT_THAT(error_of({{"particles.0.scatter", "-1 0 0 mm"}}), HasSubstr("half widths"));
  EXPECT_THAT(error_of({{"particles.0.turn", "30 mm"}}), HasSubstr("an angle"));
}

TEST(Measures, AreReadWithTheirDefaults) {
  const Case c = read();
  ASSERT_EQ(c.measures.size(), 2u);
  EXPECT_EQ(c.measures[0].kind, Measure::Kind::slip);
  EXPECT_EQ(c.measures[0].slip, 2e-3);
  EXPECT_EQ(c.measures[0].run, 20e-3);
  EXPECT_FALSE(c.measures[0].tag);
  EXPECT_EQ(c.measures[1].tag, 4);
  EXPECT_EQ(c.measures[1].name, "all");
}

TEST(Measures, MistakesAreNamed) {
  EXPECT_THAT(error_of({{"measure.0.boundary", "flor"}}), HasSubstr("did you mean \"floor\"?"));
  EXPECT_THAT(error_of({{"measure.0.kind", "slipp"}}), HasSubstr("slip"));
  EXPECT_THAT(error_of({{"measure.0.run", "1 mm"}}), HasSubstr("less than the slip"));
  EXPECT_THAT(error_of({{"measure.1.tag", "9"}}), HasSubstr("no particle carries 9"));
  EXPECT_THAT(error_of({{"measure.1.name", "a/b"}}), HasSubstr("without slashes"));
  EXPECT_THAT(error_of({{"measure.1.slip", "1 mm"}}), HasSubstr("measure.all.slip"));
  EXPECT_THAT(error_of({{"case.gravity", "0 0 0 m/s^2"}}), HasSubstr("without gravity"));
  EXPECT_THAT(error_of({{"measure.1", "{ kind = \"slip\", boundary = \"floor\" }"}}),
              HasSubstr("is taken by another measure"));
  EXPECT_THAT(error_of({{"measure.1",
                         "{ kind = \"slide\", boundary = \"floor\", from = \"2 m\", "
                         "to = \"1 m\" }"}}),
              HasSubstr("not beyond the mark"));
  EXPECT_THAT(error_of({{"measure.1",
                         "{ kind = \"heap\", region_min = \"-1 0 0 m\", region_max = "
                         "\"1 1 1 m\", peak = \"0.99 m\" }"}}),
              HasSubstr("expected a line to fit on both sides"));
  EXPECT_THAT(error_of({{"measure.1",
                         "{ kind = \"heap\", region_min = \"-1 0 0 m\", region_max = "
                         "\"1 1 1 m\", peak = \"0.94 m\" }"}}),
              HasSubstr("less than two particle sizes"));
}

TEST(UntilEmpty, EndsWhenTheLastBodyHasLeft) {
  const std::vector<Override> leaving = {
      {"stages", "[{ name = \"fall\", end_when = \"empty\", max_duration = \"0.3 s\" }]"},
      {"outlets", "[{ name = \"low\", point = \"0 0 30 mm\", normal = [0, 0, -1] }]"}};
  const Case c = read(leaving);
  EXPECT_TRUE(c.stages[0].ends_on(Stage::EndEvent::empty));
  const BenchRun r = run_case(c);
  EXPECT_EQ(r.value("present_count"), 0);
  // All have fallen by 22 mm at most by then: sqrt(2 h / g) = 67 ms; 0.3 s without an end.
  const std::string file = test::scratch_path("firn-empty.h5");
  RunOptions options;
  options.results_file = file;
  const RunSummary summary = run(c, options);
  std::filesystem::remove(file);
  EXPECT_THAT(summary.reason, HasSubstr("empty"));
  EXPECT_NEAR(summary.simulated, 0.067, 0.004);
}

}  // namespace
}  // namespace firn
