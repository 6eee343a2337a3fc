#include "reports/documents/optimization_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/optimization/optimization_document.h"
#include "experiments/storage/version.h"
#include "experiments/text/number_text.h"
#include "reports/html/results_page.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;
using page::words;
using Document = OptimizationDocument;

Badge optimization_badge(const Document& d) {
  const bool recommended = d.verdict == "recommended";
  const Mark mark = recommended                                  ? Mark::good
                    : d.verdict == "limits not shown to be kept" ? Mark::caution
                                                                 : Mark::bad;
  return {mark, d.verdict};
}

std::string event_words(const Document::Limit& limit) {
  return fmt::format("{} {} {}{}", words(limit.response), limit.side, number_text(limit.threshold),
                     unit_suffix(limit.unit));
}

double standard_error(const Document::Design& d) {
  return d.finished > 0 ? d.standard_deviation / std::sqrt(d.finished) : std::nan("");
}

void require_fitting(const Document& d, const Document::Design& design) {
  if (design.values.size() != d.parameters.size() || design.events.size() != d.limits.size())
    throw BadValue(fmt::format("the design \"{}\" has other parameters or limits", design.name));
}

page::Table design_table(const Document& d, const std::string& caption,
                         const std::vector<Document::Design>& designs) {
  page::Table table;
  table.caption = caption;
  table.columns.push_back({"design", ""});
  for (const auto& p : d.parameters) table.columns.push_back({words(p.name), p.unit});
  table.columns.push_back({words(d.objective), d.unit});
  for (const auto& limit : d.limits) table.columns.push_back({event_words(limit), ""});
  table.columns.push_back({"predicted " + words(d.objective), d.unit});
  if (!d.limits.empty()) table.columns.push_back({"limits kept, probability", ""});
  for (const Document::Design& design : designs) {
    require_fitting(d, design);
    std::vector<Cell>& row = table.rows.emplace_back(std::vector<Cell>{design.name});
    for (const double value : design.values) row.emplace_back(value);
    row.push_back(Cell::measured(design.mean, standard_error(design)));
    for (const auto& e : design.events) row.emplace_back(fmt::format("{} of {}", e.events, e.runs));
    row.push_back(Cell::measured(design.predicted_mean, design.predicted_sd));
    if (!d.limits.empty()) row.emplace_back(design.limits_kept, 2);
  }
  return table;
}

void best_section(const Document& d, page::Page& page) {
  page::Content& content = page.section("The best design", "best");
  std::vector<Document::Design> fresh = {*d.best};
  fresh.insert(fresh.end(), d.compared.begin(), d.compared.end());
  content.table(design_table(
      d,
      fmt::format("By {} fresh seeds that the search did not use; ± is one standard error",
                  d.best->runs),
      fresh));
  const std::string unit = unit_suffix(d.unit);
  std::vector<std::string> items;
  for (const auto& gain : d.gains)
    items.push_back(fmt::format(
        "{} of the best minus that of \"{}\": {}{}, 95 % interval {} to {}, by {} pairs of runs "
        "of one seed.",
        words(d.objective), gain.over, number_text(gain.mean), unit,
        number_text(gain.interval_95.first), number_text(gain.interval_95.second), gain.pairs));
  for (std::size_t k = 0; k < d.limits.size(); ++k)
    items.push_back(fmt::format(
        "{}: at most {} is allowed; {} by the model of all runs; {} to {} by the fresh seeds alone "
        "(95 %).",
        event_words(d.limits[k]), number_text(d.limits[k].probability),
        number_text(d.best->events[k].predicted, 2),
        number_text(d.best->events[k].interval_95.first, 2),
        number_text(d.best->events[k].interval_95.second, 2)));
  if (d.prediction)
    items.push_back(fmt::format(
        "A prediction that an experiment can refute: {} of one trial of this design lies between "
        "{} and {}{} with a probability of 95 %{}.",
        words(d.objective), number_text(d.prediction->interval_95.first),
        number_text(d.prediction->interval_95.second), unit,
        d.material.empty() ? "" : ", with any material of the posterior ensemble"));
  if (!items.empty()) content.list(items);
}

// The designs, and the model through the best one.
page::Figure slice_figure(const Document& d, std::size_t parameter) {
  const auto& p = d.parameters[parameter];
  const Document::Slice& slice = d.slices[parameter];
  plots::XyPlot plot;
  plot.x = {words(p.name), unit_text(p.unit), p.scale == "log", p.min, p.max};
  plot.y = {words(d.objective), unit_text(d.unit), false, {}, {}};
  plots::Series model{"model through the best", slice.values, slice.mean, plots::Style::line};
  for (std::size_t i = 0; i < slice.mean.size() && i < slice.standard_deviation.size(); ++i) {
    model.low.push_back(slice.mean[i] - 2 * slice.standard_deviation[i]);
    model.high.push_back(slice.mean[i] + 2 * slice.standard_deviation[i]);
  }
  plots::Series tried{"designs of the search", {}, {}, plots::Style::points};
  for (const Document::Design& design : d.designs) {
    require_fitting(d, design);
    tried.x.push_back(design.values[parameter]);
    tried.y.push_back(design.mean);
    tried.y_error.push_back(standard_error(design));
  }
  plot.series = {model, tried};
  plot.vertical = {{d.best->values[parameter], "best"}};
  return {plots::draw(plot), fmt::format("{} over {}.", words(d.objective), words(p.name)),
          fmt::format("{} over {}, best at {}", words(d.objective), words(p.name),
                      number_text(d.best->values[parameter]))};
}

void slices_section(const Document& d, page::Page& page) {
  if (d.slices.size() != d.parameters.size()) throw BadValue("slices and parameters differ");
  std::vector<page::Figure> figures;
  for (std::size_t i = 0; i < d.parameters.size(); ++i) figures.push_back(slice_figure(d, i));
  page.section("Over each parameter", "slices")
      .paragraph(
          "Points: mean of a design with one standard error; its other parameters differ "
          "from those of the best design. Line and band: the model through the best design "
          "and twice its standard deviation.")
      .figures(figures);
}

page::Page optimization_page_of(const Document& d) {
  page::Page page(d.name, fmt::format("optimization of {}", d.case_file));
  page.top().note(optimization_badge(d), d.headline);
  std::vector<page::Property> facts = {{d.goal, words(d.objective)}};
  for (const auto& limit : d.limits)
    facts.push_back({"probability of " + event_words(limit),
                     fmt::format("at most {}", number_text(limit.probability))});
  if (!d.material.empty())
    facts.push_back(
        {"material", d.material + ", each seed with another draw of its posterior ensemble"});
  facts.push_back({"runs", d.not_finished > 0
                               ? fmt::format("{}, {} without a value", d.runs, d.not_finished)
                               : fmt::format("{}", d.runs)});
  page.top().properties(facts);
  if (d.best) {
    require_fitting(d, *d.best);
    best_section(d, page);
    slices_section(d, page);
  }
  page.section("Designs of the search", "designs")
      .table(design_table(d, "In the order of the search; ± is one standard error", d.designs));
  page.set_footer(fmt::format("Made by Firn {}.", firn_version()));
  return page;
}

}  // namespace

page::Page optimization_page(const ResultsJson& results) {
  const Document document = read_optimization_document(results);
  return page_from(results.file, [&] { return optimization_page_of(document); });
}

}  // namespace firn
