#include "reports/documents/sweep_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "experiments/batch/sweep/sweep_document.h"
#include "experiments/storage/version.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/math.h"
#include "reports/html/results_page.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

using page::Badge;
using page::Cell;
using page::Mark;
using page::words;

constexpr std::size_t kMostPlots = 48;  // of a page
constexpr std::size_t kMostSeries = 6;  // curves of a plot
constexpr std::size_t kOpenPlots = 12;  // before the fold

struct Varied {
  std::string name;
  std::vector<std::string> values;  // different ones, in order of the sweep
  std::string unit;                 // of `numbers`
  std::vector<double> numbers;      // of `values`; empty where one of them is no number
};

struct Responded {
  std::string name, unit;
  std::vector<double> mean, deviation;  // by combination; NaN: undefined
};

struct SweepData {
  std::vector<Varied> keys;
  std::vector<std::vector<std::size_t>> value;  // [combination][key]: index into its values
  std::vector<Responded> responses;
};

// "0.03 GPa" as 0.03 and "GPa".
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  std::string unit = text.substr(static_cast<std::size_t>(end - text.data()));
  unit.erase(0, unit.find_first_not_of(' '));
  try {
    if (!unit.empty()) parse_unit(unit);
  } catch (const InputError&) {
    return std::nullopt;  // a vector, a file
  }
  return std::pair(value, unit);
}

// Only where all are numbers of one unit.
void find_numbers(Varied& key) {
  std::vector<std::pair<double, std::string>> all;
  for (const std::string& value : key.values) {
    const auto parsed = number_and_unit(value);
    if (!parsed) return;
    all.push_back(*parsed);
  }
  const bool one_unit =
      std::ranges::all_of(all, [&](const auto& v) { return v.second == all.front().second; });
  if (!one_unit) return;
  key.unit = all.front().second;
  for (const auto& [value, unit] : all) key.numbers.push_back(value);
}

template <class T>
const T& in_combination(const NamedValues<T>& values, const std::string& name) {
  const T* found = find_named(values, name);
  if (found == nullptr) throw BadValue(fmt::format("a combination has no \"{}\"", name));
  return *found;
}

SweepData data_of(const SweepDocument& results) {
  SweepData data;
  if (results.combinations.empty()) throw BadValue("it has no \"combinations\"");
  for (const auto& [name, value] : results.combinations.front().values)
    data.keys.push_back({name, {}, "", {}});
  for (const SweepDocument::NamedResponse& r : results.responses)
    data.responses.push_back({r.name, r.unit, {}, {}});
  for (const SweepDocument::Combination& row : results.combinations) {
    std::vector<std::size_t>& chosen = data.value.emplace_back();
    for (Varied& key : data.keys) {
      const std::string& value = in_combination(row.values, key.name);
      auto found = std::ranges::find(key.values, value);
      if (found == key.values.end()) found = key.values.insert(found, value);
      chosen.push_back(static_cast<std::size_t>(found - key.values.begin()));
    }
    for (Responded& r : data.responses) {
      const SweepDocument::Scatter& of = in_combination(row.responses, r.name);
      r.mean.push_back(of.mean);
      r.deviation.push_back(of.standard_deviation);
    }
  }
  for (Varied& key : data.keys) find_numbers(key);
  return data;
}

// Values of all keys but one: "friction 0.1, speed 2 m/s".
std::string others(const SweepData& data, std::size_t combination, std::size_t but) {
  std::string text;
  for (std::size_t k = 0; k < data.keys.size(); ++k)
    if (k != but)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", words(data.keys[k].name),
                          data.keys[k].values[data.value[combination][k]]);
  return text;
}

bool wide(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return low > 0 && high / low >= 20;
}

std::string range_of(const Responded& r) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double v : r.mean)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  return range_text(low, high, 4);
}

// By x; without errors where none is known.
plots::Series sorted(const plots::Series& s) {
  std::vector<std::size_t> order(s.x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return s.x[i]; });
  plots::Series result;
  for (const std::size_t i : order) {
    result.x.push_back(s.x[i]);
    result.y.push_back(s.y[i]);
    result.y_error.push_back(s.y_error[i]);
  }
  if (std::ranges::none_of(result.y_error, [](double e) { return std::isfinite(e); }))
    result.y_error.clear();
  return result;
}

// One curve for each choice of the other keys; where these are many, points for all of them.
page::Figure curves(const SweepData& data, std::size_t k, const Responded& r) {
  const Varied& key = data.keys[k];
  std::map<std::string, plots::Series> series;
  for (std::size_t c = 0; c < data.value.size(); ++c) {
    plots::Series& s = series[others(data, c, k)];
    s.x.push_back(key.numbers[data.value[c][k]]);
    s.y.push_back(r.mean[c]);
    s.y_error.push_back(r.deviation[c]);
  }
  plots::XyPlot plot;
  plot.x = {words(key.name), key.unit, wide(key.numbers), {}, {}};
  plot.y = {words(r.name), unit_text(r.unit), false, {}, {}};
  const bool many = series.size() > kMostSeries;
  for (auto& [name, s] : series) {
    s = sorted(s);
    s.name = name;
    s.style = plots::Style::joined;
    if (!many) {
      plot.series.push_back(s);
      continue;
    }
    if (plot.series.empty()) plot.series.push_back({"", {}, {}, plots::Style::points});
    plots::Series& all = plot.series.front();
    all.x.insert(all.x.end(), s.x.begin(), s.x.end());
    all.y.insert(all.y.end(), s.y.begin(), s.y.end());
  }
  return {plots::draw(plot), fmt::format("{} over {}.", words(r.name), words(key.name)),
          fmt::format("{} over {}: {}", words(r.name), words(key.name), range_of(r))};
}

// Over values that are no numbers: the mean over all other keys.
page::Figure bars(const SweepData& data, std::size_t k, const Responded& r) {
  const Varied& key = data.keys[k];
  plots::BarSeries series{"mean", {}, {}};
  for (std::size_t v = 0; v < key.values.size(); ++v) {
    double sum = 0, squares = 0;
    int count = 0, scattered = 0;
    for (std::size_t c = 0; c < data.value.size(); ++c) {
      if (data.value[c][k] != v || !std::isfinite(r.mean[c])) continue;
      sum += r.mean[c];
      ++count;
      if (!std::isfinite(r.deviation[c])) continue;
      squares += r.deviation[c] * r.deviation[c];
      ++scattered;
    }
    series.values.push_back(count > 0 ? sum / count : std::nan(""));
    series.errors.push_back(scattered > 0 ? std::sqrt(squares / scattered) : std::nan(""));
  }
  plots::BarPlot plot;
  plot.y = {words(r.name), unit_text(r.unit), false, {}, {}};
  plot.categories = key.values;
  plot.x_label = words(key.name);
  plot.series = {series};
  return {plots::draw(plot),
          fmt::format("{} by {}, mean over everything else.", words(r.name), words(key.name)),
          fmt::format("{} by {}: {}", words(r.name), words(key.name), range_of(r))};
}

bool changes(const Responded& r) {
  std::optional<double> first;
  for (const double v : r.mean) {
    if (!std::isfinite(v)) continue;
    if (first && v != *first) return true;
    first = v;
  }
  return false;
}

void response_plots(const SweepData& data, page::Page& page) {
  if (data.keys.empty()) return;
  std::vector<page::Figure> figures;
  std::string constant, missing;
  std::size_t left_out = 0;
  for (const Responded& r : data.responses) {
    if (!changes(r)) {
      const bool known = std::ranges::any_of(r.mean, [](double v) { return std::isfinite(v); });
      std::string& list = known ? constant : missing;
      list += (list.empty() ? "" : ", ") + words(r.name);
      continue;
    }
    for (std::size_t k = 0; k < data.keys.size(); ++k) {
      if (data.keys[k].values.size() < 2) continue;
      if (figures.size() == kMostPlots)
        ++left_out;
      else
        figures.push_back(data.keys[k].numbers.empty() ? bars(data, k, r) : curves(data, k, r));
    }
  }
  page::Content& content = page.section("Responses over the keys", "plots");
  const auto middle =
      figures.begin() + static_cast<std::ptrdiff_t>(std::min(figures.size(), kOpenPlots));
  if (!figures.empty())
    content.paragraph("Means over the seeds; error bars are one standard deviation of single runs.")
        .figures({figures.begin(), middle});
  if (middle != figures.end()) {
    page::Content more;
    more.figures({middle, figures.end()});
    content.collapsible(fmt::format("{} more plots", figures.end() - middle), more);
  }
  if (left_out > 0)
    content.paragraph(fmt::format(
        "{} more plots are left out: name the `responses` of the sweep to choose.", left_out));
  if (!constant.empty()) content.paragraph("The same in all combinations: " + constant + ".");
  if (!missing.empty())
    content.paragraph("Without a value, since no run came to what it measures: " + missing + ".");
}

void table_section(const SweepDocument& results, const SweepData& data, page::Page& page) {
  page::Table table;
  table.caption = "Means over the seeds; ± is one standard deviation of single runs";
  for (const Varied& key : data.keys)
    table.columns.push_back({words(key.name), key.numbers.empty() ? "" : key.unit});
  table.columns.push_back({"finished", ""});
  for (const Responded& r : data.responses) table.columns.push_back({words(r.name), r.unit});
  std::vector<std::pair<int, int>> finished(data.value.size());
  for (const SweepDocument::Run& run : results.runs) {
    if (run.combination >= finished.size())
      throw BadValue("a run of a combination that the sweep has not");
    ++finished[run.combination].second;
    finished[run.combination].first += run.status == "finished" ? 1 : 0;
  }
  for (std::size_t c = 0; c < data.value.size(); ++c) {
    std::vector<Cell>& row = table.rows.emplace_back();
    for (std::size_t k = 0; k < data.keys.size(); ++k) {
      const Varied& key = data.keys[k];
      const std::size_t v = data.value[c][k];
      row.push_back(key.numbers.empty() ? Cell(key.values[v]) : Cell(key.numbers[v], 9));
    }
    row.emplace_back(fmt::format("{} of {}", finished[c].first, finished[c].second));
    for (const Responded& r : data.responses)
      row.push_back(Cell::measured(r.mean[c], r.deviation[c], r.unit));
  }
  page.section("All combinations", "combinations").table(table);
}

void powers_section(const SweepDocument& results, page::Page& page) {
  if (results.powers.empty()) return;
  page::Table table;
  table.caption = "Each response as a power of the key; ± is one standard error";
  table.columns = {{"response", ""}, {"exponent", ""}};
  for (const auto& [response, law] : results.powers)
    table.rows.push_back({words(response), Cell::measured(law.exponent, law.standard_error)});
  page.section("Power laws", "powers").table(table);
}

// A factor with the unit of its values.
std::string factor_text(const SweepData& data, const std::string& factor) {
  const auto key = std::ranges::find(data.keys, factor, &Varied::name);
  return axis_label(words(factor), key == data.keys.end() ? "" : key->unit);
}

// A response over its factors; the noise where it is known.
page::Figure effects_plot(const std::string& response, const std::string& unit,
                          const NamedValues<SweepDocument::Effect>& effects,
                          const SweepData& data) {
  plots::IntervalPlot plot;
  plot.x = {"mean absolute effect on " + words(response), unit_text(unit), false, 0.0, {}};
  plot.names = {"95 % interval"};
  double noise = std::nan("");
  for (const auto& [factor, e] : effects) {
    plots::IntervalRow& row =
        plot.rows.emplace_back(plots::IntervalRow{factor_text(data, factor), {}});
    const bool known = std::isfinite(e.interval_95.first) && std::isfinite(e.interval_95.second);
    const auto [low, high] = known ? e.interval_95 : std::pair(e.mean_absolute, e.mean_absolute);
    row.intervals.push_back(std::isfinite(e.mean_absolute)
                                ? std::optional(plots::Interval{low, high, e.mean_absolute})
                                : std::nullopt);
    noise = std::fmax(noise, e.noise);
  }
  if (std::isfinite(noise)) plot.vertical.push_back({noise, "noise"});
  const std::string first = effects.empty() ? "nothing" : words(effects.front().first);
  return {plots::draw(plot), fmt::format("Effects on {}.", words(response)),
          fmt::format("{} depends most on {}", words(response), first)};
}

void effects_section(const SweepDocument& results, const SweepData& data, page::Page& page) {
  if (results.effects.empty()) return;
  page::Content& content = page.section("Which factor matters", "effects");
  content.paragraph(
      "Elementary effects: changes of a response when one factor passes through its whole range, "
      "everything else being equal, at random places. The mean of their absolute values ranks the "
      "factors. A scatter of the order of the mean shows curvature, interactions with other "
      "factors, "
      "or noise. An effect below the noise may be none.");
  std::vector<page::Figure> figures;
  for (std::size_t i = 0; i < results.effects.size() && i < kOpenPlots; ++i) {
    const auto& [response, effects] = results.effects[i];
    const auto named =
        std::ranges::find(results.responses, response, &SweepDocument::NamedResponse::name);
    const bool drawn = std::ranges::any_of(
        effects, [](const auto& e) { return std::isfinite(e.second.mean_absolute); });
    if (drawn && effects.size() > 1)
      figures.push_back(effects_plot(response, named == results.responses.end() ? "" : named->unit,
                                     effects, data));
  }
  if (std::ranges::all_of(results.effects, [](const auto& e) { return e.second.size() == 1; }))
    content.paragraph("One factor is varied: there is none to compare it with.");
  if (!figures.empty()) content.figures(figures);
  for (const auto& [response, effects] : results.effects) {
    const bool has_noise =
        std::ranges::any_of(effects, [](const auto& e) { return std::isfinite(e.second.noise); });
    page::Table table;
    table.caption = "Effects on " + words(response);
    table.columns = {{"factor", ""}, {"mean absolute", ""},      {"95 % interval", ""},
                     {"mean", ""},   {"standard deviation", ""}, {"effects", ""}};
    if (has_noise) table.columns.push_back({"noise", ""});
    for (const auto& [factor, e] : effects) {
      const std::string interval = range_text(e.interval_95.first, e.interval_95.second, 4);
      std::vector<Cell>& row = table.rows.emplace_back(std::vector<Cell>{
          words(factor), Cell(e.mean_absolute),
          Cell(std::isfinite(e.interval_95.first) ? interval : std::string()), Cell(e.mean),
          Cell(e.standard_deviation), Cell(static_cast<double>(e.count), 9)});
      if (has_noise) row.emplace_back(e.noise);
    }
    content.table(table);
  }
}

void failures_section(const SweepDocument& results, page::Page& page) {
  page::Table table;
  table.caption = "Runs that did not finish";
  table.columns = {{"combination", ""}, {"seed", ""}, {"status", ""}, {"reason", ""}};
  for (const SweepDocument::Run& run : results.runs) {
    if (run.status == "finished") continue;
    std::string values;
    for (const auto& [name, value] : results.combinations.at(run.combination).values)
      values += fmt::format("{}{} {}", values.empty() ? "" : ", ", words(name), value);
    table.rows.push_back({values, Cell(static_cast<double>(run.seed), 9), run.status, run.reason});
  }
  if (!table.rows.empty()) page.section("Not finished", "failures").table(table);
}

page::Page page_of(const SweepDocument& results) {
  const SweepData data = data_of(results);
  page::Page page(results.name, fmt::format("sweep of {}", results.case_file));
  const auto all = static_cast<std::ptrdiff_t>(results.runs.size());
  const auto finished =
      std::ranges::count(results.runs, std::string("finished"), &SweepDocument::Run::status);
  const bool whole = finished == all;
  page.top().note(whole ? Badge{Mark::good, "finished"} : Badge{Mark::caution, "incomplete"},
                  fmt::format("{} of {} runs finished", finished, all));
  std::vector<page::Property> facts;
  for (const Varied& key : data.keys) {
    std::string values;
    for (const std::string& v : key.values) values += (values.empty() ? "" : ", ") + v;
    facts.push_back({words(key.name), values});
  }
  if (!facts.empty()) page.top().properties(facts);
  effects_section(results, data, page);
  if (results.effects.empty()) response_plots(data, page);
  powers_section(results, page);
  table_section(results, data, page);
  failures_section(results, page);
  page.set_footer(fmt::format("Made by Firn {}.", firn_version()));
  return page;
}

}  // namespace

page::Page sweep_page(const ResultsJson& results) {
  const SweepDocument document = read_sweep_document(results);
  return page_from(results.file, [&] { return page_of(document); });
}

}  // namespace firn
