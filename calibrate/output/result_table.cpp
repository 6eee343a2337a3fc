// The result of a study as a text table.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/output/calibration_result.h"
#include "calibrate/output/result_table_sections.h"
#include "calibrate/output/text_format.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

using namespace result_table;

std::string observed_text(const Observation& o) {
  if (o.sample.count == 0) return "no value";
  return fmt::format("{:.4g} ± {:.2g}{}", o.sample.mean, o.standard_error, unit_suffix(o.unit));
}

std::string counts_text(const CheckedSet& set) {
  const int runs = set.finished + set.arched + set.failed + set.cut_short;
  std::string s = fmt::format("{} run{}", runs, runs == 1 ? "" : "s");
  if (set.arched > 0) s += fmt::format(", {} arched", set.arched);
  if (set.failed > 0) s += fmt::format(", {} failed", set.failed);
  if (set.cut_short > 0) s += fmt::format(", {} cut short", set.cut_short);
  return s;
}

void print_values(Out& out, const Study& study, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    print(out, "{}{} = {}{}", i == 0 ? "" : ", ", study.parameters[i].name,
          study.parameters[i].text(values[i]), unit_suffix(study.parameters[i].unit));
}

void print_targets(Out& out, const Study& study, const CalibrationResult& a) {
  print(out, "Targets\n");
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    print(out, "  {} = {:.4g} ± {:.2g}{}\n", t.response.label, t.value, t.uncertainty,
          unit_suffix(t.unit));
    print(out, "    {}\n", t.source);
    if (t.discrepancy > 0)
      print(out,
            "    discrepancy of the simulation, a prior: ± {:.2g}{}; with the measurement ± "
            "{:.2g}{}\n",
            t.discrepancy, unit_suffix(t.unit), t.sd(), unit_suffix(t.unit));
    if (!a.models) continue;
    const ReachedRange& r = a.reach[k];
    print(out, "    the ranges give {:.4g} to {:.4g}{}{}\n", r.lowest, r.highest,
          unit_suffix(t.unit),
          r.reachable ? (r.bracketed ? "" : "; no simulated point lies beyond the target")
                      : ": OUT OF REACH");
  }
}

void print_curves(Out& out, const Study& study, const CalibrationResult& a) {
  for (std::size_t i = 0; i < a.curves.size(); ++i) {
    const CurveTarget& c = study.curves[i];
    const CurveBasis& basis = a.curves[i];
    print(out,
          "  {}: {} principal component{} hold {:.1f} % of the variance between the simulated "
          "curves; they leave {:.2g}{} of these, {:.2g}{} of single runs and {:.2g}{} of the "
          "recorded one (root mean square)\n",
          c.label, basis.components.cols(), basis.components.cols() == 1 ? "" : "s",
          100 * basis.explained, basis.simulated_rest, unit_suffix(c.unit), basis.run_rest,
          unit_suffix(c.unit), basis.recorded_rest, unit_suffix(c.unit));
  }
}

// All choices; what follows in the table is of the best one.
void print_choices(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.choices.empty()) return;
  print(out, "\nChoices of {}\n  {:<24}{:>10}{:>14}{:>16}", study.choice->name, "choice", "before",
        "probability", "targets");
  for (const Parameter& p : study.parameters)
    print(out, "{:>36}", p.name + unit_suffix(p.unit) + ", median, 95 %");
  print(out, "\n");
  for (const ChoiceOutcome& c : a.choices) {
    print(out, "  {:<24}{:>10.3f}{:>14}{:>16}", c.label, c.prior,
          c.probability ? fmt::format("{:.3f}", *c.probability) : "-",
          !c.goodness                ? "not fitted"
          : c.goodness->acceptable() ? "met"
                                     : "NOT MET");
    for (std::size_t i = 0; i < c.marginals.size(); ++i) {
      const Parameter& p = study.parameters[i];
      const Marginal& m = c.marginals[i];
      print(out, "{:>36}",
            fmt::format("{}, {} to {}", p.text(m.median), p.text(m.low), p.text(m.high)));
    }
    print(out, "\n");
  }
  print(out, "  all that follows is for {} = {}\n", study.choice->name,
        a.choices[a.best_choice].label);
}

void print_priors(Out& out, const Study& study) {
  if (!study.priors.empty()) print(out, "\nPriors\n");
  for (const Prior& prior : study.priors) {
    std::vector<std::string> names;
    for (const std::size_t i : prior.parameters) names.push_back(study.parameters[i].name);
    print(out, "  {}: {}\n", fmt::join(names, ", "), prior.text);
  }
  if (!study.constraints.all.empty())
    print(out, "\nConstraints, which leave {:.0f} % of the ranges\n",
          100 * study.constraints.share);
  for (const Constraint& c : study.constraints.all) print(out, "  {}\n", c.rule);
}

void print_checked(Out& out, const Study& study, const CheckedSet& set) {
  print(out, "  {}: ", set.name);
  print_values(out, study, set.values);
  if (set.run()) print(out, "   [{}]", counts_text(set));
  print(out, "\n");
  const auto simulated = [&](const Observation& o) {
    std::string text = observed_text(o);
    if (o.sample.count >= 2) text += fmt::format("   (sd over seeds {:.2g})", o.sample.sd());
    return text;
  };
  // The targets come first among what was observed.
  for (std::size_t k = 0; k < set.predicted.size(); ++k) {
    print(out, "    {:<{}} fit {:.4g} ± {:.2g}{}", study.targets[k].response.label,
          label_width(study), set.predicted[k].mean, std::sqrt(set.predicted[k].variance),
          unit_suffix(study.targets[k].unit));
    if (k < set.observed.size()) print(out, ", simulated {}", simulated(set.observed[k]));
    print(out, "\n");
  }
  for (std::size_t k = set.predicted.size(); k < set.observed.size(); ++k)
    print(out, "    {:<{}} {}\n", set.observed[k].response, label_width(study),
          simulated(set.observed[k]));
}

void print_compare(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.compare.empty()) return;
  print(out, "\nSets to compare{:>24}", "");
  for (const CheckedSet& set : a.compare) print(out, "{:>26}", set.name);
  print(out, "\n");
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    print(out, "  {:<37}", study.parameters[i].name + unit_suffix(study.parameters[i].unit));
    for (const CheckedSet& set : a.compare)
      print(out, "{:>26}", study.parameters[i].text(set.values[i]));
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
  if (a.posterior) {
    print(out, "  {:<37}", "inside the 95 % region");
    for (const CheckedSet& set : a.compare)
      print(out, "{:>26}",
            !set.hpd_level
                ? "outside the ranges"
                : fmt::format("{} ({:.1f} % is denser)", *set.hpd_level <= 0.95 ? "yes" : "NO",
                              100 * *set.hpd_level));
    print(out, "\n");
  }
  print(out, "  {:<37}", "runs");
  for (const CheckedSet& set : a.compare) print(out, "{:>26}", counts_text(set));
  print(out, "\n");
}

// What the parameters of the estimate are, by the outcome of the study.
const char* title_of_best(const CalibrationResult& a) {
  switch (a.verdict) {
    case StudyVerdict::infeasible:
      return "Nearest to the targets, simulated with seeds never used before";
    case StudyVerdict::prior_conflict:
      return "Nearest to the targets and the priors, simulated with seeds never used before";
    case StudyVerdict::unconfirmed:
      return "Fitted to the targets, NOT CONFIRMED by seeds never used before";
    case StudyVerdict::direct_search_only:
      return "Best of the search, simulated with seeds never used before";
    default:
      return "Answer, confirmed with seeds never used before";
  }
}

void print_best(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.best.values.empty()) return;
  print(out, "\n{}\n", title_of_best(a));
  print_checked(out, study, a.best);
  for (std::size_t k = 0; k < a.split.size(); ++k) {
    const VarianceSplit& s = a.split[k];
    print(
        out,
        "    {:<{}} uncertainty: measurement {:.2g}, seed noise {:.2g}, surrogate {:.2g}{}{}; the "
        "other surrogate says {:.4g}\n",
        study.targets[k].response.label, label_width(study), std::sqrt(s.measurement),
        std::sqrt(s.seeds), std::sqrt(s.surrogate), discrepancy_share(s, "{:.2g}"),
        unit_suffix(study.targets[k].unit), a.cross_check[k]);
  }
}

// Response of each target as the posterior predicts it, next to its measurement.
void print_predicted(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.predictive.empty()) return;
  const int width = label_width(study) + 6;  // and a unit
  print(out, "\nPredicted responses: median, and 95 % interval\n  {:<{}}{:>22}{:>40}{:>30}\n",
        "target", width, "measured", "mean response", "one run");
  for (std::size_t k = 0; k < a.predictive.size(); ++k) {
    const Target& t = study.targets[k];
    print(out, "  {:<{}}{:>22}", t.response.label + unit_suffix(t.unit), width,
          fmt::format("{:.4g} ± {:.2g}", t.value, t.uncertainty));
    if (!a.predictive[k]) {
      print(out, "{:>40}\n", "no finite prediction");
      continue;
    }
    const auto interval = [](const PredictiveDistribution& d) {
      return fmt::format("{:.4g} to {:.4g}", d.quantiles.front(), d.quantiles.back());
    };
    const PredictiveDistribution& mean = a.predictive[k]->mean_response;
    print(out, "{:>40}{:>30}\n", fmt::format("{:.4g}, {}", mean.quantiles[2], interval(mean)),
          interval(a.predictive[k]->single_run));
  }
}

void print_ridge(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.ridge.empty()) return;
  print(out, "\nEqually good parameters, from one end of the ridge to the other\n");
  for (const CheckedSet& set : a.ridge) print_checked(out, study, set);
}

std::string effort_text(double seconds) {
  if (seconds == 0) return "-";
  return seconds < 5400 ? fmt::format("{:.0f} min", seconds / 60)
                        : fmt::format("{:.1f} h", seconds / 3600);
}

void print_advice(Out& out, const CalibrationResult& a) {
  if (a.advice.empty()) return;
  print(out, "\nWhat to measure next\n  {:<38}{:>22}{:>12}{:>16}{:>24}\n", "measurement",
        "its uncertainty", "effort", "information", "longest direction left");
  for (const MeasurementValue& m : a.advice)
    print(out, "  {:<38}{:>22}{:>12}{:>11.2f} bits{:>22.0f} %\n",
          m.response.label + (m.repeats_a_target ? ", once more" : ""),
          fmt::format("{:.3g}{}", m.uncertainty, unit_suffix(m.unit)), effort_text(m.effort),
          m.information, 100 * m.remaining_extent);
}

void print_direct(Out& out, const CalibrationResult& a) {
  if (!a.direct) return;
  print(out,
        "\nDirect search: {} evaluations. Its best looked {:.2g} standard deviations from the "
        "targets; by fresh seeds it is {:.2g}.\n",
        a.direct->evaluations, a.direct->best_observed, a.direct->confirmed);
}

void print_goodness(Out& out, const CalibrationResult& a) {
  if (!a.goodness) return;
  const auto line = [&](const char* of, const GoodnessOfFit& g) {
    print(out,
          "  {}: chi-square {:.1f} on {:.1f} degrees of freedom; chance gives as much with "
          "probability {:.2g}{}\n",
          of, g.chi_square, g.freedom, g.probability, g.acceptable() ? "" : ": NOT MET TOGETHER");
  };
  print(out, "\nAll targets together, where they are met best\n");
  line(a.without_priors ? "targets and priors" : "targets", *a.goodness);
  if (a.without_priors) line("targets alone", *a.without_priors);
}

}  // namespace

std::string render_table(const Study& study, const CalibrationResult& a) {
  Out out;
  print_targets(out, study, a);
  print_curves(out, study, a);
  print_choices(out, study, a);
  print_priors(out, study);
  print_compare(out, study, a);
  if (a.models) print_models(out, study, a);
  print_sensitivity(out, study, a);
  print_numerics(out, study, a);
  print_fidelity(out, study, a);
  print_best(out, study, a);
  print_goodness(out, a);
  for (const OutlierRun& o : a.outliers) {
    const Point& p = a.points[o.point];
    print(out, "\nOutlier, left out: {} = {:.4g} at ", o.response.label, o.value);
    print_values(out, study, p.values);
    print(out, ", seed {}; other seeds there give {:.4g}\n", p.seeds[o.seed], o.others);
  }
  print_direct(out, a);
  print_identified(out, study, a);
  print_predicted(out, study, a);
  print_ridge(out, study, a);
  print_advice(out, a);
  if (!a.stopped.empty())
    print(out, "\nAfter {} round{} of refinement: {}\n", a.rounds, a.rounds == 1 ? "" : "s",
          a.stopped);
  if (a.reused > 0)
    print(out, "{} of the runs were made by other studies of the same case\n", a.reused);
  if (a.budget_left > 0)
    print(out, "{} of the budget's {} runs are left: {}\n", a.budget_left, a.budget_runs,
          a.left_because);
  if (a.cut_short_share > 0.05)
    print(out,
          "{:.0f} % of the runs near the answer failed or met a limit: its responses rest on "
          "the others\n",
          100 * a.cut_short_share);
  print(out, "\n{} runs: {} finished, {} arched, {} failed", a.runs, a.finished, a.arched,
        a.failed);
  if (a.crashed > 0) print(out, ", {} crashed", a.crashed);
  if (a.timed_out > 0) print(out, ", {} met the time limit", a.timed_out);
  if (a.out_of_memory > 0) print(out, ", {} met the memory limit", a.out_of_memory);
  print(out, "; {:.0f} s of simulation\n", a.wall);
  for (const std::string& where : a.cut_short) print(out, "  cut short: {}\n", where);
  if (a.other_version > 0)
    print(out, "{} more in the journal were made by another program: not used\n", a.other_version);
  return fmt::to_string(out);
}

}  // namespace firn
