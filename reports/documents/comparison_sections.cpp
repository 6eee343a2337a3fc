#include "reports/documents/comparison_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>

#include "experiments/text/number_text.h"
#include "experiments/text/response_aliases.h"
#include "reports/html/results_page.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;
using ComparisonRow = ValidationDocument::ComparisonRow;

std::string share(double p) { return page::number_text(100 * p, 3) + " %"; }
std::string share_range(const ValidationDocument::Interval& ends) {
  return share(ends.first) + " to " + share(ends.second);
}

// Of names that may hold numbers, whose points words() would take for those of keys.
std::string without_underscores(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

void require_lengths(std::size_t count, std::initializer_list<const std::vector<double>*> lists) {
  for (const std::vector<double>* list : lists)
    if (list->size() != count)
      throw BadValue(
          fmt::format("a list has {} numbers where another one has {}", list->size(), count));
}

void value_content(const Sets& sets, page::Content& content) {
  plots::IntervalPlot plot;
  page::Table table;
  table.caption = "Components of the validation uncertainty: one standard deviation each";
  table.columns = {{"parameters", ""}, {"component", ""}, {"uncertainty", ""}, {"from", ""}};
  bool experiment_drawn = false;
  std::string seen;
  plot.names = {"experiment", "simulation"};
  for (const ComparisonRow* c : sets) {
    if (!c->value) continue;
    const ValidationDocument::Value& v = *c->value;
    plot.x = {"mean with 95 % interval", v.unit, false, {}, {}};
    double of_experiment = 0;
    for (const ValidationDocument::Component& part : v.components) {
      const bool is_experiment = part.name == "experiment";
      if (is_experiment) of_experiment = part.value;
      if (is_experiment && experiment_drawn) continue;
      table.rows.push_back({is_experiment ? "all" : c->parameter_set, part.name,
                            std::isnan(part.value) ? Cell("not examined") : Cell(part.value, 2),
                            is_experiment ? "see above" : part.evaluation_method});
    }
    const double measured = v.measured, simulated = v.simulated;
    // Results of earlier versions have standard uncertainties alone.
    const double all = v.validation_uncertainty;
    const double experiment = v.measured_expanded.value_or(2 * of_experiment);
    const double own = v.simulated_expanded.value_or(
        2 * std::sqrt(std::max(0.0, all * all - of_experiment * of_experiment)));
    if (!experiment_drawn)
      plot.rows.push_back({"experiment",
                           {plots::Interval{measured - experiment, measured + experiment, measured},
                            std::nullopt}});
    experiment_drawn = true;
    plot.rows.push_back(
        {c->parameter_set,
         {std::nullopt, plots::Interval{simulated - own, simulated + own, simulated}}});
    seen += fmt::format("{}: {} {}; ", c->parameter_set, page::measured_text(simulated, own / 2),
                        v.unit);
  }
  if (plot.rows.empty()) return;
  content.figure({plots::draw(plot), "Simulation and experiment.", seen});
  content.table(table);
}

void claims_content(const Sets& sets, page::Content& content) {
  plots::IntervalPlot plot;
  plot.x = {"probability that it holds in a run", "", false, 0.0, 1.0};
  plot.vertical = {{0.5, ""}};
  std::map<std::string, std::size_t> row_of;
  page::Table table;
  table.caption = "Statements, and in how many runs they hold";
  table.columns = {{"", ""},         {"statement", ""},   {"parameters", ""},
                   {"holds in", ""}, {"probability", ""}, {"verdict", ""}};
  page::Table meaning;
  meaning.caption = "What the statements are taken to mean";
  meaning.columns = {{"", ""}, {"statement", ""}, {"relation", ""}, {"rationale", ""}};
  std::string seen;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    plot.names.push_back(sets[s]->parameter_set);
    for (const ValidationDocument::CriterionRow& claim : sets[s]->criteria) {
      const std::string& statement = claim.statement;
      if (!row_of.contains(statement)) {
        row_of[statement] = plot.rows.size();
        // The plot has no room for sentences: the tables state what the numbers stand for.
        const std::string label = fmt::format("statement {}", plot.rows.size() + 1);
        plot.rows.push_back({label, std::vector<std::optional<plots::Interval>>(sets.size())});
        meaning.rows.push_back({Cell(static_cast<double>(plot.rows.size())), statement,
                                claim.relation, claim.rationale});
      }
      const int holds = claim.holds_in, runs = claim.runs;
      const std::string open =
          claim.missing > 0 ? fmt::format(", {} without an answer", claim.missing) : "";
      const auto& [low, high] = claim.probability_90;
      plot.rows[row_of[statement]].intervals[s] = plots::Interval{
          low, high, runs > 0 ? std::optional(static_cast<double>(holds) / runs) : std::nullopt};
      table.rows.push_back({Cell(static_cast<double>(row_of[statement] + 1)), statement,
                            sets[s]->parameter_set, fmt::format("{} of {}{}", holds, runs, open),
                            share_range(claim.probability_90), badge_of(claim.verdict)});
      seen += fmt::format("{}, {}: {} of {}{}. ", statement, plot.names.back(), holds, runs, open);
    }
  }
  content.figure(
      {plots::draw(plot),
       "Share of the runs in which each statement holds, with 95 % bounds on either side.", seen});
  content.table(table);
  page::Content fold;
  fold.table(meaning);
  content.collapsible("What the words are taken to mean", fold);
}

std::vector<double> shares_of(std::vector<double> counts) {
  double sum = 0;
  for (const double c : counts) sum += c;
  for (double& c : counts) c /= sum;
  return counts;
}

// Where some values are only known to be larger, the share that has passed is drawn, not the
// values.
void add_to(plots::CdfPlot& plot, const std::string& name, const std::vector<double>& values,
            const std::optional<ValidationDocument::Passed>& passed) {
  if (!passed) {
    plot.samples.push_back({name, values});
    return;
  }
  plots::Band band;
  band.name = fmt::format("{} ({} passed, {} inside)", name, values.size(), passed->still_inside);
  band.x = passed->x;
  require_lengths(band.x.size(), {&passed->share, &passed->error});
  for (std::size_t i = 0; i < band.x.size(); ++i) {
    band.low.push_back(std::max(0.0, passed->share[i] - 2 * passed->error[i]));
    band.high.push_back(std::min(1.0, passed->share[i] + 2 * passed->error[i]));
  }
  plot.bands.push_back(band);
}

// Earlier versions, and samples that are too small, lack some numbers.
std::string known_text(const std::optional<double>& value, int digits) {
  return value && std::isfinite(*value) ? page::number_text(*value, digits) : "not computed";
}

// Compares counts or single values of the experiment, if there are any, with those of all runs.
void distribution_content(const Sets& sets, page::Content& content) {
  plots::BarPlot bars;
  plots::CdfPlot steps;
  bars.y = {"share", "", false, 0.0, {}};
  std::string seen, response;
  bool by_class = false, measured = false;
  for (const ComparisonRow* c : sets) {
    if (!c->distribution) continue;
    const ValidationDocument::Distribution& d = *c->distribution;
    by_class = d.by_class;
    // A set whose runs have ended early may have fewer classes.
    if (d.classes.size() > bars.categories.size()) bars.categories = d.classes;
    if (response.empty()) {
      response = d.response;
      bars.x_label = page::words(response);
      steps.x = {page::words(response), d.unit, false, {}, {}};
      measured = !d.measured.empty();
      if (measured) {
        bars.series.push_back({"experiment", shares_of(d.measured)});
        if (!by_class) add_to(steps, "experiment", d.measured, d.measured_passed);
      }
    }
    bars.series.push_back({c->parameter_set, shares_of(d.simulated), d.deviation});
    if (!by_class) add_to(steps, c->parameter_set, d.simulated, d.simulated_passed);
    if (measured)
      seen += fmt::format("{}: distance {}, probability {}. ", c->parameter_set,
                          known_text(d.distance, 3), known_text(d.p_value, 2));
  }
  if (response.empty()) return;
  for (plots::BarSeries& series : bars.series) {
    series.values.resize(bars.categories.size());
    if (!series.errors.empty()) series.errors.resize(bars.categories.size());
  }
  const std::string scatter =
      by_class ? " Bars: one standard deviation of a single run's share." : "";
  content.figure({by_class ? plots::draw(bars) : plots::draw(steps),
                  (measured ? "Experiment and all runs together."
                            : "All runs together; the experiment's numbers are not here.") +
                      scatter,
                  response + ": " + (seen.empty() ? "simulation alone" : seen)});
}

// Means with bands of 95 %.
void curve_content(const Sets& sets, page::Content& content) {
  plots::XyPlot plot;
  std::string seen;
  for (const ComparisonRow* c : sets) {
    if (!c->curve) continue;
    const ValidationDocument::Curve& v = *c->curve;
    const auto add = [&](const std::string& name, const std::vector<double>& mean,
                         const std::vector<double>& error) {
      require_lengths(v.x.size(), {&mean, &error});
      plots::Series s;
      s.name = name;
      s.x = v.x;
      s.y = mean;
      for (std::size_t i = 0; i < s.y.size(); ++i) {
        const double reach = std::isfinite(error[i]) ? 2 * error[i] : 0;
        s.low.push_back(s.y[i] - reach);
        s.high.push_back(s.y[i] + reach);
      }
      plot.series.push_back(std::move(s));
    };
    if (plot.series.empty()) {
      plot.x = {without_underscores(v.x_name), v.x_unit, false, {}, {}};
      plot.y = {without_underscores(v.y_name), v.unit, false, {}, {}};
      if (!v.measured.empty()) add("experiment", v.measured, v.measured_error);
    }
    add(c->parameter_set, v.simulated, v.simulated_error);
    seen += c->parameter_set + (v.measured.empty()
                                    ? ": simulation alone. "
                                    : fmt::format(": {} % of the range. ",
                                                  page::number_text(100 * v.comparison_error, 2)));
  }
  if (!plot.series.empty())
    content.figure({plots::draw(plot), "Means, with 95 % bands of the means.", seen});
}

// What numerics and variants change, as shares of what was there before.
void choices_content(const Sets& sets, page::Content& content) {
  plots::IntervalPlot plot;
  plot.x = {"change, with 95 % interval", "%", false, {}, {}};
  plot.vertical = {{0, ""}};
  plot.names = {""};
  page::Table table;
  table.caption = "Means over the seeds that both have";
  table.columns = {{"response", ""}, {"variant", ""}, {"before", ""}, {"with it", ""},
                   {"unit", ""},     {"change", "%"}, {"seeds", ""}};
  std::string seen;
  for (const ComparisonRow* c : sets)
    for (const ValidationDocument::NumericalVariant& r : c->numerical_variants) {
      const double percent = 100 / std::abs(r.before);
      const double change = (r.after - r.before) * percent, error = r.error * percent;
      table.rows.push_back({r.response, r.variant, Cell(r.before), Cell(r.after), r.unit,
                            std::isfinite(error) ? Cell::measured(change, error) : Cell(change, 3),
                            Cell(r.seeds, 3)});
      if (!std::isfinite(change)) continue;
      const double reach = std::isfinite(error) ? 2 * error : 0;
      plot.rows.push_back({fmt::format("{}: {}", without_underscores(r.variant),
                                       axis_label(page::words(r.response), r.unit)),
                           {plots::Interval{change - reach, change + reach, change}}});
      seen += fmt::format("{} with {}: {} %. ", r.response, r.variant,
                          page::measured_text(change, error));
    }
  if (!plot.rows.empty())
    content.figure({plots::draw(plot), "What each choice changes, in per cent.", seen});
  content.table(table);
}

void damage_content(const Sets& sets, page::Content& content) {
  page::Table table;
  table.caption = "Probability of damage";
  table.columns = {{"parameters", ""},
                   {"load", ""},
                   {"largest", "N"},
                   {"median", "N"},
                   {"a particle, without assumption", ""},
                   {"one of a run's, without assumption", ""},
                   {"one of a run's, if Weibull", ""}};
  std::map<std::string, plots::CdfPlot> by_load;
  for (const ComparisonRow* c : sets)
    for (const ValidationDocument::Breakage& d : c->breakage) {
      const std::string response = current_response_name(d.response);
      plots::CdfPlot& plot = by_load[response];
      plot.x = {response == "compressive_loads"    ? "largest load from two sides on a particle"
                : response == "peak_normal_forces" ? "largest contact force on a particle"
                                                   : page::words(response),
                "N",
                true,
                {},
                {}};
      plot.y_label = "share of particles at or below";
      plot.samples.push_back({c->parameter_set, d.loads});
      if (plot.vertical.empty() && c->strength) {
        // The other two have no text: the lines are closer than a text is high.
        plot.vertical = {{c->strength->minimum, "weakest test"}, {c->strength->maximum, ""}};
        if (std::isfinite(c->strength->mean)) plot.vertical.push_back({c->strength->mean, ""});
      }
      table.rows.push_back(
          {c->parameter_set, response, Cell(d.largest, 4), Cell(d.median, 3),
           share_range(d.distribution_free.each), share_range(d.distribution_free.any),
           fmt::format("{} ({})", share(d.weibull.any_best), share_range(d.weibull.any))});
    }
  std::vector<page::Figure> figures;
  figures.reserve(by_load.size());
  for (const auto& [response, plot] : by_load)
    figures.push_back(
        {plots::draw(plot),
         "Loads on all particles of all runs; lines: weakest, mean and strongest breaking force.",
         response + ": see the table"});
  if (!figures.empty()) content.figures(figures);
  if (!table.rows.empty()) content.table(table);
}

void softening_content(const Sets& sets, page::Content& content) {
  page::Table table;
  table.caption = "How responses go with Young's modulus";
  table.columns = {{"response", ""},
                   {"exponent", ""},
                   {"at the real modulus, 95 %", ""},
                   {"simulated up to", "GPa"},
                   {"what to make of it", ""}};
  std::vector<page::Figure> figures;
  for (const ComparisonRow* c : sets)
    for (const ValidationDocument::StiffnessScaling& s : c->stiffness_scaling) {
      plots::XyPlot plot;
      plot.x = {"Young's modulus", "GPa", true, {}, {}};
      plot.y = {page::words(s.response), s.unit, true, {}, {}};
      require_lengths(s.modulus.size(), {&s.mean, &s.error});
      plots::Series series;
      series.style = plots::Style::joined;
      for (const double modulus : s.modulus) series.x.push_back(modulus * 1e-9);
      series.y = s.mean;
      series.y_error = s.error;
      for (double& e : series.y_error)
        if (!std::isfinite(e)) e = 0;
      plot.series = {series};
      const std::string grows = page::measured_text(s.exponent, s.exponent_error);
      if (!series.x.empty())
        figures.push_back({plots::draw(plot), fmt::format("Grows as E to the power of {}.", grows),
                           fmt::format("{}: exponent {}", s.response, grows)});
      const auto& [low, high] = s.extrapolated_95;
      table.rows.push_back({s.response, Cell::measured(s.exponent, s.exponent_error),
                            std::isnan(low) ? std::string("not known")
                                            : fmt::format("{} to {} {}", page::number_text(low, 3),
                                                          page::number_text(high, 3), s.unit),
                            series.x.empty() ? Cell("") : Cell(series.x.back(), 3),
                            s.interpretation});
    }
  if (!figures.empty()) content.figures(figures);
  content.table(table);
}

}  // namespace

Badge badge_of(const std::string& verdict) {
  if (verdict == "consistent") return {Mark::good, verdict};
  if (verdict == "inconsistent") return {Mark::bad, verdict};
  if (verdict == "inconclusive") return {Mark::caution, verdict};
  return {Mark::neutral, verdict};
}

void add_comparison(const Sets& sets, page::Content& content) {
  const std::string& kind = sets.front()->kind;
  if (kind == "value") value_content(sets, content);
  if (kind == "curve") curve_content(sets, content);
  if (kind == "criteria") claims_content(sets, content);
  if (kind == "criteria") distribution_content(sets, content);
  if (kind == "breakage") damage_content(sets, content);
  if (kind == "stiffness_scaling") softening_content(sets, content);
  if (kind == "numerical_variants") choices_content(sets, content);
}

}  // namespace firn
