// The method of the calibration, step by step; docs/calibration.md explains it.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "calibrate/answer.h"
#include "calibrate/campaign.h"
#include "calibrate/progress.h"
#include "calibrate/study_file.h"

namespace firn {

// A pure function of the study and of the results of its runs: nothing
// here remembers anything from one session to the next.
class Calibration {
 public:
  Calibration(const Study& study, Campaign& campaign, StudyProgress& progress)
      : study_(study), campaign_(campaign), progress_(progress) {}

  Answer answer() {
    explore();
    for (int round = 0; round <= study_.budget.refine_rounds; ++round) {
      if (!fit()) return finish();
      if (round < study_.budget.refine_rounds) refine(round);
    }
    describe_fit();
    confirm();
    check_valley_ends();
    return finish();
  }

 private:
  void explore();
  bool fit();
  void refine(int round);
  void describe_fit();
  void confirm();
  void check_valley_ends();
  Answer finish();

  CheckedSet checked(const std::string& name, const Point& point) const;
  void observe(const Point& point, CheckedSet& set) const;
  double standard_error(const std::string& response, const Sample& s) const;
  bool agrees(const CheckedSet& set) const;
  std::string parameter_text(const std::vector<double>& values) const;
  std::string range_text() const;

  const Study& study_;
  Campaign& campaign_;
  StudyProgress& progress_;
  Answer a_;
  Eigen::VectorXd best_;  // unit cube
};

}  // namespace firn
