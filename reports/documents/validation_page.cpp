#include "reports/documents/validation_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "experiments/text/number_text.h"
#include "firn/math.h"
#include "reports/documents/comparison_sections.h"
#include "reports/documents/validation_replays.h"
#include "reports/html/results_page.h"
#include "validation/validation_document.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;
using ComparisonRow = ValidationDocument::ComparisonRow;

// What must be known of the comparison; what holds of several parameter sets is said once.
std::vector<std::string> caveats(const Sets& sets) {
  std::vector<std::pair<std::string, std::vector<std::string>>> said;
  for (const ComparisonRow* c : sets) {
    for (const std::string& words : c->caveats) {
      auto same = std::ranges::find(said, words, [](const auto& s) { return s.first; });
      if (same == said.end()) same = said.insert(said.end(), {words, {}});
      same->second.push_back(c->parameter_set);
    }
  }
  std::vector<std::string> lines;
  for (const auto& [words, of] : said)
    lines.push_back(of.size() == sets.size() && sets.size() > 1
                        ? words
                        : fmt::format("{}: {}", fmt::join(of, "; "), words));
  return lines;
}

void comparison_section(const Sets& sets, ValidationReplays* replays, page::Page& page) {
  const ComparisonRow& first = *sets.front();
  const std::string anchor = page::slugify(first.name);
  page::Content& content = page.section(first.title, anchor);
  if (!first.note.empty()) content.paragraph(first.note);
  if (!first.measurement.empty())
    content.properties(
        {{first.code_to_code ? "by another simulation" : "measured", first.measurement},
         {"status of the measurement", first.measurement_status},
         {"simulated", first.experiment}});
  for (const ComparisonRow* c : sets) {
    std::string line = fmt::format("{}: {}", c->parameter_set, c->headline);
    if (!c->recommended_action.empty())
      line += fmt::format(". Recommended: {}", c->recommended_action);
    content.note(badge_of(c->verdict), line);
  }
  add_comparison(sets, content);
  if (const std::vector<std::string> all = caveats(sets); !all.empty()) content.list(all);
  if (replays) replays->add(first.experiment, anchor, page, content);
}

// By comparison, in the suite's order.
std::vector<Sets> grouped(const ValidationDocument& results) {
  std::vector<Sets> groups;
  for (const ComparisonRow& c : results.comparisons) {
    if (groups.empty() || groups.back().front()->name != c.name) groups.emplace_back();
    groups.back().push_back(&c);
  }
  return groups;
}

// Where several statements make up a verdict, how many of them hold.
Cell verdict_cell(const ComparisonRow& comparison) {
  Cell cell(badge_of(comparison.verdict));
  const std::vector<ValidationDocument::CriterionRow>& claims = comparison.criteria;
  const auto hold = std::ranges::count_if(
      claims, [](const auto& claim) { return claim.verdict == "consistent"; });
  if (claims.size() > 1) cell.text = fmt::format("{} of {} hold", hold, claims.size());
  if (comparison.code_to_code) cell.text += " (code-to-code)";
  return cell;
}

void validation_summary(const ValidationDocument& results, const std::vector<Sets>& groups,
                        page::Page& page) {
  std::map<std::string, int> count;
  for (const ComparisonRow& c : results.comparisons)
    if (!c.code_to_code) ++count[c.verdict];
  std::vector<page::KeyFigure> cards;
  for (const char* verdict :
       {"consistent", "inconsistent", "inconclusive", "not independent", "not comparable"})
    if (const int n = count[verdict]; n > 0)
      cards.push_back({verdict, std::to_string(n), "", {badge_of(verdict).mark, " "}});
  if (!cards.empty()) page.top().key_figures(cards);
  if (!results.note.empty()) page.top().paragraph(results.note);
  page::Table table;
  table.caption = "Verdicts by comparison and parameter set";
  table.columns = {{"comparison", ""}};
  std::vector<std::string> sets;
  for (const ValidationDocument::ParameterSetRow& p : results.parameter_sets) {
    sets.push_back(p.name);
    table.columns.push_back({sets.back(), ""});
  }
  for (const Sets& group : groups) {
    std::vector<Cell> row = {Cell::link(group.front()->title, page::slugify(group.front()->name))};
    for (const std::string& set : sets) {
      const auto found = std::ranges::find(group, set, &ComparisonRow::parameter_set);
      row.push_back(found == group.end() ? Cell("not run") : verdict_cell(**found));
    }
    table.rows.push_back(row);
  }
  page.top().table(table);
}

void parameters_section(const ValidationDocument& results, page::Page& page) {
  page::Table table;
  table.caption = "Parameter sets";
  table.columns = {{"name", ""}, {"material record", ""}, {"keys set", ""}, {"note", ""}};
  for (const ValidationDocument::ParameterSetRow& p : results.parameter_sets) {
    std::string keys;
    for (const auto& [key, value] : p.set)
      keys += fmt::format("{}{}", keys.empty() ? "" : ", ", shortest_numbers(key + " = " + value));
    table.rows.push_back({p.name, p.material, keys, p.note});
  }
  page.section("Parameters", "parameters").table(table);
}

void runs_section(const ValidationDocument& results, page::Page& page) {
  page::Table table;
  table.caption = "All runs";
  table.columns = {{"experiment", ""}, {"parameters", ""}, {"for", ""}, {"seed", ""},
                   {"ended", ""},      {"wall time", "s"}, {"key", ""}};
  for (const ValidationDocument::ExperimentRow& e : results.experiments)
    for (const ValidationDocument::RunRow& r : e.runs)
      table.rows.push_back({e.name, r.parameter_set, r.variant.empty() ? r.purpose : r.variant,
                            Cell(static_cast<double>(r.seed), 6), r.status, Cell(r.wall, 3),
                            r.key});
  page::Content& content = page.section("Runs and commands", "runs");
  std::string commands = results.command + "\n";
  std::set<std::string> cases;
  for (const ValidationDocument::ExperimentRow& e : results.experiments)
    if (cases.insert(e.case_file).second)
      commands += fmt::format("firn run {} --seed 1\n", e.case_file);
  content.code(commands, "To do it again");
  page::Content fold;
  fold.table(table);
  content.collapsible(fmt::format("{} runs", table.rows.size()), fold);
}

void method_section(page::Page& page) {
  page.section("How verdicts are reached", "method")
      .paragraph(
          "A value is inconsistent when simulation and experiment differ by more than twice the "
          "standard uncertainty of their difference, made up of run-to-run variability, time step, "
          "stiffness, input "
          "parameters and the experiment (ASME V&V 20). It is inconclusive when that uncertainty "
          "is larger "
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
          "bound it. The probability with Weibull's distribution is given in addition.");
}

page::Page page_of(const ValidationDocument& results, const std::string& folder,
                   const ValidationPageOptions& options) {
  page::Page page(results.title,
                  fmt::format("validation \"{}\", Firn {} ({}), contact model {}", results.name,
                              results.firn_version, results.git_commit, results.contact_model));
  const std::vector<Sets> groups = grouped(results);
  validation_summary(results, groups, page);
  std::optional<ValidationReplays> replays;
  if (options.replays) replays.emplace(results, folder, options.replay_budget);
  for (const Sets& group : groups) comparison_section(group, replays ? &*replays : nullptr, page);
  parameters_section(results, page);
  method_section(page);
  runs_section(results, page);
  return page;
}

}  // namespace

page::Page validation_page(const ResultsJson& results, const ValidationPageOptions& options) {
  const ValidationDocument document = read_validation_document(results);
  return page_from(results.file, [&] {
    return page_of(document, std::filesystem::path(results.file).parent_path().string(), options);
  });
}

}  // namespace firn
