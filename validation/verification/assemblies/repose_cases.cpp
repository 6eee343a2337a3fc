// Slope of the heap that a column leaves when its lateral gate is removed.
#include <fmt/format.h>

#include <cmath>

#include "validation/verification/assemblies/bulk_cases.h"
#include "validation/verification/fixtures/bulk_scenes.h"

namespace firn::verification {
namespace {

using namespace scenes;

// A bed between an end wall (x = 0), two side walls and a gate.
struct Column {
  double wide = 6 * kDie, deep = 5 * kDie;  // m
  int count = 300;
  double size = kDie;  // m, of a particle
  double tall = 0;     // m, over which they are scattered
};

// Slope, deg, of the heap that `model`'s one shape leaves: of the wedge against the wall whose
// center of mass lies where that of the bodies does, H / 3 up and L / 3 out. Nothing is fitted, and
// a cliff or a tongue counts as what it weighs.
double wedge(Model model, const Column& c, std::uint64_t seed) {
  add_particles(model, 0, c.count);
  add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  add_plane(model, Vec3::Zero(), Vec3::UnitX());
  add_plane(model, {0, 0, 0}, Vec3::UnitY());
  add_plane(model, {0, c.deep, 0}, -Vec3::UnitY());
  const int sensor = add_plane(model, {c.wide, 0, 0}, -Vec3::UnitX());
  model.timestep = advise_timestep(model, 7).timestep;
  Solver solver(model);
  const double reach = 0.5 * c.size;
  scatter(solver, 0, c.count, Vec3::Constant(reach), {c.wide - reach, c.deep - reach, c.tall},
          seed);
  run(solver, std::sqrt(2 * c.tall / kGravity) + 0.3);
  solver.remove_boundary(sensor);
  run(solver, 1.2);
  Vec3 center = Vec3::Zero();
  for (const Vec3& p : solver.particles().position) center += p / c.count;
  return std::atan2(center.z(), center.x()) / kDegToRad;
}

constexpr int kSeeds = 4;

SampleStatistics wedges(const Model& model, const Column& c) {
  std::vector<double> angles;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) angles.push_back(wedge(model, c, seed));
  return sample_statistics(angles);
}

Check rises(const std::string& what, const SampleStatistics& high, const SampleStatistics& low,
            double errors = 3) {
  return {fmt::format("{}: {:.1f} ± {:.1f} over {:.1f} ± {:.1f} deg, in standard errors", what,
                      high.mean, high.error(), low.mean, low.error()),
          (high.mean - low.mean) / std::hypot(high.error(), low.error()),
          errors,
          0,
          Bound::at_least,
          "1"};
}

Column dice_column(double deep = 5) {
  Column c;
  c.deep = deep * kDie;
  c.count = static_cast<int>(60 * deep);
  c.tall = 30 * kDie;
  return c;
}

Model dice(double friction) {
  Dice d;
  d.friction = d.wall_friction = friction;
  d.hardness = 3000;
  return dice_model(d);
}

std::vector<Check> repose_trends() {
  Dice base;
  base.hardness = 3000;
  const Column column = dice_column();
  const SampleStatistics b = wedges(dice_model(base), column);
  std::vector<Check> checks;
  checks.push_back(rises("friction 0.4 over 0.15", b, wedges(dice(0.15), column)));
  checks.push_back(rises("friction 0.8 over 0.4", wedges(dice(0.8), column), b, 0));
  Dice ball = base;
  ball.faces = 0;
  const SampleStatistics smooth = wedges(dice_model(ball), column);
  checks.push_back(rises("dodecahedra over spheres", b, smooth));
  ball.rolling_resistance = 0.2;
  checks.push_back(
      rises("spheres: rolling resistance 0.2 over none", wedges(dice_model(ball), column), smooth));
  checks.push_back(rises("box 3 over 9 diameters deep", wedges(dice_model(base), dice_column(3)),
                         wedges(dice_model(base), dice_column(9))));
  const auto same = [&](const std::string& what, const Dice& d) {
    const SampleStatistics s = wedges(dice_model(d), column);
    checks.push_back({fmt::format("{}: {:.1f} ± {:.1f} and {:.1f} ± {:.1f} deg, difference", what,
                                  s.mean, s.error(), b.mean, b.error()),
                      s.mean - b.mean, 0, 1 + 2 * std::hypot(s.error(), b.error()), Bound::absolute,
                      "deg"});
  };
  Dice other = base;
  other.hardness *= 3;
  same("three times as stiff", other);
  other = base;
  other.density *= 3;
  other.hardness /= 3;
  same("three times as dense, as stiff", other);
  other = base;
  other.restitution = 0.5;
  same("restitution 0.5 instead of 0.3", other);
  return checks;
}

// Six arms along the axes on a cube of edge a, or the convex hull of that.
constexpr double kArm = 8e-3;  // m, a; arms are 1.5 a long

Shape cross_or_hull(bool concave) {
  ShapeOptions options = ice_options(0, 6000, 0.05 * kArm);
  options.density = 1000;
  std::vector<Component> components = {{make_box(Vec3::Constant(kArm), options), Pose{}}};
  std::vector<Vec3> corners;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3 size = Vec3::Constant(kArm);
      size[axis] = 1.5 * kArm;
      Pose pose;
      pose.translation = sign * 1.25 * kArm * Vec3::Unit(axis);
      const Shape arm = make_box(size, options);
      for (const Vec3& v : arm.mesh.vertices) corners.push_back(pose * v);
      components.push_back({arm, pose});
    }
  }
  return concave ? make_compound(components, options) : make_convex(corners, options);
}

std::vector<Check> concavity() {
  Column column;
  column.wide = 0.16;
  column.deep = 0.12;
  column.count = 150;
  column.size = 4.2 * kArm;
  column.tall = 0.8;
  std::vector<Check> checks;
  for (const double friction : {0.1, 0.4}) {
    SampleStatistics both[2];
    for (const bool concave : {false, true}) {
      Model model = empty(law(friction, 0.3), law(friction, 0.3));
      add_shape(model, cross_or_hull(concave));
      both[concave] = wedges(model, column);
    }
    checks.push_back(rises(fmt::format("friction {}: crosses over their hulls", friction), both[1],
                           both[0], friction < 0.2 ? 3 : 0));
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> repose_cases() {
  return {
      {"bulk.repose", "What makes a heap steep, and what hardly does",
       "Zhou, Wright, Yang, Xu and Yu (2001): repose rises with friction and with rolling "
       "resistance, falls with the thickness of the box, and hardly depends on stiffness, "
       "density or restitution",
       "A column of 300 dodecahedra (friction 0.4 unless said) of 6 by 5 diameters collapses "
       "when its gate goes; the slope is that of the wedge with the same center of mass. Means "
       "of 4 seeds; a rise is one of three standard errors at least, and no dependence is a "
       "difference of less than a degree and two standard errors. Beyond 0.4 friction matters "
       "little, as bodies roll before they slide: it is asked only that the slope does not fall.",
       Tier::full, repose_trends},
      {"bulk.concavity", "A concave shape lies steeper than its convex hull",
       "Duverger and others (2023): concave grains 35.95 ± .88 degrees, their convex twins "
       "31.26 ± .95; the sign, beyond three standard errors",
       "150 crosses of six arms, or as many of their hulls, collapse as in bulk.repose. At a "
       "friction "
       "of 0.1 they lie twice as steep; at 0.4 the difference is of the size of its scatter over 4 "
       "seeds, and only its sign is asked for.",
       Tier::full, concavity}};
}

}  // namespace firn::verification
