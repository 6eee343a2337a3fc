#include "experiments/case_reader/process/samples.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/case_reader/process/stages.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// Indices of the elements that the key lists by name.
template <class Named>
std::vector<int> read_listed(const TomlTable& t, std::string_view key,
                             const std::vector<Named>& all, std::string_view what) {
  std::vector<int> indices;
  if (!t.has(key)) return indices;
  for (const std::string& name : t.strings(key)) {
    const int index = index_of(t, key, name, all, what);
    if (std::ranges::find(indices, index) != indices.end())
      t.fail(key, fmt::format("names \"{}\" twice; expected it once", name));
    indices.push_back(index);
  }
  return indices;
}

}  // namespace

SampledParts read_samples(const TomlTable& root, const Case& c) {
  SampledParts samples;
  const TomlTable output = root.table("output");
  if (!output.has("samples")) return samples;
  const TomlTable t = output.required_table("samples");
  t.allow({"interval", "motion_frames", "boundaries", "from_stage"});
  samples.interval = t.quantity("interval", dimension::time, Sign::positive);
  samples.frames = read_listed(t, "motion_frames", c.model.frames, "motion frame");
  samples.boundaries = read_listed(t, "boundaries", c.model.boundaries, "boundary");
  samples.stage = optional_stage(t, "from_stage", c.stages);
  if (samples.frames.empty() && samples.boundaries.empty())
    t.fail("motion_frames",
           "is missing, and boundaries too; expected names of motion frames or boundaries");
  return samples;
}

}  // namespace firn
