#include "experiments/responses/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/responses/above_responses.h"
#include "experiments/responses/accelerometer_responses.h"
#include "experiments/responses/bin_heap_responses.h"
#include "experiments/responses/contact_statistics_responses.h"
#include "experiments/responses/curve_responses.h"
#include "experiments/responses/drained_repose_responses.h"
#include "experiments/responses/drum_responses.h"
#include "experiments/responses/load_responses.h"
#include "experiments/responses/process_responses.h"
#include "experiments/responses/single_body_responses.h"
#include "experiments/results/bond_results.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

// How soft the contacts were in the last stage, as part of the smallest edge of any particle.
void add_overlaps(const Recording& recording, const Case& c, std::vector<Response>& out) {
  const std::vector<StageRecord> stages = recording.stages();
  const double start = stages.empty() ? 0 : stages.back().start;
  double edge = std::numeric_limits<double>::infinity();
  for (const Particle& p : c.model.particles)
    edge = std::min(edge, c.model.shapes[static_cast<std::size_t>(p.shape)].box.minCoeff());
  const auto mean_of = [&](const std::string& path) {
    const std::vector<double> times = recording.frame_times(), values = recording.series(path);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] < start || !std::isfinite(values[i])) continue;
      sum += values[i];
      count += 1;
    }
    return sum / count / edge;
  };
  const char* const method = "part of the thickness; mean over the frames of the last stage";
  const double median = mean_of("/diagnostics/overlap_median"),
               most = mean_of("/diagnostics/overlap_p99");
  if (!std::isfinite(median)) return;  // nothing ever touched
  out.push_back({"contact_overlap_median", {median}, {}, "1", method, 1});
  out.push_back({"contact_overlap_p99", {most}, {}, "1", method, 1});
}

// What every case can be asked.
std::vector<Response> general_responses(const Recording& recording, const Case& c) {
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
  add_overlaps(recording, c, out);
  const std::vector<double> peaks = recording.peak_normal_force();
  if (!peaks.empty() && statistics_began(recording, c)) {
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
  return measure(recording, read_case(recording));
}

std::vector<Response> measure(const Recording& recording, const Case& c) {
  if (c.model.particles.size() != recording.particle_count()) {
    throw InputError(
        fmt::format("{}: holds {} particles and a case of {}; expected a file written "
                    "by firn run",
                    recording.file(), recording.particle_count(), c.model.particles.size()));
  }
  std::vector<Response> responses = general_responses(recording, c);
  const auto append = [&](const std::vector<Response>& more) {
    responses.insert(responses.end(), more.begin(), more.end());
  };
  if (c.drained_repose) append(drained_repose_responses(drained_heap(recording, c)));
  append(body_responses(recording, c));
  append(bin_heap_responses(recording, c));
  append(drum_responses(recording, c));
  append(process_responses(recording, c));
  append(bond_responses(recording, c));
  append(accelerometer_responses(recording, c));
  append(curve_responses(recording, c));
  append(load_responses(recording, c));
  append(above_responses(recording, c));
  append(statistics_responses(recording, c));
  return responses;
}

}  // namespace firn
