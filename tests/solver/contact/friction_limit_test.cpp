// The common limit of friction force and torsion against Coulomb's law, integrated over a
// rectangle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "firn/math.h"
#include "solver/contact/contact_law.h"

namespace firn {
namespace {

// A rectangle that slides at `u`, `v` (m/s) along its first and second edge and turns at
// `angular_velocity` (rad/s).
struct Sliding {
  double a, b;  // m, edges
  double u, v, angular_velocity;
};
// Force, and torsion over the mean distance, of a rectangle that bears 1 N at a friction of 1.
struct Load {
  double u, v, torsion;
};
double distance(const Load& x, const Load& y) {
  return std::hypot(x.u - y.u, x.v - y.v, x.torsion - y.torsion);
}

double radius_of(const Sliding& s) {
  constexpr int kCells = 200;
  double sum = 0;
  for (int i = 0; i < kCells; ++i)
    for (int k = 0; k < kCells; ++k)
      sum += std::hypot(s.a * ((i + 0.5) / kCells - 0.5), s.b * ((k + 0.5) / kCells - 0.5));
  return sum / (kCells * kCells);
}

Load coulomb(const Sliding& s) {
  constexpr int kCells = 200;
  Load sum = {};
  for (int i = 0; i < kCells; ++i)
    for (int k = 0; k < kCells; ++k) {
      const double x = s.a * ((i + 0.5) / kCells - 0.5), y = s.b * ((k + 0.5) / kCells - 0.5);
      const double slip_u = s.u - s.angular_velocity * y, slip_v = s.v + s.angular_velocity * x;
      const double size = std::hypot(slip_u, slip_v) * kCells * kCells;
      if (!(size > 0)) continue;
      sum.u -= slip_u / size;
      sum.v -= slip_v / size;
      sum.torsion -= (x * slip_v - y * slip_u) / size;
    }
  sum.torsion /= radius_of(s);
  return sum;
}

// The same by the law, in a patch with this normal whose long axis is at the angle `axis` (rad)
// from the first vector of its basis, after it has slid for a while.
Load by_law(const Sliding& s, const Vec3& normal, double axis) {
  const double e = (s.a * s.a - s.b * s.b) / (s.a * s.a + s.b * s.b);
  const TangentBasis basis = tangent_basis(to_vec(normal));
  const Vec3 long_axis = std::cos(axis) * to_eigen(basis.u) + std::sin(axis) * to_eigen(basis.v);
  const Vec3 short_axis = normal.cross(long_axis);
  const FrictionLaw law{1e5, 1, 1, 1e-6};
  const FrictionRegion region{to_vec(normal), radius_of(s),
                              static_cast<float>(e * std::cos(2 * axis)),
                              static_cast<float>(e * std::sin(2 * axis))};
  constexpr double dt = 1e-5;
  const PatchMotion motion{
      0, {}, to_vec(s.u * long_axis + s.v * short_axis), s.angular_velocity * dt};
  FrictionState state{{0, 0, 0}, 0, 0};
  for (int step = 0; step < 3000; ++step)
    state = advance_friction(law, state, 1, region, motion, dt).state;
  const Vec3 force = to_eigen(state.tangential);
  EXPECT_EQ(state.sliding, 1);
  return {force.dot(long_axis), force.dot(short_axis), state.torsion / region.radius};
}

class Slidings {
 public:
  explicit Slidings(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3 direction() {
    const double z = between(-1, 1), angle = between(0, 2 * M_PI), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  Sliding any(double aspect) {
    Sliding s{0.02, 0.02 / aspect, 0, 0, 0};
    const double angle = between(0, 2 * M_PI), part = between(0, M_PI);
    s.u = std::sin(part) * std::cos(angle);
    s.v = std::sin(part) * std::sin(angle);
    s.angular_velocity = std::cos(part) / radius_of(s);
    return s;
  }

 private:
  std::mt19937_64 random_;
};

TEST(FrictionLimit, IsNearCoulombsIntegralInEachDirection) {
  Slidings draw(1);
  // Deviation of force and torsion together, in parts of what the face holds of either: root mean
  // square over random motions. Most of it belongs to narrow faces that slide across their length
  // and turn about a point near their end, where the limit of a line has a corner.
  struct {
    double aspect, most;
  } const bounds[] = {{1, 0.015}, {2, 0.035}, {4, 0.06}, {10, 0.075}};
  double low = 1;
  for (const auto& [aspect, most] : bounds) {
    constexpr int kMotions = 150;
    double squares = 0;
    for (int k = 0; k < kMotions; ++k) {
      const Sliding s = draw.any(draw.between(low, aspect));
      const double off = distance(by_law(s, draw.direction(), draw.between(0, M_PI)), coulomb(s));
      squares += off * off / kMotions;
    }
    RecordProperty("up_to_" + std::to_string(aspect), std::to_string(std::sqrt(squares)));
    EXPECT_LT(std::sqrt(squares), most) << "up to " << aspect << " : 1";
    low = aspect;
  }
}

TEST(FrictionLimit, DoesNotDependOnTheDirectionsOfSpace) {
  Slidings draw(2);
  for (int k = 0; k < 100; ++k) {
    const Sliding s = draw.any(draw.between(1, 10));
    const Load along_z = by_law(s, Vec3::UnitZ(), 0);
    EXPECT_LT(distance(by_law(s, draw.direction(), draw.between(0, M_PI)), along_z), 1e-6);
    EXPECT_LT(distance(by_law(s, -Vec3::UnitZ(), draw.between(0, M_PI)), along_z), 1e-6);
    // Mirrored: so is the load.
    const Sliding mirrored{s.a, s.b, s.u, -s.v, -s.angular_velocity};
    const Load image = by_law(mirrored, Vec3::UnitZ(), 0);
    EXPECT_LT(distance({image.u, -image.v, -image.torsion}, along_z), 1e-9);
  }
}

// Force and torsion alone are held in full, whatever the face.
TEST(FrictionLimit, HoldsForceAloneAndTorsionAlone) {
  Slidings draw(3);
  for (int k = 0; k < 20; ++k) {
    Sliding s = draw.any(draw.between(1, 10));
    const double speed = std::hypot(s.u, s.v);
    s.angular_velocity = 0;
    const Load slides = by_law(s, draw.direction(), draw.between(0, M_PI));
    EXPECT_NEAR(slides.u, -s.u / speed, 1e-6);
    EXPECT_NEAR(slides.v, -s.v / speed, 1e-6);
    const Load spins = by_law({s.a, s.b, 0, 0, 100}, draw.direction(), draw.between(0, M_PI));
    EXPECT_NEAR(spins.torsion, -1, 1e-6);
  }
}

}  // namespace
}  // namespace firn
