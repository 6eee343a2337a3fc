#include "tests/calibration_proof/problems.h"

#include <fmt/format.h>

namespace firn::proof {
namespace {

double heap(double mu1, double mu2) { return 35 * std::pow(mu1, 0.27) * std::pow(mu2, 0.22); }
double flow(double mu1, double mu2) {
  return 40 * std::pow(mu1 / 0.06, -0.2) * std::pow(mu2 / 0.15, -0.4);
}

JobStatus gaps(const std::vector<double>& mu, double luck) {
  if (std::log(mu[0] / 0.025) < 0.3 * luck) return JobStatus::failed;
  if (std::log(mu[1] / 0.25) > 0.2 * luck) return JobStatus::arched;
  return JobStatus::finished;
}

double forrester(double x) { return std::pow(6 * x - 2, 2) * std::sin(12 * x - 4); }

double branin(double x, double y) {
  constexpr double b = 5.1 / (4 * M_PI * M_PI), c = 5 / M_PI, t = 1 / (8 * M_PI);
  return std::pow(y - b * x * x + c * x - 6, 2) + 10 * (1 - t) * std::cos(x) + 10;
}

double hartmann3(const std::vector<double>& x) {
  constexpr double alpha[] = {1.0, 1.2, 3.0, 3.2};
  constexpr double a[4][3] = {{3, 10, 30}, {0.1, 10, 35}, {3, 10, 30}, {0.1, 10, 35}};
  constexpr double p[4][3] = {{0.3689, 0.1170, 0.2673},
                              {0.4699, 0.4387, 0.7470},
                              {0.1091, 0.8732, 0.5547},
                              {0.0381, 0.5743, 0.8828}};
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    double inner = 0;
    for (std::size_t j = 0; j < 3; ++j) inner += a[i][j] * (x[j] - p[i][j]) * (x[j] - p[i][j]);
    sum -= alpha[i] * std::exp(-inner);
  }
  return sum;
}

}  // namespace

std::vector<Problem> reference_problems() {
  using P = std::vector<double>;
  const Problem::Range mu1{0.01, 0.3, true}, mu2{0.03, 0.5, true}, unit{0, 1, false};
  const ProofResponse angle{"angle", 0.5, 0.8, [](const P& p) { return heap(p[0], p[1]); }};
  const ProofResponse rate{"rate", 1, 0.8, [](const P& p) { return flow(p[0], p[1]); }};
  const ProofResponse rebound{"rebound", 2, 1.5, [](const P& p) {
                                return 100 * p[2] * p[2] * (1 + 0.1 * std::log(p[1] / 0.15));
                              }};
  return {
      {"heap, two frictions", {mu1, mu2}, {0.05, 0.12}, {angle}},
      {"heap and flow, two frictions", {mu1, mu2}, {0.06, 0.15}, {angle, rate}},
      {"heap, flow and rebound",
       {mu1, mu2, {0.05, 0.8, false}},
       {0.06, 0.15, 0.35},
       {angle, rate, rebound}},
      {"heap with gaps", {mu1, mu2}, {0.03, 0.2}, {angle}, gaps},
      {"Forrester", {unit}, {0.88}, {{"f", 0.5, 0.5, [](const P& p) { return forrester(p[0]); }}}},
      {"Branin",
       {{-5, 10, false}, {0, 15, false}},
       {2, 9},
       {{"f", 4, 2, [](const P& p) { return branin(p[0], p[1]); }}}},
      {"Hartmann",
       {unit, unit, unit},
       {0.3, 0.7, 0.6},
       {{"f", 0.1, 0.05, [](const P& p) { return hartmann3(p); }}}},
  };
}

std::string study_text(const Problem& problem, const std::vector<double>& target, int runs,
                       int seed, const std::string& more) {
  std::string text = fmt::format(
      "[study]\nname = \"proof\"\ncase = \"case.toml\"\nseed = {}\n[budget]\nruns = {}\n"
      "compare_replicates = 0\n",
      seed, runs);
  std::string truth;
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const Problem::Range& r = problem.parameters[i];
    text += fmt::format(
        "[[parameters]]\nname = \"p{0}\"\nkeys = [\"p{0}\"]\nmin = {1}\nmax = {2}\nscale = "
        "\"{3}\"\n",
        i, r.min, r.max, r.logarithmic ? "log" : "linear");
    truth += fmt::format("{}p{} = {}", i == 0 ? "" : ", ", i, problem.truth[i]);
  }
  for (std::size_t k = 0; k < target.size(); ++k)
    text += fmt::format("[[targets]]\nresponse = \"{}\"\nvalue = {}\nuncertainty = {}\n",
                        problem.responses[k].name, target[k], problem.responses[k].uncertainty);
  return text + "[[compare]]\nname = \"truth\"\nvalues = { " + truth + " }\n" + more;
}

}  // namespace firn::proof
