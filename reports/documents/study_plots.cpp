#include "reports/documents/study_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "experiments/text/number_text.h"
#include "reports/html/results_page.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::words;

using Distribution = StudyDocument::Distribution;
using Indices = StudyDocument::Sensitivity::Indices;

void require_ascending(const std::vector<double>& values, std::size_t count, const char* what) {
  const bool finite = std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
  if (values.size() != count || !finite || !std::ranges::is_sorted(values))
    throw BadValue(fmt::format("{} are not {} numbers in ascending order", what, count));
}

void require_ascending(const StudyDocument::Interval& interval) {
  require_ascending(std::vector<double>{interval.first, interval.second}, 2,
                    "the ends of an interval");
}

double require_finite(double value, const char* what) {
  if (!std::isfinite(value)) throw BadValue(fmt::format("{} is not a number", what));
  return value;
}

void check_distribution(const Distribution& d) {
  constexpr std::size_t kQuantiles = 5;
  require_ascending(d.quantiles, kQuantiles, "quantiles");
  const std::vector<double>&edges = d.histogram.edges, &probability = d.histogram.probability;
  require_ascending(edges, probability.size() + 1, "the edges of a histogram");
  for (std::size_t i = 0; i < probability.size(); ++i)
    if (!(edges[i] < edges[i + 1]) || !(probability[i] >= 0))
      throw BadValue("a histogram has a bin without width or without a probability");
}

// The histogram as an outline, its largest density 1; the central 95 % are shaded.
plots::Series density_series(const std::string& name, const Distribution& d) {
  plots::Series s{name, {}, {}};
  const std::vector<double>&edges = d.histogram.edges, &probability = d.histogram.probability;
  if (probability.empty()) return s;
  std::vector<double> corners = edges, density;
  for (std::size_t i = 0; i < probability.size(); ++i)
    density.push_back(probability[i] / (edges[i + 1] - edges[i]));
  const double most = *std::ranges::max_element(density);
  const double first = d.quantiles.front(), last = d.quantiles.back();
  for (const double q : {first, last})
    if (edges.front() < q && q < edges.back()) corners.push_back(q);
  std::ranges::sort(corners);
  const auto add = [&](double x, double y, bool shaded) {
    s.x.push_back(x);
    s.y.push_back(y);
    s.low.push_back(shaded ? 0 : std::nan(""));
    s.high.push_back(shaded ? y : std::nan(""));
  };
  add(edges.front(), 0, false);
  std::size_t bin = 0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    while (bin + 2 < edges.size() && corners[i] >= edges[bin + 1]) ++bin;
    const double y = most > 0 ? density[bin] / most : 0;
    const bool shaded = first <= corners[i] && corners[i + 1] <= last;
    add(corners[i], y, shaded);
    add(corners[i + 1], y, shaded);
  }
  add(edges.back(), 0, false);
  return s;
}

page::Figure prediction_figure(const StudyDocument::Target& target, const Distribution& mean,
                               const Distribution& run) {
  const std::string response = target.response, unit = unit_text(target.unit);
  const double value = require_finite(target.value, "the value of a target"),
               uncertainty = require_finite(target.uncertainty, "the uncertainty of a target");
  plots::XyPlot plot;
  plot.x = {words(response), unit, false, {}, {}};
  plot.y = {"relative density", "", false, 0.0, 1.3};
  constexpr double kAbove = 1.15;  // the densities
  plot.series = {
      density_series("mean response", mean),
      density_series("single run", run),
      {"measured ± standard uncertainty", {value}, {kAbove}, plots::Style::points, {uncertainty}}};
  plot.vertical = {{value, ""}};
  const auto summary = [&](const Distribution& d) {
    return fmt::format("{}{}, 95 % {}", number_text(d.quantiles[2]), unit_suffix(unit),
                       range_text(d.quantiles.front(), d.quantiles.back()));
  };
  return {plots::draw(plot),
          fmt::format("Prediction of {} from the posterior samples; 95 % shaded.", words(response)),
          fmt::format("{}: measured {}; mean response {}; single run {}", response,
                      measured_text(value, uncertainty, unit), summary(mean), summary(run))};
}

// Median and intervals of one parameter after each round.
struct ParameterHistory {
  std::vector<double> runs, median, low_68, high_68, low_95, high_95;
};

ParameterHistory history_of(const std::vector<StudyDocument::Round>& rounds,
                            const std::string& parameter) {
  ParameterHistory h;
  for (const StudyDocument::Round& round : rounds) {
    const StudyDocument::Marginal* p = find_named(round.parameters, parameter);
    if (p == nullptr) throw BadValue(fmt::format("a round has no \"{}\"", parameter));
    require_ascending(p->interval_68);
    require_ascending(p->interval_95);
    h.runs.push_back(static_cast<double>(round.runs));
    h.median.push_back(require_finite(p->median, "a median"));
    h.low_68.push_back(p->interval_68.first);
    h.high_68.push_back(p->interval_68.second);
    h.low_95.push_back(p->interval_95.first);
    h.high_95.push_back(p->interval_95.second);
  }
  return h;
}

page::Figure history_figure(const StudyDocument::Parameter& parameter, const ParameterHistory& h) {
  const std::string &name = parameter.name, unit = unit_text(parameter.unit);
  plots::XyPlot plot;
  plot.x = {"runs", "", false, {}, {}, true};
  plot.y = {words(name), unit, parameter.logarithmic(), {}, {}};
  plots::Series series{"", h.runs, h.median, plots::Style::joined};
  series.low = h.low_68;
  series.high = h.high_68;
  series.wide_low = h.low_95;
  series.wide_high = h.high_95;
  plot.series = {series};
  return {plots::draw(plot),
          fmt::format("Median of {} with its 68 % (dark) and 95 % interval (light).", words(name)),
          fmt::format("{}: {}{} after {} runs, {}{} after {} runs, 95 % {}", name,
                      number_text(h.median.front()), unit_suffix(unit), number_text(h.runs.front()),
                      number_text(h.median.back()), unit_suffix(unit), number_text(h.runs.back()),
                      range_text(h.low_95.back(), h.high_95.back()))};
}

page::Figure sensitivity_figure(
    const StudyDocument& results, const char* label, const char* caption,
    const std::function<std::optional<double>(const Indices&)>& index_of,
    std::optional<StudyDocument::Interval> Indices::*interval_of) {
  plots::BarPlot bars;
  bars.y = {label, "", false, 0.0, {}};
  std::string seen;
  for (const StudyDocument::Parameter& p : results.parameters)
    bars.series.push_back({words(p.name), {}});
  for (const StudyDocument::Sensitivity& s : results.sensitivity) {
    bars.categories.push_back(words(s.response));
    for (std::size_t k = 0; k < results.parameters.size(); ++k) {
      plots::BarSeries& series = bars.series[k];
      series.values.push_back(std::nan(""));
      series.low.push_back(std::nan(""));
      series.high.push_back(std::nan(""));
      const Indices* indices = find_named(s.parameters, results.parameters[k].name);
      const std::optional<double> index = indices == nullptr ? std::nullopt : index_of(*indices);
      if (!index) continue;
      series.values.back() = *index;
      seen += fmt::format("{} by {}: {}", bars.categories.back(), series.name,
                          number_text(series.values.back(), 2));
      if (const auto& ends = indices->*interval_of) {
        require_ascending(*ends);
        series.low.back() = ends->first;
        series.high.back() = ends->second;
        seen += fmt::format(" ({})", range_text(ends->first, ends->second));
      }
      seen += ". ";
    }
  }
  if (seen.empty()) return {};
  return {plots::draw(bars), caption, seen};
}

}  // namespace

void predictions_section(const StudyDocument& results, page::Page& page) {
  page::Table table;
  table.caption =
      "Mean response: the model over the posterior samples; single run: with the uncertainty of "
      "the "
      "model and the scatter of a run between seeds";
  table.columns = {
      {"response", ""},   {"unit", ""},       {"measured", ""},         {"median", ""},
      {"mean, 68 %", ""}, {"mean, 95 %", ""}, {"single run, 68 %", ""}, {"single run, 95 %", ""}};
  std::vector<page::Figure> figures;
  for (const StudyDocument::Target& t : results.targets) {
    if (!t.posterior_predictive) continue;
    const Distribution &mean = t.posterior_predictive->mean_response,
                       &run = t.posterior_predictive->single_run;
    check_distribution(mean);
    check_distribution(run);
    figures.push_back(prediction_figure(t, mean, run));
    const std::vector<double>&m = mean.quantiles, &r = run.quantiles;
    table.rows.push_back({t.response, unit_text(t.unit),
                          page::Cell::measured(t.value, t.uncertainty), page::Cell(m[2], 4),
                          range_text(m[1], m[3]), range_text(m[0], m[4]), range_text(r[1], r[3]),
                          range_text(r[0], r[4])});
  }
  if (figures.empty()) return;
  page.section("Predicted responses", "predicted").figures(figures).table(table);
}

void estimate_history_section(const StudyDocument& results, page::Page& page) {
  const std::vector<StudyDocument::Round>& rounds = results.estimate_history;
  if (rounds.empty()) return;
  page::Table table;
  table.caption = "Each parameter after each round of runs";
  table.columns = {{"parameter", ""}, {"unit", ""}, {"after", ""}, {"runs", ""},
                   {"median", ""},    {"68 %", ""}, {"95 %", ""}};
  std::vector<page::Figure> figures;
  for (const StudyDocument::Parameter& p : results.parameters) {
    const ParameterHistory h = history_of(rounds, p.name);
    figures.push_back(history_figure(p, h));
    for (std::size_t i = 0; i < rounds.size(); ++i)
      table.rows.push_back({p.name, unit_text(p.unit), rounds[i].after, page::Cell(h.runs[i], 9),
                            page::Cell(h.median[i], 4), range_text(h.low_68[i], h.high_68[i]),
                            range_text(h.low_95[i], h.high_95[i])});
  }
  if (figures.empty()) return;
  page::Content numbers_of_all;
  numbers_of_all.table(table);
  page.section("Estimate by number of runs", "history")
      .figures(figures)
      .collapsible("Numbers of these plots", numbers_of_all);
}

void add_sensitivity(const StudyDocument& results, page::Content& content) {
  if (results.sensitivity.empty()) return;
  if (results.parameters.size() == 1) {
    content.heading("Sensitivity")
        .paragraph(fmt::format("The study has one parameter, {}: every change of a response over "
                               "its range is by it alone.",
                               words(results.parameters.front().name)));
    return;
  }
  std::vector<page::Figure> figures;
  for (const page::Figure& figure :
       {sensitivity_figure(
            results, "first-order Sobol index",
            "Share of each response's variance over the ranges by each parameter "
            "alone, with 95 % intervals.",
            [](const Indices& i) { return i.first; }, &Indices::first_interval_95),
        sensitivity_figure(
            results, "total Sobol index", "The same with its interactions with other parameters.",
            [](const Indices& i) { return i.total; }, &Indices::total_interval_95)})
    if (!figure.svg.empty()) figures.push_back(figure);
  if (!figures.empty()) content.heading("Sensitivity").figures(figures);
}

}  // namespace firn
