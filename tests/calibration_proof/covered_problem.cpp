#include "tests/calibration_proof/covered_problem.h"

#include <algorithm>
#include <cmath>

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
  std::vector<std::string> names;
  for (const TomlTable& q : t.tables("parameters")) {
    q.allow({"name", "min", "max", "scale"});
    Parameter a;
    a.name = q.string("name");
    a.min = q.number("min");
    a.max = q.number("max");
    a.logarithmic = q.choice("scale", {"linear", "log"}, "linear") == "log";
    names.push_back(a.name);
    p.parameters.push_back(a);
  }
  for (const TomlTable& q : t.tables("responses")) {
    q.allow({"name", "value", "uncertainty", "noise", "shift", "shift_share", "low_fidelity_bias"});
    const auto formula = [&](const char* key, const std::string& otherwise) {
      return q.at(key, [&] { return parse_formula(q.string(key, otherwise), names); });
    };
    p.responses.push_back({q.string("name"), q.number("uncertainty"),
                           q.at("value", [&] { return parse_formula(q.string("value"), names); }),
                           formula("noise", "0"), formula("shift", "0"),
                           formula("shift_share", "0"), formula("low_fidelity_bias", "0")});
  }
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
  for (const TomlTable& t : root.tables("problems")) all.push_back(read_covered_problem(t));
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
