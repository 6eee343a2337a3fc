#include "reports/documents/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/inspection/run_diagnostics.h"
#include "experiments/responses/measure.h"
#include "experiments/responses/response_order.h"
#include "experiments/results/bond_results.h"
#include "experiments/results/results_file.h"
#include "experiments/storage/version.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "reports/documents/run_plots.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;

Badge status_badge(const std::string& status) {
  if (status == "finished") return {Mark::good, status};
  if (status.starts_with("failed")) return {Mark::bad, "failed"};
  return {Mark::caution, status};
}

std::string plural(std::size_t n, const std::string& word) {
  return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s");
}

bool is_scalar(const Response& r) { return r.value.size() == 1; }
double uncertainty(const Response& r) {
  return r.uncertainty.empty() ? std::nan("") : r.uncertainty[0];
}

std::vector<page::KeyFigure> response_cards(const std::vector<Response>& responses, const Case& c) {
  std::vector<page::KeyFigure> cards;
  for (const Response& r : main_responses(responses, c)) {
    if (r.name == "arched")
      cards.push_back({"jam", r.value[0] == 0 ? "none" : "yes", r.method, {}});
    else
      cards.push_back({page::words(r.name),
                       page::measured_text(r.value[0], uncertainty(r), r.unit),
                       r.method,
                       {}});
  }
  return cards;
}

// A long list by its range.
std::string values_text(const std::vector<double>& values, const std::string& unit) {
  constexpr std::size_t kShort = 6;
  std::string all;
  double low = INFINITY, high = -INFINITY;
  std::size_t defined = 0;
  for (const double value : values) {
    const double v = resolved(value, unit);
    all += (all.empty() ? "" : ", ") + page::number_text(v);
    if (!std::isfinite(v)) continue;
    ++defined;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (values.size() <= kShort) return all;
  const std::string missing =
      defined < values.size() ? fmt::format(", {} undefined", values.size() - defined) : "";
  if (defined == 0) return fmt::format("{} values, all undefined", values.size());
  return fmt::format("{} values, {} to {}{}", values.size(), page::number_text(low),
                     page::number_text(high), missing);
}

page::Table response_table(const std::vector<Response>& responses) {
  page::Table table;
  table.caption = "Responses; ± is one standard deviation where it is known";
  table.columns = {{"response", ""}, {"value", ""}, {"unit", ""}, {"how", ""}};
  for (const Response& r : responses)
    table.rows.push_back({r.name,
                          is_scalar(r) ? Cell::measured(r.value[0], uncertainty(r), r.unit)
                                       : Cell(values_text(r.value, r.unit)),
                          unit_text(r.unit), r.method});
  return table;
}

struct Counts {
  std::size_t inserted = 0, left = 0;
};
Counts counts_of(const Recording& recording) {
  Counts counts;
  for (const double t : recording.insert_time()) counts.inserted += std::isfinite(t) ? 1 : 0;
  for (const double t : recording.exit_time()) counts.left += std::isfinite(t) ? 1 : 0;
  return counts;
}

void top(const Recording& recording, const Case& c, const std::vector<Response>& responses,
         page::Page& page) {
  const std::vector<double> times = recording.frame_times();
  const std::vector<StageRecord> stages = recording.stages();
  const std::string status = recording.status();
  const Counts counts = counts_of(recording);
  page.top().note(status_badge(status), status.starts_with("failed")
                                            ? status.substr(std::min<std::size_t>(8, status.size()))
                                        : stages.empty() || stages.back().end_reason.empty()
                                            ? "under way when this page was made"
                                            : fmt::format("ended: {}", stages.back().end_reason));
  for (std::size_t i = 0; i + 1 < stages.size(); ++i)
    if (stages[i].end_reason.starts_with("stalled"))
      page.top().note({Mark::caution, "jam"},
                      fmt::format("{}: {}", stages[i].name, stages[i].end_reason));
  const std::vector<page::KeyFigure> cards = response_cards(responses, c);
  if (!cards.empty()) page.top().key_figures(cards);
  page.top().properties(
      {{"simulated time",
        fmt::format("{} of at most {} s", page::number_text(times.empty() ? 0 : times.back()),
                    page::number_text(c.duration))},
       {"particles",
        fmt::format("{} were inserted, {} left through outlets", counts.inserted, counts.left)},
       {"time step", fmt::format("{} us", page::number_text(1e6 * recording.timestep()))},
       {"wall time", std::isfinite(recording.wall_time()) ? duration_text(recording.wall_time())
                                                          : "not recorded"}});
}

void stages_section(const Recording& recording, page::Page& page) {
  page::Table table;
  table.caption = "Stages, and what ended them";
  table.columns = {{"stage", ""}, {"from", "s"}, {"to", "s"}, {"duration", "s"}, {"ended by", ""}};
  for (const StageRecord& s : recording.stages()) {
    const bool over = std::isfinite(s.end);
    table.rows.push_back({s.name.empty() ? "whole run" : s.name, s.start,
                          over ? Cell(s.end) : Cell("under way"),
                          over ? Cell(s.end - s.start) : Cell(""), s.end_reason});
  }
  if (!table.rows.empty()) page.section("Stages", "stages").table(table);
}

void figures_section(const std::string& title, const std::vector<page::Figure>& figures,
                     page::Page& page) {
  if (!figures.empty()) page.section(title).figures(figures);
}

void bonds_section(const Recording& recording, const Case& c, page::Page& page) {
  const std::vector<BondOutcome> bonds = bond_outcomes(recording);
  if (bonds.empty()) return;
  std::map<std::string, std::size_t> modes;
  page::Table table;
  table.caption = "Bonds that broke or ended";
  table.columns = {{"bond", ""}, {"between", ""}, {"by", ""}, {"at", "s"}, {"stress", "kPa"}};
  for (const BondOutcome& b : bonds) {
    ++modes[b.mode];
    if (b.mode == "intact") continue;
    table.rows.push_back({b.name, bodies_text(c.model, b), b.mode,
                          std::isfinite(b.time) ? Cell(b.time) : Cell(""),
                          std::isfinite(b.stress) ? Cell(1e-3 * b.stress, 3) : Cell("")});
  }
  page::Content& content = page.section("Bonds", "bonds");
  std::vector<page::KeyFigure> cards;
  for (const auto& [mode, count] : modes)
    cards.push_back({mode, std::to_string(count), "bonds", {}});
  content.key_figures(cards);
  if (table.rows.empty()) return;
  page::Content fold;
  fold.table(table);
  content.collapsible(plural(table.rows.size(), "bond") + " that do not hold", fold);
}

// A run that has no frame yet has none of these numbers.
std::string recorded_text(double value, double scale, int digits, const char* unit) {
  return std::isfinite(value) ? page::number_text(scale * value, digits) + unit : "not recorded";
}

// Whether the numbers can be trusted.
void diagnostics_section(const Recording& recording, const Case& c, page::Page& page) {
  const double overlap = last_finite(recording.series("/diagnostics/largest_overlap"));
  const double rise = last_finite(recording.series("/diagnostics/energy_error"));
  const double turned = last_finite(recording.series("/energy/dissipated"));
  const double late = last_finite(recording.series("/diagnostics/late_contacts"));
  page::Content& content = page.section("Diagnostics", "diagnostics");
  const std::set<std::string> rounded = shapes_with_stated_rounding(c);
  for (const Shape& shape : c.model.shapes) {
    const std::string warning = deviation_warning(shape, rounded.contains(shape.name));
    if (!warning.empty()) content.note({Mark::caution, "shape"}, warning);
  }
  for (const RunWarning& warning : run_warnings(recording, c))
    content.note({Mark::caution, warning.subject}, warning.text);
  if (rise > 0.01 * turned && rise > 0)
    content.note(
        {Mark::caution, "energy"},
        fmt::format(
            "rises of energy that nothing explains add up to {} % of what was "
            "dissipated; repeat the run with a smaller time step to check whether they matter",
            page::number_text(100 * rise / turned, 3)));
  std::vector<page::Property> facts = {
      {"largest overlap", recorded_text(overlap, 1e3, 3, " mm")},
      {"energy error", recorded_text(rise, 1, 3, " J") + ", compared with " +
                           recorded_text(turned, 1, 3, " J") + " dissipated"},
      {"contacts detected late", recorded_text(late, 1, 9, "")}};
  if (recording.contains("/diagnostics/unconverged_steps"))
    facts.push_back({"steps without convergence of joints",
                     recorded_text(joint_convergence(recording).unconverged, 1, 9, "")});
  content.properties(facts);
}

void case_section(const Recording& recording, const Case& c, page::Page& page) {
  page::Content& content = page.section("Case and commands", "case");
  const std::string file = std::filesystem::path(recording.file()).filename().string();
  content.code(fmt::format("firn measure {0}\nfirn export {0} --to vtk\nfirn report {0}\n", file),
               "The same numbers, ParaView's files and this page, from the results file");
  content.code(fmt::format("firn run case.toml --seed {} -o again.h5\n", recording.seed()),
               "To run it again, with the case below kept as case.toml");
  for (const AppliedMaterial& m : c.material_records)
    content.paragraph(fmt::format("Material record {}{}{}, SHA-256 {}.", m.record,
                                  m.selection.empty() ? "" : ", ", m.selection, m.sha256));
  if (!c.start.empty()) content.paragraph(fmt::format("Starts from {}.", c.start));
  page::Content fold;
  fold.code(shortest_numbers(c.resolved));
  content.collapsible("The whole case, defaults filled in", fold);
}

}  // namespace

page::Page run_page(const std::string& results_file, const ReplayViewOptions& options) {
  const Recording recording(results_file);
  const Case c = read_case(recording);
  const std::vector<Response> responses =
      in_display_order(recording.measured() ? recording.responses() : measure(recording, c), c);
  page::Page page(c.name, fmt::format("one run, seed {}, {}, contact model {}", recording.seed(),
                                      recording.program(), recording.contact_model()));
  top(recording, c, responses, page);
  add_replay(page, recording, c, options);
  if (!responses.empty()) page.section("Responses", "responses").table(response_table(responses));
  stages_section(recording, page);
  figures_section("Passages", passage_figures(recording, c), page);
  figures_section("Loads on boundaries", load_figures(recording, c), page);
  figures_section("Samples", sample_figures(recording, c), page);
  figures_section("Moving parts", motion_figures(recording, c), page);
  figures_section("Curves", measured_curve_figures(responses, c), page);
  figures_section("Energy", energy_figures(recording), page);
  bonds_section(recording, c, page);
  diagnostics_section(recording, c, page);
  case_section(recording, c, page);
  page.set_footer(fmt::format("Made from {} by Firn {}.",
                              std::filesystem::path(results_file).filename().string(),
                              firn_version()));
  return page;
}

}  // namespace firn
