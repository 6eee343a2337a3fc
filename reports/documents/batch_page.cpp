#include "reports/documents/batch_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/math.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::Cell;
using page::Mark;

constexpr std::size_t kMostRows = 500;       // of the table of runs: the latest ones
constexpr std::size_t kMostPointPlots = 12;  // responses over parameters
constexpr std::size_t kMostColumns = 6;      // responses in the table of runs

std::string task_name(const std::string& command) {
  if (command == "calibrate") return "study";
  if (command == "validate") return "validation";
  return command.empty() ? "batch" : command;
}

// "friction=0.1 e=0.3": names with values that begin with a number.
std::vector<std::pair<std::string, double>> parameters_of(const std::string& text) {
  std::vector<std::pair<std::string, double>> all;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t at = word.find('=');
    if (at == std::string::npos) continue;
    const char* const begin = word.c_str() + at + 1;
    char* end = nullptr;
    const double value = std::strtod(begin, &end);
    if (end != begin && std::isfinite(value)) all.emplace_back(word.substr(0, at), value);
  }
  return all;
}

struct ResponseColumn {
  std::string name, unit;
  bool operator<(const ResponseColumn& other) const { return name < other.name; }
};

double scalar(const JournalRun& run, const std::string& name) {
  for (const Response& r : run.result.responses)
    if (r.name == name && r.value.size() == 1) return r.value[0];
  return std::numeric_limits<double>::quiet_NaN();
}

using FittedTarget = BatchKnowledge::FittedTarget;

std::vector<FittedTarget> targets_of(const BatchState& state) {
  return state.progress.knowledge ? state.progress.knowledge->targets : std::vector<FittedTarget>();
}

// Scalar responses that differ between runs: targets first, then in alphabetical order.
std::vector<ResponseColumn> varying_responses(const BatchState& state) {
  std::map<ResponseColumn, std::set<double>> values;
  for (const JournalRun& run : state.runs)
    for (const Response& r : run.result.responses)
      if (r.value.size() == 1 && std::isfinite(r.value[0]))
        values[{r.name, r.unit}].insert(r.value[0]);
  std::vector<ResponseColumn> names;
  for (const auto& [name, different] : values)
    if (different.size() > 1) names.push_back(name);
  const std::vector<FittedTarget> targets = targets_of(state);
  std::stable_partition(names.begin(), names.end(), [&](const ResponseColumn& r) {
    return std::ranges::find(targets, r.name, &FittedTarget::response) != targets.end();
  });
  return names;
}

void batch_summary(const BatchState& state, page::Page& page) {
  const std::string task = task_name(state.progress.command);
  const int ended = state.ended(), running = state.count("running");
  const int total = std::max(state.progress.most_runs, static_cast<int>(state.runs.size()));
  std::string line = fmt::format("{} of at most {} runs have ended", ended, total);
  if (const double left = state.time_left(); state.at_work && std::isfinite(left))
    line += fmt::format("; about {} left", estimated_duration_text(left));
  if (state.at_work)
    page.top().note({Mark::neutral, task + " is running"}, line + ".");
  else
    page.top().note({Mark::caution, task + " is not running"},
                    line + ". The same command continues from here.");
  std::vector<page::KeyFigure> cards = {{"ended", std::to_string(ended), "", {}},
                                        {"running", std::to_string(running), "", {}}};
  const int stopped = state.count("failed") + state.count("crashed");
  const int limited = state.count("timed out") + state.count("out of memory");
  cards.push_back(
      {"failed", std::to_string(stopped), "", {stopped > 0 ? Mark::bad : Mark::none, ""}});
  if (limited > 0)
    cards.push_back(
        {"beyond a limit", std::to_string(limited), "time or memory", {Mark::caution, ""}});
  if (const double wall = state.mean_wall(); std::isfinite(wall))
    cards.push_back({"mean time of a run", duration_text(wall), "", {}});
  page.top().key_figures(cards);
}

void estimate_section(const BatchState& state, page::Page& page) {
  if (!state.progress.knowledge || state.progress.knowledge->best.empty()) return;
  const BatchKnowledge& known = *state.progress.knowledge;
  page::Content& content = page.section("Best parameters so far", "best");
  page::Table table{
      "after the latest fit", {{"parameter", ""}, {"value", ""}, {"95 % interval", ""}}, {}};
  for (const auto& [name, p] : known.best)
    table.rows.push_back({page::words(name), number_text(p.value) + unit_suffix(p.unit),
                          range_text(p.low, p.high, 4) + unit_suffix(p.unit)});
  content.table(table);
  std::vector<std::string> determined;
  for (const BatchKnowledge::Determined& d : known.determined) determined.push_back(d.text());
  if (determined.empty())
    content.paragraph("No combination of parameters is determined yet.");
  else
    content.paragraph("Determined so far:").list(determined);
}

void plots_section(const BatchState& state, const std::vector<ResponseColumn>& responses,
                   page::Page& page) {
  // By parameter: its value in each run, NaN where the run has none.
  std::map<std::string, std::vector<double>> parameters;
  for (std::size_t i = 0; i < state.runs.size(); ++i)
    for (const auto& [name, value] : parameters_of(state.runs[i].label.parameters)) {
      std::vector<double>& values = parameters[name];
      values.resize(state.runs.size(), std::numeric_limits<double>::quiet_NaN());
      values[i] = value;
    }
  std::erase_if(parameters, [](const auto& parameter) {
    std::set<double> different;
    for (const double value : parameter.second)
      if (std::isfinite(value)) different.insert(value);
    return different.size() < 2;
  });
  std::vector<page::Figure> figures;
  for (const ResponseColumn& response : responses) {
    for (const auto& [parameter, values] : parameters) {
      if (figures.size() == kMostPointPlots) break;
      plots::Series points;
      points.style = plots::Style::points;
      for (std::size_t i = 0; i < state.runs.size(); ++i) {
        const double y = scalar(state.runs[i], response.name);
        if (!std::isfinite(y) || !std::isfinite(values[i])) continue;
        points.x.push_back(values[i]);
        points.y.push_back(y);
      }
      if (points.x.empty()) continue;
      plots::XyPlot plot;
      plot.x.label = page::words(parameter);
      plot.y.label = page::words(response.name);
      plot.y.unit = response.unit;
      const std::string what =
          fmt::format("{} over {}", page::words(response.name), page::words(parameter));
      for (const FittedTarget& target : targets_of(state))
        if (target.response == response.name) plot.horizontal.push_back({target.value, "measured"});
      plot.series = {std::move(points)};
      figures.push_back({plots::draw(plot), what + ", one point for each run.",
                         fmt::format("{}: {} runs", what, plot.series[0].x.size())});
    }
  }
  if (!figures.empty()) page.section("Responses over parameters", "responses").figures(figures);
}

void batch_runs_section(const BatchState& state, std::vector<ResponseColumn> responses,
                        page::Page& page) {
  if (responses.size() > kMostColumns) responses.resize(kMostColumns);
  page::Content& content = page.section("Runs");
  const std::size_t first = state.runs.size() - std::min(state.runs.size(), kMostRows);
  page::Table table{
      first > 0 ? fmt::format("the latest {} runs", kMostRows) : "in the order of planning",
      {{"phase", ""}, {"parameters", ""}, {"seed", ""}, {"status", ""}, {"time", "s"}},
      {}};
  for (const ResponseColumn& r : responses) table.columns.push_back({page::words(r.name), r.unit});
  for (std::size_t i = first; i < state.runs.size(); ++i) {
    const JournalRun& run = state.runs[i];
    std::string phase = run.label.phase;
    if (!run.label.experiment.empty()) phase = run.label.experiment + ", " + phase;
    std::vector<Cell> row = {
        phase, run.label.parameters, std::to_string(run.label.seed),
        run.result.reason.empty() ? run.status : run.status + ": " + run.result.reason,
        run.result.wall > 0 ? Cell(run.result.wall, 3) : Cell("")};
    for (const ResponseColumn& r : responses) {
      const double value = scalar(run, r.name);
      row.push_back(std::isfinite(value) ? Cell(value) : Cell(""));
    }
    table.rows.push_back(std::move(row));
  }
  content.table(table);
}

}  // namespace

page::Page batch_page(const BatchState& state, const std::string& name) {
  page::Page page(name, task_name(state.progress.command) + " in progress");
  const std::vector<ResponseColumn> responses = varying_responses(state);
  batch_summary(state, page);
  estimate_section(state, page);
  plots_section(state, responses, page);
  batch_runs_section(state, responses, page);
  return page;
}

}  // namespace firn
