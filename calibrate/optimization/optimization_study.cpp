#include "calibrate/optimization/optimization_study.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibrate/study/budget.h"
#include "calibrate/study/read_parameters.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/number_text.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// The index of the response among the observed ones, where it is added. `unit`: empty where the
// file states none.
std::size_t observe(const TomlTable& t, const char* key, const std::string& unit, Study& study) {
  const std::string name = current_response(t, key, t.string(key));
  auto found = std::ranges::find_if(study.observed,
                                    [&](const Observed& o) { return o.response.name == name; });
  if (found == study.observed.end())
    found = study.observed.insert(found, {.response = {0, name, name}, .unit = unit});
  if (found->unit.empty()) found->unit = unit;
  if (!unit.empty() && found->unit != unit)
    t.fail(key, fmt::format("\"{}\" has a limit in \"{}\" and one in \"{}\"; expected one unit",
                            name, found->unit, unit));
  return static_cast<std::size_t>(found - study.observed.begin());
}

void read_objective(const TomlTable& head, OptimizationStudy& o) {
  if (head.has("maximize") == head.has("minimize"))
    head.fail("maximize", head.has("maximize")
                              ? "is given together with minimize; expected one or the other"
                              : "is missing; expected maximize or minimize with a response");
  o.maximize = head.has("maximize");
  observe(head, o.maximize ? "maximize" : "minimize", "", o.study);
}

double read_probability(const TomlTable& t, const char* key) {
  const double p = t.number(key);
  if (!(p > 0 && p < 1))
    t.fail(key, fmt::format("is {}; expected a probability above 0 and below 1", p));
  return p;
}

EventLimit read_limit(const TomlTable& t, OptimizationStudy& o) {
  t.allow({"response", "above", "below", "probability"});
  if (t.has("above") == t.has("below"))
    t.fail("above", t.has("above") ? "is given together with below; expected one or the other"
                                   : "is missing; expected above or below with the threshold of "
                                     "the event");
  EventLimit limit;
  limit.above = t.has("above");
  const StatedQuantity threshold = read_stated_quantity(t, limit.above ? "above" : "below");
  limit.threshold = threshold.value;
  limit.response = observe(t, "response", threshold.unit.empty() ? "1" : threshold.unit, o.study);
  limit.probability = read_probability(t, "probability");
  return limit;
}

void read_design_parameters(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("parameters"))
    for (const char* key : {"choices", "prior_mean", "prior_sd"})
      if (t.has(key)) t.fail(key, "does not belong to a design; expected a range, min and max");
  read_parameters(root, study);
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    if (study.parameters[i].keys.empty())
      root.tables("parameters")[i].fail(
          "keys", "is missing; expected a list such as [\"boundaries.auger.pitch\"]");
}

}  // namespace

std::string OptimizationStudy::event_text(const EventLimit& limit) const {
  const Observed& o = study.observed[limit.response];
  return fmt::format("{} {} {}{}", o.response.name, limit.above ? "above" : "below",
                     number_text(limit.threshold), unit_suffix(o.unit));
}

std::int64_t OptimizationStudy::confirmation_runs() const {
  return (1 + std::ssize(study.compare)) * confirmation_replicates;
}

int OptimizationStudy::largest_designs() const {
  return static_cast<int>(std::max<std::int64_t>(0, runs - confirmation_runs()) /
                          replicates_per_design);
}

OptimizationStudy read_optimization(const std::string& file) {
  OptimizationStudy o;
  Study& study = o.study;
  study.source = file;
  study.text = read_input_file(file, "an optimization file (TOML)", input_limits::toml_bytes);
  TomlDocument document(study.text, file, TomlFormat::study);
  require_kind(document, "optimization");
  const TomlTable root = TomlTable::root(document);
  root.allow({"optimization", "parameters", "limits", "compare", "execution"});
  const TomlTable head = root.required_table("optimization");
  head.allow({"name", "case", "set", "material", "maximize", "minimize", "runs",
              "replicates_per_design", "designs_per_round", "confirmation_replicates", "confidence",
              "seed", "threads"});
  study.name = valid_name(head);
  study.seed = static_cast<std::uint64_t>(head.integer("seed", 0, 1));
  study.threads = head.integer("threads", 1, 1);
  if (head.has("material")) study.drawn_material = head.string("material");
  if (study.drawn_material.find('#') != std::string::npos)
    head.fail("material", fmt::format("\"{}\" names one draw of the record; expected the record, "
                                      "as each seed takes another draw",
                                      study.drawn_material));
  read_design_parameters(root, study);
  Experiment experiment{"",
                        case_path(head, file, "optimization"),
                        {},
                        std::vector<bool>(study.parameters.size(), true)};
  experiment.set = read_case_overrides(head, &experiment.set_places);
  study.experiments.push_back(std::move(experiment));
  read_objective(head, o);
  for (const TomlTable& t : root.tables("limits")) o.limits.push_back(read_limit(t, o));
  read_compare(root, study);
  study.execution = read_execution(root);
  const auto count = [&](const char* key, int least, int usual) {
    return checked_count(head, key, head.integer(key, least, usual));
  };
  o.replicates_per_design = count("replicates_per_design", 2, 3);
  o.designs_per_round = count("designs_per_round", 1, 2);
  o.confirmation_replicates = count("confirmation_replicates", 2, 10);
  if (head.has("confidence")) o.confidence = read_probability(head, "confidence");
  o.runs = checked_count(head, "runs", head.integer("runs", 1));
  const int d = static_cast<int>(study.parameters.size()), least = d + 2;
  if (o.largest_designs() < least)
    head.fail("runs",
              fmt::format("{} are too few: {} confirm, and a model of {} parameters needs "
                          "{} designs of {} runs; expected at least {}",
                          o.runs, o.confirmation_runs(), d, least, o.replicates_per_design,
                          o.confirmation_runs() + std::int64_t{least} * o.replicates_per_design));
  return o;
}

}  // namespace firn
