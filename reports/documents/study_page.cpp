#include "reports/documents/study_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/math.h"
#include "reports/documents/study_estimate.h"
#include "reports/documents/study_plots.h"
#include "reports/html/json_values.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using page::Badge;
using page::Cell;
using page::Mark;
using page::words;

Badge verdict_badge(const std::string& verdict) {
  if (verdict == "calibrated") return {Mark::good, verdict};
  if (verdict == "infeasible" || verdict == "too few runs") return {Mark::bad, verdict};
  return {Mark::caution, verdict};
}

std::string unit_of(const Json& j) { return unit_text(j.value("unit", "1")); }

std::string with_unit(double value, double uncertainty, const Json& j) {
  return page::measured_text(value, uncertainty) + unit_suffix(unit_of(j));
}

std::string interval_text(const Json& ends) {
  const auto [low, high] = interval(ends);
  return fmt::format("{} to {}", page::number_text(low, 3), page::number_text(high, 3));
}

// Without the verdict in front, which the badge says.
std::string headline(const Json& results) {
  std::string sentence = text(results, "headline");
  const std::string verdict = text(results, "verdict") + ": ";
  if (sentence.starts_with(verdict)) sentence.erase(0, verdict.size());
  // Results of earlier builds have it in ASCII.
  for (std::size_t at = 0; (at = sentence.find(" +- ", at)) != std::string::npos;)
    sentence.replace(at, 4, " ± ");
  return sentence;
}

// False of a study of which too few runs finished to fit anything.
bool is_fitted(const Json& parameter) { return parameter.contains("interval_95"); }

// The answer, as every other place of the page and the command have it; without one the median.
void study_summary(const Json& results, page::Page& page) {
  const bool answered = results.contains("estimate") && results.at("estimate").is_object();
  std::vector<page::Card> cards;
  for (const Json& p : results.at("parameters")) {
    if (!answered && !is_fitted(p)) continue;
    const std::string name = text(p, "name");
    const double value = answered ? number(results.at("estimate").at("parameters"), name.c_str())
                                  : number(p, "median");
    const std::string unit = unit_of(p);
    cards.push_back({words(name) + (answered ? "" : ", median"),
                     number_text(value) + (unit.empty() ? "" : " " + unit),
                     "95 %: " + interval_text(p.at("interval_95")),
                     {}});
  }
  page.top().note(verdict_badge(text(results, "verdict")), headline(results));
  page.top().cards(cards);
  if (const std::vector<page::Fact> facts = study_estimate(results); !facts.empty())
    page.top().facts(facts);
}

void targets_section(const Json& results, page::Page& page) {
  page::Table table;
  table.caption = "What the parameters were fitted to";
  table.columns = {{"response", ""},
                   {"measured", ""},
                   {"at the answer", ""},
                   {"can be reached", ""},
                   {"source", ""}};
  for (const Json& t : results.at("targets")) {
    std::string fitted;
    const std::string response = text(t, "response");
    if (results.contains("estimate") && results.at("estimate").contains("simulated") &&
        results.at("estimate").at("simulated").contains(response)) {
      const Json& s = results.at("estimate").at("simulated").at(response);
      fitted = with_unit(number(s, "value"), number(s, "standard_error"), t);
    }
    std::string reach;
    if (t.contains("reach") && t.at("reach").is_object())
      reach = fmt::format("{} to {}", page::number_text(number(t.at("reach"), "lowest"), 3),
                          page::number_text(number(t.at("reach"), "highest"), 3));
    std::string measured = with_unit(number(t, "value"), number(t, "uncertainty"), t);
    if (t.contains("discrepancy"))
      measured += fmt::format(", discrepancy of the simulation ± {} {}",
                              page::number_text(number(t, "discrepancy"), 2), unit_of(t));
    table.rows.push_back({response, measured, fitted, reach, t.value("source", "")});
  }
  page.section("Targets", "targets").table(table);
}

// Recorded curves, and what the model gives at the answer: the mean of the simulated curves and the
// components, each times its score.
void curves_section(const Json& results, page::Page& page) {
  if (!results.contains("curves")) return;
  std::vector<page::Figure> figures;
  for (const Json& c : list(results, "curves")) {
    const std::string name = text(c, "curve");
    const std::vector<double> x = numbers(c.at("x"));
    plots::XyPlot plot;
    plot.x = {"x", unit_text(text(c, "x_unit")), false, {}, {}};
    plot.y = {words(name), unit_of(c), false, {}, {}};
    plots::Series recorded{"recorded", x, numbers(c.at("recorded"), x.size())};
    plot.series = {recorded};
    plots::Series fitted{"model at the answer", x, numbers(c.at("simulated_mean"), x.size())};
    const Json& components = list(c, "components");
    std::size_t scores = 0;
    for (std::size_t k = 0; k < components.size(); ++k) {
      const std::string score = fmt::format("{}.score_{}", name, k + 1);
      if (!results.contains("estimate") || !results.at("estimate").contains("fit") ||
          !results.at("estimate").at("fit").contains(score))
        continue;
      const double value = number(results.at("estimate").at("fit").at(score), "value");
      const std::vector<double> component = numbers(components[k], x.size());
      for (std::size_t i = 0; i < x.size(); ++i) fitted.y[i] += value * component[i];
      ++scores;
    }
    if (scores == components.size()) plot.series.push_back(fitted);
    figures.push_back(
        {plots::draw(plot),
         fmt::format("{}: {} principal components hold {} % of the variance between the simulated "
                     "curves.",
                     name, components.size(),
                     number_text(100 * number(c, "explained_variance"), 3)),
         fmt::format("{}: {} places, root mean square that the components leave of the recorded "
                     "curve: {} {}",
                     name, x.size(), number_text(number(c, "recorded_rest"), 2), unit_of(c))});
  }
  if (!figures.empty()) page.section("Curves", "curves").figures(figures);
}

// The choices of a parameter without order, and what each of them gives.
void choices_section(const Json& results, page::Page& page) {
  if (!results.contains("choice")) return;
  const Json& choice = results.at("choice");
  page::Table table;
  table.caption = fmt::format(
      "Choices of {}, and the parameters given each of them; the rest of "
      "this page is for {}",
      text(choice, "parameter"), text(choice, "best"));
  table.columns = {{"choice", ""}, {"before", ""}, {"probability", ""}, {"verdict", ""}};
  for (const Json& p : results.at("parameters"))
    table.columns.push_back({text(p, "name") + ", median, 95 %", unit_of(p)});
  for (const Json& c : list(choice, "choices")) {
    std::vector<Cell> row = {
        text(c, "choice"), Cell(number(c, "prior"), 3),
        c.at("probability").is_number() ? Cell(number(c, "probability"), 3) : Cell("not known"),
        c.value("verdict", "")};
    for (const Json& p : results.at("parameters")) {
      std::string known;
      const std::string name = text(p, "name");
      if (c.contains("parameters") && c.at("parameters").contains(name)) {
        const Json& m = c.at("parameters").at(name);
        known = fmt::format("{}, {}", number_text(number(m, "median")),
                            interval_text(m.at("interval_95")));
      }
      row.emplace_back(known);
    }
    table.rows.push_back(row);
  }
  page.section("Choices", "choices").table(table);
}

page::Figure profile_figure(const Json& p) {
  const Json& profile = p.at("profile");
  plots::XyPlot plot;
  plot.x = {words(text(p, "name")), unit_of(p), p.value("scale", "") == "log", {}, {}};
  plot.y = {"minus twice the log likelihood", "", false, 0.0, 10.0};
  plots::Series series;
  series.x = numbers(profile.at("values"));
  series.y = numbers(profile.at("minus_twice_log_likelihood"), series.x.size());
  const auto least = std::ranges::min_element(series.y);
  const double low = least == series.y.end() ? 0 : *least;
  for (double& y : series.y) y = y - low > 12 ? std::nan("") : y - low;
  plot.series = {series};
  plot.horizontal = {{3.841, "95 %"}};
  return {plots::draw(plot),
          fmt::format("Profile of {}: flat where the data say nothing.", text(p, "name")),
          fmt::format("{}: 95 % from {}", text(p, "name"), interval_text(p.at("interval_95")))};
}

void study_parameters_section(const Json& results, page::Page& page) {
  page::Content& content = page.section("Parameters", "parameters");
  page::Table table;
  table.caption = "How well each parameter is known";
  table.columns = {{"parameter", ""}, {"unit", ""}, {"looked at", ""},
                   {"median", ""},    {"95 %", ""}, {"width left of the prior's", "%"},
                   {"remark", ""},    {"keys", ""}};
  std::vector<page::Figure> figures;
  for (const Json& p : results.at("parameters")) {
    std::string keys;
    for (const Json& key : p.at("keys"))
      keys += (keys.empty() ? "" : ", ") + key.get<std::string>();
    std::string remark;
    if (p.value("at_min", false)) remark = "its lower bound limits it";
    if (p.value("at_max", false))
      remark += std::string(remark.empty() ? "" : "; ") + "its upper bound limits it";
    table.rows.push_back(
        {text(p, "name"), unit_of(p),
         fmt::format("{} to {}", page::number_text(number(p, "min"), 3),
                     page::number_text(number(p, "max"), 3)),
         is_fitted(p) ? Cell(number(p, "median"), 4) : Cell(""),
         is_fitted(p) ? interval_text(p.at("interval_95")) : "",
         is_fitted(p) ? Cell(100 * number(p, "posterior_to_prior_sd"), 3) : Cell(""), remark,
         keys});
    if (p.contains("profile") && p.at("profile").is_object()) figures.push_back(profile_figure(p));
  }
  content.table(table);
  if (!figures.empty()) content.figures(figures);
  if (!results.contains("combinations")) return;
  page::Table combinations;
  combinations.caption = "What the data determine, and what they do not";
  combinations.columns = {{"combination", ""}, {"value", ""}, {"", ""}};
  for (const Json& c : results.at("combinations")) {
    const bool identified = c.value("identifiable", false);
    combinations.rows.push_back(
        {combination_text(c),
         identified ? page::measured_text(number(c, "value"), number(c, "uncertainty"))
                    : std::string("limited by the range only"),
         identified ? Badge{Mark::good, "determined"} : Badge{Mark::caution, "not determined"}});
  }
  content.table(combinations);
}

// The answer, the family of equally good sets and what was compared, over the first two parameters.
void add_map(const Json& results, page::Content& content) {
  const Json& parameters = list(results, "parameters");
  if (parameters.size() < 2) return;
  plots::XyPlot plot;
  const auto axis = [](const Json& p) {
    return plots::Axis{words(text(p, "name")), unit_of(p), p.value("scale", "") == "log",
                       number(p, "min"), number(p, "max")};
  };
  plot.x = axis(parameters[0]);
  plot.y = axis(parameters[1]);
  const std::string a = text(parameters[0], "name"), b = text(parameters[1], "name");
  const auto add = [&](const char* name, const std::vector<const Json*>& sets) {
    plots::Series series{name, {}, {}, plots::Style::points};
    for (const Json* set : sets) {
      series.x.push_back(number(set->at("parameters"), a.c_str()));
      series.y.push_back(number(set->at("parameters"), b.c_str()));
    }
    if (!sets.empty()) plot.series.push_back(series);
  };
  std::vector<const Json*> answer, valley, compare;
  if (results.contains("estimate") && results.at("estimate").is_object())
    answer.push_back(&results.at("estimate"));
  if (results.contains("compare"))
    for (const Json& set : results.at("compare")) compare.push_back(&set);
  add("answer", answer);
  if (results.contains("ridge"))
    for (const Json& set : results.at("ridge")) valley.push_back(&set);
  add("equally good", valley);
  add("compared", compare);
  content.figure({plots::draw(plot), "Parameter sets that were looked at closely.",
                  fmt::format("answer, {} members of the family, {} sets compared", valley.size(),
                              compare.size())});
}

void add_set(const Json& set, const Json& results, page::Table& table) {
  std::vector<Cell> row = {text(set, "name")};
  for (const Json& p : results.at("parameters"))
    row.emplace_back(number(set.at("parameters"), text(p, "name").c_str()), 4);
  for (const Json& t : results.at("targets")) {
    const std::string response = text(t, "response");
    const auto value = [&](const char* where, const char* uncertainty) -> std::string {
      if (!set.contains(where) || !set.at(where).contains(response)) return "";
      const Json& v = set.at(where).at(response);
      return page::measured_text(number(v, "value"), number(v, uncertainty));
    };
    row.emplace_back(value("fit", "uncertainty"));
    row.emplace_back(value("simulated", "standard_error"));
  }
  table.rows.push_back(row);
}

void sets_section(const Json& results, const fs::path& folder, page::Page& page) {
  page::Content& content = page.section("Parameter sets", "sets");
  add_map(results, content);
  page::Table table;
  table.caption =
      "Answer, family and what was compared: the model's word, and simulations with "
      "fresh seeds";
  table.columns = {{"set", ""}};
  for (const Json& p : results.at("parameters"))
    table.columns.push_back({text(p, "name"), unit_of(p)});
  for (const Json& t : results.at("targets")) {
    table.columns.push_back({text(t, "response") + ", model", unit_of(t)});
    table.columns.push_back({text(t, "response") + ", simulated", unit_of(t)});
  }
  if (results.contains("estimate") && results.at("estimate").is_object())
    add_set(results.at("estimate"), results, table);
  for (const char* list : {"ridge", "compare"})
    if (results.contains(list))
      for (const Json& set : results.at(list)) add_set(set, results, table);
  content.table(table);
  const fs::path drawn = folder / "fitted_response.svg";
  std::error_code unreadable;
  if (!fs::is_regular_file(drawn, unreadable)) return;
  const std::string svg =
      read_input_file(drawn.string(), "a picture of firn calibrate", input_limits::svg_bytes);
  const std::size_t start = svg.find("<svg");
  if (start != std::string::npos)
    content.figure({svg.substr(start), "The fitted response over the parameters.",
                    "The fitted response over the parameters", true});
}

void knowledge_section(const Json& results, page::Page& page) {
  page::Content& content = page.section("What to measure next", "next");
  if (results.contains("measure_next")) {
    page::Table table;
    table.caption = "Measurements, ranked by expected information for their effort";
    table.columns = {{"response", ""},
                     {"measured to", ""},
                     {"information", "bit"},
                     {"longest direction left", "%"},
                     {"effort", "min"}};
    for (const Json& m : results.at("measure_next"))
      table.rows.push_back(
          {text(m, "response"),
           fmt::format("± {} {}", page::number_text(number(m, "uncertainty"), 2), unit_of(m)),
           Cell(number(m, "information_bits"), 3), Cell(100 * number(m, "remaining_extent"), 3),
           m.contains("effort_seconds") ? Cell(number(m, "effort_seconds") / 60, 3) : Cell("-")});
    content.table(table);
  }
  add_sensitivity(results, content);
}

void numerics_section(const Json& results, page::Page& page) {
  page::Content& content = page.section("Numerics and convergence", "numerics");
  if (results.contains("refinement") && results.at("refinement").is_object())
    content.paragraph(fmt::format("rounds of refinement: {}; stopped: {}",
                                  page::number_text(number(results.at("refinement"), "rounds")),
                                  results.at("refinement").value("stopped", "")));
  page::Table table;
  table.caption = "What numerics do to the responses";
  table.columns = {{"change", ""}, {"response", ""}, {"shift", ""}};
  for (const Json& n : results.value("numerics", Json::array()))
    for (const auto& [response, shift] : n.at("shifts").items())
      table.rows.push_back(
          {text(n, "name"), response,
           with_unit(number(shift, "shift"), number(shift, "standard_error"), shift)});
  if (!table.rows.empty()) content.table(table);
  page::Table models;
  models.caption = "Models of the responses";
  models.columns = {{"response", ""}, {"model", ""},      {"cross-check", ""},
                    {"points", ""},   {"seed noise", ""}, {"largest leave-one-out error", "sd"}};
  for (const Json& m : results.value("models", Json::array()))
    models.rows.push_back({text(m, "response"), m.value("surrogate", ""),
                           m.value("cross_check", ""), Cell(number(m, "points"), 4),
                           m.contains("seed_noise") && m.at("seed_noise").is_object()
                               ? Cell(number(m.at("seed_noise"), "sd"), 3)
                               : Cell(""),
                           m.contains("largest_leave_one_out_z")
                               ? Cell(number(m, "largest_leave_one_out_z"), 3)
                               : Cell("")});
  if (!models.rows.empty()) content.table(models);
}

void study_runs_section(const Json& results, page::Page& page) {
  page::Content& content = page.section("Runs", "runs");
  std::vector<page::Fact> facts;
  for (const auto& [name, value] : results.at("runs").items())
    if (value.is_number() && number(value) > 0) {
      std::string words = name;
      std::ranges::replace(words, '_', ' ');
      facts.push_back({words, page::number_text(number(value))});
    }
  if (results.contains("wall_seconds"))
    facts.push_back({"time of all runs", duration_text(number(results, "wall_seconds"))});
  content.facts(facts);
}

page::Page page_of(const Json& results, const fs::path& folder) {
  page::Page page(
      text(results, "study"),
      fmt::format("study, Firn {} ({}), contact model {}", results.value("firn_version", ""),
                  results.value("git_commit", ""), contact_model_of(results)));
  study_summary(results, page);
  targets_section(results, page);
  curves_section(results, page);
  choices_section(results, page);
  study_parameters_section(results, page);
  predictions_section(results, page);
  estimate_history_section(results, page);
  sets_section(results, folder, page);
  knowledge_section(results, page);
  numerics_section(results, page);
  study_runs_section(results, page);
  return page;
}

}  // namespace

page::Page study_page(const std::string& results_file) {
  const Json results = read_results_json(results_file);
  if (!results.is_object() || !results.contains("study"))
    throw InputError(
        fmt::format("{}: is no result of a study; expected the results.json that firn calibrate "
                    "writes",
                    results_file));
  return page_from(results_file,
                   [&] { return page_of(results, fs::path(results_file).parent_path()); });
}

}  // namespace firn
