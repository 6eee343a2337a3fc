// What the data determine, as a section of the table of a study.
#include <cmath>

#include "calibrate/output/result_table_sections.h"
#include "calibrate/output/text_format.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

std::string term(double coefficient, const Parameter& p, bool first) {
  return fmt::format("{}{:.2f} {}{}{}",
                     coefficient < 0 ? (first ? "-" : " - ")
                     : first         ? ""
                                     : " + ",
                     std::abs(coefficient), p.logarithmic ? "ln(" : "", p.name,
                     p.logarithmic ? ")" : "");
}

}  // namespace

std::string combination_text(const Study& study, const Combination& c) {
  std::string s;
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    s += term(c.coefficients[static_cast<Eigen::Index>(i)], study.parameters[i], i == 0);
  return s;
}

namespace result_table {

void print_identified(Out& out, const Study& study, const CalibrationResult& a) {
  if (!a.posterior) return;
  print(out, "\nWhat the data determine\n");
  print(out, "  {:<18}{:>12}{:>28}{:>28}{:>22}\n", "parameter", "median", "95 % interval",
        "profile's 95 %", "width left, of before");
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    const Marginal& m = a.posterior->marginals[i];
    print(out, "  {:<18}{:>12}{:>28}{:>28}{:>20.0f} %", p.name + unit_suffix(p.unit),
          p.text(m.median), fmt::format("{} to {}", p.text(m.low), p.text(m.high)),
          i < a.profiles.size()
              ? fmt::format("{} to {}", p.text(a.profiles[i].low), p.text(a.profiles[i].high))
              : "-",
          100 * m.posterior_to_prior_sd);
    if (m.posterior_to_prior_sd > 0.8) print(out, "   nothing learned");
    if (m.at_min) print(out, "   at the lower end of the range");
    if (m.at_max) print(out, "   at the upper end of the range");
    print(out, "\n");
  }
  print(out, "  by {} samples of the posterior, worth {:.0f} independent ones (posterior.csv)\n",
        a.posterior->u.size(), a.posterior->effective_samples);
  for (const Combination& c : a.combinations) {
    if (!c.identifiable) {
      print(out, "  not determined:  {}   (the data see {:.1f} sd over the whole range)\n",
            combination_text(study, c), c.singular_value);
      continue;
    }
    print(out,
          "  determined:      {} = {:.3f} ± {:.3f}   (measurement {:.3f}, seed noise {:.3f}, "
          "surrogate {:.3f}{})\n",
          combination_text(study, c), c.value, c.uncertainty(), std::sqrt(c.split.measurement),
          std::sqrt(c.split.seeds), std::sqrt(c.split.surrogate),
          discrepancy_share(c.split, "{:.3f}"));
    if (c.is_curved())
      print(out,
            "    ± {:.3f} near the answer; farther off the equally good parameters bend away from "
            "it, by {:.3f} (root mean square)\n",
            c.sd, c.spread);
  }
}

}  // namespace result_table
}  // namespace firn
