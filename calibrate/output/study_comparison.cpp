#include "calibrate/output/study_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>

#include "calibrate/inference/goodness_of_fit.h"
#include "calibrate/inference/posterior.h"
#include "calibrate/output/study_document.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/text/csv/csv_reader.h"
#include "experiments/text/vector_json.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

struct Column {
  std::string name, unit;
  bool logarithmic = false;
  double estimate = std::numeric_limits<double>::quiet_NaN();
  double low = 0, median = 0, high = 0;
  std::vector<double> values;
};

struct FinishedStudy {
  std::string name, verdict;
  std::vector<Column> columns;
  std::vector<double> weight;  // sums to 1
};

FinishedStudy read_finished(const std::string& folder) {
  const std::filesystem::path path(folder);
  const ResultsJson results = read_results_json(
      (path / "results.json").string(), "the results of a study (results.json in its folder)");
  const StudyDocument document = read_study_document(results);
  FinishedStudy s;
  s.name = document.study;
  s.verdict = document.verdict;
  const std::string file = (path / "posterior.csv").string();
  const std::vector<CsvRow> rows = read_csv_table(file);
  const auto read_column = [&](const std::string& heading) {
    const auto& header = rows.front().fields;
    const auto found = std::find(header.begin(), header.end(), heading);
    if (found == header.end())
      throw InputError(fmt::format("{}:1: has no column \"{}\"; expected the samples of the study",
                                   file, heading));
    const CsvColumn column{heading, static_cast<std::size_t>(found - header.begin()), 1};
    std::vector<double> values;
    for (std::size_t i = 1; i < rows.size(); ++i)
      values.push_back(csv_number(file, rows[i], column));
    return values;
  };
  for (const StudyDocument::Parameter& p : document.parameters) {
    if (!p.median || !p.interval_95)
      throw InputError(fmt::format(
          "{}: parameters: \"{}\" has no median and no interval_95; expected a study with a "
          "posterior",
          results.file, p.name));
    Column c;
    c.name = p.name;
    c.unit = p.unit;
    c.logarithmic = p.logarithmic();
    c.values = read_column(c.unit == "1" ? c.name : c.name + " / " + c.unit);
    c.median = *p.median;
    std::tie(c.low, c.high) = *p.interval_95;
    for (const double known : {c.median, c.low, c.high})
      if (!std::isfinite(known))
        throw InputError(fmt::format(
            "{}: parameters: \"{}\" has a median or an interval_95 without a number; expected "
            "numbers",
            results.file, p.name));
    if (document.estimate)
      if (const double* value = find_named(document.estimate->parameters, p.name))
        c.estimate = *value;
    s.columns.push_back(std::move(c));
  }
  s.weight = read_column("weight");
  double sum = 0;
  for (const double w : s.weight) sum += w;
  if (!(sum > 0) || *std::min_element(s.weight.begin(), s.weight.end()) < 0)
    throw InputError(fmt::format(
        "{}: has a weight below 0, or none above; expected weights of at least 0", file));
  for (double& w : s.weight) w /= sum;
  return s;
}

// The integral of the smaller density: histograms over what both cover, as fine as a twentieth of
// the narrower middle half.
double overlap_of(const Column& a, const std::vector<double>& wa, const Column& b,
                  const std::vector<double>& wb) {
  const auto quantile = [](const Column& c, const std::vector<double>& w, double q) {
    return weighted_quantile(c.values, w, q);
  };
  const auto width = [&](const Column& c, const std::vector<double>& w) {
    return quantile(c, w, 0.75) - quantile(c, w, 0.25);
  };
  const double low =
      std::min(*std::ranges::min_element(a.values), *std::ranges::min_element(b.values));
  const double high =
      std::max(*std::ranges::max_element(a.values), *std::ranges::max_element(b.values));
  if (!(high > low)) return 1;
  constexpr double most_cells = 2000;
  const double narrow = std::min(width(a, wa), width(b, wb)) / 5;
  const auto cells = static_cast<std::size_t>(std::clamp((high - low) / narrow, 1.0, most_cells));
  std::vector<double> ha(cells, 0), hb(cells, 0);
  const auto fill = [&](const Column& c, const std::vector<double>& w, std::vector<double>& h) {
    for (std::size_t s = 0; s < w.size(); ++s) {
      const double at = (c.values[s] - low) / (high - low) * static_cast<double>(cells);
      h[std::min(cells - 1, static_cast<std::size_t>(at))] += w[s];
    }
  };
  fill(a, wa, ha);
  fill(b, wb, hb);
  double sum = 0;
  for (std::size_t i = 0; i < cells; ++i) sum += std::min(ha[i], hb[i]);
  return sum;
}

// Probability that a value of the first exceeds one of the second.
double above(const Column& a, const std::vector<double>& wa, const Column& b,
             const std::vector<double>& wb) {
  std::vector<std::pair<double, double>> order;
  for (std::size_t s = 0; s < wb.size(); ++s) order.emplace_back(b.values[s], wb[s]);
  std::ranges::sort(order);
  std::vector<double> below = {0};
  for (const auto& [value, w] : order) below.push_back(below.back() + w);
  double sum = 0;
  for (std::size_t s = 0; s < wa.size(); ++s) {
    const auto first =
        std::ranges::lower_bound(order, a.values[s], {}, &std::pair<double, double>::first);
    sum += wa[s] * below[static_cast<std::size_t>(first - order.begin())];
  }
  return sum;
}

// Mean and covariance of some columns, logarithms where both studies vary the logarithm.
void moments(const std::vector<const Column*>& columns, const std::vector<bool>& logarithms,
             const std::vector<double>& weight, VectorXd& mean, MatrixXd& covariance) {
  const auto d = static_cast<Index>(columns.size()), n = static_cast<Index>(weight.size());
  MatrixXd x(n, d);
  for (Index i = 0; i < d; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (Index s = 0; s < n; ++s) {
      const double value = columns[k]->values[static_cast<std::size_t>(s)];
      x(s, i) = logarithms[k] ? std::log(value) : value;
    }
  }
  const Eigen::Map<const VectorXd> w(weight.data(), n);
  mean = x.transpose() * w;
  const MatrixXd off = x.rowwise() - mean.transpose();
  covariance = off.transpose() * w.asDiagonal() * off;
}

}  // namespace

StudyComparison compare_studies(const std::string& folder_a, const std::string& folder_b) {
  const FinishedStudy a = read_finished(folder_a), b = read_finished(folder_b);
  StudyComparison c{a.name, b.name, a.verdict, b.verdict, {}, 0, 0, {}, {}};
  std::vector<const Column*> of_a, of_b;
  std::vector<bool> logarithms;
  const auto find = [](const FinishedStudy& s, const Column& wanted) -> const Column* {
    for (const Column& column : s.columns)
      if (column.name == wanted.name && column.unit == wanted.unit) return &column;
    return nullptr;
  };
  for (const Column& x : a.columns) {
    const Column* y = find(b, x);
    if (y == nullptr) {
      c.only_a.push_back(x.name);
      continue;
    }
    of_a.push_back(&x);
    of_b.push_back(y);
    const auto positive = [](const Column& k) { return *std::ranges::min_element(k.values) > 0; };
    logarithms.push_back(x.logarithmic && y->logarithmic && positive(x) && positive(*y));
    c.parameters.push_back({x.name,
                            x.unit,
                            {x.estimate, x.low, x.median, x.high},
                            {y->estimate, y->low, y->median, y->high},
                            overlap_of(x, a.weight, *y, b.weight),
                            above(x, a.weight, *y, b.weight)});
  }
  for (const Column& y : b.columns)
    if (find(a, y) == nullptr) c.only_b.push_back(y.name);
  if (of_a.empty())
    throw InputError(
        fmt::format("{} and {} have no parameter of the same name and unit; expected "
                    "studies of the same parameters",
                    folder_a, folder_b));
  VectorXd mean_a, mean_b;
  MatrixXd covariance_a, covariance_b;
  moments(of_a, logarithms, a.weight, mean_a, covariance_a);
  moments(of_b, logarithms, b.weight, mean_b, covariance_b);
  const VectorXd off = mean_a - mean_b;
  c.chi_square = off.dot((covariance_a + covariance_b).ldlt().solve(off));
  c.probability = chi_square_tail(c.chi_square, static_cast<double>(off.size()));
  return c;
}

std::string comparison_table(const StudyComparison& c) {
  std::string out =
      fmt::format("A: {}: {}\nB: {}: {}\n\n", c.study_a, c.verdict_a, c.study_b, c.verdict_b);
  out += fmt::format("{:<24}{:>12}{:>24}{:>12}{:>24}{:>10}{:>12}\n", "parameter", "answer A",
                     "95 % of A", "answer B", "95 % of B", "overlap", "A above B");
  const auto estimate = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.4g}", x) : std::string("-");
  };
  for (const ParameterComparison& p : c.parameters) {
    const auto interval = [](const ParameterComparison::Side& s) {
      return fmt::format("{:.4g} to {:.4g}", s.low, s.high);
    };
    out += fmt::format("{:<24}{:>12}{:>24}{:>12}{:>24}{:>10}{:>12}\n",
                       p.unit == "1" ? p.name : fmt::format("{} / {}", p.name, p.unit),
                       estimate(p.a.estimate), interval(p.a), estimate(p.b.estimate), interval(p.b),
                       fmt::format("{:.0f} %", 100 * p.overlap),
                       fmt::format("{:.0f} %", 100 * p.a_above_b));
  }
  out += fmt::format(
      "\nThe means differ by a chi-square of {:.1f} on {} degrees of freedom; two estimates of the "
      "same truth differ by more with probability {:.2g}\n",
      c.chi_square, c.parameters.size(), c.probability);
  if (!c.only_a.empty()) out += fmt::format("of A alone: {}\n", fmt::join(c.only_a, ", "));
  if (!c.only_b.empty()) out += fmt::format("of B alone: {}\n", fmt::join(c.only_b, ", "));
  return out;
}

std::string comparison_json(const StudyComparison& c) {
  ordered_json j = {{"a", {{"study", c.study_a}, {"verdict", c.verdict_a}}},
                    {"b", {{"study", c.study_b}, {"verdict", c.verdict_b}}},
                    {"parameters", ordered_json::array()},
                    {"chi_square", number_json(c.chi_square)},
                    {"degrees_of_freedom", c.parameters.size()},
                    {"probability", number_json(c.probability)},
                    {"only_a", c.only_a},
                    {"only_b", c.only_b}};
  const auto side = [](const ParameterComparison::Side& s) {
    return ordered_json{{"estimate", number_json(s.estimate)},
                        {"interval_95", {s.low, s.high}},
                        {"median", s.median}};
  };
  for (const ParameterComparison& p : c.parameters)
    j["parameters"].push_back({{"name", p.name},
                               {"unit", p.unit},
                               {"a", side(p.a)},
                               {"b", side(p.b)},
                               {"overlap", p.overlap},
                               {"probability_a_above_b", p.a_above_b}});
  return j.dump(2);
}

}  // namespace firn
