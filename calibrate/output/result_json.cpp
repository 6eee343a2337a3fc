// The result of a study as JSON and CSV.
#include <fmt/format.h>

#include <cmath>

#include "calibrate/output/calibration_result.h"
#include "calibrate/output/study_document.h"
#include "calibrate/output/text_format.h"
#include "experiments/storage/version.h"
#include "experiments/system/text_encoding.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

using Document = StudyDocument;

std::vector<double> list_of(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

NamedValues<double> named_values(const Study& study, const std::vector<double>& values) {
  NamedValues<double> named;
  for (std::size_t i = 0; i < values.size(); ++i)
    named.emplace_back(study.parameters[i].name, values[i]);
  return named;
}

Document::VarianceParts parts_of(const VarianceSplit& s) {
  Document::VarianceParts parts{
      std::sqrt(s.measurement), std::sqrt(s.seeds), std::sqrt(s.surrogate), {}};
  if (s.discrepancy > 0) parts.discrepancy = std::sqrt(s.discrepancy);
  return parts;
}

Document::Set set_of(const Study& study, const CheckedSet& set) {
  Document::Set d;
  d.name = set.name;
  d.parameters = named_values(study, set.values);
  for (std::size_t k = 0; k < set.predicted.size(); ++k)
    d.fit.push_back(
        {study.targets[k].response.label,
         {set.predicted[k].mean, std::sqrt(set.predicted[k].variance), study.targets[k].unit}});
  if (set.hpd_level) {
    d.hpd_level = set.hpd_level;
    d.inside_95_region = *set.hpd_level <= 0.95;
  }
  if (!set.run()) return d;
  d.runs = {set.finished, set.arched, set.failed, set.cut_short};
  for (const Observation& o : set.observed)
    d.simulated.push_back({o.response,
                           {o.sample.count > 0 ? o.sample.mean : std::nan(""), o.standard_error,
                            o.sample.sd(), o.sample.count, o.unit}});
  return d;
}

std::vector<Document::Set> sets_of(const Study& study, const std::vector<CheckedSet>& sets) {
  std::vector<Document::Set> all;
  all.reserve(sets.size());
  for (const CheckedSet& set : sets) all.push_back(set_of(study, set));
  return all;
}

Document::Model model_of(const ResponseModel& m) {
  Document::Model d;
  d.response = m.response.label;
  d.unit = m.unit;
  d.surrogate = m.surrogate.best.form().describe();
  d.gp_residual_sd = m.surrogate.best.gp_residual_sd();
  d.lengths = list_of(m.surrogate.best.lengths());
  d.cross_check = m.surrogate.other.form().describe();
  d.points = m.samples.size();
  d.largest_leave_one_out_z = m.largest_leave_one_out_z;
  d.passes_cross_validation = m.passes_cross_validation();
  const bool relative = m.noise.is_relative();
  d.seed_noise = {relative ? m.noise.relative_sd : m.noise.constant_sd, relative,
                  m.noise.relative_probability, m.noise.degrees_of_freedom,
                  m.local_noise.uniform()};
  return d;
}

std::vector<Document::Parameter> parameters_of(const Study& study, const CalibrationResult& a) {
  std::vector<Document::Parameter> all;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    Document::Parameter& d = all.emplace_back();
    d.name = p.name;
    d.keys = p.keys;
    d.min = p.min;
    d.max = p.max;
    d.unit = p.unit.empty() ? "1" : p.unit;
    d.scale = p.logarithmic ? "log" : "linear";
    if (p.prior_mean) d.prior = {*p.prior_mean, *p.prior_sd};
    if (a.posterior) {
      const Marginal& m = a.posterior->marginals[i];
      d.median = m.median;
      d.interval_68 = {m.low_68, m.high_68};
      d.interval_95 = {m.low, m.high};
      d.posterior_to_prior_sd = m.posterior_to_prior_sd;
      d.at_min = m.at_min;
      d.at_max = m.at_max;
    }
    if (i < a.profiles.size()) {
      const Profile& profile = a.profiles[i];
      d.profile = {{profile.low, profile.high}, {}, profile.cost};
      for (const double u : profile.u) d.profile->values.push_back(p.from_unit(u));
    }
  }
  return all;
}

Document::Goodness goodness_of(const Study& study, const GoodnessOfFit& g) {
  Document::Goodness d{g.chi_square, g.freedom, g.probability, g.acceptable(), {}};
  for (std::size_t k = 0; k < g.z.size(); ++k)
    d.standardized_residuals.emplace_back(study.targets[k].response.label, g.z[k]);
  return d;
}

NamedValues<Document::Marginal> marginals_of(const Study& study,
                                             const std::vector<Marginal>& marginals) {
  NamedValues<Document::Marginal> all;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Marginal& m = marginals[i];
    all.push_back({study.parameters[i].name, {m.median, {m.low_68, m.high_68}, {m.low, m.high}}});
  }
  return all;
}

Document::Curve curve_of(const CurveTarget& c, const CurveBasis& basis) {
  Document::Curve d;
  d.label = c.label;
  d.unit = c.unit;
  d.x_unit = c.x_unit;
  d.uncertainty = c.uncertainty;
  d.explained_variance = basis.explained;
  d.simulated_rest = basis.simulated_rest;
  d.single_run_rest = basis.run_rest;
  d.recorded_rest = basis.recorded_rest;
  d.x = list_of(c.x);
  d.recorded = list_of(c.y);
  d.simulated_mean = list_of(basis.mean);
  for (Eigen::Index k = 0; k < basis.components.cols(); ++k)
    d.components.push_back(list_of(basis.components.col(k)));
  return d;
}

Document::Choices choices_of(const Study& study, const CalibrationResult& a) {
  Document::Choices d{study.choice->name, study.choice->keys, a.choices[a.best_choice].label, {}};
  for (const ChoiceOutcome& c : a.choices) {
    Document::Choices::Choice& one = d.choices.emplace_back();
    one.label = c.label;
    one.prior = c.prior;
    one.probability = c.probability.value_or(std::nan(""));
    one.verdict = to_string(c.verdict);
    one.headline = c.headline;
    if (c.goodness) one.goodness_of_fit = goodness_of(study, *c.goodness);
    one.estimate = named_values(study, c.best);
    if (!c.marginals.empty()) one.parameters = marginals_of(study, c.marginals);
  }
  return d;
}

std::vector<Document::Combination> combinations_of(const Study& study, const CalibrationResult& a) {
  std::vector<Document::Combination> all;
  for (const Combination& c : a.combinations) {
    Document::Combination& d = all.emplace_back();
    d.identifiable = c.identifiable;
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      d.terms.push_back({study.parameters[i].name,
                         study.parameters[i].logarithmic ? "logarithm" : "value",
                         c.coefficients[static_cast<Eigen::Index>(i)]});
    d.spread_over_posterior = c.spread;
    d.singular_value = c.singular_value;
    if (!c.identifiable) continue;
    d.value = c.value;
    d.uncertainty = c.uncertainty();
    d.uncertainty_near_estimate = c.sd;
    d.split = parts_of(c.split);
  }
  return all;
}

Document::Distribution distribution_of(const PredictiveDistribution& d) {
  return {{d.quantiles.begin(), d.quantiles.end()}, {d.edges, d.probability}};
}

std::vector<Document::Target> targets_of(const Study& study, const CalibrationResult& a) {
  std::vector<Document::Target> all;
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    Document::Target& d = all.emplace_back();
    d.response = t.response.label;
    d.value = t.value;
    d.uncertainty = t.uncertainty;
    d.unit = t.unit;
    d.source = t.source;
    if (t.discrepancy > 0) d.discrepancy = t.discrepancy;
    if (a.models)
      d.reach = {a.reach[k].lowest, a.reach[k].highest, a.reach[k].bracketed, a.reach[k].reachable};
    if (k < a.split.size()) {
      d.uncertainty_at_estimate = parts_of(a.split[k]);
      d.other_surrogate_at_estimate = a.cross_check[k];
    }
    if (k < a.predictive.size() && a.predictive[k])
      d.posterior_predictive = {{predictive_probabilities.begin(), predictive_probabilities.end()},
                                distribution_of(a.predictive[k]->mean_response),
                                distribution_of(a.predictive[k]->single_run)};
  }
  return all;
}

std::vector<Document::Sensitivity> sensitivity_of(const Study& study, const CalibrationResult& a) {
  const auto interval = [](const Eigen::MatrixX2d& ends, Eigen::Index k) {
    return Document::Interval(ends(k, 0), ends(k, 1));
  };
  std::vector<Document::Sensitivity> all;
  for (const Sensitivity& s : a.sensitivity) {
    Document::Sensitivity& d = all.emplace_back();
    d.response = s.response;
    d.noise_share = s.noise_share;
    for (std::size_t i = 0; i < study.parameters.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      d.parameters.push_back({study.parameters[i].name,
                              {s.indices.first[k], interval(s.indices.first_interval, k),
                               s.indices.total[k], interval(s.indices.total_interval, k)}});
    }
  }
  return all;
}

std::vector<Document::Round> rounds_of(const Study& study, const CalibrationResult& a) {
  std::vector<Document::Round> all;
  for (const EstimateRound& round : a.estimate_history)
    all.push_back({round.after, static_cast<std::uint64_t>(round.runs),
                   marginals_of(study, round.marginals)});
  return all;
}

std::vector<Document::Numerics> numerics_of(const CalibrationResult& a) {
  std::vector<Document::Numerics> all;
  for (const NumericsOutcome& n : a.numerics) {
    Document::Numerics& d = all.emplace_back();
    d.name = n.name;
    for (const NumericsOutcome::Shift& s : n.shifts)
      d.shifts.push_back({s.response, {s.value, s.standard_error, s.unit}});
  }
  return all;
}

Document::LowFidelity fidelity_of(const Study& study, const FidelityOutcome& outcome) {
  Document::LowFidelity d;
  for (const auto& [key, value] : study.low_fidelity->set) d.set.emplace_back(key, value);
  for (const FidelityOutcome::Bias& b : outcome.biases)
    d.biases.push_back({b.response, {b.bias.value, b.bias.sd, b.unit}});
  d.runs = outcome.low.count;
  d.wall_seconds = outcome.low.wall;
  d.high_fidelity_runs = outcome.high.count;
  d.high_fidelity_wall_seconds = outcome.high.wall;
  return d;
}

std::vector<Document::Advice> advice_of(const CalibrationResult& a) {
  std::vector<Document::Advice> all;
  for (const MeasurementValue& m : a.advice) {
    Document::Advice& d = all.emplace_back();
    d.response = m.response.label;
    d.repeats_a_target = m.repeats_a_target;
    d.uncertainty = m.uncertainty;
    d.unit = m.unit;
    d.information_bits = m.information;
    d.remaining_extent = m.remaining_extent;
    if (m.discrepancy > 0) d.discrepancy = m.discrepancy;
    if (m.effort > 0) d.effort_seconds = m.effort;
  }
  return all;
}

}  // namespace

StudyDocument study_document(const Study& study, const CalibrationResult& a) {
  StudyDocument d;
  d.study = study.name;
  d.verdict = to_string(a.verdict);
  d.headline = a.headline;
  d.firn_version = firn_version();
  d.git_commit = firn_git_commit();
  d.contact_model = kContactModel;
  d.targets = targets_of(study, a);
  d.parameters = parameters_of(study, a);
  if (!a.choices.empty()) d.choice = choices_of(study, a);
  for (std::size_t i = 0; i < a.curves.size(); ++i)
    d.curves.push_back(curve_of(study.curves[i], a.curves[i]));
  for (const Prior& prior : study.priors) {
    d.priors.push_back({{}, prior.text});
    for (const std::size_t i : prior.parameters)
      d.priors.back().parameters.push_back(study.parameters[i].name);
  }
  for (const Constraint& c : study.constraints.all) d.constraints.push_back(c.rule);
  d.cautions = a.caveats;
  for (const OutlierRun& o : a.outliers)
    d.outliers.push_back({o.response.label, named_values(study, a.points[o.point].values),
                          a.points[o.point].seeds[o.seed], o.value, o.others});
  if (!a.best.values.empty()) d.estimate = set_of(study, a.best);
  if (a.goodness) d.goodness_of_fit = goodness_of(study, *a.goodness);
  if (a.without_priors) d.goodness_of_fit_without_priors = goodness_of(study, *a.without_priors);
  if (a.posterior)
    d.posterior = {a.posterior->u.size(), a.posterior->effective_samples, "posterior.csv"};
  d.estimate_history = rounds_of(study, a);
  d.combinations = combinations_of(study, a);
  d.ridge = sets_of(study, a.ridge);
  d.compare = sets_of(study, a.compare);
  d.sensitivity = sensitivity_of(study, a);
  d.numerics = numerics_of(a);
  if (a.fidelity) d.low_fidelity = fidelity_of(study, *a.fidelity);
  d.measure_next = advice_of(a);
  if (a.direct)
    d.direct_search = {to_string(study.direct), a.direct->evaluations, a.direct->best_observed,
                       a.direct->confirmed};
  if (a.budget_runs > 0) d.budget = {a.budget_runs, a.reused, a.budget_left, a.left_because};
  if (!a.stopped.empty()) d.refinement = {a.rounds, a.stopped};
  if (a.models)
    for (const auto* models : {&a.models->targets, &a.models->observed})
      for (const ResponseModel& m : *models) d.models.push_back(model_of(m));
  d.runs = {a.runs,          a.finished, a.arched,    a.failed,       a.timed_out,
            a.out_of_memory, a.crashed,  a.cut_short, a.other_version};
  d.wall_seconds = a.wall;
  return d;
}

std::string render_json(StudyDocument document) { return json_text(std::move(document), 2); }

StudyDocument read_study_document(const ResultsJson& results) {
  return document_from_results<StudyDocument>(results, "study", "firn calibrate");
}

std::string render_posterior_csv(const Study& study, const CalibrationResult& a) {
  fmt::memory_buffer out;
  for (const Parameter& p : study.parameters)
    print(out, "{},", encode::csv_field(p.unit.empty() ? p.name : p.name + " / " + p.unit));
  print(out, "weight,log_density\n");
  const Posterior& posterior = *a.posterior;
  for (std::size_t s = 0; s < posterior.u.size(); ++s) {
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      print(out, "{},",
            study.parameters[i].from_unit(posterior.u[s][static_cast<Eigen::Index>(i)]));
    print(out, "{},{}\n", posterior.weight[s], -0.5 * posterior.cost[s]);
  }
  return fmt::to_string(out);
}

std::string render_runs_csv(const Study& study, const std::vector<JournalRun>& runs) {
  std::vector<ResponseId> columns;
  for (const Target& t : study.targets) columns.push_back(t.response);
  for (const Observed& o : study.observed) columns.push_back(o.response);
  fmt::memory_buffer out;
  print(out,
        "run,experiment,phase,point,parameters,seed,status,reason,wall_s,attempts,program,git_"
        "commit");
  for (const ResponseId& c : columns)
    print(out, ",{},{}", encode::csv_field(c.label), encode::csv_field(c.label + "_uncertainty"));
  print(out, "\n");
  for (const JournalRun& run : runs) {
    print(out, "{},{},{},{},{},{},{},{},{:.1f},{},{},{}", encode::csv_field(run.key),
          encode::csv_field(run.label.experiment), encode::csv_field(run.label.phase),
          run.label.point, encode::csv_field(run.label.parameters), run.label.seed,
          encode::csv_field(run.status), encode::csv_field(run.result.reason), run.result.wall,
          run.attempts, encode::csv_field(run.program), encode::csv_field(run.git_commit));
    for (const ResponseId& c : columns) {
      std::string value, uncertainty;
      for (const Response& r : run.result.responses)
        if (r.name == c.name && r.value.size() == 1 &&
            run.label.experiment == study.experiments[c.experiment].name) {
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
