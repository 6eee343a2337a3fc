#include <algorithm>
#include <cmath>
#include <numbers>

#include "firn/motion.h"

namespace firn {
namespace {

// Displacement from the start of a period to `tau` seconds after it.
double displacement_since_start(const Motion& m, double tau) {
  switch (m.profile) {
    case Motion::Profile::constant:
      return m.kind == Motion::Kind::translation ? tau : m.angular_speed * tau;
    case Motion::Profile::ramp: {
      const double ramp = std::min(tau, m.ramp_time);
      const double slope = m.ramp_time > 0 ? (m.end_rate - m.rate) / m.ramp_time : 0;
      return (m.rate + 0.5 * slope * ramp) * ramp + m.end_rate * (tau - ramp);
    }
    case Motion::Profile::sinusoidal:
      return m.amplitude *
             (std::sin(2 * std::numbers::pi * m.frequency * tau + m.phase) - std::sin(m.phase));
    case Motion::Profile::table: {
      const auto next = std::ranges::upper_bound(m.times, tau);
      if (next == m.times.begin()) return 0;
      const auto i = static_cast<std::size_t>(next - m.times.begin()) - 1;
      if (next == m.times.end()) return m.positions[i] - m.positions[0];
      const double share = (tau - m.times[i]) / (m.times[i + 1] - m.times[i]);
      return m.positions[i] - m.positions[0] + share * (m.positions[i + 1] - m.positions[i]);
    }
  }
  return 0;
}

// Of the period that begins at `begin`.
double displacement_in_period(const Motion& m, double begin, double t, double dt) {
  const double until = std::min(begin + (m.stop - m.start), m.end);
  const double from = std::max(t, begin), to = std::min(t + dt, until);
  if (!(to > from)) return 0;
  // At constant speed, no digits are lost with time.
  if (m.profile == Motion::Profile::constant) return displacement_since_start(m, to - from);
  return displacement_since_start(m, to - begin) - displacement_since_start(m, from - begin);
}

double periods_before(const Schedule& s, double t) {
  return s.period > 0 ? std::max(0.0, std::floor((t - s.start) / s.period)) : 0;
}

}  // namespace

bool Schedule::acts(double t) const {
  const double begin = start + periods_before(*this, t) * period;
  return t >= begin && t < begin + (stop - start) && t < end;
}

bool descends_from(const std::vector<MotionFrame>& frames, int frame, int above) {
  while (frame >= 0 && frame != above) frame = frames[static_cast<std::size_t>(frame)].parent;
  return frame >= 0;
}

int free_frame(const std::vector<MotionFrame>& frames, int frame) {
  while (frame >= 0 && !frames[static_cast<std::size_t>(frame)].free)
    frame = frames[static_cast<std::size_t>(frame)].parent;
  return frame;
}

double Motion::displacement(double t, double dt) const {
  const double k = periods_before(*this, t);
  double sum = displacement_in_period(*this, start + k * period, t, dt);
  if (period > 0) sum += displacement_in_period(*this, start + (k + 1) * period, t, dt);
  return sum;
}

double Motion::total_displacement(double t) const {
  const double until = std::min(t, end);
  if (!(until > start)) return 0;
  const double periods = periods_before(*this, until), begin = start + periods * period;
  const double whole = periods > 0 ? periods * displacement_since_start(*this, stop - start) : 0;
  return whole + displacement_since_start(*this, std::min(until, begin + (stop - start)) - begin);
}

}  // namespace firn
