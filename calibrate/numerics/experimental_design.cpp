#include "calibrate/numerics/experimental_design.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

using Eigen::VectorXd;

constexpr int trials = 2000;
constexpr double edge = 0.05;  // distance of the outermost levels from the faces

void shuffle(std::vector<std::size_t>& order, std::mt19937_64& random) {
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random_below_by_remainder(random, i)]);
}

std::size_t next_prime(std::size_t n) {
  for (std::size_t candidate = n + 1;; ++candidate) {
    bool prime = true;
    for (std::size_t divisor = 2; divisor * divisor <= candidate && prime; ++divisor)
      prime = candidate % divisor != 0;
    if (prime) return candidate;
  }
}

std::vector<VectorXd> latin_hypercube(int count, int dimensions, std::mt19937_64& random) {
  std::vector<VectorXd> points(static_cast<std::size_t>(count), VectorXd(dimensions));
  std::vector<std::size_t> order(points.size());
  for (int k = 0; k < dimensions; ++k) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    shuffle(order, random);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i][k] = count == 1 ? 0.5 : edge + (1 - 2 * edge) * double(order[i]) / (count - 1);
  }
  return points;
}

double smallest_distance(const std::vector<VectorXd>& points, const std::vector<VectorXd>& taken) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      smallest = std::min(smallest, (points[i] - points[j]).squaredNorm());
    for (const VectorXd& t : taken) smallest = std::min(smallest, (points[i] - t).squaredNorm());
  }
  return smallest;
}

}  // namespace

std::vector<VectorXd> maximin_latin_hypercube(int count, int dimensions, std::uint64_t seed,
                                              const std::vector<VectorXd>& taken) {
  std::mt19937_64 random(seed);
  std::vector<VectorXd> best;
  double best_distance = -1;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<VectorXd> points = latin_hypercube(count, dimensions, random);
    const double distance = smallest_distance(points, taken);
    if (distance > best_distance) {
      best_distance = distance;
      best = std::move(points);
    }
  }
  return best;
}

VectorXd quasi_random_point(std::uint64_t i, int dimensions) {
  double ratio = 2;  // the positive root of x^(d + 1) = x + 1
  for (int n = 0; n < 60; ++n) ratio = std::pow(1 + ratio, 1.0 / (dimensions + 1));
  VectorXd u(dimensions);
  double step = 1;
  for (int k = 0; k < dimensions; ++k) {
    step /= ratio;
    const double x = 0.5 + step * static_cast<double>(i + 1);
    u[k] = x - std::floor(x);
  }
  return u;
}

Eigen::MatrixXd randomized_halton(int count, int dimensions, std::mt19937_64& random) {
  constexpr double resolution = 0x1p-50;
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(count, dimensions);
  std::size_t base = 1;
  for (int k = 0; k < dimensions; ++k) {
    base = next_prime(base);
    std::vector<std::size_t> rest(static_cast<std::size_t>(count)), digit(base);
    std::iota(rest.begin(), rest.end(), std::size_t{0});
    std::iota(digit.begin(), digit.end(), std::size_t{0});
    for (double place = 1.0 / double(base); place > resolution; place /= double(base)) {
      shuffle(digit, random);
      for (std::size_t i = 0; i < rest.size(); ++i) {
        points(static_cast<Eigen::Index>(i), k) += place * double(digit[rest[i] % base]);
        rest[i] /= base;
      }
    }
  }
  return points;
}

}  // namespace firn
