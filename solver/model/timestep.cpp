// Stable time step of a model.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "firn/model.h"
#include "solver/dynamics/free_body.h"
#include "solver/dynamics/mechanism.h"
#include "solver/model/bond_checks.h"
#include "solver/model/used_shapes.h"

namespace firn {

namespace {

// One candidate for the stiffest spring of the model.
struct Spring {
  std::string name;
  double stiffness = 0;  // N/m, the stiffer of loading and unloading
  bool unloading = true;
  double mass = 0;  // kg
  double quarter_period() const { return 0.5 * std::numbers::pi * std::sqrt(mass / stiffness); }
};

Spring spring(std::string name, double loading, const Interaction& law, double mass) {
  Spring s;
  s.name = std::move(name);
  s.unloading = law.restitution < 1;
  s.stiffness = loading / (law.restitution * law.restitution);
  s.mass = mass;
  return s;
}

// [frames] 1: a mechanism moves it.
std::vector<char> frames_of_mechanisms(const Model& model) {
  std::vector<char> members(model.frames.size(), 0);
  for (const MechanismMembers& m : find_mechanisms(model.frames, model.couplings))
    for (const int f : m.frames) members[index(f)] = 1;
  return members;
}

// Replaces the joints of a body by free motion, if it has inertia about all axes.
void release_joints(FreeBody& body) {
  if (!(Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia).eigenvalues().minCoeff() > 0)) return;
  body.joints.clear();
  for (int k = 0; k < 3; ++k) {
    Joint& slide = body.joints.emplace_back();
    slide.kind = Joint::Kind::translation;
    slide.direction = Vec3::Unit(k);
  }
  body.free_rotation = true;
}

// Reciprocal of the minimum effective mass of a boundary on a free body, 1/kg; 0: not on a free
// body.
double max_mobility(const Model& model, const std::vector<char>& in_mechanism, const Boundary& b) {
  const int free = free_frame(model.frames, b.frame);
  if (free < 0) return 0;
  const MotionFrame& frame = model.frames[static_cast<std::size_t>(free)];
  FreeBody body = *frame.free;
  // In a mechanism the carrying bodies move as well. The effective mass is at least that of the
  // body without joints.
  if (in_mechanism[index(free)]) release_joints(body);
  double least = kUnbounded;
  const auto include = [&](const Vec3& at) {
    const Vec3 arm = b.origin + b.orientation * at - frame.origin;
    least = std::min(least, min_effective_mass(body, frame.origin, arm));
  };
  for (const Vec3& v : b.mesh.vertices) include(v);
  if (b.mesh.vertices.empty()) include(Vec3::Zero());
  return 1 / least;
}

TimestepAdvice advise_for_contacts(const Model& model, double steps) {
  const std::vector<char> used = used_shapes(model);
  const std::vector<char> in_mechanism = frames_of_mechanisms(model);
  std::vector<double> mobility;
  for (const Boundary& b : model.boundaries)
    mobility.push_back(max_mobility(model, in_mechanism, b));
  std::vector<Spring> springs;
  for (std::size_t i = 0; i < model.shapes.size(); ++i) {
    if (!used[i]) continue;
    const Shape& a = model.shapes[i];
    for (std::size_t j = i; j < model.shapes.size(); ++j) {
      if (!used[j]) continue;
      const Shape& b = model.shapes[j];
      springs.push_back(spring(a.name + " on " + b.name, particle_pair_stiffness(a, b),
                               model.interaction(a.material, b.material),
                               a.mass * b.mass / (a.mass + b.mass)));
    }
    for (std::size_t k = 0; k < model.boundaries.size(); ++k) {
      const Boundary& b = model.boundaries[k];
      springs.push_back(spring(a.name + " on " + b.name, boundary_pair_stiffness(model, a, b),
                               model.interaction(a.material, b.material),
                               1 / (1 / a.mass + mobility[k])));
    }
  }
  for (const BoundaryContact& c : model.boundary_contacts) {
    const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
    springs.push_back(spring(model.boundaries[a].name + " on " + model.boundaries[b].name,
                             c.stiffness, c.law, 1 / (mobility[a] + mobility[b])));
  }
  if (springs.empty()) {
    return {1e-4, false, "no particle can touch anything: 0.1 ms"};
  }
  const Spring& s = *std::min_element(
      springs.begin(), springs.end(),
      [](const auto& x, const auto& y) { return x.quarter_period() < y.quarter_period(); });
  TimestepAdvice advice;
  advice.timestep = s.quarter_period() / steps;
  advice.limited_by_spring = true;
  advice.reason = fmt::format(
      "{:.4g} steps in the quarter period {:.4g} s of {}: {} stiffness {:.4g} N/m, effective mass "
      "{:.4g} kg",
      steps, s.quarter_period(), s.name, s.unloading ? "unloading" : "loading", s.stiffness,
      s.mass);
  return advice;
}

}  // namespace

TimestepAdvice advise_timestep(const Model& model, double steps) {
  TimestepAdvice advice = advise_for_contacts(model, steps);
  const auto swings = [&](double frequency, const auto& what) {
    const double quarter_period = 0.5 * std::numbers::pi / frequency;
    if (advice.limited_by_spring && quarter_period / steps >= advice.timestep) return;
    advice = {quarter_period / steps, true,
              fmt::format("{:.4g} steps in the quarter period {:.4g} s of {}", steps,
                          quarter_period, what())};
  };
  for (MechanismMembers& members : find_mechanisms(model.frames, model.couplings)) {
    const std::string& first = model.frames[index(members.frames.front())].name;
    const Mechanism mechanism(model.frames, model.couplings, std::move(members));
    if (const double frequency = mechanism.highest_frequency(); frequency > 0)
      swings(frequency, [&] {
        return fmt::format("the mechanism of the motion frame \"{}\" on its springs", first);
      });
  }
  const std::vector<char> in_mechanism = frames_of_mechanisms(model);
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const MotionFrame& frame = model.frames[f];
    if (in_mechanism[f]) continue;
    const double frequency = frame.free ? highest_frequency(*frame.free, frame.origin) : 0;
    if (frequency > 0)
      swings(frequency,
             [&] { return fmt::format("the free body \"{}\" on its springs", frame.name); });
  }
  const FastestBond fastest = fastest_bond(model);
  if (fastest.bond >= 0) {
    swings(fastest.frequency, [&] {
      const Bond& bond = model.bonds[static_cast<std::size_t>(fastest.bond)];
      return fmt::format("the bond \"{}\" between {}",
                         model.beams[static_cast<std::size_t>(bond.law)].name,
                         ends_text(model, bond));
    });
  }
  return advice;
}

}  // namespace firn
