// Channel filters for traces of forces and accelerations.
#pragma once

#include <vector>

namespace firn {

// Filter of the channel frequency class `cfc` (Hz) according to SAE J211-1, annex C: a two-pole
// Butterworth filter, applied forwards and backwards for zero phase shift. -3 dB at 1.65 cfc.
// `interval` (s): time between two samples; the standard requires at least ten samples per period
// of the class. The trace is continued with its first and last value beyond its ends.
std::vector<double> channel_filter(const std::vector<double>& samples, double interval, double cfc);
inline constexpr double kSamplesPerClass = 10;

}  // namespace firn
