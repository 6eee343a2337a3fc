#include "experiments/bin_heap_responses.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/experiments/bench_run.h"

namespace firn {
namespace {

// A bin 0.4 m long whose floor lies at z = 0.5 m, with a staircase of bricks, 50 x 20 x 10 mm, up
// to its middle: `left` and `right` more layers with each of the four treads. Nothing has time to
// move.
std::string stairs(int left, int right) {
  std::string text = R"([case]
duration = "0.1 ms"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.brick]
kind = "box"
size = "49.99 19.99 9.99 mm"
material = "ice"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
point = "0 0 0.5 m"
normal = [0, 0, 1]
[[measure]]
kind = "heap"
region_min = "-200 -70 500 mm"
region_max = "200 70 800 mm"
peak = "0 mm"
peak_margin = "0 mm"
end_margin = "0 mm"
[[particles]]                     # beside the bin
shape = "brick"
position = "300 0 505 mm"
)";
  for (int tread = 1; tread <= 4; ++tread) {
    for (const auto& [sign, layers] : {std::pair{-1, left}, std::pair{1, right}}) {
      text += fmt::format(
          "[[particles]]\nshape = \"brick\"\nposition = \"{} -60 505 mm\"\n"
          "grid = [1, 7, {}]\nspacing = \"0 20 10 mm\"\n",
          sign * (225 - 50 * tread), tread * layers);
    }
  }
  return text;
}

BenchRun heap(int left, int right, const std::vector<Override>& overrides = {}) {
  return run_case(read_case_text(stairs(left, right), "stairs.toml", ".", overrides));
}

double degrees(double slope) { return std::atan(slope) * 180 / std::numbers::pi; }

TEST(BinHeap, StairsHaveTheirAnglesHeightAndMass) {
  const BenchRun r = heap(1, 2);
  // The median slope of a staircase is that of its treads' middles to within their own length.
  EXPECT_NEAR(r.value("heap_angle_left"), degrees(10.0 / 50), 0.5);
  EXPECT_NEAR(r.value("heap_angle_right"), degrees(20.0 / 50), 1);
  EXPECT_NEAR(r.value("heap_angle"), (r.value("heap_angle_left") + r.value("heap_angle_right")) / 2,
              1e-12);
  // The uppermost treads are 40 and 80 mm high, the strip sees as much of both.
  EXPECT_NEAR(r.value("heap_height"), 60e-3, 1e-3);
  EXPECT_EQ(r.value("heap_count"), 7 * 10 * 3);
  EXPECT_NEAR(r.value("heap_mass"), 210 * 49.99e-3 * 19.99e-3 * 9.99e-3 * 916.7, 1e-6);
}

TEST(BinHeap, IsMirroredWithItsBin) {
  const BenchRun r = heap(1, 2), mirrored = heap(2, 1);
  EXPECT_NEAR(r.value("heap_angle_left"), mirrored.value("heap_angle_right"), 1e-6);
  EXPECT_NEAR(r.value("heap_angle_right"), mirrored.value("heap_angle_left"), 1e-6);
}

TEST(BinHeap, AnEmptyBinHasNoAngle) {
  const BenchRun r = heap(1, 1, {{"measure.0.region_min", "-200 -70 700 mm"}});
  EXPECT_EQ(r.value("heap_count"), 0);
  EXPECT_FALSE(r.has("heap_angle"));
}

TEST(BinHeap, MarginsMustLeaveAWindow) {
  EXPECT_THROW(heap(1, 1, {{"measure.0.peak_margin", "170 mm"}}), InputError);
}

// A small pour: the responses are there, and the same when measured again.
TEST(BinHeapLong, APourIsMeasured) {
  const BenchRun r = run_bench("bin_heap/case.toml", {{"fills.0.count", "40"}});
  EXPECT_EQ(r.value("heap_count"), 40);
  EXPECT_GT(r.value("heap_height"), 20e-3);
  EXPECT_GT(r.value("heap_angle"), 0);
  ASSERT_EQ(r.responses.size(), r.measured_again.size());
  for (std::size_t i = 0; i < r.responses.size(); ++i)
    EXPECT_EQ(r.responses[i].value, r.measured_again[i].value) << r.responses[i].name;
}

}  // namespace
}  // namespace firn
