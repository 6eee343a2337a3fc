// Studies of a formula that gives responses t0, t1, ...
#pragma once

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/support/fake_experiment.h"

namespace firn::lab {

using Values = FakeExperiment::Values;

struct Range {
  std::string name;
  double min, max;
};
struct Aim {  // a target named t0, t1, ...
  double value, uncertainty;
};

inline const std::vector<Range> unit_square = {{"a", 0, 1}, {"b", 0, 1}};

inline std::string study_text(const std::vector<Range>& ranges, const std::vector<Aim>& aims,
                              int runs, int seed, const std::string& more = "") {
  std::string s =
      fmt::format("[study]\nname = \"lab\"\ncase = \"case.toml\"\nseed = {}\n[budget]\nruns = {}\n",
                  seed, runs);
  for (const Range& r : ranges)
    s += fmt::format("[[parameters]]\nname = \"{0}\"\nkeys = [\"{0}\"]\nmin = {1}\nmax = {2}\n",
                     r.name, r.min, r.max);
  for (std::size_t k = 0; k < aims.size(); ++k)
    s += fmt::format("[[targets]]\nresponse = \"t{}\"\nvalue = {}\nuncertainty = {}\n", k,
                     aims[k].value, aims[k].uncertainty);
  return s + more;
}

struct Outcome {
  StudySummary summary;
  nlohmann::json j;
  int runs = 0;
};

// One study of responses t0, t1, ... that `formula` gives.
using Formula = std::function<std::vector<double>(const Values&, std::mt19937_64&)>;
inline Outcome carry_out(const std::string& text, const Formula& formula) {
  const Folder folder("lab");
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    std::vector<Response> all;
    for (const double y : formula(v, random))
      all.push_back(scalar("t" + std::to_string(all.size()), y, "1"));
    return all.empty() ? JobResult{JobStatus::failed, "no value here", {}, 1} : finished(all);
  });
  Outcome o;
  o.summary = run_study(folder.write("study.toml", text), folder / "out", experiment);
  o.j = nlohmann::json::parse(o.summary.json);
  o.runs = experiment.runs;
  return o;
}

}  // namespace firn::lab
