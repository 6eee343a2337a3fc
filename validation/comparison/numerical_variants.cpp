// Effects of numerics and of the experiment's variants on responses.
#include <fmt/format.h>

#include <cmath>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/responses/response_expression.h"
#include "validation/comparison/comparison_kinds.h"

namespace firn::comparison {
namespace {

struct NumericalVariant {
  std::string name;
  const RunGroup* runs;
};

std::vector<NumericalVariant> variants_of(const ComparisonRuns& e) {
  std::vector<NumericalVariant> all;
  if (e.timestep != nullptr) all.push_back({describe_setting(*e.timestep), e.timestep});
  for (const RunGroup* group : e.stiffness) all.push_back({describe_setting(*group), group});
  for (const ComparisonRuns::Other& other : e.variants)
    all.push_back({other.what->name, other.runs});
  return all;
}

// The largest change, in shares of what was there, that is one for certain.
std::string headline(const std::vector<VariantEffect>& all) {
  const VariantEffect* worst = nullptr;
  int certain = 0;
  const auto share = [](const VariantEffect& c) { return std::abs(c.after / c.before - 1); };
  for (const VariantEffect& c : all) {
    if (c.seeds < 2 || !(std::abs(c.after - c.before) > student_factor(c.seeds - 1) * c.error))
      continue;
    ++certain;
    if (std::isfinite(share(c)) && (worst == nullptr || share(c) > share(*worst))) worst = &c;
  }
  if (all.empty()) return "no run shows what choices do";
  std::string text =
      fmt::format("{} of {} changes stand out from the scatter of the seeds", certain, all.size());
  if (worst != nullptr)
    text += fmt::format("; the largest: {} goes from {} to {} with {}", worst->response,
                        rounded_text(worst->before, worst->unit),
                        rounded_text(worst->after, worst->unit), worst->variant);
  return text;
}

}  // namespace

void compare_variants(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  c.verdict = ValidationVerdict::not_judged;
  for (std::size_t i = 0; i < what.responses.size(); ++i) {
    const std::string& response = what.responses[i];
    for (const NumericalVariant& variant : variants_of(e)) {
      const Change change = with_place(what.response_place(i), [&] {
        return change_between(*e.numerics_base, *variant.runs, response);
      });
      if (change.seeds == 0) {
        c.caveats.push_back(fmt::format("{}: no run finished", variant.name));
        continue;
      }
      std::string unit;
      for (const JobResult* r : e.numerics_base->finished())
        unit = unit_of(parse_response_expression(response), r->responses);
      c.variants.push_back(
          {response, unit, variant.name, change.seeds, change.before, change.after, change.error});
    }
  }
  c.headline = headline(c.variants);
}

}  // namespace firn::comparison
