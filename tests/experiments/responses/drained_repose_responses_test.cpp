#include "experiments/responses/drained_repose_responses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/synthetic_heap.h"

namespace firn {
namespace {

using synthetic::drained_box;
using synthetic::ramp;

constexpr double kCubeSize = 20.57e-3;   // m, middle edge of the crescent's box
constexpr double kCubeVolume = 14.9e-6;  // m^3

const Response& find(const std::vector<Response>& all, const std::string& name) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Response& r) { return r.name == name; });
  if (found == all.end()) throw std::runtime_error("no response " + name);
  return *found;
}

double value(const std::vector<Response>& all, const std::string& name) {
  return find(all, name).value.at(0);
}

// A heap whose ledges carry plane ramps of 10 and 12 degrees, each one "particle".
class DrainedReposeResponses : public testing::Test {
 protected:
  DrainedReposeResponses() {
    heap.setup = drained_box();
    heap.particle_size = kCubeSize;
    heap.opened = heap.settled = true;
    heap.observed = 5;
    heap.time_resolution = 1e-5;
    add(heap.remaining, right, Vec3(0.2, 0, 0.02));
    add(heap.remaining, left, Vec3(-0.2, 0, 0.02));
    heap.filled = heap.remaining;
    for (int k = 1; k <= 100; ++k) heap.discharge_times.push_back(0.02 * k);
  }
  void add(std::vector<DrainedHeap::Particle>& to, const TriangleMesh& mesh, const Vec3& center) {
    to.push_back({{&mesh, {}}, center, 0.0137, kCubeVolume});
  }
  // A box of given size resting on nothing but what lies under it.
  void add_box(const TriangleMesh& mesh, const Vec3& center) {
    heap.remaining.push_back({{&mesh, {Mat3::Identity(), center}}, center, 0.0137, kCubeVolume});
  }
  std::vector<Response> measured() const { return drained_repose_responses(heap); }

  static TriangleMesh mirrored(TriangleMesh mesh) {
    for (Vec3& v : mesh.vertices) v.x() = -v.x();
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
  }
  TriangleMesh right = ramp(std::tan(10 * kDegToRad), 0, 15e-3);
  TriangleMesh left = mirrored(ramp(std::tan(12 * kDegToRad), 0, 15e-3));
  DrainedHeap heap;
};

TEST_F(DrainedReposeResponses, AnglesOfBothSidesAndTheirMean) {
  const auto r = measured();
  EXPECT_NEAR(value(r, "angle_of_repose_right"), 10, 1e-9);
  EXPECT_NEAR(value(r, "angle_of_repose_left"), 12, 1e-9);
  EXPECT_NEAR(value(r, "angle_of_repose"), 11, 1e-9);
  EXPECT_NEAR(value(r, "angle_of_repose_least_squares"), 11, 1e-9);
  EXPECT_NEAR(find(r, "angle_of_repose").uncertainty.at(0),
              find(r, "angle_of_repose_left").uncertainty.at(0) / std::sqrt(2.0), 1e-12);
  for (const Response& response : r) {
    EXPECT_FALSE(response.unit.empty()) << response.name;
    EXPECT_FALSE(response.method.empty()) << response.name;
    EXPECT_EQ(response.uncertainty.size(), response.value.size()) << response.name;
  }
}

TEST_F(DrainedReposeResponses, PlaneRampsStandNoHigherAtTheWalls) {
  const auto r = measured();
  for (const char* name :
       {"wall_height_excess", "wall_height_excess_left", "wall_height_excess_right"})
    EXPECT_NEAR(value(r, name), 0, 1e-9) << name;
}

TEST_F(DrainedReposeResponses, AShallowBoxHasNoMiddleToCompareWith) {
  heap.setup.box.y() = 3.9 * kCubeSize;
  EXPECT_THROW(find(measured(), "wall_height_excess"), std::runtime_error);
}

TEST_F(DrainedReposeResponses, FloatersAreNoPartOfTheSurface) {
  const auto before = measured();
  const TriangleMesh cube = synthetic::crescent();
  add_box(cube, Vec3(0.25, 0, 0.2));
  add_box(cube, Vec3(0.12, 0.03, 0.25));
  const auto after = measured();
  EXPECT_EQ(value(after, "angle_of_repose_right"), value(before, "angle_of_repose_right"));
  EXPECT_EQ(value(after, "remaining_count_right"), 3);  // they have not left the box, though
}

TEST_F(DrainedReposeResponses, CountsAndMassesBySide) {
  const auto r = measured();
  EXPECT_EQ(value(r, "remaining_count"), 2);
  EXPECT_EQ(value(r, "remaining_count_left"), 1);
  EXPECT_DOUBLE_EQ(value(r, "remaining_mass"), 0.0274);
  EXPECT_DOUBLE_EQ(value(r, "remaining_mass_right"), 0.0137);
  EXPECT_EQ(value(r, "discharged_count"), 100);
}

TEST_F(DrainedReposeResponses, TimesAndRateOfTheDischarge) {
  const auto r = measured();
  EXPECT_DOUBLE_EQ(value(r, "t10"), 0.2);  // the 10th of 100, one every 20 ms
  EXPECT_DOUBLE_EQ(value(r, "t50"), 1.0);
  EXPECT_DOUBLE_EQ(value(r, "t90"), 1.8);
  EXPECT_DOUBLE_EQ(value(r, "discharge_time"), 1.8);
  EXPECT_NEAR(value(r, "discharge_rate"), 50, 1e-9);
  EXPECT_NEAR(find(r, "discharge_rate").uncertainty.at(0), 0, 1e-9);  // perfectly regular
  EXPECT_EQ(find(r, "discharge_curve").value, heap.discharge_times);
}

TEST_F(DrainedReposeResponses, IrregularDischargeHasAnUncertainRate) {
  // Gaps of 10 and 30 ms in turn: coefficient of variation 0.5, 80 gaps.
  heap.discharge_times.clear();
  double t = 0;
  for (int k = 0; k < 100; ++k) heap.discharge_times.push_back(t += k % 2 ? 10e-3 : 30e-3);
  const auto r = measured();
  EXPECT_NEAR(value(r, "discharge_rate"), 50, 1e-9);
  EXPECT_NEAR(find(r, "discharge_rate").uncertainty.at(0), 50 * 0.5 / std::sqrt(80.0), 0.05);
}

TEST_F(DrainedReposeResponses, NoDischargeHasNoTimes) {
  heap.discharge_times.clear();
  const auto r = measured();
  EXPECT_EQ(value(r, "discharged_count"), 0);
  EXPECT_THROW(find(r, "t50"), std::runtime_error);
}

TEST_F(DrainedReposeResponses, ABridgeFromLipToLipIsAnArch) {
  EXPECT_EQ(value(measured(), "arched"), 0);
  // Three planks that overlap; the outer ones rest on the ramps' toes, 15 mm high.
  const TriangleMesh plank = synthetic::box_mesh({60e-3, 20e-3, 10e-3});
  add_box(plank, Vec3(-0.055, 0, 0.021));
  add_box(plank, Vec3(0.055, 0, 0.021));
  EXPECT_EQ(value(measured(), "arched"), 0);  // the middle is open
  add_box(plank, Vec3(0, 0, 0.032));
  EXPECT_EQ(value(measured(), "arched"), 1);
  heap.observed = heap.discharge_times.back() + 0.4;  // something passed 0.4 s ago: not yet stopped
  EXPECT_EQ(value(measured(), "arched"), 0);
}

TEST_F(DrainedReposeResponses, AFullBoxHasTheDensityOfItsContent) {
  const TriangleMesh bed = synthetic::box_mesh({0.5969, 0.1397, 0.2});
  const double volume = 0.5969 * 0.1397 * 0.2;
  heap.filled = {{{&bed, {Mat3::Identity(), Vec3(0, 0, 0.1)}}, Vec3(0, 0, 0.1), 10.0, volume}};
  const auto r = measured();
  EXPECT_NEAR(value(r, "fill_height"), 0.2, 1e-12);
  EXPECT_NEAR(value(r, "bulk_density"), 10 / volume, 1e-6);
  EXPECT_NEAR(value(r, "solid_fraction"), 1, 1e-9);
  EXPECT_NEAR(find(r, "fill_height").uncertainty.at(0), 0, 1e-12);
}

TEST_F(DrainedReposeResponses, WithoutAnOpenDoorThereIsNothingToMeasure) {
  heap.opened = false;
  EXPECT_TRUE(measured().empty());
}

}  // namespace
}  // namespace firn
