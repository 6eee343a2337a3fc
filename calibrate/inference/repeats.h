// Selects points for second runs in a study with one run per point, when its noise may be
// underestimated.
#pragma once

#include <vector>

#include "calibrate/inference/response_model.h"

namespace firn {

// Whether points with one run each are farther from the models of a target, each predicted by the
// others, than both the noise between seeds and the uncertainty of the measurement explain. Then
// either the model fits badly, or the noise is larger there than where seeds were repeated.
bool scatter_exceeds_noise(const Study& study, const ResponseModels& models);

// Whether the pooled noise of a target exceeds the uncertainty of its measurement.
bool noise_exceeds_measurement(const Study& study, const ResponseModels& models);

// Indices of points within the ranges that have one run and a value for every target: at most
// `most`, those that meet the targets best by the models. The choice does not depend on the
// residual of the run of a point, so that the scatter of second runs is an unbiased estimate.
std::vector<std::size_t> points_to_repeat(const Study& study, const ResponseModels& models,
                                          const std::vector<Point>& points, std::size_t most);

}  // namespace firn
