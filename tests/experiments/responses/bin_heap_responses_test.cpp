#include "experiments/responses/bin_heap_responses.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "experiments/analysis/line_fit.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/bench_run.h"

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
[[particles]]                     # next to the bin
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

// The robust line over four treads of 50 mm, `rise` (m) each, in degrees: a staircase is less steep
// than its nosings.
double stairs_angle(double rise) {
  std::vector<double> x, z;
  for (int i = 0; i < 80; ++i) {
    x.push_back(2.5e-3 * (i + 0.5));
    z.push_back(rise * (i / 20 + 1));
  }
  return std::atan(theil_sen_line(x, z).slope) * kRadToDeg;
}

TEST(BinHeap, StairsHaveTheirAnglesHeightAndMass) {
  const BenchRun r = heap(1, 2);
  EXPECT_NEAR(r.value("heap_angle_left"), stairs_angle(10e-3), 0.1);
  EXPECT_NEAR(r.value("heap_angle_right"), stairs_angle(20e-3), 0.1);
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
