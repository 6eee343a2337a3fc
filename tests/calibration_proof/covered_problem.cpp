#include "tests/calibration_proof/covered_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/analysis/random_stream.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "tests/calibration_proof/problems.h"

namespace firn::proof {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;
using Values = std::vector<double>;

void read_problem_parameters(const TomlTable& t, CoveredProblem& p) {
  for (const TomlTable& q : t.tables("parameters")) {
    q.allow({"name", "min", "max", "scale"});
    Parameter a;
    a.name = q.string("name");
    a.min = q.number("min");
    a.max = q.number("max");
    a.logarithmic = q.choice("scale", {"linear", "log"}, "linear") == "log";
    p.parameters.push_back(a);
    p.definition +=
        fmt::format("{}: {} to {}{}; ", a.name, a.min, a.max, a.logarithmic ? ", log" : "");
  }
}

void read_problem_responses(const TomlTable& t, CoveredProblem& p) {
  std::vector<std::string> names;
  for (const Parameter& a : p.parameters) names.push_back(a.name);
  for (const TomlTable& q : t.tables("responses")) {
    q.allow({"name", "value", "uncertainty", "noise", "shift", "shift_share", "low_fidelity_bias"});
    const std::string none = "0";
    CoveredResponse r;
    r.name = q.string("name");
    r.uncertainty = q.number("uncertainty");
    p.definition += fmt::format("{}: uncertainty {}; ", r.name, r.uncertainty);
    const auto formula = [&](const char* key, const std::string& text) {
      if (text != none) p.definition += fmt::format("{} = {}; ", key, text);
      return q.at(key, [&] { return parse_formula(text, names); });
    };
    r.value = formula("value", q.string("value"));
    r.noise = formula("noise", q.string("noise", none));
    r.shift = formula("shift", q.string("shift", none));
    r.shift_share = formula("shift_share", q.string("shift_share", none));
    r.low_fidelity_bias = formula("low_fidelity_bias", q.string("low_fidelity_bias", none));
    p.responses.push_back(r);
  }
}

CoveredProblem read_covered_problem(const TomlTable& t) {
  t.allow({"name", "truths", "parameters", "responses", "low_fidelity_cost"});
  CoveredProblem p;
  p.name = t.string("name");
  p.truths = t.strings("truths");
  if (p.truths.empty()) p.truths = {"prior"};
  for (const std::string& truth : p.truths)
    if (truth != "prior" && truth != "border" && truth != "corner")
      t.fail("truths", "has another word; expected some of prior, border, corner");
  p.low_fidelity_cost = t.number("low_fidelity_cost", 0);
  if (p.low_fidelity_cost > 0)
    p.definition += fmt::format("low_fidelity_cost {}; ", p.low_fidelity_cost);
  read_problem_parameters(t, p);
  read_problem_responses(t, p);
  if (p.parameters.empty() || p.responses.empty())
    t.fail("", "has no parameters or no responses; expected both");
  return p;
}

}  // namespace

double CoveredResponse::run(const Values& v, std::mt19937_64& random) const {
  const double scatter = noise(v) * normal_deviate(random);
  return value(v) + scatter + (uniform_open(random) < shift_share(v) ? shift(v) : 0);
}

std::vector<CoveredProblem> read_covered_problems(const std::string& file) {
  TomlDocument document(
      read_input_file(file, "a file of coverage problems (TOML)", input_limits::toml_bytes), file);
  const TomlTable root = TomlTable::root(document);
  root.allow({"problems"});
  std::vector<CoveredProblem> all;
  std::set<std::string> names;
  for (const TomlTable& t : root.tables("problems")) {
    all.push_back(read_covered_problem(t));
    if (!names.insert(all.back().name).second)
      t.fail("name", "is that of another problem, too; expected different names");
  }
  return all;
}

VectorXd draw_truth(const CoveredProblem& p, const std::string& where, std::mt19937_64& random) {
  VectorXd u(static_cast<Index>(p.parameters.size()));
  const auto end = [&] { return uniform_open(random) < 0.5 ? 0.0 : 1.0; };
  for (double& x : u) x = where == "corner" ? end() : uniform_open(random);
  if (where == "border")
    u[static_cast<Index>(random() % static_cast<std::uint64_t>(u.size()))] = end();
  return u;
}

Values values_at(const CoveredProblem& p, const VectorXd& u) {
  Values v;
  for (std::size_t i = 0; i < p.parameters.size(); ++i)
    v.push_back(std::clamp(p.parameters[i].from_unit(u[static_cast<Index>(i)]), p.parameters[i].min,
                           p.parameters[i].max));
  return v;
}

json solve_covered(const CoveredProblem& p, const Values& truth, const std::vector<double>& target,
                   int runs, int seed) {
  Problem plain;
  for (const Parameter& a : p.parameters) plain.parameters.push_back({a.min, a.max, a.logarithmic});
  plain.truth = truth;
  for (const CoveredResponse& r : p.responses)
    plain.responses.push_back({r.name, r.uncertainty, 0, {}});
  FakeExperiment experiment([&](const FakeExperiment::Values& keys, std::mt19937_64& random) {
    const Values v = plain.values(keys);
    std::vector<Response> all;
    const bool low = keys.contains("low_fidelity");
    for (const CoveredResponse& r : p.responses)
      all.push_back(scalar(r.name, r.run(v, random) + (low ? r.low_fidelity_bias(v) : 0), "1"));
    JobResult result = finished(all);
    if (low) result.wall = p.low_fidelity_cost;
    return result;
  });
  const Folder folder("coverage");
  std::string text = study_text(plain, target, runs, seed);
  if (p.low_fidelity_cost > 0) text += "\n[low_fidelity]\nset = { low_fidelity = 1 }\n";
  const std::string file = folder.write("study.toml", text);
  return json::parse(run_study(file, folder / "out", experiment).json);
}

}  // namespace firn::proof
