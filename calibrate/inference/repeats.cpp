#include "calibrate/inference/repeats.h"

#include <algorithm>
#include <cmath>

namespace firn {

bool scatter_exceeds_noise(const Study& study, const ResponseModels& models) {
  constexpr double clearly_more = 2;  // standard deviations of the noise, root mean square
  constexpr int enough = 5;           // points
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const ResponseModel& m = models.targets[k];
    const Eigen::VectorXd errors = m.surrogate.best.leave_one_out_errors();
    double squares = 0, noise = 0;
    int count = 0;
    for (std::size_t i = 0; i < m.samples.size(); ++i) {
      if (m.samples[i].count != 1) continue;
      squares += std::pow(errors[static_cast<Eigen::Index>(i)], 2);
      noise += std::pow(m.noise.at(m.samples[i].mean), 2);
      ++count;
    }
    if (count >= enough && squares > clearly_more * clearly_more * noise &&
        squares > count * study.targets[k].variance())
      return true;
  }
  return false;
}

bool noise_exceeds_measurement(const Study& study, const ResponseModels& models) {
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    if (models.targets[k].noise.at(t.value) > t.sd()) return true;
  }
  return false;
}

std::vector<std::size_t> points_to_repeat(const Study& study, const ResponseModels& models,
                                          const std::vector<Point>& points, std::size_t most) {
  const NegativeLogPosterior misfit(study, models);
  std::vector<std::pair<double, std::size_t>> candidates;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    if (p.seeds.size() != 1 || p.u.minCoeff() < 0 || p.u.maxCoeff() > 1) continue;
    if (std::any_of(study.targets.begin(), study.targets.end(),
                    [&](const Target& t) { return p.finished(t.response).empty(); }))
      continue;
    candidates.emplace_back(misfit.cost(p.u), i);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < candidates.size() && i < most; ++i)
    chosen.push_back(candidates[i].second);
  return chosen;
}

}  // namespace firn
