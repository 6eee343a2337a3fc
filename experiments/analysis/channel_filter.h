// Channel filters for traces of forces and accelerations.
#pragma once

#include <vector>

namespace firn {

// The filter of channel frequency class `cfc` (Hz) of SAE J211-1, annex C: a Butterworth filter of
// two poles, run forwards and backwards, so that nothing is delayed. -3 dB at 1.65 cfc. Samples are
// `interval` s apart; the standard requires at least ten in a period of the class. The ends count
// as if the trace went on with its first and last value.
std::vector<double> channel_filter(const std::vector<double>& samples, double interval, double cfc);
inline constexpr double kSamplesPerClass = 10;

}  // namespace firn
