// What is sampled of boundaries and motion frames ([output.samples], docs/case-files.md).
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "experiments/case/case.h"

namespace firn {

struct SampledQuantity {
  std::string_view name, unit;
  bool by_joint = false;  // one value a joint; otherwise a vector
};

// In the order of the columns. `frame`: a motion frame; nullptr: a boundary.
inline std::vector<SampledQuantity> sampled_quantities(const MotionFrame* frame) {
  std::vector<SampledQuantity> all = {{"force", "N"}, {"torque", "N m"}};
  if (!frame || !frame->free) return all;
  all.insert(all.end(), {{"reaction_force", "N"}, {"reaction_torque", "N m"}});
  if (frame->free->joints.empty()) return all;
  all.insert(all.end(),
             {{"coordinate", "SI", true}, {"rate", "SI", true}, {"motor_load", "SI", true}});
  return all;
}

// Whether the samples begin no later than the stage of a load, or the run without one.
inline bool covers_load(const Case& c, const Measure& m) {
  const auto stage = std::ranges::find(c.stages, m.stage, &Stage::name);
  return c.samples.stage <= (m.stage.empty() ? 0 : stage - c.stages.begin());
}

// Whether all of `names` are sampled of the boundary or motion frame of the measure, in the whole
// stage of a load. Of these names, "time" always is, and "acceleration" comes from "rate".
inline bool has_samples(const Case& c, const Measure& m,
                        std::initializer_list<std::string_view> names) {
  if (m.contact >= 0 || m.coupling >= 0) return false;
  if (m.kind == Measure::Kind::load && !covers_load(c, m)) return false;
  const bool is_frame = m.boundary.empty();
  const bool sampled =
      is_frame ? std::ranges::count(c.samples.frames, m.frame) > 0
               : std::ranges::any_of(c.samples.boundaries, [&](int b) {
                   return c.model.boundaries[static_cast<std::size_t>(b)].name == m.boundary;
                 });
  if (!sampled) return false;
  const std::vector<SampledQuantity> all =
      sampled_quantities(is_frame ? &c.model.frames[static_cast<std::size_t>(m.frame)] : nullptr);
  return std::ranges::all_of(names, [&](std::string_view name) {
    const std::string_view source = name == "acceleration" ? "rate" : name;
    return name == "time" || std::ranges::count(all, source, &SampledQuantity::name) > 0;
  });
}

}  // namespace firn
