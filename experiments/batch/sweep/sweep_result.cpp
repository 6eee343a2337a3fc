// Text, JSON and statistics of the results of a sweep.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/batch/sweep/sweep.h"
#include "experiments/batch/sweep/sweep_document.h"
#include "experiments/results/response.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

SweepDocument::Scatter scatter(const SweepResult& r, std::size_t combination,
                               std::size_t response) {
  std::vector<double> values;
  for (const SweepRun& run : r.runs)
    if (run.combination == combination && std::isfinite(run.values[response]))
      values.push_back(run.values[response]);
  const SampleStatistics s = sample_statistics(values);
  return {.mean = s.mean, .standard_deviation = s.deviation, .runs = s.count};
}

// Standard error of the mean of a combination: the scatter over seeds, pooled over all of them.
// NaN: no combination has two runs.
double pooled_standard_error(const SweepResult& r, std::size_t response) {
  double squares = 0, freedom = 0;
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    const SweepDocument::Scatter s = scatter(r, c, response);
    if (s.runs < 2) continue;
    squares += (s.runs - 1) * s.standard_deviation * s.standard_deviation;
    freedom += s.runs - 1;
  }
  return freedom > 0 ? std::sqrt(squares / freedom / static_cast<double>(r.sweep.seeds.size()))
                     : kUndefined;
}

// A value that is a number, with a unit or without, in SI.
std::optional<double> number(const std::string& value) {
  const std::string text = plain_value(value);
  double n = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (error != std::errc()) return std::nullopt;
  const std::string unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (unit.empty()) return n;
  try {
    return n * parse_unit(unit).factor;
  } catch (const InputError&) {
    return std::nullopt;  // a vector, a file
  }
}

}  // namespace

std::vector<SweptPower> powers(const SweepResult& r) {
  if (r.sweep.vary.size() != 1 || r.sweep.design == SweepDesign::morris) return {};
  std::vector<double> x;
  for (const std::string& value : r.sweep.vary.front().values)
    x.push_back(number(value).value_or(kUndefined));
  std::vector<SweptPower> all;
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    std::vector<double> mean, error;
    std::vector<int> runs;
    for (std::size_t c = 0; c < x.size(); ++c) {
      const SweepDocument::Scatter s = scatter(r, c, i);
      mean.push_back(s.mean);
      error.push_back(s.standard_deviation / std::sqrt(s.runs));
      runs.push_back(s.runs);
    }
    if (has_power_law(x, mean))
      all.push_back({r.responses[i], fit_power_law(x, mean, error, runs)});
  }
  return all;
}

std::vector<ScreenedResponse> screened_responses(const SweepResult& r) {
  std::vector<ScreenedResponse> all;
  if (r.sweep.design != SweepDesign::morris) return all;
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    std::vector<double> means;
    for (std::size_t c = 0; c < r.sweep.combinations(); ++c) means.push_back(scatter(r, c, i).mean);
    ScreenedResponse& one = all.emplace_back();
    one.response = r.responses[i];
    one.effects = elementary_effects(r.sweep.screening, means);
    const double error = pooled_standard_error(r, i);
    if (std::isfinite(error)) one.noise = noise_effects(r.sweep.screening, error);
  }
  return all;
}

namespace {

// The factors of a response, the most important ones first, those without an effect last.
std::vector<std::size_t> by_importance(const ScreenedResponse& s) {
  std::vector<std::size_t> order(s.effects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto importance = [&](std::size_t k) {
    const double mean = s.effects[k].mean_absolute;
    return std::isfinite(mean) ? mean : -1;
  };
  std::ranges::stable_sort(order, std::ranges::greater(), importance);
  return order;
}

std::string render_screening(const SweepResult& r) {
  std::string text;
  const std::vector<ScreenedResponse> screened = screened_responses(r);
  for (std::size_t i = 0; i < screened.size(); ++i) {
    const ScreenedResponse& s = screened[i];
    const std::string unit = i < r.units.size() && r.units[i] != "1" ? " " + r.units[i] : "";
    text += fmt::format("{}{}, change over the range of a factor:\n", s.response, unit);
    text += fmt::format("    {:<28} {:>10} {:>23} {:>10} {:>10}{}\n", "factor", "mean |e|",
                        "95 % interval", "mean", "sd", s.noise.empty() ? "" : "      noise");
    for (const std::size_t k : by_importance(s)) {
      const ElementaryEffects& e = s.effects[k];
      const auto text_of = [](double v) {
        return std::isfinite(v) ? fmt::format("{:.3g}", v) : std::string("-");
      };
      text += fmt::format("    {:<28} {:>10} {:>23} {:>10} {:>10}{}\n", r.sweep.vary[k].name,
                          text_of(e.mean_absolute),
                          fmt::format("{} to {}", text_of(e.lower), text_of(e.upper)),
                          text_of(e.mean), text_of(e.standard_deviation),
                          s.noise.empty() ? "" : fmt::format(" {:>10}", text_of(s.noise[k])));
    }
  }
  return text;
}

std::string render_combinations(const SweepResult& r) {
  std::string text;
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    const auto finished = std::ranges::count_if(r.runs, [&](const SweepRun& run) {
      return run.combination == c && run.result.status == JobStatus::finished;
    });
    text += fmt::format("{}: {} of {} runs finished\n",
                        r.sweep.vary.empty() ? r.sweep.name : r.sweep.label(c), finished,
                        r.sweep.seeds.size());
    for (std::size_t i = 0; i < r.responses.size(); ++i) {
      const SweepDocument::Scatter s = scatter(r, c, i);
      const std::string unit = i < r.units.size() && r.units[i] != "1" ? r.units[i] : "";
      text += fmt::format(
          "    {:<36} {:>12} {:<7} {}\n", r.responses[i],
          s.runs > 0 ? fmt::format("{:.4g}", s.mean) : "undefined", unit,
          s.runs > 1 ? fmt::format("sd {:.2g} over {} runs", s.standard_deviation, s.runs) : "");
    }
    for (const SweepRun& run : r.runs)
      if (run.combination == c && run.result.status != JobStatus::finished)
        text += fmt::format("    seed {} {}: {}\n", run.seed, to_string(run.result.status),
                            run.result.reason);
  }
  return text;
}

}  // namespace

std::string render_table(const SweepResult& r) {
  std::string text = render_combinations(r) + render_screening(r);
  const std::vector<SweptPower> laws = powers(r);
  if (!laws.empty()) text += fmt::format("as a power of {}:\n", r.sweep.vary.front().name);
  for (const auto& [response, law] : laws)
    text += fmt::format("    {:<36} {:>12.2f} {}\n", response, law.exponent,
                        std::isfinite(law.exponent_error)
                            ? fmt::format("± {:.2g}, one standard error", law.exponent_error)
                            : "(two values: how straight it is, is not known)");
  return text;
}

namespace {

SweepDocument document_of(const SweepResult& r) {
  SweepDocument d;
  d.name = r.sweep.name;
  d.case_file = r.sweep.case_file;
  for (std::size_t i = 0; i < r.responses.size(); ++i)
    d.responses.push_back({r.responses[i], i < r.units.size() ? r.units[i] : ""});
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    SweepDocument::Combination& row = d.combinations.emplace_back();
    const std::vector<std::string> labels = r.sweep.value_labels(c);
    for (std::size_t i = 0; i < labels.size(); ++i)
      row.values.emplace_back(r.sweep.vary[i].name, labels[i]);
    for (std::size_t i = 0; i < r.responses.size(); ++i)
      row.responses.emplace_back(r.responses[i], scatter(r, c, i));
  }
  for (const auto& [response, law] : powers(r))
    d.powers.push_back({response, {law.exponent, law.exponent_error}});
  for (const ScreenedResponse& s : screened_responses(r)) {
    NamedValues<SweepDocument::Effect> factors;
    for (const std::size_t k : by_importance(s)) {
      const ElementaryEffects& e = s.effects[k];
      factors.push_back(
          {r.sweep.vary[k].name,
           {e.mean_absolute, std::pair(e.lower, e.upper), e.mean, e.standard_deviation,
            s.noise.empty() ? kUndefined : s.noise[k], e.count}});
    }
    d.effects.push_back({s.response, std::move(factors)});
  }
  for (const SweepRun& run : r.runs)
    d.runs.push_back({run.combination, run.seed, run.key, to_string(run.result.status),
                      run.result.reason, run.result.wall, run.values, run.result.results_file});
  return d;
}

}  // namespace

std::string render_json(const SweepResult& r) { return json_text(document_of(r), 1); }

SweepDocument read_sweep_document(const ResultsJson& results) {
  return document_from_results<SweepDocument>(results, "sweep", "firn sweep");
}

}  // namespace firn
