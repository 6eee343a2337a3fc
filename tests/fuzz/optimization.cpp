// Optimization files, next to a case that exists.
#include <cmath>

#include "calibrate/optimization/optimization_study.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const fuzz::FolderWithCase folder;
  const std::string file = folder.put("optimization.toml", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const OptimizationStudy o = read_optimization(file);
    const int parameters = static_cast<int>(o.study.parameters.size());
    fuzz::require(o.largest_designs() >= parameters + 2, "a model can be fitted");
    fuzz::require(
        std::int64_t{o.largest_designs()} * o.replicates_per_design + o.confirmation_runs() <=
            o.runs,
        "the runs are not exceeded");
    fuzz::require(!o.study.observed.empty(), "there is an objective");
    for (const EventLimit& limit : o.limits) {
      fuzz::require(limit.response < o.study.observed.size(), "a limit has a response");
      fuzz::require(std::isfinite(limit.threshold), "a threshold is finite");
      fuzz::require(limit.probability > 0 && limit.probability < 1, "a limit is a probability");
      fuzz::require_one_line(o.event_text(limit));
    }
    for (const CompareSet& set : o.study.compare)
      fuzz::require(set.values.size() == o.study.parameters.size(),
                    "a compared design is complete");
  });
  return 0;
}
