// The result of a study as JSON.
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/output/calibration_result.h"
#include "calibrate/output/text_format.h"
#include "experiments/storage/version.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/vector_json.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

Json named_values(const Study& study, const std::vector<double>& values) {
  Json j = Json::object();
  for (std::size_t i = 0; i < values.size(); ++i) j[study.parameters[i].name] = values[i];
  return j;
}

Json split_json(const VarianceSplit& s) {
  Json j = {{"measurement", std::sqrt(s.measurement)},
            {"seed_noise", std::sqrt(s.seeds)},
            {"surrogate", std::sqrt(s.surrogate)}};
  if (s.discrepancy > 0) j["discrepancy"] = std::sqrt(s.discrepancy);
  return j;
}

Json checked_json(const Study& study, const CheckedSet& set) {
  Json j = {{"name", set.name}, {"parameters", named_values(study, set.values)}};
  for (std::size_t k = 0; k < set.predicted.size(); ++k)
    j["fit"][study.targets[k].response.label] = {
        {"value", set.predicted[k].mean},
        {"uncertainty", std::sqrt(set.predicted[k].variance)},
        {"unit", study.targets[k].unit}};
  if (set.hpd_level) {
    j["hpd_level"] = *set.hpd_level;
    j["inside_95_region"] = *set.hpd_level <= 0.95;
  }
  if (!set.run()) return j;
  j["runs"] = {{"finished", set.finished},
               {"arched", set.arched},
               {"failed", set.failed},
               {"cut_short", set.cut_short}};
  for (const Observation& o : set.observed)
    j["simulated"][o.response] = {
        {"value", o.sample.count > 0 ? number_json(o.sample.mean) : nullptr},
        {"standard_error", number_json(o.standard_error)},
        {"sd_over_seeds", number_json(o.sample.sd())},
        {"seeds", o.sample.count},
        {"unit", o.unit}};
  return j;
}

Json model_json(const ResponseModel& m) {
  Json lengths = Json::array();
  for (const double length : m.surrogate.best.lengths()) lengths.push_back(length);
  return {{"response", m.response.label},
          {"unit", m.unit},
          {"surrogate", m.surrogate.best.form().describe()},
          {"discrepancy_sd", m.surrogate.best.discrepancy_sd()},
          {"lengths", lengths},
          {"cross_check", m.surrogate.other.form().describe()},
          {"points", m.samples.size()},
          {"largest_leave_one_out_z", m.largest_leave_one_out_z},
          {"passes_cross_validation", m.passes_cross_validation()},
          {"seed_noise",
           {{"sd", m.noise.sd},
            {"relative", m.noise.relative},
            {"degrees_of_freedom", m.noise.degrees_of_freedom},
            {"uniform", m.local_noise.uniform()}}}};
}

Json parameters_json(const Study& study, const CalibrationResult& a) {
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
      j["interval_68"] = {m.low_68, m.high_68};
      j["interval_95"] = {m.low, m.high};
      j["posterior_to_prior_sd"] = m.posterior_to_prior_sd;
      j["at_min"] = m.at_min;
      j["at_max"] = m.at_max;
    }
    if (i < a.profiles.size()) {
      const Profile& profile = a.profiles[i];
      Json values = Json::array(), cost = Json::array();
      for (const double u : profile.u) values.push_back(p.from_unit(u));
      for (const double c : profile.cost) cost.push_back(number_json(c));
      j["profile"] = {{"interval_95", {profile.low, profile.high}},
                      {"values", values},
                      {"minus_twice_log_likelihood", cost}};
    }
    all.push_back(j);
  }
  return all;
}

Json goodness_json(const Study& study, const GoodnessOfFit& g) {
  Json j = {{"chi_square", number_json(g.chi_square)},
            {"degrees_of_freedom", g.freedom},
            {"probability", g.probability},
            {"acceptable", g.acceptable()}};
  for (std::size_t k = 0; k < g.z.size(); ++k)
    j["standardized_residuals"][study.targets[k].response.label] = number_json(g.z[k]);
  return j;
}

Json marginals_json(const Study& study, const std::vector<Marginal>& marginals) {
  Json j = Json::object();
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Marginal& m = marginals[i];
    j[study.parameters[i].name] = {{"median", m.median},
                                   {"interval_68", {m.low_68, m.high_68}},
                                   {"interval_95", {m.low, m.high}}};
  }
  return j;
}

Json curve_json(const CurveTarget& c, const CurveBasis& basis) {
  const auto list = [](const auto& v) { return std::vector<double>(v.begin(), v.end()); };
  Json components = Json::array();
  for (Eigen::Index k = 0; k < basis.components.cols(); ++k)
    components.push_back(list(Eigen::VectorXd(basis.components.col(k))));
  return {{"curve", c.label},
          {"unit", c.unit},
          {"x_unit", c.x_unit},
          {"uncertainty", c.uncertainty},
          {"explained_variance", basis.explained},
          {"simulated_rest", basis.simulated_rest},
          {"single_run_rest", basis.run_rest},
          {"recorded_rest", basis.recorded_rest},
          {"x", list(c.x)},
          {"recorded", list(c.y)},
          {"simulated_mean", list(basis.mean)},
          {"components", components}};
}

Json choices_json(const Study& study, const CalibrationResult& a) {
  Json all = Json::array();
  for (const ChoiceOutcome& c : a.choices) {
    Json j = {{"choice", c.label},
              {"prior", c.prior},
              {"probability", c.probability ? number_json(*c.probability) : nullptr},
              {"verdict", to_string(c.verdict)},
              {"headline", c.headline}};
    if (c.goodness) j["goodness_of_fit"] = goodness_json(study, *c.goodness);
    if (!c.best.empty()) j["estimate"] = named_values(study, c.best);
    if (!c.marginals.empty()) j["parameters"] = marginals_json(study, c.marginals);
    all.push_back(j);
  }
  return {{"parameter", study.choice->name},
          {"keys", study.choice->keys},
          {"best", a.choices[a.best_choice].label},
          {"choices", all}};
}

Json combinations_json(const Study& study, const CalibrationResult& a) {
  Json all = Json::array();
  for (const Combination& c : a.combinations) {
    Json terms = Json::array();
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      terms.push_back({{"parameter", study.parameters[i].name},
                       {"of", study.parameters[i].logarithmic ? "logarithm" : "value"},
                       {"coefficient", c.coefficients[static_cast<Eigen::Index>(i)]}});
    Json j = {{"identifiable", c.identifiable},
              {"terms", terms},
              {"value", c.identifiable ? number_json(c.value) : nullptr},
              {"uncertainty", c.identifiable ? number_json(c.uncertainty()) : nullptr},
              {"uncertainty_near_estimate", c.identifiable ? number_json(c.sd) : nullptr},
              {"spread_over_posterior", c.spread},
              {"singular_value", c.singular_value}};
    if (c.identifiable) j["split"] = split_json(c.split);
    all.push_back(j);
  }
  return all;
}

Json distribution_json(const PredictiveDistribution& d) {
  return {{"quantiles", d.quantiles},
          {"histogram", {{"edges", d.edges}, {"probability", d.probability}}}};
}

Json targets_json(const Study& study, const CalibrationResult& a) {
  Json all = Json::array();
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    Json j = {{"response", t.response.label},
              {"value", t.value},
              {"uncertainty", t.uncertainty},
              {"unit", t.unit},
              {"source", t.source}};
    if (t.discrepancy > 0) j["discrepancy"] = t.discrepancy;
    if (a.models)
      j["reach"] = {{"lowest", a.reach[k].lowest},
                    {"highest", a.reach[k].highest},
                    {"bracketed", a.reach[k].bracketed},
                    {"reachable", a.reach[k].reachable}};
    if (k < a.split.size()) {
      j["uncertainty_at_estimate"] = split_json(a.split[k]);
      j["other_surrogate_at_estimate"] = a.cross_check[k];
    }
    if (k < a.predictive.size() && a.predictive[k])
      j["posterior_predictive"] = {
          {"probabilities", predictive_probabilities},
          {"mean_response", distribution_json(a.predictive[k]->mean_response)},
          {"single_run", distribution_json(a.predictive[k]->single_run)}};
    all.push_back(j);
  }
  return all;
}

Json sensitivity_json(const Study& study, const CalibrationResult& a) {
  Json all = Json::array();
  for (const Sensitivity& s : a.sensitivity) {
    Json j = {{"response", s.response}, {"noise_share", number_json(s.noise_share)}};
    for (std::size_t i = 0; i < study.parameters.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      j["parameters"][study.parameters[i].name] = {
          {"first", s.indices.first[k]},
          {"first_interval_95", {s.indices.first_interval(k, 0), s.indices.first_interval(k, 1)}},
          {"total", s.indices.total[k]},
          {"total_interval_95", {s.indices.total_interval(k, 0), s.indices.total_interval(k, 1)}}};
    }
    all.push_back(j);
  }
  return all;
}

Json history_json(const Study& study, const CalibrationResult& a) {
  Json all = Json::array();
  for (const EstimateRound& round : a.estimate_history) {
    all.push_back({{"after", round.after},
                   {"runs", round.runs},
                   {"parameters", marginals_json(study, round.marginals)}});
  }
  return all;
}

Json numerics_json(const CalibrationResult& a) {
  Json all = Json::array();
  for (const NumericsOutcome& n : a.numerics) {
    Json shifts = Json::object();
    for (const NumericsOutcome::Shift& s : n.shifts)
      shifts[s.response] = {
          {"shift", s.value}, {"standard_error", number_json(s.standard_error)}, {"unit", s.unit}};
    all.push_back({{"name", n.name}, {"shifts", shifts}});
  }
  return all;
}

Json advice_json(const CalibrationResult& a) {
  Json all = Json::array();
  for (const MeasurementValue& m : a.advice) {
    Json j = {{"response", m.response.label},      {"repeats_a_target", m.repeats_a_target},
              {"uncertainty", m.uncertainty},      {"unit", m.unit},
              {"information_bits", m.information}, {"remaining_extent", m.remaining_extent}};
    if (m.discrepancy > 0) j["discrepancy"] = m.discrepancy;
    if (m.effort > 0) j["effort_seconds"] = m.effort;
    all.push_back(j);
  }
  return all;
}

}  // namespace

std::string render_json(const Study& study, const CalibrationResult& a) {
  Json j = {{"study", study.name},
            {"verdict", to_string(a.verdict)},
            {"headline", a.headline},
            {"firn_version", firn_version()},
            {"git_commit", firn_git_commit()},
            {"contact_model", kContactModel},
            {"targets", targets_json(study, a)},
            {"parameters", parameters_json(study, a)}};
  if (!a.choices.empty()) j["choice"] = choices_json(study, a);
  for (std::size_t i = 0; i < a.curves.size(); ++i)
    j["curves"].push_back(curve_json(study.curves[i], a.curves[i]));
  for (const Prior& prior : study.priors) {
    Json names = Json::array();
    for (const std::size_t i : prior.parameters) names.push_back(study.parameters[i].name);
    j["priors"].push_back({{"parameters", names}, {"prior", prior.text}});
  }
  for (const Constraint& c : study.constraints.all) j["constraints"].push_back(c.rule);
  j["cautions"] = a.caveats;
  j["outliers"] = Json::array();
  for (const OutlierRun& o : a.outliers)
    j["outliers"].push_back({{"response", o.response.label},
                             {"parameters", named_values(study, a.points[o.point].values)},
                             {"seed", a.points[o.point].seeds[o.seed]},
                             {"value", o.value},
                             {"median_of_other_seeds", o.others}});
  if (!a.best.values.empty()) j["estimate"] = checked_json(study, a.best);
  if (a.goodness) j["goodness_of_fit"] = goodness_json(study, *a.goodness);
  if (a.without_priors)
    j["goodness_of_fit_without_priors"] = goodness_json(study, *a.without_priors);
  if (a.posterior)
    j["posterior"] = {{"samples", a.posterior->u.size()},
                      {"effective_samples", a.posterior->effective_samples},
                      {"file", "posterior.csv"}};
  j["estimate_history"] = history_json(study, a);
  j["combinations"] = combinations_json(study, a);
  j["ridge"] = Json::array();
  for (const CheckedSet& set : a.ridge) j["ridge"].push_back(checked_json(study, set));
  j["compare"] = Json::array();
  for (const CheckedSet& set : a.compare) j["compare"].push_back(checked_json(study, set));
  j["sensitivity"] = sensitivity_json(study, a);
  j["numerics"] = numerics_json(a);
  j["measure_next"] = advice_json(a);
  if (a.direct)
    j["direct_search"] = {{"search", to_string(study.direct)},
                          {"evaluations", a.direct->evaluations},
                          {"best_observed_distance", number_json(a.direct->best_observed)},
                          {"confirmed_distance", number_json(a.direct->confirmed)}};
  if (a.budget_runs > 0)
    j["budget"] = {{"runs", a.budget_runs},
                   {"reused", a.reused},
                   {"left", a.budget_left},
                   {"left_because", a.left_because}};
  if (!a.stopped.empty()) j["refinement"] = {{"rounds", a.rounds}, {"stopped", a.stopped}};
  j["models"] = Json::array();
  if (a.models) {
    for (const ResponseModel& m : a.models->targets) j["models"].push_back(model_json(m));
    for (const ResponseModel& m : a.models->observed) j["models"].push_back(model_json(m));
  }
  j["runs"] = {
      {"total", a.runs},      {"finished", a.finished},   {"arched", a.arched},
      {"failed", a.failed},   {"timed_out", a.timed_out}, {"out_of_memory", a.out_of_memory},
      {"crashed", a.crashed}, {"cut_short", a.cut_short}, {"by_another_version", a.other_version}};
  j["wall_seconds"] = a.wall;
  return j.dump(2);
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
