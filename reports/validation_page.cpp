#include "reports/validation_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "reports/json_values.h"
#include "reports/plots.h"
#include "reports/validation_replays.h"
#include "solver/types.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;

Badge badge_of(const std::string& verdict) {
  if (verdict == "consistent") return {Mark::good, verdict};
  if (verdict == "inconsistent") return {Mark::bad, verdict};
  if (verdict == "not enough data to say") return {Mark::caution, verdict};
  return {Mark::neutral, verdict};
}

std::string share(double p) { return page::number_text(100 * p, 3) + " %"; }
std::string share_range(const Json& interval) {
  return share(number(interval[0])) + " to " + share(number(interval[1]));
}

// All parameter sets of one comparison, in the suite's order.
using Sets = std::vector<const Json*>;

void value_content(const Sets& sets, page::Content& content) {
  plots::IntervalPlot plot;
  page::Table table;
  table.caption = "What the difference is uncertain by: one standard deviation each";
  table.columns = {{"parameters", ""}, {"part", ""}, {"uncertainty", ""}, {"from", ""}};
  bool experiment_drawn = false;
  std::string seen;
  plot.names = {"experiment", "simulation"};
  for (const Json* c : sets) {
    if (!c->contains("value")) continue;
    const Json& v = c->at("value");
    const std::string unit = text(v, "unit");
    plot.x = {"mean with 95 % interval", unit, false, {}, {}};
    double experiment = 0;
    for (const Json& part : v.at("parts")) {
      const bool is_experiment = text(part, "name") == "experiment";
      if (is_experiment) experiment = number(part, "value");
      if (is_experiment && experiment_drawn) continue;
      table.rows.push_back(
          {is_experiment ? "all" : text(*c, "parameter_set"), text(part, "name"),
           part.at("value").is_null() ? Cell("not looked at") : Cell(number(part, "value"), 2),
           is_experiment ? "see above" : text(part, "how")});
    }
    const double measured = number(v, "measured"), simulated = number(v, "simulated");
    const double all = number(v, "standard_uncertainty");
    const double own = std::sqrt(std::max(0.0, all * all - experiment * experiment));
    if (!experiment_drawn)
      plot.rows.push_back(
          {"experiment",
           {plots::Interval{measured - 2 * experiment, measured + 2 * experiment, measured},
            std::nullopt}});
    experiment_drawn = true;
    plot.rows.push_back(
        {text(*c, "parameter_set"),
         {std::nullopt, plots::Interval{simulated - 2 * own, simulated + 2 * own, simulated}}});
    seen += fmt::format("{}: {} {}; ", text(*c, "parameter_set"),
                        page::measured_text(simulated, own), unit);
  }
  if (plot.rows.empty()) return;
  content.figure({plots::draw(plot), "Simulation beside experiment.", seen});
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
  meaning.columns = {{"", ""}, {"statement", ""}, {"relation", ""}, {"because", ""}};
  std::string seen;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    plot.names.push_back(text(*sets[s], "parameter_set"));
    for (const Json& claim : sets[s]->at("claims")) {
      const std::string statement = text(claim, "statement");
      if (!row_of.contains(statement)) {
        row_of[statement] = plot.rows.size();
        // The plot has no room for sentences: the tables say what the numbers stand for.
        const std::string label = fmt::format("statement {}", plot.rows.size() + 1);
        plot.rows.push_back({label, std::vector<std::optional<plots::Interval>>(sets.size())});
        meaning.rows.push_back({Cell(static_cast<double>(plot.rows.size())), statement,
                                text(claim, "relation"), text(claim, "because")});
      }
      const Json& p = claim.at("probability_90");
      const int holds = claim.at("holds_in"), runs = claim.at("runs");
      plot.rows[row_of[statement]].intervals[s] = plots::Interval{
          number(p[0]), number(p[1]),
          runs > 0 ? std::optional(static_cast<double>(holds) / runs) : std::nullopt};
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
                          p.at("still_inside").get<int>());
  const std::vector<double> x = numbers(p.at("x")), share = numbers(p.at("share")),
                            error = numbers(p.at("error"));
  for (std::size_t i = 0; i < x.size(); ++i) {
    band.x.push_back(x[i]);
    band.low.push_back(std::max(0.0, share[i] - 2 * error[i]));
    band.high.push_back(std::min(1.0, share[i] + 2 * error[i]));
  }
  plot.bands.push_back(band);
}

// What was counted or measured one by one, where there is such, beside the same of all runs.
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
                  (measured ? "Experiment beside all runs together."
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
      s.y = numbers(v.at(mean));
      const std::vector<double> one = numbers(v.at(error));
      for (std::size_t i = 0; i < s.y.size(); ++i) {
        const double reach = std::isfinite(one[i]) ? 2 * one[i] : 0;
        s.low.push_back(s.y[i] - reach);
        s.high.push_back(s.y[i] + reach);
      }
      plot.series.push_back(std::move(s));
    };
    if (plot.series.empty()) {
      plot.x = {"x", text(v, "x_unit"), false, {}, {}};
      plot.y = {"y", text(v, "unit"), false, {}, {}};
      add("experiment", "measured", "measured_error");
    }
    add(text(*c, "parameter_set"), "simulated", "simulated_error");
    seen += fmt::format("{}: {} % of the range. ", text(*c, "parameter_set"),
                        page::number_text(100 * number(v, "difference"), 2));
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
  table.columns = {{"response", ""}, {"choice", ""},  {"before", ""}, {"with it", ""},
                   {"unit", ""},     {"change", "%"}, {"seeds", ""}};
  std::string seen;
  for (const Json* c : sets) {
    if (!c->contains("choices")) continue;
    for (const Json& r : c->at("choices")) {
      const double before = number(r, "before"), after = number(r, "after");
      const double percent = 100 / std::abs(before);
      const double change = (after - before) * percent, error = number(r, "error") * percent;
      table.rows.push_back({text(r, "response"), text(r, "choice"), Cell(before), Cell(after),
                            text(r, "unit"),
                            std::isfinite(error) ? Cell::measured(change, error) : Cell(change, 3),
                            Cell(number(r, "seeds"), 3)});
      if (!std::isfinite(change)) continue;
      const double reach = std::isfinite(error) ? 2 * error : 0;
      plot.rows.push_back({fmt::format("{}: {}", text(r, "choice"), text(r, "response")),
                           {plots::Interval{change - reach, change + reach, change}}});
      seen += fmt::format("{} with {}: {} %. ", text(r, "response"), text(r, "choice"),
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
    if (!c->contains("damage")) continue;
    for (const Json& d : c->at("damage")) {
      const std::string response = text(d, "response");
      plots::CdfPlot& plot = by_load[response];
      plot.x = {response == "opposed_loads"        ? "largest load from two sides on a particle"
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
      const Json& free = d.at("without_assumption");
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
    if (!c->contains("softening")) continue;
    for (const Json& s : c->at("softening")) {
      plots::XyPlot plot;
      plot.x = {"Young's modulus", "GPa", true, {}, {}};
      plot.y = {text(s, "response"), text(s, "unit"), true, {}, {}};
      plots::Series series;
      series.style = plots::Style::joined;
      for (const double modulus : numbers(s.at("modulus"))) series.x.push_back(modulus * 1e-9);
      series.y = numbers(s.at("mean"));
      series.y_error = numbers(s.at("error"));
      for (double& e : series.y_error)
        if (!std::isfinite(e)) e = 0;
      plot.series = {series};
      const double exponent = number(s, "exponent"), error = number(s, "exponent_error");
      const std::string grows = page::measured_text(exponent, error);
      if (!series.x.empty())
        figures.push_back({plots::draw(plot), fmt::format("Grows as E to the power of {}.", grows),
                           fmt::format("{}: exponent {}", text(s, "response"), grows)});
      const Json& at = s.at("extrapolated_95");
      table.rows.push_back(
          {text(s, "response"), Cell::measured(exponent, error),
           at[0].is_null() ? std::string("not known")
                           : fmt::format("{} to {} {}", page::number_text(number(at[0]), 3),
                                         page::number_text(number(at[1]), 3), text(s, "unit")),
           series.x.empty() ? Cell("") : Cell(series.x.back(), 3), text(s, "word")});
    }
  }
  if (!figures.empty()) content.figures(figures);
  content.table(table);
}

void comparison_section(const Sets& sets, ValidationReplays* replays, page::Page& page) {
  const Json& first = *sets.front();
  const std::string anchor = page::anchor_of(text(first, "name"));
  page::Content& content = page.section(text(first, "title"), anchor);
  if (!text(first, "note").empty()) content.paragraph(text(first, "note"));
  if (!text(first, "measurement").empty())
    content.facts({{"measured", text(first, "measurement")},
                   {"status of the measurement", text(first, "measurement_status")},
                   {"simulated", text(first, "experiment")}});
  for (const Json* c : sets) {
    std::string line = fmt::format("{}: {}", text(*c, "parameter_set"), text(*c, "headline"));
    if (!text(*c, "would_decide").empty())
      line += fmt::format(". Would decide: {}", text(*c, "would_decide"));
    content.note(badge_of(text(*c, "verdict")), line);
  }
  const std::string kind = text(first, "kind");
  if (kind == "value") value_content(sets, content);
  if (kind == "claims") claims_content(sets, content);
  if (kind == "claims") distribution_content(sets, content);
  if (kind == "damage") damage_content(sets, content);
  if (kind == "softening") softening_content(sets, content);
  if (kind == "choices") choices_content(sets, content);
  if (kind == "curve") curve_content(sets, content);
  std::vector<std::string> caveats;
  for (const Json* c : sets)
    for (const Json& caveat : c->at("caveats"))
      caveats.push_back(
          fmt::format("{}: {}", text(*c, "parameter_set"), caveat.get<std::string>()));
  if (!caveats.empty()) content.list(caveats);
  if (replays) replays->add(text(first, "experiment"), anchor, page, content);
}

// By comparison, in the suite's order.
std::vector<Sets> grouped(const Json& results) {
  std::vector<Sets> groups;
  for (const Json& c : results.at("comparisons")) {
    if (groups.empty() || text(*groups.back().front(), "name") != text(c, "name"))
      groups.emplace_back();
    groups.back().push_back(&c);
  }
  return groups;
}

void summary(const Json& results, const std::vector<Sets>& groups, page::Page& page) {
  std::map<std::string, int> count;
  for (const Json& c : results.at("comparisons")) ++count[text(c, "verdict")];
  std::vector<page::Card> cards;
  for (const char* verdict :
       {"consistent", "inconsistent", "not enough data to say", "not independent"})
    cards.push_back({verdict == std::string_view("not enough data to say") ? "open" : verdict,
                     std::to_string(count[verdict]),
                     "",
                     {badge_of(verdict).mark, " "}});
  page.top().cards(cards);
  if (!text(results, "note").empty()) page.top().paragraph(text(results, "note"));
  page::Table table;
  table.caption = "Verdicts by comparison and parameter set";
  table.columns = {{"comparison", ""}};
  std::vector<std::string> sets;
  for (const Json& p : results.at("parameter_sets")) {
    sets.push_back(text(p, "name"));
    table.columns.push_back({sets.back(), ""});
  }
  for (const Sets& group : groups) {
    std::vector<Cell> row = {
        Cell::link(text(*group.front(), "title"), page::anchor_of(text(*group.front(), "name")))};
    for (const std::string& set : sets) {
      const auto found = std::ranges::find_if(
          group, [&](const Json* c) { return text(*c, "parameter_set") == set; });
      row.push_back(found == group.end() ? Cell("") : Cell(badge_of(text(**found, "verdict"))));
    }
    table.rows.push_back(row);
  }
  page.top().table(table);
}

void parameters_section(const Json& results, page::Page& page) {
  page::Table table;
  table.caption = "Parameter sets";
  table.columns = {{"name", ""}, {"material record", ""}, {"keys set", ""}, {"note", ""}};
  for (const Json& p : results.at("parameter_sets")) {
    std::string keys;
    for (const auto& [key, value] : p.at("set").items())
      keys += fmt::format("{}{} = {}", keys.empty() ? "" : ", ", key, value.get<std::string>());
    table.rows.push_back({text(p, "name"), text(p, "material"), keys, text(p, "note")});
  }
  page.section("Parameters", "parameters").table(table);
}

void runs_section(const Json& results, page::Page& page) {
  page::Table table;
  table.caption = "All runs";
  table.columns = {{"experiment", ""}, {"parameters", ""}, {"for", ""}, {"seed", ""},
                   {"ended", ""},      {"wall time", "s"}, {"key", ""}};
  for (const Json& e : results.at("experiments"))
    for (const Json& r : e.at("runs"))
      table.rows.push_back({text(e, "name"), text(r, "parameter_set"),
                            text(r, "variant").empty() ? text(r, "purpose") : text(r, "variant"),
                            Cell(number(r, "seed"), 6), text(r, "status"),
                            Cell(number(r, "wall"), 3), text(r, "key")});
  page::Content& content = page.section("Runs and commands", "runs");
  std::string commands = text(results, "command") + "\n";
  std::set<std::string> cases;
  for (const Json& e : results.at("experiments"))
    if (cases.insert(text(e, "case")).second)
      commands += fmt::format("firn run {} --seed 1\n", text(e, "case"));
  content.code(commands, "To do it again");
  page::Content fold;
  fold.table(table);
  content.fold(fmt::format("{} runs", table.rows.size()), fold);
}

void method_section(page::Page& page) {
  page.section("How verdicts are reached", "method")
      .paragraph(
          "A value is inconsistent when simulation and experiment differ by more than twice the "
          "standard uncertainty of their difference, made up of seeds, time step, stiffness, input "
          "parameters and the experiment (ASME V&V 20). It is open when that uncertainty is larger "
          "than the difference that would matter.")
      .paragraph(
          "A statement in words is taken as a relation that holds in a run or not. It is "
          "consistent "
          "when the runs show it to hold more often than not, inconsistent when less often, with "
          "95 "
          "% confidence; what was seen once only has to be possible.")
      .paragraph(
          "Damage is judged without an assumption on how strengths are distributed: a few tests "
          "only "
          "bound it. The probability with Weibull's distribution stands beside it.");
}

page::Page page_of(const Json& results, const std::string& folder,
                   const ValidationPageOptions& options) {
  page::Page page(text(results, "title"),
                  fmt::format("validation \"{}\", Firn {} ({})", text(results, "name"),
                              text(results, "firn_version"), text(results, "git_commit")));
  const std::vector<Sets> groups = grouped(results);
  summary(results, groups, page);
  std::optional<ValidationReplays> replays;
  if (options.replays) replays.emplace(results, folder, options.replay_budget);
  for (const Sets& group : groups) comparison_section(group, replays ? &*replays : nullptr, page);
  parameters_section(results, page);
  method_section(page);
  runs_section(results, page);
  return page;
}

}  // namespace

page::Page validation_page(const std::string& results_file, const ValidationPageOptions& options) {
  std::ifstream stream(results_file);
  const Json results = Json::parse(stream, nullptr, false);
  if (!results.is_object() || results.value("kind", Json()) != "validation")
    throw InputError(
        fmt::format("{}: is no result of a validation; expected the results.json that firn "
                    "validate writes",
                    results_file));
  try {
    return page_of(results, std::filesystem::path(results_file).parent_path().string(), options);
  } catch (const Json::exception& e) {
    throw InputError(
        fmt::format("{}: lacks what a page needs: {}; expected the results.json that "
                    "firn validate writes",
                    results_file, e.what()));
  }
}

}  // namespace firn
