#include "calibrate/inference/outliers.h"

#include <algorithm>
#include <cmath>

#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

constexpr double far = 40;               // robust standard deviations between seeds
constexpr double far_from_around = 20;   // of the differences to the nearest points
constexpr double to_deviation = 1.4826;  // median absolute deviation of a normal distribution
constexpr double many = 0.1;             // of all runs
constexpr std::size_t few = 2;           // that never are many
constexpr std::size_t neighbors = 5;
constexpr double rounding = 1e-6;  // of the spread of the response over the ranges

struct Place {
  std::size_t point;
  std::vector<double> values;
  double middle;
};

std::vector<Place> places_of(const ResponseId& response, const std::vector<Point>& points) {
  std::vector<Place> places;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::vector<double> values = points[p].finished(response);
    if (!values.empty()) places.push_back({p, values, median(values)});
  }
  return places;
}

// Robust standard deviation between seeds; 0 when no point has two.
double seed_deviation(const std::vector<Place>& places) {
  std::vector<double> differences, middles;
  for (const Place& p : places) {
    middles.push_back(p.middle);
    for (std::size_t i = 0; i < p.values.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        differences.push_back(std::abs(p.values[i] - p.values[j]) / std::sqrt(2));
  }
  if (differences.empty()) return 0;
  const double level = median(middles);
  for (double& m : middles) m = std::abs(m - level);
  return std::max(to_deviation * median(differences), rounding * median(middles));
}

std::vector<ResponseId> responses_of(const Study& study) {
  std::vector<ResponseId> all;
  for (const Target& t : study.targets) all.push_back(t.response);
  for (const Observed& o : study.observed) all.push_back(o.response);
  return all;
}

}  // namespace

std::vector<std::size_t> outlier_candidates(const Study& study, const std::vector<Point>& points,
                                            std::size_t most) {
  std::vector<std::pair<double, std::size_t>> suspects;  // how far, point
  for (const ResponseId& response : responses_of(study)) {
    const std::vector<Place> places = places_of(response, points);
    if (places.size() < 2 * neighbors) continue;
    const double seeds = seed_deviation(places);
    std::vector<double> from_around, sizes;
    for (const Place& p : places) {
      std::vector<std::pair<double, double>> others;  // distance, value
      for (const Place& q : places)
        if (&p != &q)
          others.emplace_back((points[p.point].u - points[q.point].u).squaredNorm(), q.middle);
      std::sort(others.begin(), others.end());
      std::vector<double> around;
      for (std::size_t i = 0; i < neighbors; ++i) around.push_back(others[i].second);
      from_around.push_back(p.middle - median(around));
      sizes.push_back(std::abs(from_around.back()));
    }
    const double around = std::max(to_deviation * median(sizes), seeds);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Place& p = places[i];
      if (points[p.point].seeds.size() >= 3) continue;
      double how_far = around > 0 ? std::abs(from_around[i]) / around / far_from_around : 0;
      if (p.values.size() == 2 && seeds > 0)
        how_far = std::max(how_far, std::abs(p.values[0] - p.values[1]) / seeds / far);
      if (how_far > 1) suspects.emplace_back(how_far, p.point);
    }
  }
  std::sort(suspects.rbegin(), suspects.rend());
  std::vector<std::size_t> chosen;
  for (const auto& [how_far, point] : suspects)
    if (chosen.size() < most && std::find(chosen.begin(), chosen.end(), point) == chosen.end())
      chosen.push_back(point);
  return chosen;
}

std::vector<OutlierRun> mark_outliers(const Study& study, std::vector<Point>& points) {
  for (Point& p : points) p.outliers.clear();
  std::vector<OutlierRun> all;
  for (const ResponseId& response : responses_of(study)) {
    const std::vector<Place> places = places_of(response, points);
    const double seeds = seed_deviation(places);
    std::vector<OutlierRun> found;
    std::size_t runs = 0;
    for (const Place& p : places) {
      runs += p.values.size();
      if (p.values.size() < 3) continue;
      for (std::size_t s = 0; s < points[p.point].seeds.size(); ++s) {
        const auto value = points[p.point].value(response, s);
        if (!value) continue;
        std::vector<double> others = p.values;
        others.erase(std::find(others.begin(), others.end(), *value));
        const double middle = median(others);
        for (double& o : others) o = std::abs(o - middle);
        const double scale = std::max(seeds, to_deviation * median(others));
        if (std::abs(*value - middle) > far * scale)
          found.push_back({response, p.point, s, *value, middle});
      }
    }
    if (found.size() > few && static_cast<double>(found.size()) > many * static_cast<double>(runs))
      continue;
    all.insert(all.end(), found.begin(), found.end());
  }
  for (const OutlierRun& o : all) points[o.point].outliers[o.response.label].insert(o.seed);
  return all;
}

}  // namespace firn
