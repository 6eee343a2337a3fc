// What an accelerometer on a part that gives way would read, and channel filters for such traces.
#pragma once

#include <vector>

#include "experiments/case.h"
#include "experiments/response.h"

namespace firn {

class Recording;

// The filter of channel frequency class `cfc` (Hz) of SAE J211-1, annex C: a Butterworth filter of
// two poles, run forwards and backwards, so that nothing is delayed. -3 dB at 1.65 cfc. Samples are
// `interval` s apart; the standard asks for at least ten in a period of the class. The ends count
// as if the trace went on with its first and last value.
std::vector<double> channel_filter(const std::vector<double>& samples, double interval, double cfc);
inline constexpr double kSamplesPerClass = 10;

// Of every measure of the kind `accelerometer`: largest magnitudes of the filtered acceleration,
// from the rates of neighbouring frames, of the filtered contact force along the axis, and of
// acceleration times the mass of a particle.
std::vector<Response> accelerometer_responses(const Recording& recording, const Case& c);

}  // namespace firn
