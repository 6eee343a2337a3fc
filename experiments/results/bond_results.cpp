#include "experiments/results/bond_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace firn {

namespace {

BodyInMotion at_rest(const Boundary& boundary) {
  return {boundary.origin, Vec3::Zero(), Vec3::Zero(), boundary.orientation};
}

BodyInMotion body_at(const Model& model, const Frame& frame, int body) {
  if (!is_particle(model, body)) return at_rest(boundary_of(model, body));
  const auto i = static_cast<std::size_t>(body);
  const auto& q = frame.orientation[i];
  const Shape& shape = model.shapes[static_cast<std::size_t>(model.particles[i].shape)];
  return {Vec3(frame.position[i].data()), Vec3::Zero(), Vec3::Zero(),
          Quat(q[0], q[1], q[2], q[3]) * shape.shape_from_body};
}

}  // namespace

bool BondOutcome::is_broken() const {
  return !std::isnan(time) && mode != to_string(BondMode::lifetime);
}

Vec3 end_on_boundary(const Model& model, const Bond& bond) {
  const Boundary& boundary = boundary_of(model, bond.b);
  return boundary.origin + boundary.orientation * bond.end_b;
}

std::string bodies_text(const Model& model, const BondOutcome& outcome) {
  if (outcome.b >= 0) return fmt::format("particles {} and {}", outcome.a, outcome.b);
  return fmt::format("particle {} and boundary \"{}\"", outcome.a,
                     model.boundaries[index(-1 - outcome.b)].name);
}

std::vector<BondOutcome> bond_outcomes(const Recording& recording) {
  if (!recording.contains("/bonds/a")) return {};
  const std::vector<std::string> name = recording.strings("/bonds/name"),
                                 mode = recording.strings("/bonds/break_mode");
  const std::vector<double> a = recording.values("/bonds/a"), b = recording.values("/bonds/b"),
                            time = recording.values("/bonds/break_time"),
                            stress = recording.values("/bonds/break_stress"),
                            place = recording.values("/bonds/break_position");
  std::vector<BondOutcome> outcomes;
  for (std::size_t k = 0; k < a.size(); ++k)
    outcomes.push_back({name[k], static_cast<int>(a[k]), static_cast<int>(b[k]), mode[k], time[k],
                        stress[k], Vec3(place[3 * k], place[3 * k + 1], place[3 * k + 2])});
  return outcomes;
}

std::vector<BondBox> intact_bonds_at(const Case& c, const std::vector<BondOutcome>& outcomes,
                                     double time, const Frame& frame) {
  const Model& model = c.model;
  std::vector<BondBox> bridges;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const Bond& bond = model.bonds[k];
    const auto present = [&](int body) {
      return !is_particle(model, body) ||
             !std::isnan(frame.position[static_cast<std::size_t>(body)][0]);
    };
    if (outcomes[k].time <= time || !present(bond.a) || !present(bond.b)) continue;
    const BeamLaw& law = model.beams[static_cast<std::size_t>(bond.law)];
    const BodyInMotion a = body_at(model, frame, bond.a), b = body_at(model, frame, bond.b);
    const BeamPose pose = pose_of(law, bond, a, b);
    bridges.push_back({static_cast<int>(k), a.position + pose.arm_a + 0.5 * pose.end_offset,
                       Quat(pose.axes),
                       Vec3(law.length, 2 * law.section.half_width, 2 * law.section.half_height)});
  }
  return bridges;
}

std::vector<Response> bond_responses(const Recording& recording, const Case& c) {
  const std::vector<BondOutcome> outcomes = bond_outcomes(recording);
  if (c.model.bonds.empty() || outcomes.empty()) return {};
  constexpr std::array<BondMode, 4> kModes = {BondMode::tension, BondMode::bending, BondMode::shear,
                                              BondMode::torsion};
  const std::vector<double> inserted = recording.insert_time();
  const auto came = [&](int body) {
    return body < 0 || !std::isnan(inserted[static_cast<std::size_t>(body)]);
  };
  double joined = 0;
  std::vector<double> times, by_mode(kModes.size(), 0);
  for (const BondOutcome& one : outcomes) {
    joined += came(one.a) && came(one.b) ? 1 : 0;
    if (!one.is_broken()) continue;
    times.push_back(one.time);
    for (std::size_t m = 0; m < kModes.size(); ++m)
      by_mode[m] += one.mode == to_string(kModes[m]) ? 1 : 0;
  }
  std::ranges::sort(times);
  std::vector<Response> out;
  const auto add = [&](const std::string& name, std::vector<double> value, const char* unit,
                       const char* method) {
    out.push_back({response_name(name), std::move(value), {}, unit, method, 1});
  };
  add("bonds_count", {joined}, "1", "bonds whose two bodies have come");
  add("bonds_broken_count", {static_cast<double>(times.size())}, "1", "of them, that broke");
  const std::vector<StageRecord> begun = recording.stages();
  for (std::size_t k = 1; k < c.stages.size(); ++k)
    add("bonds_broken_count_since_" + c.stages[k].name, {count_since(begun, k, times)}, "1",
        "those that broke since the stage began; undefined: it did not begin");
  add("bonds_broken_by_mode", by_mode, "1", "in tension, bending, shear, torsion");
  if (!times.empty()) add("bond_breaks", times, "s", "when they broke, ascending");
  return out;
}

}  // namespace firn
