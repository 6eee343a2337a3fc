// The energy of a contact region: its gradient, cuts, and the overlap volume that it stands for.
#include "solver/region_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/solver/contact_energy/impacts.h"
#include "tests/solver/contact_energy/moment_energy.h"

namespace firn {
namespace {

using contact_energy::Dice;
using contact_energy::kStiffness;

struct Facets {
  std::vector<RegionFacet> facets;
  std::vector<RegionEdge> edges;

  void add(const std::vector<Eigen::Vector2d>& outline, double depth, double sx, double sy) {
    facets.push_back({depth, sx, sy, static_cast<int>(outline.size())});
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d &p = outline[i], &q = outline[(i + 1) % outline.size()];
      edges.push_back({p.x(), p.y(), q.x(), q.y()});
    }
  }
  RegionEnergy energy(const RegionMotion& motion = {}) const {
    return region_energy(kStiffness, facets, edges, motion);
  }
};

// A convex polygon with corners at random on an ellipse.
std::vector<Eigen::Vector2d> random_outline(Dice& dice, int corners) {
  std::vector<double> angles;
  angles.reserve(corners);
  for (int i = 0; i < corners; ++i) angles.push_back(dice.between(-3.1, 3.1));
  std::ranges::sort(angles);
  const double x = dice.between(-0.01, 0.01), y = dice.between(-0.01, 0.01);
  std::vector<Eigen::Vector2d> out;
  out.reserve(corners);
  for (const double a : angles) out.emplace_back(x + 0.01 * std::cos(a), y + 0.006 * std::sin(a));
  return out;
}

Facets random_region(Dice& dice) {
  Facets out;
  const int count = static_cast<int>(dice.between(1, 4));
  for (int i = 0; i < count; ++i) {
    const double slope = dice.between(0, 1) < 0.3 ? 0.5 : 0.02;
    out.add(random_outline(dice, 3 + i), dice.between(-1e-4, 2e-4), slope * dice.between(-1, 1),
            slope * dice.between(-1, 1));
  }
  return out;
}

TEST(RegionEnergy, ForceAndMomentsAreTheGradient) {
  Dice dice(1);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    const Facets r = random_region(dice);
    const RegionEnergy e = r.energy();
    if (!(e.energy > 0)) continue;
    ++touching;
    const double h = 1e-9, t = 1e-7;
    const auto slope = [](const RegionEnergy& more, const RegionEnergy& less, double step) {
      return (more.energy - less.energy) / (2 * step);
    };
    const double size = std::abs(e.force) + 0.1;
    EXPECT_NEAR(e.force, slope(r.energy({h, 0, 0}), r.energy({-h, 0, 0}), h), 1e-4 * size);
    EXPECT_NEAR(e.moment_x, slope(r.energy({0, t, 0}), r.energy({0, -t, 0}), t), 2e-6 * size);
    EXPECT_NEAR(e.moment_y, slope(r.energy({0, 0, t}), r.energy({0, 0, -t}), t), 2e-6 * size);
  }
  EXPECT_GT(touching, 200);
}

void expect_equal(const RegionEnergy& a, const RegionEnergy& b, double tolerance) {
  const double force = std::abs(b.force) + std::sqrt(kStiffness * b.energy);
  EXPECT_NEAR(a.energy, b.energy, tolerance * b.energy);
  EXPECT_NEAR(a.force, b.force, tolerance * force);
  EXPECT_NEAR(a.moment_x, b.moment_x, tolerance * force * 0.02);
  EXPECT_NEAR(a.moment_y, b.moment_y, tolerance * force * 0.02);
  EXPECT_NEAR(a.area, b.area, tolerance * 1e-4);
  EXPECT_NEAR(a.volume, b.volume, tolerance * b.volume);
}

TEST(RegionEnergy, CutsOfAFacetChangeNothing) {
  Dice dice(2);
  for (int i = 0; i < 300; ++i) {
    const auto outline = random_outline(dice, 6);
    const double depth = dice.between(0, 2e-4), sx = dice.between(-0.03, 0.03),
                 sy = dice.between(-0.03, 0.03);
    Facets uncut, cut;
    uncut.add(outline, depth, sx, sy);
    // By a line between two corners, or into triangles about a point inside.
    if (i % 2) {
      const int at = 2 + i % 3;
      cut.add({outline.begin(), outline.begin() + at + 1}, depth, sx, sy);
      std::vector<Eigen::Vector2d> rest(outline.begin() + at, outline.end());
      rest.push_back(outline[0]);
      cut.add(rest, depth, sx, sy);
    } else {
      const Eigen::Vector2d inside = (outline[0] + outline[2] + outline[4]) / 3;
      for (std::size_t k = 0; k < outline.size(); ++k)
        cut.add({inside, outline[k], outline[(k + 1) % outline.size()]}, depth, sx, sy);
    }
    if (uncut.energy().energy > 0) expect_equal(cut.energy(), uncut.energy(), 1e-9);
  }
}

// A notched outline.
TEST(RegionEnergy, OutlinesNeedNotBeConvex) {
  Facets whole, parts;
  whole.add({{0, 0}, {0.02, 0}, {0.02, 0.01}, {0.01, 0.002}, {0, 0.01}}, 1e-4, 0.01, -0.02);
  parts.add({{0, 0}, {0.01, 0}, {0.01, 0.002}, {0, 0.01}}, 1e-4, 0.01, -0.02);
  parts.add({{0.01, 0}, {0.02, 0}, {0.02, 0.01}, {0.01, 0.002}}, 1e-4, 0.01, -0.02);
  expect_equal(whole.energy(), parts.energy(), 1e-12);
}

TEST(RegionEnergy, AFlatRegionNeedsOnlyItsMoments) {
  Dice dice(3);
  int below = 0;
  for (int i = 0; i < 300; ++i) {
    Facets r;
    r.add(random_outline(dice, 3 + i % 6), dice.between(1e-4, 4e-4), dice.between(-0.01, 0.01),
          dice.between(-0.01, 0.01));
    if (!is_below(r.edges, r.facets[0])) continue;
    ++below;
    expect_equal(flat_region_energy(kStiffness, flat_region(r.edges), r.facets[0]), r.energy(),
                 1e-10);
  }
  EXPECT_GT(below, 100);
}

// A box in a floor: the same energy as that of the overlap volume. Near flat, the face of the box
// is the base of that, and the two differ by the square of the tilt.
TEST(RegionEnergy, IsTheEnergyOfTheOverlapVolume) {
  namespace ce = contact_energy;
  Dice dice(4);
  const ce::Solid cube = ce::box({0.03, 0.02, 0.012});
  const ce::PiecedBody body{{cube, {}, 1}}, floor{{ce::box({0.2, 0.2, 0.2}), {}, 1}};
  for (int i = 0; i < 100; ++i) {
    const Quat turn = i % 3 ? dice.turn() : dice.tilt(0.01);
    double lowest = 0;
    for (const Vec3& v : cube.vertices) lowest = std::min(lowest, (turn * v).z());
    const Pose pose{turn.toRotationMatrix(), {0, 0, 0.1 - lowest - dice.between(1e-5, 4e-4)}};
    Facets r;
    for (const ce::Solid::Face& f : cube.faces) {
      const Vec3 n = pose.rotation * f.normal;
      if (std::abs(n.z()) < 1e-9) continue;  // upward faces count as negative
      const Vec3 at = pose * cube.vertices[f.loop[0]];
      std::vector<Eigen::Vector2d> outline;  // counter-clockwise from above if n is downward
      for (auto v = f.loop.rbegin(); v != f.loop.rend(); ++v)
        outline.emplace_back((pose * cube.vertices[*v]).head<2>());
      const double sx = n.x() / n.z(), sy = n.y() / n.z();
      r.add(outline, 0.1 - at.z() - sx * at.x() - sy * at.y(), sx, sy);
    }
    const ce::MomentContact c = ce::moment_contact(kStiffness, body, pose, floor, {});
    const RegionEnergy e = r.energy();
    EXPECT_NEAR(e.energy, c.energy, 1e-7 * c.energy + 1e-3 * c.energy * (i % 3 == 0)) << i;
    if (i % 3) {
      EXPECT_NEAR(e.force, c.wrench.force.z(), 1e-6 * c.wrench.force.norm()) << i;
    }
  }
}

TEST(RegionEnergy, NothingBelowThePlaneIsNoContact) {
  Facets r;
  r.add({{0, 0}, {0.01, 0}, {0, 0.01}}, -1e-6, -0.01, 0);
  EXPECT_EQ(r.energy().energy, 0);
  EXPECT_EQ(r.energy().force, 0);
  EXPECT_EQ(region_energy(kStiffness, {}, {}, {}).energy, 0);
  EXPECT_EQ(flat_region({}).area, 0);
}

}  // namespace
}  // namespace firn
