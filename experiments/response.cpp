#include "experiments/response.h"

#include <algorithm>
#include <cmath>

#include "experiments/drained_repose_responses.h"
#include "experiments/recording.h"

namespace firn {
namespace {

// What every case can be asked.
std::vector<Response> general_responses(const Recording& recording) {
  std::vector<Response> out;
  const std::vector<double> times = recording.frame_times();
  if (times.empty()) return out;
  const Frame last = recording.frame(times.size() - 1);
  const std::vector<double> mass = recording.mass();
  double count = 0, total = 0;
  for (std::size_t k = 0; k < mass.size(); ++k) {
    if (!std::isfinite(last.position[k][0])) continue;
    count += 1;
    total += mass[k];
  }
  const std::string present = "particles that exist in the last frame";
  out.push_back({"present_count", {count}, {0.0}, "1", present, 1});
  out.push_back({"present_mass", {total}, {0.0}, "kg", present, 1});
  out.push_back({"kinetic_energy_end",
                 {recording.series("/energy/kinetic").back()},
                 {},
                 "J",
                 "translation and rotation in the last frame",
                 1});
  const std::vector<double> peaks = recording.peak_normal_force();
  if (!peaks.empty()) {
    out.push_back({"peak_normal_force",
                   {*std::max_element(peaks.begin(), peaks.end())},
                   {},
                   "N",
                   "largest contact normal force on any particle over every step",
                   1});
  }
  return out;
}

}  // namespace

std::vector<Response> measure(const Recording& recording) {
  const Case c = recording.read_case();
  std::vector<Response> responses = general_responses(recording);
  if (c.drained_repose) {
    const auto more = drained_repose_responses(drained_heap(recording, c));
    responses.insert(responses.end(), more.begin(), more.end());
  }
  return responses;
}

}  // namespace firn
