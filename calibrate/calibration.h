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

// A pure function of the study and of the results of its runs: nothing
// here remembers anything from one session to the next.
class Calibration {
 public:
  Calibration(const Study& study, Campaign& campaign, BatchProgress& progress)
      : study_(study), campaign_(campaign), progress_(progress) {}

  Answer answer() {
    explore();
    bool fitted = fit();
    while (!fitted && explore_further()) fitted = fit();
    while (fitted && worth_refining()) {
      refine();
      fitted = fit();
    }
    if (fitted) {
      choose_answer();
      confirm();
      check_valley_ends();
      describe_knowledge();
    }
    return finish();
  }

 private:
  void explore();
  std::vector<Point> reused_points();
  void spread_design();
  bool quiet() const;
  bool explore_further();
  void check_outliers();
  bool fit();
  void record_estimate(const std::string& after);
  void judge_fit();
  bool simulated_nearby(const Eigen::VectorXd& u) const;
  int seeds_left() const;
  int seeds_reserved() const;
  void report_estimate() const;
  bool worth_refining();
  void refine();
  void choose_answer();
  void decide_whether_determined();
  void confirm();
  void check_valley_ends();
  void describe_knowledge();
  Answer finish();

  void compare_numerics();
  CheckedSet checked(const std::string& name, const Point& point) const;
  bool agrees(const CheckedSet& set) const;
  std::string misfit_text() const;
  std::string failure_text() const;
  void account_for_budget();

  const Study& study_;
  Campaign& campaign_;
  BatchProgress& progress_;
  Answer a_;
  std::vector<Point> numerics_;
  Eigen::VectorXd best_;      // unit cube
  int seeds_each_ = 1;        // at each point of the design and of the refinement
  std::size_t reused_ = 0;    // points
  int more_points_ = 1;       // times as many as planned
  bool budget_used_ = false;  // refinement ended for want of runs
};

// Fills in what the runs of a point gave; `knowledge` (may be null) has the noise.
void observe(const Study& study, const Knowledge* knowledge, const Point& point, CheckedSet& set);
// "ice_ice = 0.094, ice_plastic = 0.085"
std::string parameter_text(const Study& study, const std::vector<double>& values);
// `count` seeds from `first` on.
std::vector<std::uint64_t> seed_range(std::uint64_t first, int count);
// Seeds of the confirmation start this far above the study's: never used before.
constexpr std::uint64_t confirm_seeds = 1000;

}  // namespace firn
