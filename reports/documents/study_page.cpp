#include "reports/documents/study_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calibrate/output/study_document.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/math.h"
#include "reports/documents/study_estimate.h"
#include "reports/documents/study_plots.h"
#include "reports/html/results_page.h"
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

std::string interval_text(const StudyDocument::Interval& ends) {
  return range_text(ends.first, ends.second);
}

// Without the verdict at the beginning, which the badge shows.
std::string headline(const StudyDocument& results) {
  std::string sentence = results.headline;
  const std::string verdict = results.verdict + ": ";
  if (sentence.starts_with(verdict)) sentence.erase(0, verdict.size());
  // Results of earlier builds have it in ASCII.
  for (std::size_t at = 0; (at = sentence.find(" +- ", at)) != std::string::npos;)
    sentence.replace(at, 4, " ± ");
  return sentence;
}

// False of a study of which too few runs finished to fit anything.
bool is_fitted(const StudyDocument::Parameter& p) { return p.interval_95 && p.median; }

// Of a parameter in a set; throws BadValue where the set lacks it.
double value_in(const StudyDocument::Set& set, const std::string& parameter) {
  const double* value = find_named(set.parameters, parameter);
  if (value == nullptr)
    throw BadValue(fmt::format("parameter set \"{}\" has no \"{}\"", set.name, parameter));
  return *value;
}

// The answer, as every other place of the page and the command have it; without one the median.
void study_summary(const StudyDocument& results, page::Page& page) {
  const bool answered = results.estimate.has_value();
  std::vector<page::KeyFigure> cards;
  for (const StudyDocument::Parameter& p : results.parameters) {
    if (!is_fitted(p)) {
      if (!answered) continue;
      throw BadValue(fmt::format("parameter \"{}\" has no interval", p.name));
    }
    const double value = answered ? value_in(*results.estimate, p.name) : *p.median;
    const std::string unit = unit_text(p.unit);
    cards.push_back({words(p.name) + (answered ? "" : ", median"),
                     number_text(value) + unit_suffix(unit),
                     "95 %: " + interval_text(*p.interval_95),
                     {}});
  }
  page.top().note(verdict_badge(results.verdict), headline(results));
  page.top().key_figures(cards);
  if (const std::vector<page::Property> facts = study_estimate(results); !facts.empty())
    page.top().properties(facts);
}

void targets_section(const StudyDocument& results, page::Page& page) {
  page::Table table;
  table.caption = "What the parameters were fitted to";
  table.columns = {{"response", ""},
                   {"measured", ""},
                   {"at the answer", ""},
                   {"can be reached", ""},
                   {"source", ""}};
  for (const StudyDocument::Target& t : results.targets) {
    std::string fitted;
    if (results.estimate)
      if (const auto* s = find_named(results.estimate->simulated, t.response))
        fitted = measured_text(s->value, s->standard_error, t.unit);
    const std::string reach = t.reach ? interval_text({t.reach->lowest, t.reach->highest}) : "";
    std::string measured = measured_text(t.value, t.uncertainty, t.unit);
    if (t.discrepancy)
      measured += fmt::format(", discrepancy of the simulation ± {} {}",
                              page::number_text(*t.discrepancy, 2), unit_text(t.unit));
    table.rows.push_back({t.response, measured, fitted, reach, t.source});
  }
  page.section("Targets", "targets").table(table);
}

// Recorded curves, and what the model gives at the answer: the mean of the simulated curves and the
// components, each times its score.
void curves_section(const StudyDocument& results, page::Page& page) {
  std::vector<page::Figure> figures;
  for (const StudyDocument::Curve& c : results.curves) {
    const std::string unit = unit_text(c.unit);
    const auto require_places = [&](const std::vector<double>& values) {
      if (values.size() != c.x.size())
        throw BadValue(fmt::format("curve \"{}\" has lists of {} and of {} numbers", c.label,
                                   c.x.size(), values.size()));
    };
    require_places(c.recorded);
    require_places(c.simulated_mean);
    plots::XyPlot plot;
    plot.x = {"x", unit_text(c.x_unit), false, {}, {}};
    plot.y = {words(c.label), unit, false, {}, {}};
    plots::Series recorded{"recorded", c.x, c.recorded};
    plot.series = {recorded};
    plots::Series fitted{"model at the answer", c.x, c.simulated_mean};
    std::size_t scores = 0;
    for (std::size_t k = 0; results.estimate && k < c.components.size(); ++k) {
      const auto* score =
          find_named(results.estimate->fit, fmt::format("{}.score_{}", c.label, k + 1));
      if (score == nullptr) continue;
      require_places(c.components[k]);
      for (std::size_t i = 0; i < c.x.size(); ++i) fitted.y[i] += score->value * c.components[k][i];
      ++scores;
    }
    if (scores == c.components.size()) plot.series.push_back(fitted);
    figures.push_back(
        {plots::draw(plot),
         fmt::format("{}: {} principal components hold {} % of the variance between the simulated "
                     "curves.",
                     c.label, c.components.size(), number_text(100 * c.explained_variance, 3)),
         fmt::format("{}: {} places, root mean square that the components leave of the recorded "
                     "curve: {} {}",
                     c.label, c.x.size(), number_text(c.recorded_rest, 2), unit)});
  }
  if (!figures.empty()) page.section("Curves", "curves").figures(figures);
}

// The choices of a parameter without order, and what each of them gives.
void choices_section(const StudyDocument& results, page::Page& page) {
  if (!results.choice) return;
  const StudyDocument::Choices& choice = *results.choice;
  page::Table table;
  table.caption = fmt::format(
      "Choices of {}, and the parameters given each of them; the rest of "
      "this page is for {}",
      choice.parameter, choice.best);
  table.columns = {{"choice", ""}, {"before", ""}, {"probability", ""}, {"verdict", ""}};
  for (const StudyDocument::Parameter& p : results.parameters)
    table.columns.push_back({p.name + ", median, 95 %", unit_text(p.unit)});
  for (const StudyDocument::Choices::Choice& c : choice.choices) {
    std::vector<Cell> row = {c.label, Cell(c.prior, 3),
                             std::isnan(c.probability) ? Cell("not known") : Cell(c.probability, 3),
                             c.verdict};
    for (const StudyDocument::Parameter& p : results.parameters) {
      const StudyDocument::Marginal* m = find_named(c.parameters, p.name);
      row.emplace_back(m == nullptr ? std::string()
                                    : fmt::format("{}, {}", number_text(m->median),
                                                  interval_text(m->interval_95)));
    }
    table.rows.push_back(row);
  }
  page.section("Choices", "choices").table(table);
}

page::Figure profile_figure(const StudyDocument::Parameter& p) {
  plots::XyPlot plot;
  plot.x = {words(p.name), unit_text(p.unit), p.logarithmic(), {}, {}};
  plot.y = {"minus twice the log likelihood", "", false, 0.0, 10.0};
  plots::Series series;
  series.x = p.profile->values;
  series.y = p.profile->minus_twice_log_likelihood;
  if (series.x.size() != series.y.size())
    throw BadValue(fmt::format("the profile of \"{}\" has lists of {} and of {} numbers", p.name,
                               series.x.size(), series.y.size()));
  const auto least = std::ranges::min_element(series.y);
  const double low = least == series.y.end() ? 0 : *least;
  for (double& y : series.y) y = y - low > 12 ? std::nan("") : y - low;
  plot.series = {series};
  plot.horizontal = {{3.841, "95 %"}};
  return {plots::draw(plot),
          fmt::format("Profile of {}: flat where the data say nothing.", words(p.name)),
          fmt::format("{}: 95 % from {}", p.name,
                      interval_text(p.interval_95.value_or(p.profile->interval_95)))};
}

void study_parameters_section(const StudyDocument& results, page::Page& page) {
  page::Content& content = page.section("Parameters", "parameters");
  page::Table table;
  table.caption = "How well each parameter is known";
  table.columns = {{"parameter", ""}, {"unit", ""}, {"range", ""},
                   {"median", ""},    {"95 %", ""}, {"width left of the prior's", "%"},
                   {"remark", ""},    {"keys", ""}};
  std::vector<page::Figure> figures;
  for (const StudyDocument::Parameter& p : results.parameters) {
    std::string remark;
    if (p.at_min.value_or(false)) remark = "its lower bound limits it";
    if (p.at_max.value_or(false))
      remark += std::string(remark.empty() ? "" : "; ") + "its upper bound limits it";
    table.rows.push_back(
        {p.name, unit_text(p.unit), interval_text({p.min, p.max}),
         is_fitted(p) ? Cell(*p.median, 4) : Cell(""),
         is_fitted(p) ? interval_text(*p.interval_95) : "",
         p.posterior_to_prior_sd ? Cell(100 * *p.posterior_to_prior_sd, 3) : Cell(""), remark,
         fmt::format("{}", fmt::join(p.keys, ", "))});
    if (p.profile) figures.push_back(profile_figure(p));
  }
  content.table(table);
  if (!figures.empty()) content.figures(figures);
  page::Table combinations;
  combinations.caption = "What the data determine, and what they do not";
  combinations.columns = {{"combination", ""}, {"value", ""}, {"", ""}};
  for (const StudyDocument::Combination& c : results.combinations)
    combinations.rows.push_back({combination_text(c),
                                 c.identifiable ? page::measured_text(c.value, c.uncertainty)
                                                : std::string("limited by the range only"),
                                 c.identifiable ? Badge{Mark::good, "determined"}
                                                : Badge{Mark::caution, "not determined"}});
  content.table(combinations);
}

// The answer, the members of the ridge and the compared sets, over the first two parameters.
void add_map(const StudyDocument& results, page::Content& content) {
  const std::vector<StudyDocument::Parameter>& parameters = results.parameters;
  if (parameters.size() < 2) return;
  plots::XyPlot plot;
  const auto axis = [](const StudyDocument::Parameter& p) {
    return plots::Axis{words(p.name), unit_text(p.unit), p.logarithmic(), p.min, p.max};
  };
  plot.x = axis(parameters[0]);
  plot.y = axis(parameters[1]);
  const auto add = [&](const char* name, const std::vector<StudyDocument::Set>& sets) {
    plots::Series series{name, {}, {}, plots::Style::points};
    for (const StudyDocument::Set& set : sets) {
      series.x.push_back(value_in(set, parameters[0].name));
      series.y.push_back(value_in(set, parameters[1].name));
    }
    if (!sets.empty()) plot.series.push_back(series);
  };
  if (results.estimate) add("answer", {*results.estimate});
  add("equally good", results.ridge);
  add("compared", results.compare);
  content.figure({plots::draw(plot), "Parameter sets that were examined closely.",
                  fmt::format("answer, {} members of the ridge, {} sets compared",
                              results.ridge.size(), results.compare.size())});
}

void add_set(const StudyDocument::Set& set, const StudyDocument& results, page::Table& table) {
  std::vector<Cell> row = {set.name};
  for (const StudyDocument::Parameter& p : results.parameters)
    row.emplace_back(value_in(set, p.name), 4);
  for (const StudyDocument::Target& t : results.targets) {
    const auto* fitted = find_named(set.fit, t.response);
    const auto* simulated = find_named(set.simulated, t.response);
    row.emplace_back(fitted == nullptr ? std::string()
                                       : page::measured_text(fitted->value, fitted->uncertainty));
    row.emplace_back(simulated == nullptr
                         ? std::string()
                         : page::measured_text(simulated->value, simulated->standard_error));
  }
  table.rows.push_back(row);
}

void sets_section(const StudyDocument& results, const fs::path& folder, page::Page& page) {
  page::Content& content = page.section("Parameter sets", "sets");
  add_map(results, content);
  page::Table table;
  table.caption =
      "Answer, members of the ridge and compared sets: predicted by the model, and simulated with "
      "fresh seeds";
  table.columns = {{"set", ""}};
  for (const StudyDocument::Parameter& p : results.parameters)
    table.columns.push_back({p.name, unit_text(p.unit)});
  for (const StudyDocument::Target& t : results.targets) {
    table.columns.push_back({t.response + ", model", unit_text(t.unit)});
    table.columns.push_back({t.response + ", simulated", unit_text(t.unit)});
  }
  if (results.estimate) add_set(*results.estimate, results, table);
  for (const auto* sets : {&results.ridge, &results.compare})
    for (const StudyDocument::Set& set : *sets) add_set(set, results, table);
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

void knowledge_section(const StudyDocument& results, page::Page& page) {
  page::Content& content = page.section("What to measure next", "next");
  page::Table table;
  table.caption = "Measurements, ranked by expected information for their effort";
  table.columns = {{"response", ""},
                   {"measured to", ""},
                   {"information", "bit"},
                   {"longest direction left", "%"},
                   {"effort", "min"}};
  for (const StudyDocument::Advice& m : results.measure_next)
    table.rows.push_back(
        {m.response, fmt::format("± {} {}", page::number_text(m.uncertainty, 2), unit_text(m.unit)),
         Cell(m.information_bits, 3), Cell(100 * m.remaining_extent, 3),
         m.effort_seconds ? Cell(*m.effort_seconds / 60, 3) : Cell("-")});
  content.table(table);
  add_sensitivity(results, content);
}

void add_low_fidelity(const StudyDocument::LowFidelity& low, page::Content& content) {
  page::Table table;
  table.caption = fmt::format(
      "What the low fidelity moves at the answer ({} runs of {}; {} of "
      "high fidelity of {})",
      low.runs, duration_text(low.wall_seconds / std::max(low.runs, 1)), low.high_fidelity_runs,
      duration_text(low.high_fidelity_wall_seconds / std::max(low.high_fidelity_runs, 1)));
  table.columns = {{"response", ""}, {"bias", ""}};
  for (const auto& [response, bias] : low.biases)
    table.rows.push_back({response, measured_text(bias.value, bias.uncertainty, bias.unit)});
  content.table(table);
}

void numerics_section(const StudyDocument& results, page::Page& page) {
  page::Content& content = page.section("Numerics and convergence", "numerics");
  if (results.refinement)
    content.paragraph(fmt::format("rounds of refinement: {}; stopped: {}",
                                  results.refinement->rounds, results.refinement->stopped));
  page::Table table;
  table.caption = "What numerics do to the responses";
  table.columns = {{"change", ""}, {"response", ""}, {"shift", ""}};
  for (const StudyDocument::Numerics& n : results.numerics)
    for (const auto& [response, of] : n.shifts)
      table.rows.push_back({n.name, response, measured_text(of.shift, of.standard_error, of.unit)});
  if (!table.rows.empty()) content.table(table);
  if (results.low_fidelity) add_low_fidelity(*results.low_fidelity, content);
  page::Table models;
  models.caption = "Models of the responses";
  models.columns = {{"response", ""}, {"model", ""},      {"cross-check", ""},
                    {"points", ""},   {"seed noise", ""}, {"largest leave-one-out error", "sd"}};
  for (const StudyDocument::Model& m : results.models)
    models.rows.push_back(
        {m.response, m.surrogate, m.cross_check, Cell(static_cast<double>(m.points), 4),
         m.seed_noise ? Cell(m.seed_noise->sd, 3) : Cell(""),
         m.largest_leave_one_out_z ? Cell(*m.largest_leave_one_out_z, 3) : Cell("")});
  if (!models.rows.empty()) content.table(models);
}

void study_runs_section(const StudyDocument& results, page::Page& page) {
  page::Content& content = page.section("Runs", "runs");
  const StudyDocument::RunCounts& runs = results.runs;
  std::vector<page::Property> facts;
  for (const auto& [name, count] : {std::pair("total", runs.total),
                                    {"finished", runs.finished},
                                    {"arched", runs.arched},
                                    {"failed", runs.failed},
                                    {"timed out", runs.timed_out},
                                    {"out of memory", runs.out_of_memory},
                                    {"crashed", runs.crashed},
                                    {"by another version", runs.by_another_version}})
    if (count > 0) facts.push_back({name, page::number_text(count)});
  if (results.wall_seconds)
    facts.push_back({"time of all runs", duration_text(*results.wall_seconds)});
  content.properties(facts);
}

page::Page page_of(const StudyDocument& results, const fs::path& folder) {
  page::Page page(results.study,
                  fmt::format("study, Firn {} ({}), contact model {}", results.firn_version,
                              results.git_commit, results.contact_model));
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

page::Page study_page(const ResultsJson& results) {
  const StudyDocument document = read_study_document(results);
  return page_from(results.file,
                   [&] { return page_of(document, fs::path(results.file).parent_path()); });
}

}  // namespace firn
