// How responses were modeled and what they depend on, as sections of the table of a study.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/output/result_table_sections.h"
#include "calibrate/output/text_format.h"
#include "experiments/text/number_text.h"

namespace firn::result_table {

void print_models(Out& out, const Study& study, const CalibrationResult& a) {
  print(out, "\nHow the responses were modeled\n");
  const auto line = [&](const ResponseModel& m) {
    print(out,
          "  {:<{}} {} points, {}; seed sd {:.2g}{} ({} degrees of freedom); leave-one-out |z| "
          "at most {:.1f}\n",
          m.response.label, label_width(study), m.samples.size(),
          m.surrogate.best.form().describe(),
          m.noise.is_relative() ? 100 * m.noise.relative_sd : m.noise.constant_sd,
          m.noise.is_relative() ? " %" : unit_suffix(m.unit), m.noise.degrees_of_freedom,
          m.largest_leave_one_out_z);
    if (!m.local_noise.uniform())
      print(out,
            "    its noise is not the same all over the ranges: it is modeled place by place\n");
    if (!m.passes_cross_validation())
      print(
          out,
          "    IT DOES NOT EXPLAIN ITS OWN RUNS: do not rely on regions and intervals that rest on "
          "it; smaller ranges or more points may help\n");
  };
  for (const ResponseModel& m : a.models->targets) line(m);
  for (const ResponseModel& m : a.models->observed) line(m);
}

void print_sensitivity(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.sensitivity.empty()) return;
  const int width = label_width(study);
  print(out,
        "\nWhat each response depends on, over the ranges (share of its variance: alone / with "
        "interactions)\n  {:<{}}",
        "", width);
  for (const Parameter& p : study.parameters) print(out, "{:>18}", p.name);
  print(out, "{:>20}\n", "noise of one run");
  for (const Sensitivity& s : a.sensitivity) {
    print(out, "  {:<{}}", s.response, width);
    for (Eigen::Index i = 0; i < s.indices.total.size(); ++i)
      print(out, "{:>18}",
            fmt::format("{:.2f} / {:.2f}", std::max(0.0, s.indices.first[i]), s.indices.total[i]));
    print(out, "{:>20.2f}\n    95 % of the latter", s.noise_share);
    for (Eigen::Index i = 0; i < s.indices.total.size(); ++i)
      print(out, "{:>{}}",
            fmt::format("{:.2f} to {:.2f}", s.indices.total_interval(i, 0),
                        s.indices.total_interval(i, 1)),
            i == 0 ? width - 2 : 18);
    print(out, "\n");
  }
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (std::all_of(a.sensitivity.begin(), a.sensitivity.end(),
                    [&](const Sensitivity& s) { return s.indices.total[k] < s.noise_share; }))
      print(out, "  {} moves no response by more than the noise of a single run\n",
            study.parameters[i].name);
  }
}

void print_numerics(Out& out, const Study& study, const CalibrationResult& a) {
  if (a.numerics.empty()) return;
  print(out, "\nOther numerics at the middle of the ranges\n");
  for (const NumericsOutcome& n : a.numerics) {
    print(out, "  {}\n", n.name);
    for (const NumericsOutcome::Shift& s : n.shifts)
      print(out, "    {:<{}} moves by {:.3g} ± {:.2g}{}{}\n", s.response, label_width(study),
            s.value, s.standard_error, unit_suffix(s.unit),
            std::abs(s.value) > 2 * s.standard_error ? ": MORE THAN THE NOISE" : "");
    if (n.shifts.empty()) print(out, "    no run finished\n");
  }
}

void print_fidelity(Out& out, const Study& study, const CalibrationResult& a) {
  if (!a.fidelity) return;
  const FidelityOutcome& f = *a.fidelity;
  const auto each = [](const FidelityOutcome::Runs& runs) {
    return runs.count > 0 ? runs.wall / runs.count : 0;
  };
  std::vector<std::string> changes;
  for (const auto& [key, value] : study.low_fidelity->set)
    changes.push_back(fmt::format("{} = {}", key, value));
  print(out, "\nLow fidelity: {}\n", fmt::join(changes, ", "));
  print(out, "  {} runs of {:.3g} s each; {} of high fidelity of {:.3g} s\n", f.low.count,
        each(f.low), f.high.count, each(f.high));
  for (const FidelityOutcome::Bias& b : f.biases)
    print(out, "  moves {:<{}} by {:.3g} ± {:.2g}{} at the answer\n", b.response,
          label_width(study), b.bias.value, b.bias.sd, unit_suffix(b.unit));
}

}  // namespace firn::result_table
