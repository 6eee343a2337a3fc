#include "experiments/responses/response_order.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "experiments/text/units.h"

namespace firn {
namespace {

// Names of the responses of a measure without its prefix: those that lead, and those that follow
// after the counts of the case.
struct MeasureNames {
  std::vector<std::string> leading, following;
};

MeasureNames names_of_kind(Measure::Kind kind) {
  switch (kind) {
    case Measure::Kind::slip:
      return {{"slide_angle", "tip_angle"}, {"slid", "tipped"}};
    case Measure::Kind::slide:
      return {{"sliding_acceleration"}, {"slide_time", "slide_distance", "passed"}};
    case Measure::Kind::rebound:
      return {{"restitution"}, {"rebound_height", "drop_height", "landed"}};
    case Measure::Kind::heap:
      return {{"heap_angle"}, {"heap_height", "heap_count", "heap_mass"}};
    case Measure::Kind::accelerometer:
      return {{"contact_force_peak"}, {"acceleration_peak"}};
    case Measure::Kind::drum:
      return {{"drum_angle"}, {"drum_angle_scatter", "drum_mass_angle"}};
    case Measure::Kind::curve:
      return {{"curve_x", "curve_y"}, {"curve_y_min", "curve_y_max"}};
    case Measure::Kind::load:
      return {{"load_peak"}, {"load_mean"}};
    case Measure::Kind::above:
      return {{"above_count"}, {"below_count", "above_force"}};
  }
  return {};
}

// The sensors of the case, those first for which a stage waits.
std::vector<std::string> sensor_names(const Case& c) {
  std::vector<std::string> names;
  for (const bool awaited : {true, false})
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
      const bool waits = std::ranges::any_of(c.stages, [&](const Stage& s) {
        return s.ends_on(Stage::EndEvent::passed) && s.sensor == static_cast<int>(i);
      });
      if (waits == awaited) names.push_back(c.sensors[i].name);
    }
  return names;
}

// The names of the main responses of a case, most informative first. Responses that are undefined
// in a run, and those of earlier versions, may be missing in its results.
class MainNames {
 public:
  explicit MainNames(const Case& c) {
    if (c.drained_repose) add_all("", {"angle_of_repose", "arched"});
    for (const Measure& m : c.measures) add_all(m.prefix(), names_of_kind(m.kind).leading);
    for (const Inlet& inlet : c.inlets) add_all(inlet.name, {"_batches", "_batches_released"});
    const std::vector<std::string> sensors = sensor_names(c);
    for (const std::string& sensor : sensors) add(sensor + "_count");
    for (const Stage& stage : c.stages) add_all(stage.name, {"_stalled", "_time_to_count"});
    if (c.drained_repose) add_all("", {"discharge_time", "remaining_count", "discharge_rate"});
    add("bonds_broken_count");
    for (const std::string& sensor : sensors) add_all(sensor, {"_mass_flow", "_residence_time"});
    for (const Measure& m : c.measures) add_all(m.prefix(), names_of_kind(m.kind).following);
    for (const MotionFrame& frame : c.model.frames) add(frame.name + "_largest_motor_load");
    for (const MotionFrame& frame : c.model.frames)
      add_all(frame.name, {"_coordinate_end", "_largest_force"});
    for (const Stage& stage : c.stages) add("duration_" + stage.name);
    add_all("", {"peak_normal_force", "largest_compressive_load", "bulk_density", "present_count"});
  }

  // Position of a name; none of them: their number.
  std::size_t rank(const std::string& name) const {
    const auto found = rank_.find(response_name(name));
    return found == rank_.end() ? rank_.size() : found->second;
  }
  bool contains(const std::string& name) const { return rank(name) < rank_.size(); }

 private:
  void add(const std::string& name) { rank_.emplace(response_name(name), rank_.size()); }
  void add_all(const std::string& prefix, const std::vector<std::string>& endings) {
    for (const std::string& ending : endings) add(prefix + ending);
  }

  std::map<std::string, std::size_t> rank_;
};

// Whether all values are 0 as resolved() shows them, or undefined where `or_undefined` says so.
bool is_zero(const Response& r, bool or_undefined = false) {
  const double least = resolution(r.unit);
  return std::ranges::all_of(r.value, [&](double v) {
    return v == 0 || std::abs(v) < least || (or_undefined && !std::isfinite(v));
  });
}

bool has_measured_nothing(const Response& r) { return r.name != "arched" && is_zero(r, true); }

// Names of the censored times of sensors that no particle has passed: they list all particles.
std::vector<std::string> censored_times_without_passage(const std::vector<Response>& responses,
                                                        const Case& c) {
  std::vector<std::string> names;
  for (const Sensor& sensor : c.sensors) {
    const std::string prefix = response_name(sensor.name);
    if (std::ranges::any_of(responses, [&](const Response& r) {
          return r.name == prefix + "_count" && is_zero(r);
        }))
      names.push_back(prefix + "_censored_times");
  }
  return names;
}

}  // namespace

std::vector<Response> in_display_order(std::vector<Response> responses, const Case& c) {
  const MainNames main(c);
  const std::vector<std::string> censored = censored_times_without_passage(responses, c);
  std::vector<std::pair<std::pair<bool, std::size_t>, Response>> ranked;
  ranked.reserve(responses.size());
  for (Response& r : responses) {
    const bool is_last =
        has_measured_nothing(r) || std::ranges::find(censored, r.name) != censored.end();
    const std::size_t rank = main.rank(r.name);
    ranked.emplace_back(std::pair(is_last, rank), std::move(r));
  }
  std::ranges::stable_sort(ranked, {}, [](const auto& one) { return one.first; });
  for (std::size_t i = 0; i < ranked.size(); ++i) responses[i] = std::move(ranked[i].second);
  return responses;
}

std::vector<Response> main_responses(const std::vector<Response>& responses, const Case& c,
                                     std::size_t most) {
  const MainNames main(c);
  std::vector<Response> found = in_display_order(responses, c);
  std::erase_if(found, [&](const Response& r) {
    return !main.contains(r.name) || r.value.size() != 1 || !std::isfinite(r.value[0]) ||
           has_measured_nothing(r);
  });
  found.resize(std::min(found.size(), most));
  return found;
}

}  // namespace firn
