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
#include "reports/html/json_values.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;

// What must be known of the comparison; what holds of several parameter sets is said once.
std::vector<std::string> caveats(const Sets& sets) {
  std::vector<std::pair<std::string, std::vector<std::string>>> said;
  for (const Json* c : sets) {
    for (const Json& caveat : c->at("caveats")) {
      const std::string words = caveat.get<std::string>();
      auto same = std::ranges::find(said, words, [](const auto& s) { return s.first; });
      if (same == said.end()) same = said.insert(said.end(), {words, {}});
      same->second.push_back(text(*c, "parameter_set"));
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
  const Json& first = *sets.front();
  const std::string anchor = page::anchor_of(text(first, "name"));
  page::Content& content = page.section(text(first, "title"), anchor);
  if (!text(first, "note").empty()) content.paragraph(text(first, "note"));
  if (!text(first, "measurement").empty())
    content.facts({{first.value("code_to_code", false) ? "by another simulation" : "measured",
                    text(first, "measurement")},
                   {"status of the measurement", text(first, "measurement_status")},
                   {"simulated", text(first, "experiment")}});
  for (const Json* c : sets) {
    std::string line = fmt::format("{}: {}", text(*c, "parameter_set"), text(*c, "headline"));
    if (!text(*c, "recommended_action").empty())
      line += fmt::format(". Recommended: {}", text(*c, "recommended_action"));
    content.note(badge_of(text(*c, "verdict")), line);
  }
  add_comparison(sets, content);
  if (const std::vector<std::string> all = caveats(sets); !all.empty()) content.list(all);
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

// Where several statements make up a verdict, how many of them hold.
Cell verdict_cell(const Json& comparison) {
  Cell cell(badge_of(text(comparison, "verdict")));
  const Json claims = comparison.value("criteria", Json::array());
  const auto hold = std::ranges::count_if(
      claims, [](const Json& claim) { return text(claim, "verdict") == "consistent"; });
  if (claims.size() > 1) cell.text = fmt::format("{} of {} hold", hold, claims.size());
  if (comparison.value("code_to_code", false)) cell.text += " (code-to-code)";
  return cell;
}

void validation_summary(const Json& results, const std::vector<Sets>& groups, page::Page& page) {
  std::map<std::string, int> count;
  for (const Json& c : results.at("comparisons"))
    if (!c.value("code_to_code", false)) ++count[text(c, "verdict")];
  std::vector<page::Card> cards;
  for (const char* verdict :
       {"consistent", "inconsistent", "inconclusive", "not independent", "not comparable"})
    cards.push_back({verdict, std::to_string(count[verdict]), "", {badge_of(verdict).mark, " "}});
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
      row.push_back(found == group.end() ? Cell("not run") : verdict_cell(**found));
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
      keys += fmt::format("{}{}", keys.empty() ? "" : ", ",
                          shortest_numbers(key + " = " + value.get<std::string>()));
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

page::Page page_of(const Json& results, const std::string& folder,
                   const ValidationPageOptions& options) {
  page::Page page(text(results, "title"),
                  fmt::format("validation \"{}\", Firn {} ({}), contact model {}",
                              text(results, "name"), text(results, "firn_version"),
                              text(results, "git_commit"), contact_model_of(results)));
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

page::Page validation_page(const std::string& results_file, const ValidationPageOptions& options) {
  const Json results = read_results_json(results_file);
  if (!results.is_object() || results.value("kind", Json()) != "validation")
    throw InputError(
        fmt::format("{}: is no result of a validation; expected the results.json that firn "
                    "validate writes",
                    results_file));
  return page_from(results_file, [&] {
    return page_of(results, std::filesystem::path(results_file).parent_path().string(), options);
  });
}

}  // namespace firn
