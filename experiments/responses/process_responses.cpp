#include "experiments/responses/process_responses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "experiments/analysis/line_fit.h"
#include "experiments/responses/contact_statistics_responses.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

struct Out {
  std::vector<Response> responses;
  void add(const std::string& name, std::vector<double> value, const char* unit,
           const char* method) {
    responses.push_back({response_name(name), std::move(value), {}, unit, method, 1});
  }
};

// Of the values by key: the mean and the number of each, keys ascending from the first to the last.
struct Grouped {
  std::vector<double> count, mean;
};
Grouped grouped(const std::vector<int>& keys, const std::vector<double>& values) {
  std::map<int, std::pair<double, double>> sums;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    auto& [count, sum] = sums[keys[i]];
    if (std::isnan(values[i])) continue;
    count += 1;
    sum += values[i];
  }
  Grouped g;
  for (const auto& [key, one] : sums) {
    g.count.push_back(one.first);
    g.mean.push_back(one.second / one.first);  // NaN: none yet
  }
  return g;
}

// Tendency of older particles to pass before younger ones. Of the pairs that were inserted at
// different times and whose order of passing is known: those in which the older one passed first
// minus those in which the younger one did, as a share. Particles that have not passed will pass
// later than those that have.
double order_index(const std::vector<double>& inserted, const std::vector<double>& passed) {
  double older_first = 0, younger_first = 0;
  const auto later = [](double a, double b) { return std::isnan(a) ? !std::isnan(b) : a > b; };
  for (std::size_t i = 0; i < passed.size(); ++i)
    for (std::size_t j = 0; j < passed.size(); ++j) {
      if (!(inserted[i] < inserted[j])) continue;
      older_first += later(passed[j], passed[i]);
      younger_first += later(passed[i], passed[j]);
    }
  return (older_first - younger_first) / (older_first + younger_first);  // NaN: no such pairs
}

// How far the first half of those that passed is made up by batch as all that came: 1 less the
// share that would have to be exchanged.
struct FirstHalf {
  double similarity = 0;
  double at_random = 0, by_age = 0;  // what it would be drawn at random, and in strict order of age
};

double similarity(const std::map<int, double>& all, const std::map<int, double>& part) {
  double n = 0, m = 0, exchanged = 0;
  for (const auto& [batch, count] : all) n += count;
  for (const auto& [batch, count] : part) m += count;
  for (const auto& [batch, count] : all) {
    const auto found = part.find(batch);
    exchanged += std::abs((found == part.end() ? 0 : found->second / m) - count / n) / 2;
  }
  return 1 - exchanged;
}

// Expectation for `drawn` of all, without replacement: the counts are hypergeometric.
double similarity_at_random(const std::map<int, double>& all, double drawn) {
  double n = 0, exchanged = 0;
  for (const auto& [batch, count] : all) n += count;
  const auto choose = [](double from, double k) {
    return std::lgamma(from + 1) - std::lgamma(k + 1) - std::lgamma(from - k + 1);
  };
  for (const auto& [batch, count] : all)
    for (double k = std::max(0.0, drawn - (n - count)); k <= std::min(count, drawn); ++k) {
      const double p = std::exp(choose(count, k) + choose(n - count, drawn - k) - choose(n, drawn));
      exchanged += p * std::abs(k / drawn - count / n) / 2;
    }
  return 1 - exchanged;
}

FirstHalf first_half(const std::vector<int>& batch, const std::vector<double>& passed) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < passed.size(); ++i)
    if (!std::isnan(passed[i])) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return passed[i]; });
  order.resize((order.size() + 1) / 2);
  if (order.empty()) return {kUndefined, kUndefined, kUndefined};
  std::map<int, double> all, part, oldest;
  for (const int b : batch) ++all[b];
  for (const std::size_t i : order) ++part[batch[i]];
  double left = static_cast<double>(order.size());
  for (const auto& [b, count] : all) {
    oldest[b] = std::min(left, count);
    left -= oldest[b];
  }
  return {similarity(all, part), similarity_at_random(all, static_cast<double>(order.size())),
          similarity(all, oldest)};
}

// Slope of the mass that has passed over time, between a fifth and four fifths of all passages:
// beginning and end of a discharge left out.
void add_flow(std::vector<std::pair<double, double>> passages, const std::string& name, Out& out) {
  constexpr std::size_t kFewest = 10;
  std::ranges::sort(passages);  // time in s, mass in kg
  std::vector<double> times, passed;
  double sum = 0;
  for (std::size_t i = 0; i < passages.size(); ++i) {
    sum += passages[i].second;
    if (5 * i < passages.size() || 5 * (i + 1) > 4 * passages.size()) continue;
    times.push_back(passages[i].first);
    passed.push_back(sum);
  }
  constexpr double kShortest = 1e-12;  // s: less is one instant
  if (times.size() < kFewest || times.back() - times.front() < kShortest) return;
  out.add(
      name + "mass_flow", {least_squares_line(times, passed).slope}, "kg/s",
      "line through the mass passed over time, between a fifth and four fifths of all passages");
}

// Of those that have not passed: until they left, or the run ended.
std::vector<double> censored_times(const Recording& recording, const std::vector<double>& passed) {
  const std::vector<double> came = recording.insert_time(), left = recording.exit_time();
  const double end = recording.frame_count() == 0 ? 0 : recording.frame_times().back();
  std::vector<double> censored;
  for (std::size_t i = 0; i < passed.size(); ++i)
    if (std::isnan(passed[i]) && !std::isnan(came[i]))
      censored.push_back((std::isnan(left[i]) ? end : left[i]) - came[i]);
  return censored;
}

// Of each column of each rule, in the order of the case: how many that carry its tag have passed. A
// column in which nothing lay counts 0.
void add_columns(const std::vector<TagRule>& rules, const std::vector<int>& tag,
                 const std::vector<double>& passed, const std::string& name, Out& out) {
  std::vector<double> count;
  for (const TagRule& rule : rules)
    for (int k = 0; k < rule.bins; ++k) {
      double through = 0;
      for (std::size_t i = 0; i < tag.size(); ++i)
        through += tag[i] == rule.first + k && !std::isnan(passed[i]) ? 1 : 0;
      count.push_back(through);
    }
  if (!count.empty())
    out.add(name + "count_by_column", std::move(count), "1",
            "one value for each column of [[tag_rules]], in order");
}

// `passed`: s, of each particle; NaN: not yet.
void add_since_stages(const std::vector<Stage>& stages, const std::vector<StageRecord>& begun,
                      const std::vector<double>& passed, const std::string& name, Out& out) {
  for (std::size_t k = 1; k < stages.size(); ++k)
    out.add(name + "count_since_" + stages[k].name, {count_since(begun, k, passed)}, "1",
            "particles whose center has passed the sensor since the stage began; undefined: it did "
            "not begin");
}

void add_sensor(const Recording& recording, const std::vector<StageRecord>& stages,
                const Sensor& sensor, const Case& c, Out& out) {
  const std::vector<double> passed = recording.sensor_time(sensor.name),
                            inserted = recording.insert_time(), mass = recording.mass();
  std::vector<int> batch = recording.batch(), tag = recording.tag();
  std::vector<double> times, residence, came, through;
  std::vector<std::pair<double, double>> passages;
  std::vector<int> batches, tags;
  double total = 0;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (std::isnan(inserted[i])) continue;
    batches.push_back(batch[i]);
    tags.push_back(tag[i]);
    residence.push_back(passed[i] - inserted[i]);
    came.push_back(inserted[i]);
    through.push_back(passed[i]);
    if (std::isnan(passed[i])) continue;
    times.push_back(passed[i]);
    passages.emplace_back(passed[i], mass[i]);
    total += mass[i];
  }
  const std::string name = sensor.name + "_";
  out.add(name + "count", {static_cast<double>(times.size())}, "1",
          "particles whose center has passed the sensor");
  add_since_stages(c.stages, stages, passed, name, out);
  out.add(name + "mass", {total}, "kg", "mass of the particles whose center has passed the sensor");
  if (!times.empty()) {
    const auto [first, last] = std::ranges::minmax(times);
    out.add(name + "first_time", {first}, "s", "time of the first passage");
    out.add(name + "last_time", {last}, "s", "time of the last passage");
    double sum = 0;
    for (double r : residence) sum += std::isnan(r) ? 0 : r;
    out.add(name + "residence_time", {sum / static_cast<double>(times.size())}, "s",
            "from insertion to the sensor; mean of those that have passed");
  }
  add_flow(std::move(passages), name, out);
  const Grouped by_batch = grouped(batches, residence), by_tag = grouped(tags, residence);
  const char* const rows = "one value for each number that occurs, ascending";
  out.add(name + "count_by_batch", by_batch.count, "1", rows);
  out.add(name + "residence_time_by_batch", by_batch.mean, "s", rows);
  out.add(name + "count_by_tag", by_tag.count, "1", rows);
  add_columns(c.tag_rules, tags, through, name, out);
  const bool all_passed = std::ranges::none_of(residence, [](double v) { return std::isnan(v); });
  out.add(name + "residence_times", residence, "s",
          all_passed ? "from insertion to the sensor, one value for each inserted particle"
                     : "from insertion to the sensor, one value for each inserted particle; "
                       "undefined ones: not passed yet");
  if (const std::vector<double> censored = censored_times(recording, passed); !censored.empty())
    out.add(name + "censored_times", censored, "s",
            "of those that have not passed: from insertion to the end of the run, or until they "
            "left by an outlet");
  out.add(name + "order_index", {order_index(came, through)}, "1",
          "1: the older always first, 0: no order by age, -1: the younger always first");
  const FirstHalf half = first_half(batches, through);
  out.add(
      name + "first_half_similarity", {half.similarity}, "1",
      "1 less the share of the first half through that would have to be exchanged to be made up "
      "by batch as all inserted particles");
  out.add(name + "first_half_similarity_at_random", {half.at_random}, "1",
          "its expectation for as many particles drawn at random");
  if (half.at_random > half.by_age)
    out.add(name + "mixing_index",
            {(half.similarity - half.by_age) / (half.at_random - half.by_age)}, "1",
            "similarity of the first half: 1 as drawn at random, 0 as in strict order of age");
}

void add_loads(const Recording& recording, const std::vector<double>& inserted, bool has_peaks,
               Out& out) {
  const std::vector<double> peaks = recording.peak_normal_force();
  std::vector<double> of_those_that_came;
  for (std::size_t i = 0; i < peaks.size(); ++i)
    if (!std::isnan(inserted[i])) of_those_that_came.push_back(peaks[i]);
  const std::vector<double> mass = recording.mass();
  double total = 0;
  for (std::size_t i = 0; i < mass.size(); ++i) total += std::isnan(inserted[i]) ? 0 : mass[i];
  if (!of_those_that_came.empty())
    out.add("mean_particle_mass", {total / static_cast<double>(of_those_that_came.size())}, "kg",
            "mean over all inserted particles");
  if (has_peaks)
    out.add("peak_normal_forces", of_those_that_came, "N",
            "largest contact normal force over every step, one value for each inserted particle");
}

void add_frame(const Recording& recording, const MotionFrame& frame, Out& out) {
  const std::string group = "/motion_frames/" + frame.name + "/", name = frame.name + "_";
  const auto largest = [&](const std::string& path) {
    const std::vector<double> v = recording.series(group + path);
    double most = 0;
    for (std::size_t i = 0; i + 2 < v.size(); i += 3)
      most = std::max(most, Vec3(v[i], v[i + 1], v[i + 2]).norm());
    return most;
  };
  const char* const of_frames = "largest magnitude of the means over output frames";
  out.add(name + "largest_force", {largest("force")}, "N", of_frames);
  out.add(name + "largest_torque", {largest("torque")}, "N m", of_frames);
  if (!frame.free || frame.free->joints.empty()) return;
  const std::size_t axes = frame.free->joints.size();
  const std::vector<double> at = recording.series(group + "coordinate"),
                            drive = recording.series(group + "motor_load");
  if (at.size() < axes) return;
  const bool turns = frame.free->joints[0].kind == Joint::Kind::rotation;
  out.add(name + "coordinate_end", {at[at.size() - axes]}, turns ? "rad" : "m",
          "of its first axis in the last frame");
  double most = 0;
  for (std::size_t i = 0; i < drive.size(); i += axes) most = std::max(most, std::abs(drive[i]));
  out.add(name + "largest_motor_load", {most}, turns ? "N m" : "N",
          "of its first axis; largest mean over an output frame");
  const std::string friction = group + "dissipated_friction";
  if (!recording.contains(friction)) return;
  const std::vector<double> dissipated = recording.series(friction);
  double sum = 0;
  for (std::size_t i = dissipated.size() - axes; i < dissipated.size(); ++i) sum += dissipated[i];
  out.add(name + "dissipated_joint_friction", {sum}, "J",
          "by friction of its joints from the start to the last frame");
}

void add_coupling_friction(const Recording& recording, const Coupling& coupling, Out& out) {
  const std::string path = "/couplings/" + coupling.name + "/dissipated_friction";
  if (!recording.contains(path) || recording.frame_count() == 0) return;
  out.add(coupling.name + "_dissipated_friction", {recording.series(path).back()}, "J",
          "by friction of the coupling from the start to the last frame");
}

// Whether all of an inlet's batch, whose first particle is this, are farther than a bounding radius
// from where they came, or gone.
bool has_left(const Inlet& source, std::size_t first, const Frame& last, const Model& model) {
  for (std::size_t i = 0; i < source.positions.size() && first + i < last.position.size(); ++i) {
    const auto& p = last.position[first + i];
    const auto shape = static_cast<std::size_t>(model.particles[first + i].shape);
    const double away = (Vec3(p[0], p[1], p[2]) - source.positions[i]).norm();
    if (away <= model.shapes[shape].bounding_radius) return false;  // NaN: gone
  }
  return true;
}

}  // namespace

std::vector<Response> process_responses(const Recording& recording, const Case& c) {
  Out out;
  if (c.sensors.empty() && c.limit_switches.empty() && c.inlets.empty() && c.model.frames.empty())
    return {};
  const std::vector<StageRecord> stages = recording.stages();
  for (const StageRecord& stage : stages) {
    if (!std::isfinite(stage.end)) continue;
    const double duration = stage.end - stage.start;
    out.add("duration_" + stage.name, {duration}, "s", "duration of the stage");
    const auto is_any = [&](const auto& has_property) {
      return std::ranges::any_of(
          c.stages, [&](const Stage& s) { return s.name == stage.name && has_property(s); });
    };
    if (is_any([](const Stage& s) { return s.ends_on(Stage::EndEvent::stalled); }))
      out.add(stage.name + "_stalled", {stage.end_reason.starts_with("stalled") ? 1.0 : 0.0}, "1",
              "1: a stalled motor, as in a jam, has ended the stage; 0: it has not");
    if (!is_any([](const Stage& s) { return s.count > 0; })) continue;
    const bool passed = stage.end_reason.starts_with("passed");
    out.add(stage.name + "_time_to_count", {passed ? duration : kUndefined}, "s",
            passed ? "until so many had passed the stage's sensor"
                   : "until so many had passed the stage's sensor; undefined: it ended before");
  }
  const std::vector<double> inserted = recording.insert_time();
  const std::size_t frames = recording.frame_count();
  const Frame last = frames > 0 ? recording.frame(frames - 1) : Frame{};
  std::size_t coming = inserted.size();
  for (const Inlet& s : c.inlets)
    coming -= static_cast<std::size_t>(s.batches) * s.positions.size();
  for (const Inlet& s : c.inlets) {
    double batches = 0, released = 0;
    for (int b = 0; b < s.batches; ++b, coming += s.positions.size()) {
      if (std::isnan(inserted[coming])) continue;
      ++batches;
      released += has_left(s, coming, last, c.model) ? 1 : 0;
    }
    out.add(s.name + "_batches", {batches}, "1", "batches that the inlet has inserted");
    out.add(s.name + "_batches_released", {released}, "1",
            "inserted batches of which no particle is in its place any more at the end");
  }
  add_loads(recording, inserted, statistics_began(recording, c), out);
  for (const Sensor& sensor : c.sensors) add_sensor(recording, stages, sensor, c, out);
  for (const MotionFrame& frame : c.model.frames) add_frame(recording, frame, out);
  for (const Coupling& coupling : c.model.couplings)
    add_coupling_friction(recording, coupling, out);
  return out.responses;
}

}  // namespace firn
