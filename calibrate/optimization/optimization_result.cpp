// The result of an optimization as a text table and as results.json.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/optimization/optimization_document.h"
#include "calibrate/optimization/optimize_design.h"
#include "calibrate/output/text_format.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

using Document = OptimizationDocument;

Document::Design design_document(const TriedDesign& t) {
  Document::Design d;
  d.name = t.name;
  d.values = t.values;
  d.runs = t.runs;
  d.finished = t.finished;
  if (t.objective.count > 0) d.mean = t.objective.mean;
  d.standard_deviation = t.objective.sd();
  for (const EventRate& e : t.events)
    d.events.push_back({e.events, e.runs, {e.interval_95.low, e.interval_95.high}, std::nan("")});
  if (!t.predicted) return d;
  d.predicted_mean = t.predicted->mean;
  d.predicted_sd = t.predicted->sd;
  d.limits_kept = t.predicted->kept;
  for (std::size_t k = 0; k < d.events.size(); ++k)
    d.events[k].predicted = t.predicted->probabilities[k];
  return d;
}

// 95 % of single runs of a design, another seed and another draw of the material, by Student's
// distribution from its own runs.
std::optional<Document::Prediction> next_run(const Sample& s) {
  if (s.count < 2) return std::nullopt;
  const double reach = student_factor(s.count - 1) * s.sd() * std::sqrt(1 + 1.0 / s.count);
  return Document::Prediction{{s.mean - reach, s.mean + reach}};
}

Document document_of(const OptimizationResult& r) {
  const OptimizationStudy& o = r.optimization;
  const Study& study = o.study;
  Document d;
  d.name = study.name;
  d.case_file = study.experiments.front().case_file;
  d.verdict = to_string(r.verdict);
  d.headline = r.headline;
  d.goal = o.maximize ? "maximize" : "minimize";
  d.objective = o.objective().label;
  d.unit = stored_unit(r.objective_unit);
  d.material = study.drawn_material;
  d.confidence = o.confidence;
  d.runs = r.runs;
  d.not_finished = r.not_finished;
  for (const Parameter& p : study.parameters)
    d.parameters.push_back(
        {p.name, stored_unit(p.unit), p.logarithmic ? "log" : "linear", p.keys, p.min, p.max});
  for (const EventLimit& limit : o.limits)
    d.limits.push_back({study.observed[limit.response].response.name,
                        limit.above ? "above" : "below", limit.threshold,
                        study.observed[limit.response].unit, limit.probability});
  for (const TriedDesign& t : r.designs) d.designs.push_back(design_document(t));
  for (const TriedDesign& t : r.compared) d.compared.push_back(design_document(t));
  if (r.best) {
    d.best = design_document(*r.best);
    d.prediction = next_run(r.best->objective);
  }
  for (std::size_t i = 0; i < r.gains.size(); ++i) {
    const DesignDifference& gain = r.gains[i];
    d.gains.push_back({r.compared[i].name, gain.mean, {gain.low, gain.high}, gain.pairs});
  }
  for (std::size_t i = 0; i < r.slices.size(); ++i) {
    const DesignSlice& s = r.slices[i];
    d.slices.push_back({study.parameters[i].name, s.values, s.mean, s.sd, s.kept});
  }
  return d;
}

// Texts in columns, the first to the left and the others to the right.
std::string columns(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      width.resize(std::max(width.size(), row.size()));
      width[i] = std::max(width[i], fmt::formatted_size("{}", row[i]));
    }
  std::string text;
  for (const auto& row : rows) {
    std::string line = fmt::format("  {:<{}}", row[0], width[0]);
    for (std::size_t i = 1; i < row.size(); ++i) line += fmt::format("  {:>{}}", row[i], width[i]);
    text += line + "\n";
  }
  return text;
}

std::vector<std::string> head(const OptimizationResult& r) {
  const OptimizationStudy& o = r.optimization;
  std::vector<std::string> cells = {"design"};
  for (const Parameter& p : o.study.parameters)
    cells.push_back(p.name + (p.unit.empty() ? "" : " [" + p.unit + "]"));
  const std::string unit = unit_text(r.objective_unit);
  cells.push_back(o.objective().label + (unit.empty() ? "" : " [" + unit + "]"));
  for (const EventLimit& limit : o.limits) cells.push_back(o.event_text(limit));
  cells.emplace_back("limits kept");
  return cells;
}

std::vector<std::string> row(const OptimizationResult& r, const TriedDesign& t) {
  const OptimizationStudy& o = r.optimization;
  std::vector<std::string> cells = {t.name};
  for (std::size_t i = 0; i < t.values.size(); ++i)
    cells.push_back(o.study.parameters[i].text(t.values[i]));
  cells.push_back(
      t.objective.count == 0
          ? "no value"
          : measured_text(t.objective.mean, t.objective.sd() / std::sqrt(t.objective.count)));
  for (const EventRate& e : t.events) cells.push_back(fmt::format("{} of {}", e.events, e.runs));
  cells.push_back(t.predicted ? fmt::format("{:.2g}", t.predicted->kept) : "");
  return cells;
}

}  // namespace

std::string render_json(const OptimizationResult& r) { return json_text(document_of(r), 1); }

OptimizationDocument read_optimization_document(const ResultsJson& results) {
  return document_from_results<OptimizationDocument>(results, "optimization", "firn optimize");
}

std::string render_table(const OptimizationResult& r) {
  const OptimizationStudy& o = r.optimization;
  fmt::memory_buffer out;
  print(out, "Designs of the search\n");
  std::vector<std::vector<std::string>> rows = {head(r)};
  for (const TriedDesign& t : r.designs) rows.push_back(row(r, t));
  print(out, "{}", columns(rows));
  if (r.best) {
    print(out, "\nBy fresh seeds\n");
    rows = {head(r), row(r, *r.best)};
    for (const TriedDesign& t : r.compared) rows.push_back(row(r, t));
    print(out, "{}", columns(rows));
    for (std::size_t i = 0; i < r.gains.size(); ++i)
      print(out, "  best minus {}: {}{}, 95 % interval {} to {}, {} pairs of runs\n",
            r.compared[i].name, number_text(r.gains[i].mean), unit_suffix(r.objective_unit),
            number_text(r.gains[i].low), number_text(r.gains[i].high), r.gains[i].pairs);
    if (const auto next = next_run(r.best->objective))
      print(out, "  one more run of the best: {} to {}{} with a probability of 95 %\n",
            number_text(next->interval_95.first), number_text(next->interval_95.second),
            unit_suffix(r.objective_unit));
    for (std::size_t k = 0; k < o.limits.size(); ++k)
      print(out, "  {}: probability {} by the model, {} to {} by the fresh seeds alone; limit {}\n",
            o.event_text(o.limits[k]), number_text(r.best->predicted->probabilities[k], 2),
            number_text(r.best->events[k].interval_95.low, 2),
            number_text(r.best->events[k].interval_95.high, 2),
            number_text(o.limits[k].probability));
  }
  print(out, "\n{} of at most {} runs{}\n{}: {}\n", r.runs, o.runs,
        r.not_finished > 0 ? fmt::format(", {} of which gave no value", r.not_finished) : "",
        to_string(r.verdict), r.headline);
  return fmt::to_string(out);
}

}  // namespace firn
