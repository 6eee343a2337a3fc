#include "experiments/responses/single_body_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/responses/heap_slope.h"

namespace firn {
namespace {

// A body flies between two frames when contacts have changed its momentum by less than this part of
// what gravity has.
constexpr double kFree = 1e-3;

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The value of y where x passes `at` between two neighboring frames.
double interpolated(double x0, double x1, double at, double y0, double y1) {
  return y0 + (y1 - y0) * (at - x0) / (x1 - x0);
}

// The first frame in which the body has moved that far.
std::optional<std::size_t> first_beyond(const BoundaryTrack& track, double distance) {
  const auto& d = track.distance;
  const auto found = std::find_if(d.begin(), d.end(), [&](double x) { return x >= distance; });
  if (found == d.end()) return std::nullopt;
  return static_cast<std::size_t>(found - d.begin());
}

// When it had moved that far, s.
std::optional<double> time_at(const BoundaryTrack& track, double distance) {
  const auto k = first_beyond(track, distance);
  if (!k) return std::nullopt;
  if (*k == 0) return track.time[0];
  return interpolated(track.distance[*k - 1], track.distance[*k], distance, track.time[*k - 1],
                      track.time[*k]);
}

// Second derivative of the parabola nearest to the points; of at least three.
double curvature(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<Eigen::Index>(x.size());
  const double middle = (x.front() + x.back()) / 2, half = (x.back() - x.front()) / 2;
  const Eigen::ArrayXd u = (Eigen::Map<const Eigen::ArrayXd>(x.data(), n) - middle) / half;
  Eigen::MatrixXd powers(n, 3);
  powers << Eigen::ArrayXd::Ones(n), u, u.square();
  const Eigen::Vector3d fit =
      powers.colPivHouseholderQr().solve(Eigen::Map<const Eigen::VectorXd>(y.data(), n));
  return 2 * fit[2] / (half * half);
}

}  // namespace

SlipResult measure_slip(const BoundaryTrack& track, const Measure& measure) {
  SlipResult result;
  const auto moved = first_beyond(track, measure.slip);
  if (!moved || *moved == 0) return result;
  const std::size_t k = *moved;
  const auto &distance = track.distance, &inclination = track.inclination;
  result.angle =
      interpolated(distance[k - 1], distance[k], measure.slip, inclination[k - 1], inclination[k]);
  result.resolution = std::abs(inclination[k] - inclination[k - 1]);
  const std::size_t end = first_beyond(track, measure.run).value_or(distance.size() - 1);
  const double turned = *std::max_element(
      track.turn.begin(), track.turn.begin() + static_cast<std::ptrdiff_t>(end) + 1);
  result.end = turned >= measure.tip_angle ? SlipResult::End::tipped : SlipResult::End::slid;
  return result;
}

SlideResult measure_slide(const BoundaryTrack& track, const Measure& measure) {
  SlideResult result;
  if (track.time.size() < 2) return result;
  result.distance = track.distance.back();
  const auto from = time_at(track, measure.from), to = time_at(track, measure.to);
  if (!from || !to) return result;
  result.passed = true;
  result.time = *to - *from;
  result.resolution = track.time[1] - track.time[0];
  std::vector<double> time, distances;
  for (std::size_t k = 0; k < track.time.size(); ++k) {
    if (track.time[k] < *from || track.time[k] > *to) continue;
    time.push_back(track.time[k]);
    distances.push_back(track.distance[k]);
  }
  if (time.size() >= 3) result.acceleration = curvature(time, distances);
  return result;
}

ReboundResult measure_rebound(const FallTrack& track, const Vec3& gravity) {
  ReboundResult result;
  const Vec3 up = -gravity.normalized();
  bool was_free = false;
  for (std::size_t k = 0; k + 1 < track.time.size(); ++k) {
    const Vec3 from_gravity = gravity * (track.time[k + 1] - track.time[k]);
    const Vec3 from_contacts = track.velocity[k + 1] - track.velocity[k] - from_gravity;
    const bool is_free = from_contacts.norm() <= kFree * from_gravity.norm();
    const double rising = up.dot(track.velocity[k]);
    if (!result.landed) {
      if (k == 0 && !is_free) return result;  // lay on something from the start
      if (!is_free) {
        result.landed = true;
        result.impact_speed = -rising;
        result.resolution = from_gravity.norm();
      }
    } else if (is_free && !was_free) {
      result.take_off_speed = std::max(result.take_off_speed, rising);
    }
    was_free = is_free;
  }
  return result;
}

namespace {

// All frames at once, and which bodies a measure is about.
class Frames {
 public:
  Frames(const Recording& recording, const Case& c)
      : recording_(recording),
        case_(c),
        time_(recording.frame_times()),
        position_(recording.series("/frames/position")),
        orientation_(recording.series("/frames/orientation")),
        velocity_(recording.series("/frames/velocity")) {}

  std::vector<std::size_t> bodies(const Measure& m) const {
    std::vector<std::size_t> chosen;
    const std::vector<Particle>& particles = case_.model.particles;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      if (!m.tag || particles[i].tag == *m.tag) chosen.push_back(i);
    }
    return chosen;
  }

  BoundaryTrack on_boundary(std::size_t body, const std::string& name) const {
    const std::string group = "/boundaries/" + name;
    const std::vector<double> origin = boundary_series(group + "/position", 3),
                              axes = boundary_series(group + "/orientation", 4);
    const Vec3 up = -case_.model.gravity.normalized();
    BoundaryTrack track;
    Vec3 first_place = Vec3::Zero(), first_normal = Vec3::Zero();
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const Vec3 position = vector(position_, row(k, body));
      const Vec3 boundary_origin = vector(origin, k);
      if (!position.allFinite() || !boundary_origin.allFinite()) continue;
      const Quat boundary = rotation(axes, k), particle = rotation(orientation_, row(k, body));
      const Vec3 place = boundary.conjugate() * (position - boundary_origin);
      const Vec3 normal = boundary * Vec3::UnitZ(), seen = particle.conjugate() * normal;
      if (track.time.empty()) {
        first_place = place;
        first_normal = seen;
      }
      track.time.push_back(time_[k]);
      track.distance.push_back((place - first_place).head<2>().norm());
      track.turn.push_back(angle_between(first_normal, seen));
      track.inclination.push_back(angle_between(normal, up));
    }
    return track;
  }

  FallTrack falling(std::size_t body) const {
    FallTrack track;
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const Vec3 velocity = vector(velocity_, row(k, body));
      if (!velocity.allFinite()) continue;
      track.time.push_back(time_[k]);
      track.velocity.push_back(velocity);
    }
    return track;
  }

 private:
  std::vector<double> boundary_series(const std::string& path, std::size_t width) const {
    std::vector<double> values = recording_.series(path);
    if (values.size() != width * time_.size()) {
      throw InputError(fmt::format("{}: {} has the wrong shape; expected {} values a frame",
                                   recording_.file(), path, width));
    }
    return values;
  }
  std::size_t row(std::size_t frame, std::size_t body) const {
    return frame * case_.model.particles.size() + body;
  }
  static Vec3 vector(const std::vector<double>& values, std::size_t row) {
    return Vec3(values[3 * row], values[3 * row + 1], values[3 * row + 2]);
  }
  static Quat rotation(const std::vector<double>& values, std::size_t row) {
    return Quat(values[4 * row], values[4 * row + 1], values[4 * row + 2], values[4 * row + 3]);
  }

  const Recording& recording_;
  const Case& case_;
  std::vector<double> time_, position_, orientation_, velocity_;
};

// One number of each of several bodies.
struct Sample {
  std::vector<double> values;
  double resolution = 0;  // of the coarsest

  void add(double value, double its_resolution) {
    values.push_back(value);
    resolution = std::max(resolution, its_resolution);
  }
};

class Responses {
 public:
  explicit Responses(const Measure& m) : prefix_(m.prefix()) {}

  void add(const std::string& name, double value, const std::string& method) {
    list.push_back({prefix_ + name, {value}, {0.0}, "1", method, 1});
  }
  // The mean, with its standard error or, of a single body, its resolution. Nothing of none.
  void add(const std::string& name, const Sample& sample, const std::string& unit,
           const std::string& method) {
    const std::vector<double>& v = sample.values;
    if (v.empty()) return;
    const double n = static_cast<double>(v.size());
    double mean = 0;
    for (double x : v) mean += x / n;
    const double error = v.size() > 1 ? standard_deviation(v) / std::sqrt(n) : sample.resolution;
    list.push_back({prefix_ + name, {mean}, {error}, unit, method, 1});
    if (v.size() > 1) {
      list.push_back({prefix_ + name + "_each", v, std::vector<double>(v.size(), sample.resolution),
                      unit, method + ", of each body", 1});
    }
  }

  std::vector<Response> list;

 private:
  std::string prefix_;
};

void measure_slip(const Frames& frames, const Measure& m, Responses& out) {
  Sample slide, tip;
  const std::vector<std::size_t> bodies = frames.bodies(m);
  for (std::size_t body : bodies) {
    const SlipResult r = measure_slip(frames.on_boundary(body, m.boundary), m);
    if (r.end == SlipResult::End::at_rest) continue;
    (r.end == SlipResult::End::slid ? slide : tip)
        .add(r.angle * kRadToDeg, r.resolution * kRadToDeg);
  }
  const double all = static_cast<double>(bodies.size());
  out.add("slid", static_cast<double>(slide.values.size()) / all, "part of the bodies that slid");
  out.add("tipped", static_cast<double>(tip.values.size()) / all, "part of the bodies that tipped");
  out.add("slide_angle", slide, "deg",
          "inclination of the boundary when a body that slides has moved by the slip");
  out.add("tip_angle", tip, "deg", "the same of a body that tips");
}

void measure_slide(const Frames& frames, const Measure& m, Responses& out) {
  Sample time, acceleration, distance;
  const std::vector<std::size_t> bodies = frames.bodies(m);
  for (std::size_t body : bodies) {
    const SlideResult r = measure_slide(frames.on_boundary(body, m.boundary), m);
    distance.add(r.distance, 0);
    if (!r.passed) continue;
    time.add(r.time, r.resolution);
    acceleration.add(r.acceleration, 0);
  }
  out.add("passed", static_cast<double>(time.values.size()) / static_cast<double>(bodies.size()),
          "part of the bodies that passed both marks");
  out.add("slide_time", time, "s", "time from mark to mark");
  out.add("sliding_acceleration", acceleration, "m/s^2",
          "least-squares parabola through the way between the marks");
  out.add("slide_distance", distance, "m", "way along the boundary up to the last frame");
}

void measure_rebound(const Frames& frames, const Measure& m, const Vec3& gravity, Responses& out) {
  Sample drop, rebound, restitution;
  const std::vector<std::size_t> bodies = frames.bodies(m);
  const double g = gravity.norm();
  for (std::size_t body : bodies) {
    const ReboundResult r = measure_rebound(frames.falling(body), gravity);
    if (!r.landed || r.impact_speed <= 0) continue;
    const auto height = [g](double speed) { return speed * speed / (2 * g); };
    const auto resolution = [&](double speed) { return speed * r.resolution / g; };
    drop.add(height(r.impact_speed), resolution(r.impact_speed));
    rebound.add(height(r.take_off_speed), resolution(r.take_off_speed));
    const double ratio = r.take_off_speed / r.impact_speed;
    restitution.add(ratio, (1 + ratio) * r.resolution / r.impact_speed);
  }
  out.add("landed", static_cast<double>(drop.values.size()) / static_cast<double>(bodies.size()),
          "part of the bodies that fell freely and landed");
  out.add("drop_height", drop, "m", "from the vertical speed at the first touch");
  out.add("rebound_height", rebound, "m",
          "highest rise of the center of mass in any flight after the first touch");
  out.add("restitution", restitution, "1",
          "vertical speed of the highest take-off over that of the first touch");
}

}  // namespace

std::vector<Response> body_responses(const Recording& recording, const Case& c) {
  std::vector<Response> all;
  const auto is_body = [](const Measure& m) { return m.kind != Measure::Kind::heap; };
  if (std::ranges::none_of(c.measures, is_body)) return all;
  const Frames frames(recording, c);
  for (const Measure& m : c.measures) {
    Responses out(m);
    if (m.kind == Measure::Kind::slip) measure_slip(frames, m, out);
    if (m.kind == Measure::Kind::slide) measure_slide(frames, m, out);
    if (m.kind == Measure::Kind::rebound) measure_rebound(frames, m, c.model.gravity, out);
    all.insert(all.end(), out.list.begin(), out.list.end());
  }
  return all;
}

}  // namespace firn
