#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/answer.h"
#include "experiments/version.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;
using Out = fmt::memory_buffer;

template <class... Args>
void print(Out& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

std::string unit_text(const std::string& unit) {
  return unit.empty() || unit == "1" ? "" : " " + unit;
}

// ---- tables -------------------------------------------------------------------------------------

std::string observed_text(const Observation& o) {
  if (o.sample.count == 0) return "no value";
  return fmt::format("{:.4g} +- {:.2g}{}", o.sample.mean, o.standard_error, unit_text(o.unit));
}

std::string counts_text(const CheckedSet& set) {
  const int runs = set.finished + set.arched + set.failed;
  std::string s = fmt::format("{} run{}", runs, runs == 1 ? "" : "s");
  if (set.arched > 0) s += fmt::format(", {} arched", set.arched);
  if (set.failed > 0) s += fmt::format(", {} failed", set.failed);
  return s;
}

void print_values(Out& out, const Study& study, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    print(out, "{}{} = {:.4g}{}", i == 0 ? "" : ", ", study.parameters[i].name, values[i],
          unit_text(study.parameters[i].unit));
}

void print_targets(Out& out, const Study& study, const Answer& a) {
  print(out, "Targets\n");
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    print(out, "  {} = {:.4g} +- {:.2g}{}\n", t.response, t.value, t.uncertainty,
          unit_text(t.unit));
    print(out, "    {}\n", t.source);
    if (!a.knowledge) continue;
    const ReachedRange& r = a.reach[k];
    print(out, "    the ranges give {:.4g} to {:.4g}{}{}\n", r.lowest, r.highest, unit_text(t.unit),
          r.reachable ? (r.bracketed ? "" : "; no simulated point lies beyond the target")
                      : ": OUT OF REACH");
  }
}

void print_models(Out& out, const Answer& a) {
  print(out, "\nHow the responses were modelled\n");
  const auto line = [&](const ResponseModel& m) {
    print(out,
          "  {:<22} {} points, {}; seed sd {:.2g}{} ({} degrees of freedom); leave-one-out |z| "
          "at most {:.1f}\n",
          m.name, m.samples.size(), m.surrogate.best.form().describe(),
          m.noise.relative ? 100 * m.noise.sd : m.noise.sd,
          m.noise.relative ? " %" : unit_text(m.unit), m.noise.degrees_of_freedom,
          m.largest_leave_one_out_z);
  };
  for (const ResponseModel& m : a.knowledge->targets) line(m);
  for (const ResponseModel& m : a.knowledge->observed) line(m);
}

void print_checked(Out& out, const Study& study, const CheckedSet& set) {
  print(out, "  {}: ", set.name);
  print_values(out, study, set.values);
  if (set.run()) print(out, "   [{}]", counts_text(set));
  print(out, "\n");
  for (std::size_t k = 0; k < set.predicted.size(); ++k)
    print(out, "    {:<22} fit {:.4g} +- {:.2g}{}{}\n", study.targets[k].response,
          set.predicted[k].mean, std::sqrt(set.predicted[k].variance),
          unit_text(study.targets[k].unit), set.run() ? ", simulated:" : "");
  for (const Observation& o : set.observed) {
    print(out, "    {:<22} {}", o.response, observed_text(o));
    if (o.sample.count >= 2) print(out, "   (sd over seeds {:.2g})", o.sample.sd());
    print(out, "\n");
  }
}

void print_compare(Out& out, const Study& study, const Answer& a) {
  if (a.compare.empty()) return;
  print(out, "\nSets to compare{:>24}", "");
  for (const CheckedSet& set : a.compare) print(out, "{:>26}", set.name);
  print(out, "\n");
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    print(out, "  {:<37}", study.parameters[i].name + unit_text(study.parameters[i].unit));
    for (const CheckedSet& set : a.compare) print(out, "{:>26.4g}", set.values[i]);
    print(out, "\n");
  }
  for (std::size_t k = 0; k < a.compare.front().observed.size(); ++k) {
    print(out, "  {:<37}", a.compare.front().observed[k].response);
    for (const CheckedSet& set : a.compare) print(out, "{:>26}", observed_text(set.observed[k]));
    print(out, "\n  {:<37}", "  sd over seeds");
    for (const CheckedSet& set : a.compare) {
      const Sample& s = set.observed[k].sample;
      print(out, "{:>26}", s.count < 2 ? "-" : fmt::format("{:.2g}", s.sd()));
    }
    print(out, "\n");
  }
  print(out, "  {:<37}", "runs");
  for (const CheckedSet& set : a.compare) print(out, "{:>26}", counts_text(set));
  print(out, "\n");
}

void print_best(Out& out, const Study& study, const Answer& a) {
  if (a.best.values.empty()) return;
  print(out, "\n{}\n",
        a.best.run() ? "Answer, confirmed with seeds never used before"
                     : "Nearest to the targets, by the fit alone");
  print_checked(out, study, a.best);
  for (std::size_t k = 0; k < a.split.size(); ++k) {
    const VarianceSplit& s = a.split[k];
    print(out,
          "    {:<22} uncertainty: measurement {:.2g}, seed noise {:.2g}, surrogate {:.2g}{}; the "
          "other surrogate says {:.4g}\n",
          study.targets[k].response, std::sqrt(s.measurement), std::sqrt(s.seeds),
          std::sqrt(s.surrogate), unit_text(study.targets[k].unit), a.cross_check[k]);
  }
}

std::string term(double coefficient, const Parameter& p, bool first) {
  return fmt::format("{}{:.2f} {}{}{}",
                     coefficient < 0 ? (first ? "-" : " - ")
                     : first         ? ""
                                     : " + ",
                     std::abs(coefficient), p.logarithmic ? "ln(" : "", p.name,
                     p.logarithmic ? ")" : "");
}

std::string combination_text(const Study& study, const Combination& c) {
  std::string s;
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    s += term(c.coefficients[static_cast<Eigen::Index>(i)], study.parameters[i], i == 0);
  return s;
}

void print_identified(Out& out, const Study& study, const Answer& a) {
  if (!a.posterior) return;
  print(out, "\nWhat the data determine\n");
  print(out, "  {:<18}{:>12}{:>28}{:>22}\n", "parameter", "median", "95 % interval",
        "width left, of before");
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    const Marginal& m = a.posterior->marginals[i];
    print(out, "  {:<18}{:>12.4g}{:>28}{:>20.0f} %", p.name + unit_text(p.unit), m.median,
          fmt::format("{:.4g} to {:.4g}", m.low, m.high), 100 * m.width_ratio);
    if (m.width_ratio > 0.8) print(out, "   nothing learned");
    if (m.at_min) print(out, "   at the lower end of the range");
    if (m.at_max) print(out, "   at the upper end of the range");
    print(out, "\n");
  }
  for (const Combination& c : a.combinations) {
    if (!c.identified) {
      print(out, "  not determined:  {}   (the data see {:.1f} sd over the whole range)\n",
            combination_text(study, c), c.singular_value);
      continue;
    }
    print(out,
          "  determined:      {} = {:.3f} +- {:.3f}   (measurement {:.3f}, seed noise {:.3f}, "
          "surrogate {:.3f})\n",
          combination_text(study, c), c.value, c.sd, std::sqrt(c.split.measurement),
          std::sqrt(c.split.seeds), std::sqrt(c.split.surrogate));
  }
}

void print_valley(Out& out, const Study& study, const Answer& a) {
  if (a.valley.empty()) return;
  print(out, "\nEqually good parameters, from one end of the valley to the other\n");
  for (const CheckedSet& set : a.valley) print_checked(out, study, set);
}

// ---- JSON ---------------------------------------------------------------------------------------

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json named_values(const Study& study, const std::vector<double>& values) {
  Json j = Json::object();
  for (std::size_t i = 0; i < values.size(); ++i) j[study.parameters[i].name] = values[i];
  return j;
}

Json split_json(const VarianceSplit& s) {
  return {{"measurement", std::sqrt(s.measurement)},
          {"seed_noise", std::sqrt(s.seeds)},
          {"surrogate", std::sqrt(s.surrogate)}};
}

Json checked_json(const Study& study, const CheckedSet& set) {
  Json j = {{"name", set.name}, {"parameters", named_values(study, set.values)}};
  for (std::size_t k = 0; k < set.predicted.size(); ++k)
    j["fit"][study.targets[k].response] = {{"value", set.predicted[k].mean},
                                           {"uncertainty", std::sqrt(set.predicted[k].variance)},
                                           {"unit", study.targets[k].unit}};
  if (!set.run()) return j;
  j["runs"] = {{"finished", set.finished}, {"arched", set.arched}, {"failed", set.failed}};
  for (const Observation& o : set.observed)
    j["simulated"][o.response] = {{"value", o.sample.count > 0 ? number(o.sample.mean) : nullptr},
                                  {"standard_error", number(o.standard_error)},
                                  {"sd_over_seeds", number(o.sample.sd())},
                                  {"seeds", o.sample.count},
                                  {"unit", o.unit}};
  return j;
}

Json model_json(const ResponseModel& m) {
  Json lengths = Json::array();
  for (const double length : m.surrogate.best.lengths()) lengths.push_back(length);
  return {{"response", m.name},
          {"unit", m.unit},
          {"surrogate", m.surrogate.best.form().describe()},
          {"departure_sd", m.surrogate.best.departure_sd()},
          {"lengths", lengths},
          {"cross_check", m.surrogate.other.form().describe()},
          {"points", m.samples.size()},
          {"largest_leave_one_out_z", m.largest_leave_one_out_z},
          {"seed_noise",
           {{"sd", m.noise.sd},
            {"relative", m.noise.relative},
            {"degrees_of_freedom", m.noise.degrees_of_freedom}}}};
}

Json parameters_json(const Study& study, const Answer& a) {
  Json all = Json::array();
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    Json j = {{"name", p.name},
              {"keys", p.keys},
              {"min", p.min},
              {"max", p.max},
              {"unit", p.unit.empty() ? "1" : p.unit},
              {"scale", p.logarithmic ? "log" : "linear"}};
    if (p.prior_mean) j["prior"] = {{"mean", *p.prior_mean}, {"sd", *p.prior_sd}};
    if (a.posterior) {
      const Marginal& m = a.posterior->marginals[i];
      j["median"] = m.median;
      j["interval_95"] = {m.low, m.high};
      j["width_ratio"] = m.width_ratio;
      j["at_min"] = m.at_min;
      j["at_max"] = m.at_max;
    }
    all.push_back(j);
  }
  return all;
}

Json combinations_json(const Study& study, const Answer& a) {
  Json all = Json::array();
  for (const Combination& c : a.combinations) {
    Json terms = Json::array();
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      terms.push_back({{"parameter", study.parameters[i].name},
                       {"of", study.parameters[i].logarithmic ? "logarithm" : "value"},
                       {"coefficient", c.coefficients[static_cast<Eigen::Index>(i)]}});
    Json j = {{"identified", c.identified},
              {"terms", terms},
              {"value", c.identified ? number(c.value) : nullptr},
              {"uncertainty", c.identified ? number(c.sd) : nullptr},
              {"singular_value", c.singular_value}};
    if (c.identified) j["split"] = split_json(c.split);
    all.push_back(j);
  }
  return all;
}

Json targets_json(const Study& study, const Answer& a) {
  Json all = Json::array();
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    Json j = {{"response", t.response},
              {"value", t.value},
              {"uncertainty", t.uncertainty},
              {"unit", t.unit},
              {"source", t.source}};
    if (a.knowledge)
      j["reach"] = {{"lowest", a.reach[k].lowest},
                    {"highest", a.reach[k].highest},
                    {"bracketed", a.reach[k].bracketed},
                    {"reachable", a.reach[k].reachable}};
    if (k < a.split.size()) {
      j["uncertainty_at_answer"] = split_json(a.split[k]);
      j["other_surrogate_at_answer"] = a.cross_check[k];
    }
    all.push_back(j);
  }
  return all;
}

std::string csv_text(std::string s) {
  if (s.find_first_of(",\"\n") == std::string::npos) return s;
  for (std::size_t i = 0; (i = s.find('"', i)) != std::string::npos; i += 2) s.insert(i, 1, '"');
  return '"' + s + '"';
}

}  // namespace

std::string render_table(const Study& study, const Answer& a) {
  Out out;
  print_targets(out, study, a);
  print_compare(out, study, a);
  if (a.knowledge) print_models(out, a);
  print_best(out, study, a);
  print_identified(out, study, a);
  print_valley(out, study, a);
  print(out, "\n{} runs: {} finished, {} arched, {} failed; {:.0f} s of simulation\n", a.runs,
        a.finished, a.arched, a.failed, a.wall);
  if (a.other_version > 0)
    print(out, "{} more in the journal were made by another version of the program: not used\n",
          a.other_version);
  return fmt::to_string(out);
}

std::string render_json(const Study& study, const Answer& a) {
  Json j = {{"study", study.name},
            {"verdict", to_string(a.verdict)},
            {"headline", a.headline},
            {"firn_version", firn_version()},
            {"git_commit", firn_git_commit()},
            {"targets", targets_json(study, a)},
            {"parameters", parameters_json(study, a)}};
  if (!a.best.values.empty()) j["answer"] = checked_json(study, a.best);
  j["combinations"] = combinations_json(study, a);
  j["valley"] = Json::array();
  for (const CheckedSet& set : a.valley) j["valley"].push_back(checked_json(study, set));
  j["compare"] = Json::array();
  for (const CheckedSet& set : a.compare) j["compare"].push_back(checked_json(study, set));
  j["models"] = Json::array();
  if (a.knowledge) {
    for (const ResponseModel& m : a.knowledge->targets) j["models"].push_back(model_json(m));
    for (const ResponseModel& m : a.knowledge->observed) j["models"].push_back(model_json(m));
  }
  j["runs"] = {{"total", a.runs},
               {"finished", a.finished},
               {"arched", a.arched},
               {"failed", a.failed},
               {"by_another_version", a.other_version}};
  j["wall_seconds"] = a.wall;
  return j.dump(2);
}

std::string render_runs_csv(const Study& study, const std::vector<JournalRun>& runs) {
  std::vector<std::string> names;
  for (const Target& t : study.targets) names.push_back(t.response);
  names.insert(names.end(), study.observed.begin(), study.observed.end());
  Out out;
  print(out, "run,phase,point,parameters,seed,status,reason,wall_s,attempts,version");
  for (const std::string& name : names) print(out, ",{0},{0}_uncertainty", csv_text(name));
  print(out, "\n");
  for (const JournalRun& run : runs) {
    print(out, "{},{},{},{},{},{},{},{:.1f},{},{}", run.key, csv_text(run.label.phase),
          run.label.point, csv_text(run.label.parameters), run.label.seed, run.status,
          csv_text(run.result.reason), run.result.wall, run.attempts, csv_text(run.version));
    for (const std::string& name : names) {
      std::string value, uncertainty;
      for (const Response& r : run.result.responses)
        if (r.name == name && r.value.size() == 1) {
          value = fmt::format("{}", r.value[0]);
          if (!r.uncertainty.empty()) uncertainty = fmt::format("{}", r.uncertainty[0]);
        }
      print(out, ",{},{}", value, uncertainty);
    }
    print(out, "\n");
  }
  return fmt::to_string(out);
}

}  // namespace firn
