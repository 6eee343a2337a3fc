#include "experiments/case_statistics.h"

namespace firn {

StatisticsOptions read_statistics(const TomlTable& root) {
  StatisticsOptions options;
  if (!root.has("statistics")) return options;
  const TomlTable t = root.required_table("statistics");
  t.allow({"events"});
  if (t.has("events")) {
    const TomlTable events = t.required_table("events");
    events.allow({"threshold", "merge"});
    options.events = true;
    options.threshold = events.quantity("threshold", dimension::force, Sign::non_negative);
    options.merge = events.quantity("merge", dimension::time, Sign::non_negative, "0 s");
  }
  return options;
}

}  // namespace firn
