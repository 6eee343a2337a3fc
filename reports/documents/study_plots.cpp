#include "reports/documents/study_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/text/number_text.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::words;

// "9.1 to 10.9"
std::string range_text(double low, double high) {
  return fmt::format("{} to {}", number_text(low, 3), number_text(high, 3));
}

// A predicted distribution of one response (calibrate/inference/posterior_predictive.h).
struct PredictedDistribution {
  std::vector<double> quantiles;           // of 2.5, 16, 50, 84 and 97.5 %
  std::vector<double> edges, probability;  // [bins + 1], [bins]
};

PredictedDistribution predicted_distribution(const Json& j) {
  constexpr std::size_t kQuantiles = 5;
  const Json& histogram = j.at("histogram");
  const std::size_t bins = list(histogram, "probability").size();
  PredictedDistribution d{ascending_numbers(j.at("quantiles"), kQuantiles),
                          ascending_numbers(histogram.at("edges"), bins + 1),
                          finite_numbers(histogram.at("probability"), bins)};
  for (std::size_t i = 0; i < bins; ++i)
    if (!(d.edges[i] < d.edges[i + 1]) || d.probability[i] < 0)
      throw BadValue("a histogram has a bin without width or with a negative probability");
  return d;
}

// The histogram as an outline, its largest density 1; the central 95 % are shaded.
plots::Series density_series(const std::string& name, const PredictedDistribution& d) {
  plots::Series s{name, {}, {}};
  if (d.probability.empty()) return s;
  std::vector<double> corners = d.edges, density;
  for (std::size_t i = 0; i < d.probability.size(); ++i)
    density.push_back(d.probability[i] / (d.edges[i + 1] - d.edges[i]));
  const double most = *std::ranges::max_element(density);
  const double first = d.quantiles.front(), last = d.quantiles.back();
  for (const double q : {first, last})
    if (d.edges.front() < q && q < d.edges.back()) corners.push_back(q);
  std::ranges::sort(corners);
  const auto add = [&](double x, double y, bool shaded) {
    s.x.push_back(x);
    s.y.push_back(y);
    s.low.push_back(shaded ? 0 : std::nan(""));
    s.high.push_back(shaded ? y : std::nan(""));
  };
  add(d.edges.front(), 0, false);
  std::size_t bin = 0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    while (bin + 2 < d.edges.size() && corners[i] >= d.edges[bin + 1]) ++bin;
    const double y = most > 0 ? density[bin] / most : 0;
    const bool shaded = first <= corners[i] && corners[i + 1] <= last;
    add(corners[i], y, shaded);
    add(corners[i + 1], y, shaded);
  }
  add(d.edges.back(), 0, false);
  return s;
}

page::Figure prediction_figure(const Json& target, const PredictedDistribution& mean,
                               const PredictedDistribution& run) {
  const std::string response = text(target, "response"),
                    unit = unit_text(target.value("unit", "1"));
  const double value = finite_number(target.at("value")),
               uncertainty = finite_number(target.at("uncertainty"));
  plots::XyPlot plot;
  plot.x = {words(response), unit, false, {}, {}};
  plot.y = {"relative density", "", false, 0.0, 1.3};
  constexpr double kAbove = 1.15;  // the densities
  plot.series = {density_series("mean response", mean),
                 density_series("single run", run),
                 {"measured ± 1 standard uncertainty",
                  {value},
                  {kAbove},
                  plots::Style::points,
                  {uncertainty}}};
  plot.vertical = {{value, ""}};
  const auto summary = [&](const PredictedDistribution& d) {
    return fmt::format("{}{}, 95 % {}", number_text(d.quantiles[2]), unit_suffix(unit),
                       range_text(d.quantiles.front(), d.quantiles.back()));
  };
  return {plots::draw(plot),
          fmt::format("Prediction of {} from the posterior samples; 95 % shaded.", response),
          fmt::format("{}: measured {}{}; mean response {}; single run {}", response,
                      measured_text(value, uncertainty), unit_suffix(unit), summary(mean),
                      summary(run))};
}

// Median and intervals of one parameter after each round.
struct ParameterHistory {
  std::vector<double> runs, median, low_68, high_68, low_95, high_95;
};

ParameterHistory history_of(const Json& rounds, const std::string& parameter) {
  ParameterHistory h;
  for (const Json& round : rounds) {
    const Json& p = round.at("parameters").at(parameter);
    const std::vector<double> inner = ascending_numbers(p.at("interval_68"), 2),
                              outer = ascending_numbers(p.at("interval_95"), 2);
    h.runs.push_back(whole_number(round, "runs"));
    h.median.push_back(finite_number(p.at("median")));
    h.low_68.push_back(inner[0]);
    h.high_68.push_back(inner[1]);
    h.low_95.push_back(outer[0]);
    h.high_95.push_back(outer[1]);
  }
  return h;
}

page::Figure history_figure(const Json& parameter, const ParameterHistory& h) {
  const std::string name = text(parameter, "name"), unit = unit_text(parameter.value("unit", "1"));
  plots::XyPlot plot;
  plot.x = {"runs", "", false, {}, {}, true};
  plot.y = {words(name), unit, parameter.value("scale", "") == "log", {}, {}};
  plots::Series series{"", h.runs, h.median, plots::Style::joined};
  series.low = h.low_68;
  series.high = h.high_68;
  series.wide_low = h.low_95;
  series.wide_high = h.high_95;
  plot.series = {series};
  return {plots::draw(plot),
          fmt::format("Median of {} with its 68 % (dark) and 95 % interval (light).", name),
          fmt::format("{}: {}{} after {} runs, {}{} after {} runs, 95 % {}", name,
                      number_text(h.median.front()), unit_suffix(unit), number_text(h.runs.front()),
                      number_text(h.median.back()), unit_suffix(unit), number_text(h.runs.back()),
                      range_text(h.low_95.back(), h.high_95.back()))};
}

page::Figure sensitivity_figure(const Json& results, const char* index, const char* label,
                                const char* caption) {
  plots::BarPlot bars;
  bars.y = {label, "", false, 0.0, {}};
  const std::string interval = fmt::format("{}_interval_95", index);
  std::string seen;
  std::vector<std::string> parameters;
  for (const Json& p : results.at("parameters")) {
    parameters.push_back(text(p, "name"));
    bars.series.push_back({words(parameters.back()), {}});
  }
  for (const Json& s : results.at("sensitivity")) {
    bars.categories.push_back(words(text(s, "response")));
    const Json& of = s.at("parameters");
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      plots::BarSeries& series = bars.series[k];
      series.values.push_back(std::nan(""));
      series.low.push_back(std::nan(""));
      series.high.push_back(std::nan(""));
      if (!of.contains(parameters[k])) continue;
      const Json& indices = of.at(parameters[k]);
      if (std::string(index) == "total" && !indices.contains(index)) continue;
      series.values.back() = number(indices, index);
      seen += fmt::format("{} by {}: {}", bars.categories.back(), series.name,
                          number_text(series.values.back(), 2));
      if (indices.contains(interval)) {
        const std::vector<double> ends = ascending_numbers(indices.at(interval), 2);
        series.low.back() = ends[0];
        series.high.back() = ends[1];
        seen += fmt::format(" ({})", range_text(ends[0], ends[1]));
      }
      seen += ". ";
    }
  }
  if (seen.empty()) return {};
  return {plots::draw(bars), caption, seen};
}

}  // namespace

void predictions_section(const Json& results, page::Page& page) {
  page::Table table;
  table.caption =
      "Mean response: the model over the posterior samples; single run: with the uncertainty of "
      "the "
      "model and the scatter of a run between seeds";
  table.columns = {
      {"response", ""},   {"unit", ""},       {"measured", ""},         {"median", ""},
      {"mean, 68 %", ""}, {"mean, 95 %", ""}, {"single run, 68 %", ""}, {"single run, 95 %", ""}};
  std::vector<page::Figure> figures;
  for (const Json& t : results.at("targets")) {
    if (!t.contains("posterior_predictive")) continue;
    const Json& predicted = t.at("posterior_predictive");
    const PredictedDistribution mean = predicted_distribution(predicted.at("mean_response")),
                                run = predicted_distribution(predicted.at("single_run"));
    figures.push_back(prediction_figure(t, mean, run));
    const std::vector<double>&m = mean.quantiles, &r = run.quantiles;
    table.rows.push_back(
        {text(t, "response"), unit_text(t.value("unit", "1")),
         page::Cell::measured(finite_number(t.at("value")), finite_number(t.at("uncertainty"))),
         page::Cell(m[2], 4), range_text(m[1], m[3]), range_text(m[0], m[4]),
         range_text(r[1], r[3]), range_text(r[0], r[4])});
  }
  if (figures.empty()) return;
  page.section("Predicted responses", "predicted").figures(figures).table(table);
}

void estimate_history_section(const Json& results, page::Page& page) {
  if (!results.contains("estimate_history")) return;
  const Json& rounds = list(results, "estimate_history");
  if (rounds.empty()) return;
  page::Table table;
  table.caption = "Each parameter after each round of runs";
  table.columns = {{"parameter", ""}, {"unit", ""}, {"after", ""}, {"runs", ""},
                   {"median", ""},    {"68 %", ""}, {"95 %", ""}};
  std::vector<page::Figure> figures;
  for (const Json& p : results.at("parameters")) {
    const ParameterHistory h = history_of(rounds, text(p, "name"));
    figures.push_back(history_figure(p, h));
    for (std::size_t i = 0; i < rounds.size(); ++i)
      table.rows.push_back({text(p, "name"), unit_text(p.value("unit", "1")),
                            text(rounds[i], "after"), page::Cell(h.runs[i], 9),
                            page::Cell(h.median[i], 4), range_text(h.low_68[i], h.high_68[i]),
                            range_text(h.low_95[i], h.high_95[i])});
  }
  if (figures.empty()) return;
  page::Content numbers_of_all;
  numbers_of_all.table(table);
  page.section("Estimate by number of runs", "history")
      .figures(figures)
      .fold("Numbers of these plots", numbers_of_all);
}

void add_sensitivity(const Json& results, page::Content& content) {
  if (!results.contains("sensitivity")) return;
  std::vector<page::Figure> figures;
  for (const page::Figure& figure :
       {sensitivity_figure(results, "first", "first-order Sobol index",
                           "Share of each response's variance over the ranges by each parameter "
                           "alone, with 95 % intervals."),
        sensitivity_figure(results, "total", "total Sobol index",
                           "The same with its interactions with other parameters.")})
    if (!figure.svg.empty()) figures.push_back(figure);
  if (!figures.empty()) content.heading("Sensitivity").figures(figures);
}

}  // namespace firn
