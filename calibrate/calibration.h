// The method of the calibration, step by step; docs/calibration.md explains it.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_file.h"
#include "calibrate/study/study_runs.h"
#include "experiments/batch/progress.h"

namespace firn {

// Phase of the runs of a [[compare]] set, before its name.
inline constexpr const char* kComparePhase = "compare: ";

// A pure function of the study and of the results of its runs. No state is kept between sessions.
class Calibration {
 public:
  Calibration(const Study& study, StudyRuns& study_runs, BatchProgress& progress)
      : study_(study), study_runs_(study_runs), progress_(progress) {}

  CalibrationResult result() {
    make_runs();
    return conclude({});
  }
  // The two steps of it. `elsewhere` are the points of the other choices of the study.
  void make_runs() {
    run_initial_design();
    if (!define_scores()) return;
    fitted_ = fit();
    while (!fitted_ && extend_design()) fitted_ = fit();
    while (fitted_ && should_refine()) {
      refine();
      fitted_ = fit();
    }
    if (!fitted_) return;
    choose_estimate();
    confirm();
    check_ridge_ends();
  }
  CalibrationResult conclude(const std::vector<Point>& elsewhere) {
    if (fitted_) summarize_posterior(elsewhere);
    return finish();
  }
  const std::vector<Point>& points() const { return a_.points; }

 private:
  void run(std::vector<Point>& points);
  bool define_scores();
  void run_initial_design();
  std::vector<Point> reused_points();
  std::vector<std::uint64_t> unused_seeds(int count);
  void space_filling_design();
  std::vector<Point> in_both_forms(std::vector<Point> design) const;
  bool noise_is_negligible() const;
  bool extend_design();
  void check_outliers();
  void run_more_seeds(const std::string& phase, const std::vector<std::size_t>& points,
                      const std::vector<int>& seeds);
  bool repeat_points();
  bool fit();
  void record_estimate(const std::string& after);
  void judge_fit();
  bool has_run_near(const Eigen::VectorXd& u) const;
  bool is_bias_dominant() const;
  void describe_fidelity();
  int seeds_left() const;
  int seeds_reserved() const;
  void report_estimate() const;
  bool should_refine();
  void refine();
  void choose_estimate();
  void judge_identifiability();
  void confirm();
  void check_ridge_ends();
  void summarize_posterior(const std::vector<Point>& elsewhere);
  CalibrationResult finish();

  void compare_sets();
  void compare_numerics();
  void analyze_sensitivity();
  std::string headline() const;
  CheckedSet checked(const std::string& name, const Point& point) const;
  bool agrees(const CheckedSet& set) const;
  std::string misfit_text() const;
  std::string failure_text() const;
  void account_for_budget();

  Study study_;  // with the targets that its curves become
  StudyRuns& study_runs_;
  BatchProgress& progress_;
  CalibrationResult a_;
  std::vector<Point> numerics_;
  Eigen::VectorXd best_;                    // unit cube
  int replicates_per_point_ = 1;            // at each point of the design and of the refinement
  std::size_t reused_ = 0;                  // points
  std::optional<std::uint64_t> next_seed_;  // unused, of the design and what follows it
  int point_multiplier_ = 1;                // factor on the planned number of points
  bool repeated_ = false;     // points with one run have been repeated, to estimate their noise
  bool budget_used_ = false;  // refinement ended because the budget was used
  bool fitted_ = false;
};

// Fills in the responses of the runs of a point. `fitted` (may be null) has the noise.
void observe(const Study& study, const ResponseModels* models, const Point& point, CheckedSet& set);
// "ice_ice = 0.094, ice_plastic = 0.085"
std::string parameter_text(const Study& study, const std::vector<double>& values);
// Offset of the confirmation seeds from the seed of the study: these seeds have not been used
// before.
constexpr std::uint64_t confirm_seeds = 1000;
// The same of the points of the design and the refinement.
constexpr std::uint64_t design_seeds = 10000;

}  // namespace firn
