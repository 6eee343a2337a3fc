#include "reports/documents/comparison_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "experiments/text/response_aliases.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;

std::string share(double p) { return page::number_text(100 * p, 3) + " %"; }
std::string share_range(const Json& ends) {
  const auto [low, high] = interval(ends);
  return share(low) + " to " + share(high);
}

void value_content(const Sets& sets, page::Content& content) {
  plots::IntervalPlot plot;
  page::Table table;
  table.caption = "Components of the validation uncertainty: one standard deviation each";
  table.columns = {{"parameters", ""}, {"component", ""}, {"uncertainty", ""}, {"from", ""}};
  bool experiment_drawn = false;
  std::string seen;
  plot.names = {"experiment", "simulation"};
  for (const Json* c : sets) {
    if (!c->contains("value")) continue;
    const Json& v = c->at("value");
    const std::string unit = text(v, "unit");
    plot.x = {"mean with 95 % interval", unit, false, {}, {}};
    double of_experiment = 0;
    for (const Json& part : v.at("components")) {
      const bool is_experiment = text(part, "name") == "experiment";
      if (is_experiment) of_experiment = number(part, "value");
      if (is_experiment && experiment_drawn) continue;
      table.rows.push_back(
          {is_experiment ? "all" : text(*c, "parameter_set"), text(part, "name"),
           part.at("value").is_null() ? Cell("not looked at") : Cell(number(part, "value"), 2),
           is_experiment ? "see above" : text(part, "evaluation_method")});
    }
    const double measured = number(v, "measured"), simulated = number(v, "simulated");
    // Results of earlier versions have standard uncertainties alone.
    const auto expanded = [&](const char* key, double standard) {
      return v.contains(key) ? number(v, key) : 2 * standard;
    };
    const double all = number(v, "validation_uncertainty");
    const double experiment = expanded("measured_expanded", of_experiment);
    const double own = expanded(
        "simulated_expanded", std::sqrt(std::max(0.0, all * all - of_experiment * of_experiment)));
    if (!experiment_drawn)
      plot.rows.push_back({"experiment",
                           {plots::Interval{measured - experiment, measured + experiment, measured},
                            std::nullopt}});
    experiment_drawn = true;
    plot.rows.push_back(
        {text(*c, "parameter_set"),
         {std::nullopt, plots::Interval{simulated - own, simulated + own, simulated}}});
    seen += fmt::format("{}: {} {}; ", text(*c, "parameter_set"),
                        page::measured_text(simulated, own / 2), unit);
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
    plot.names.push_back(text(*sets[s], "parameter_set"));
    for (const Json& claim : sets[s]->at("criteria")) {
      const std::string statement = text(claim, "statement");
      if (!row_of.contains(statement)) {
        row_of[statement] = plot.rows.size();
        // The plot has no room for sentences: the tables say what the numbers stand for.
        const std::string label = fmt::format("statement {}", plot.rows.size() + 1);
        plot.rows.push_back({label, std::vector<std::optional<plots::Interval>>(sets.size())});
        meaning.rows.push_back({Cell(static_cast<double>(plot.rows.size())), statement,
                                text(claim, "relation"), text(claim, "rationale")});
      }
      const Json& p = claim.at("probability_90");
      const int holds = whole_number(claim, "holds_in"), runs = whole_number(claim, "runs");
      const auto [low, high] = interval(p);
      plot.rows[row_of[statement]].intervals[s] = plots::Interval{
          low, high, runs > 0 ? std::optional(static_cast<double>(holds) / runs) : std::nullopt};
      table.rows.push_back({Cell(static_cast<double>(row_of[statement] + 1)), statement,
                            text(*sets[s], "parameter_set"), fmt::format("{} of {}", holds, runs),
                            share_range(p), badge_of(text(claim, "verdict"))});
      seen += fmt::format("{}, {}: {} of {}. ", statement, plot.names.back(), holds, runs);
    }
  }
  content.figure(
      {plots::draw(plot),
       "Share of the runs in which each statement holds, with 95 % bounds on either side.", seen});
  content.table(table);
  page::Content fold;
  fold.table(meaning);
  content.fold("What the words are taken to mean", fold);
}

std::vector<double> shares_of(std::vector<double> counts) {
  double sum = 0;
  for (const double c : counts) sum += c;
  for (double& c : counts) c /= sum;
  return counts;
}

// Where some values are only known to be larger, the share that has passed is drawn, not the
// values.
void add_to(plots::CdfPlot& plot, const std::string& name, const Json& d, const char* values,
            const char* passed) {
  if (!d.contains(passed)) {
    plot.samples.push_back({name, numbers(d.at(values))});
    return;
  }
  const Json& p = d.at(passed);
  plots::Band band;
  band.name = fmt::format("{} ({} passed, {} still inside)", name, d.at(values).size(),
                          whole_number(p, "still_inside"));
  const std::vector<double> x = numbers(p.at("x")), share = numbers(p.at("share"), x.size()),
                            error = numbers(p.at("error"), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    band.x.push_back(x[i]);
    band.low.push_back(std::max(0.0, share[i] - 2 * error[i]));
    band.high.push_back(std::min(1.0, share[i] + 2 * error[i]));
  }
  plot.bands.push_back(band);
}

// Compares counts or single values of the experiment, if there are any, with those of all runs.
void distribution_content(const Sets& sets, page::Content& content) {
  plots::BarPlot bars;
  plots::CdfPlot steps;
  bars.y = {"share", "", false, 0.0, {}};
  std::string seen, response;
  bool by_class = false, measured = false;
  for (const Json* c : sets) {
    if (!c->contains("distribution")) continue;
    const Json& d = c->at("distribution");
    by_class = d.at("by_class").get<bool>();
    // A set whose runs have ended early may have fewer classes.
    if (const auto classes = d.at("classes").get<std::vector<std::string>>();
        classes.size() > bars.categories.size())
      bars.categories = classes;
    if (response.empty()) {
      response = text(d, "response");
      bars.x_label = response;
      steps.x = {response, text(d, "unit"), false, {}, {}};
      measured = !d.at("measured").empty();
      if (measured) {
        bars.series.push_back({"experiment", shares_of(numbers(d.at("measured")))});
        if (!by_class) add_to(steps, "experiment", d, "measured", "measured_passed");
      }
    }
    bars.series.push_back({text(*c, "parameter_set"), shares_of(numbers(d.at("simulated"))),
                           numbers(d.at("deviation"))});
    if (!by_class) add_to(steps, text(*c, "parameter_set"), d, "simulated", "simulated_passed");
    if (measured)
      seen += fmt::format("{}: distance {}, probability {}. ", text(*c, "parameter_set"),
                          page::number_text(number(d, "distance"), 3),
                          page::number_text(number(d, "p_value"), 2));
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
  for (const Json* c : sets) {
    if (!c->contains("curve")) continue;
    const Json& v = c->at("curve");
    const auto add = [&](const std::string& name, const char* mean, const char* error) {
      plots::Series s;
      s.name = name;
      s.x = numbers(v.at("x"));
      s.y = numbers(v.at(mean), s.x.size());
      const std::vector<double> one = numbers(v.at(error), s.x.size());
      for (std::size_t i = 0; i < s.y.size(); ++i) {
        const double reach = std::isfinite(one[i]) ? 2 * one[i] : 0;
        s.low.push_back(s.y[i] - reach);
        s.high.push_back(s.y[i] + reach);
      }
      plot.series.push_back(std::move(s));
    };
    if (plot.series.empty()) {
      plot.x = {text(v, "x_name"), text(v, "x_unit"), false, {}, {}};
      plot.y = {text(v, "y_name"), text(v, "unit"), false, {}, {}};
      if (!v.at("measured").empty()) add("experiment", "measured", "measured_error");
    }
    add(text(*c, "parameter_set"), "simulated", "simulated_error");
    seen += text(*c, "parameter_set") +
            (v.at("measured").empty()
                 ? ": simulation alone. "
                 : fmt::format(": {} % of the range. ",
                               page::number_text(100 * number(v, "comparison_error"), 2)));
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
  for (const Json* c : sets) {
    if (!c->contains("numerical_variants")) continue;
    for (const Json& r : c->at("numerical_variants")) {
      const double before = number(r, "before"), after = number(r, "after");
      const double percent = 100 / std::abs(before);
      const double change = (after - before) * percent, error = number(r, "error") * percent;
      table.rows.push_back({text(r, "response"), text(r, "variant"), Cell(before), Cell(after),
                            text(r, "unit"),
                            std::isfinite(error) ? Cell::measured(change, error) : Cell(change, 3),
                            Cell(number(r, "seeds"), 3)});
      if (!std::isfinite(change)) continue;
      const double reach = std::isfinite(error) ? 2 * error : 0;
      plot.rows.push_back({fmt::format("{}: {}", text(r, "variant"), text(r, "response")),
                           {plots::Interval{change - reach, change + reach, change}}});
      seen += fmt::format("{} with {}: {} %. ", text(r, "response"), text(r, "variant"),
                          page::measured_text(change, error));
    }
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
  for (const Json* c : sets) {
    if (!c->contains("breakage")) continue;
    for (const Json& d : c->at("breakage")) {
      const std::string response = current_response_name(text(d, "response"));
      plots::CdfPlot& plot = by_load[response];
      plot.x = {response == "compressive_loads"    ? "largest load from two sides on a particle"
                : response == "peak_normal_forces" ? "largest contact force on a particle"
                                                   : response,
                "N",
                true,
                {},
                {}};
      plot.y_label = "share of particles at or below";
      plot.samples.push_back({text(*c, "parameter_set"), numbers(d.at("loads"))});
      if (plot.vertical.empty() && c->contains("strength"))
        plot.vertical = {{number(c->at("strength"), "minimum"), "weakest test"},
                         {number(c->at("strength"), "maximum"), "strongest test"}};
      const Json& free = d.at("distribution_free");
      const Json& weibull = d.at("weibull");
      table.rows.push_back({text(*c, "parameter_set"), response, Cell(number(d, "largest"), 4),
                            Cell(number(d, "median"), 3), share_range(free.at("each")),
                            share_range(free.at("any")),
                            fmt::format("{} ({})", share(number(weibull, "any_best")),
                                        share_range(weibull.at("any")))});
    }
  }
  std::vector<page::Figure> figures;
  for (const auto& [response, plot] : by_load)
    figures.push_back({plots::draw(plot),
                       "Loads on all particles of all runs; lines: breaking forces.",
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
  for (const Json* c : sets) {
    if (!c->contains("stiffness_scaling")) continue;
    for (const Json& s : c->at("stiffness_scaling")) {
      plots::XyPlot plot;
      plot.x = {"Young's modulus", "GPa", true, {}, {}};
      plot.y = {text(s, "response"), text(s, "unit"), true, {}, {}};
      plots::Series series;
      series.style = plots::Style::joined;
      for (const double modulus : numbers(s.at("modulus"))) series.x.push_back(modulus * 1e-9);
      series.y = numbers(s.at("mean"), series.x.size());
      series.y_error = numbers(s.at("error"), series.x.size());
      for (double& e : series.y_error)
        if (!std::isfinite(e)) e = 0;
      plot.series = {series};
      const double exponent = number(s, "exponent"), error = number(s, "exponent_error");
      const std::string grows = page::measured_text(exponent, error);
      if (!series.x.empty())
        figures.push_back({plots::draw(plot), fmt::format("Grows as E to the power of {}.", grows),
                           fmt::format("{}: exponent {}", text(s, "response"), grows)});
      const auto [low, high] = interval(s.at("extrapolated_95"));
      table.rows.push_back(
          {text(s, "response"), Cell::measured(exponent, error),
           std::isnan(low) ? std::string("not known")
                           : fmt::format("{} to {} {}", page::number_text(low, 3),
                                         page::number_text(high, 3), text(s, "unit")),
           series.x.empty() ? Cell("") : Cell(series.x.back(), 3), text(s, "interpretation")});
    }
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
  const std::string kind = text(*sets.front(), "kind");
  if (kind == "value") value_content(sets, content);
  if (kind == "curve") curve_content(sets, content);
  if (kind == "criteria") claims_content(sets, content);
  if (kind == "criteria") distribution_content(sets, content);
  if (kind == "breakage") damage_content(sets, content);
  if (kind == "stiffness_scaling") softening_content(sets, content);
  if (kind == "numerical_variants") choices_content(sets, content);
}

}  // namespace firn
