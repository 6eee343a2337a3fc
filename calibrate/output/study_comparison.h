// Two finished studies side by side: where their posteriors agree.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct ParameterComparison {
  std::string name, unit;
  struct Side {
    double estimate = 0;  // NaN: none
    double low = 0, median = 0, high = 0;
  };
  Side a, b;
  // Share of probability that both posteriors have in common: 1 for the same, 0 for separate ones.
  double overlap = 0;
  double a_above_b = 0;  // probability
};

struct StudyComparison {
  std::string study_a, study_b;                 // names
  std::string verdict_a, verdict_b;             // as in results.json
  std::vector<ParameterComparison> parameters;  // of the same name and unit in both
  // Squared distance of the means by the sum of the covariances of these parameters, and the
  // probability of a larger distance between two Gaussian estimates of the same parameters.
  double chi_square = 0, probability = 0;
  std::vector<std::string> only_a, only_b;  // parameters
};

// From the folders of two studies. Throws InputError where one holds no posterior, or where they
// have no parameter in common.
StudyComparison compare_studies(const std::string& folder_a, const std::string& folder_b);

std::string comparison_table(const StudyComparison& c);
std::string comparison_json(const StudyComparison& c);

}  // namespace firn
