#include "experiments/run/interference_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "experiments/run/placement.h"
#include "firn/distance.h"
#include "firn/solver.h"

namespace firn {
namespace {

constexpr double kTouch = 0.1e-3;            // m, deeper is an overlap
constexpr int kSamples = 72;                 // of a period: every 5 degrees of a turn
constexpr double kMaxInitialOverlap = 0.05;  // of a particle's smallest edge, as in the solver

bool moves(const Case& c, int frame) {
  const MotionFrame& f = c.model.frames[index(frame)];
  const auto started = [&](const Stage& stage) {
    return std::ranges::count(stage.motions, frame, &Stage::StartedMotion::frame) > 0;
  };
  return f.free || !f.motions.empty() || std::ranges::any_of(c.stages, started);
}

bool moves_itself(const Case& c, int boundary) {
  const auto started = [&](const Stage& stage) {
    return std::ranges::count(stage.motions, boundary, &Stage::StartedMotion::boundary) > 0;
  };
  return !c.model.boundaries[index(boundary)].motions.empty() ||
         std::ranges::any_of(c.stages, started);
}

// What a boundary is fixed to: the world (-1), a frame that moves, or nothing but itself.
int carrier(const Case& c, int boundary) {
  if (moves_itself(c, boundary)) return static_cast<int>(c.model.frames.size()) + boundary;
  int frame = c.model.boundaries[index(boundary)].frame;
  while (frame >= 0 && !moves(c, frame)) frame = c.model.frames[index(frame)].parent;
  return frame;
}

struct Path {
  std::vector<std::pair<int, Motion>> boundaries, frames;  // started at its beginning
  double length = 0;                                       // s
  std::set<std::string> removed;                           // boundaries
  std::string name;                                        // "in stage \"pull\""; may be empty
};

// Of the machine's parts that can move against each other and have no contact with each other.
class BoundaryPairs {
 public:
  explicit BoundaryPairs(const Case& c) : c_(c) {
    const int n = static_cast<int>(c.model.boundaries.size());
    std::set<std::pair<int, int>> allowed(c.allow_overlap_with.begin(), c.allow_overlap_with.end());
    for (int a = 0; a < n; ++a) {
      Extents& extents = extents_.emplace_back();
      for (const ConvexPart& part : c.model.boundaries[index(a)].parts) {
        extents.parts.push_back(extent_of(part));
        extents.whole.extend(extents.parts.back());
      }
      for (int b = 0; b < a; ++b) {
        if (carrier(c, a) == carrier(c, b) || is_plane(a, b)) continue;
        if (allowed.contains({a, b}) || allowed.contains({b, a})) continue;
        const bool free = on_free_frame(a) || on_free_frame(b);
        const bool touches = std::ranges::any_of(c.model.boundary_contacts, [&](const auto& k) {
          return std::minmax(k.a, k.b) == std::minmax(a, b);
        });
        pairs_.push_back({b, a, free, touches, std::nullopt});
      }
    }
  }
  bool none() const { return pairs_.empty(); }

  // Throws InputError when a pair whose places have changed since the last check overlaps. Along a
  // path, places of free bodies are not known. Parts with a contact may meet but at the start.
  void check(const std::vector<BoundaryState>& walls, const std::string& when,
             const Path* path = nullptr, bool at_start = false) {
    if (const auto found = find(walls, path, at_start)) refuse(*found, when);
  }
  // Throws RunError when parts that are there have run into each other.
  void watch(const std::vector<BoundaryState>& walls, double time) {
    const auto found = find(walls, nullptr, false);
    if (!found) return;
    const Vec3 p = 1e3 * found->position;
    throw RunError(fmt::format(
        "boundaries \"{}\" and \"{}\" have run into each other at {:.6g} s, by {:.3g} mm near "
        "({:.1f} {:.1f} {:.1f}) mm; expected room, a [[boundary_contacts]] between them, or "
        "allow_overlap_with where it does not matter",
        c_.model.boundaries[index(found->a)].name, c_.model.boundaries[index(found->b)].name, time,
        1e3 * found->depth, p.x(), p.y(), p.z()));
  }

 private:
  struct PairToWatch {
    int a = 0, b = 0;
    bool free = false;         // one of them moves by forces
    bool touches = false;      // they have a contact
    std::optional<Pose> seen;  // b in a
  };
  struct Found {
    int a = 0, b = 0;
    double depth = 0;              // m
    Vec3 position = Vec3::Zero();  // m, world
  };

  std::optional<Found> find(const std::vector<BoundaryState>& walls, const Path* path,
                            bool at_start) {
    const auto removed = [&](int b) {
      return !walls[index(b)].present ||
             (path && path->removed.contains(c_.model.boundaries[index(b)].name));
    };
    for (PairToWatch& pair : pairs_) {
      if ((path && pair.free) || (pair.touches && !at_start)) continue;
      if (removed(pair.a) || removed(pair.b)) continue;
      const Pose pose_a = pose_of(walls[index(pair.a)]), pose_b = pose_of(walls[index(pair.b)]);
      const Mat3 turn = pose_a.rotation.transpose();
      const Pose relative{turn * pose_b.rotation, turn * (pose_b.translation - pose_a.translation)};
      if (pair.seen && same(*pair.seen, relative)) continue;
      pair.seen = relative;
      if (const auto overlap = overlap_of(pair, relative))
        return Found{pair.a, pair.b, overlap->depth, pose_a * overlap->position};
    }
    return std::nullopt;
  }

  using Extent = Eigen::AlignedBox3d;  // m, boundary axes
  struct Extents {
    std::vector<Extent> parts;
    Extent whole;
  };

  static Extent extent_of(const ConvexPart& part) {
    Extent e;
    for (int k = 0; k < part.vertex_count; ++k) e.extend(part.vertex(k));
    const Vec3 sweep = Vec3::Constant(part.radius);
    return {e.min() - sweep, e.max() + sweep};
  }
  static Pose pose_of(const BoundaryState& s) {
    return {s.orientation.toRotationMatrix(), s.position};
  }
  static bool same(const Pose& x, const Pose& y) {
    constexpr double kStill = 1e-9;
    return (x.rotation - y.rotation).cwiseAbs().maxCoeff() < kStill &&
           (x.translation - y.translation).cwiseAbs().maxCoeff() < kStill;
  }
  bool on_free_frame(int b) const {
    return free_frame(c_.model.frames, c_.model.boundaries[index(b)].frame) >= 0;
  }
  bool is_plane(int a, int b) const {
    return c_.model.boundaries[index(a)].kind == Boundary::Kind::plane &&
           c_.model.boundaries[index(b)].kind == Boundary::Kind::plane;
  }

  std::optional<PartOverlap> overlap_of(const PairToWatch& pair, const Pose& b_in_a) const {
    const Boundary &a = c_.model.boundaries[index(pair.a)], &b = c_.model.boundaries[index(pair.b)];
    if (a.kind == Boundary::Kind::plane) return below_plane(b, b_in_a);
    const Mat3 back = b_in_a.rotation.transpose();
    const Pose a_in_b{back, back * -b_in_a.translation};
    if (b.kind == Boundary::Kind::plane) {
      auto overlap = below_plane(a, a_in_b);
      if (overlap) overlap->position = b_in_a * overlap->position;
      return overlap;
    }
    const Extents &of_a = extents_[index(pair.a)], &of_b = extents_[index(pair.b)];
    const auto far = [](const Extent& e, const Vec3& center, const ConvexPart& part) {
      return e.exteriorDistance(center) > part.bounding_radius;
    };
    std::vector<std::size_t> near_a;
    for (std::size_t k = 0; k < b.parts.size(); ++k)
      if (!far(of_a.whole, b_in_a * b.parts[k].center, b.parts[k])) near_a.push_back(k);
    for (std::size_t i = 0; i < a.parts.size() && !near_a.empty(); ++i) {
      const ConvexPart& part = a.parts[i];
      const Vec3 center = a_in_b * part.center;
      if (far(of_b.whole, center, part)) continue;
      for (const std::size_t k : near_a) {
        const ConvexPart& other = b.parts[k];
        if (far(of_b.parts[k], center, part) || far(of_a.parts[i], b_in_a * other.center, other))
          continue;
        if (auto overlap = part_overlap(part, other, b_in_a, kTouch)) return overlap;
      }
    }
    return std::nullopt;
  }

  // Of a solid placed in the axes of a plane.
  static std::optional<PartOverlap> below_plane(const Boundary& solid, const Pose& pose) {
    std::optional<PartOverlap> deepest;
    for (const ConvexPart& part : solid.parts) {
      for (int k = 0; k < part.vertex_count; ++k) {
        const Vec3 p = pose * part.vertex(k);
        const double depth = part.radius - p.z();
        if (depth > kTouch && (!deepest || depth > deepest->depth)) deepest = PartOverlap{depth, p};
      }
    }
    return deepest;
  }

  [[noreturn]] void refuse(const Found& found, const std::string& when) const {
    // The later of the two: what it runs into was there.
    const int b = found.b;
    const std::string place = index(b) < c_.boundary_places.size() ? c_.boundary_places[index(b)]
                                                                   : c_.source + ": boundaries";
    const std::string& other = c_.model.boundaries[index(found.a)].name;
    const Vec3 p = 1e3 * found.position;
    throw InputError(fmt::format(
        "{}: \"{}\" overlaps boundary \"{}\" {}, by {:.3g} mm near ({:.1f} {:.1f} {:.1f}) mm; "
        "expected room between them, or allow_overlap_with = [\"{}\"] where it does not matter",
        place, c_.model.boundaries[index(b)].name, other, when, 1e3 * found.depth, p.x(), p.y(),
        p.z(), other));
  }

  const Case& c_;
  std::vector<PairToWatch> pairs_;
  std::vector<Extents> extents_;  // [boundaries]
};

// The machine alone. validate() accepts it where it accepts the case with particles.
Model without_particles(const Case& c) {
  Model model = c.model;
  model.particles.clear();
  model.bonds.clear();
  model.statistics = {};
  return model;
}

// The machine with its free frames fixed where they start: prescribed motions alone.
Model with_fixed_frames(const Case& c) {
  Model model = without_particles(c);
  for (MotionFrame& frame : model.frames) frame.free.reset();
  model.couplings.clear();
  model.boundary_contacts.clear();
  return model;
}

// Something else than time may end it.
bool ends_on_event(const Stage& stage) {
  return std::ranges::any_of(stage.end_when,
                             [](auto until) { return until != Stage::EndEvent::time; });
}

// Time after which a motion has passed through all of its displacements, at most `end`, s. A motion
// without a period lasts until `end` if the end is known in advance (`by_time`), else 0.
double first_period(const Motion& m, double end, bool by_time) {
  double period = m.period > 0 ? m.period : m.stop;
  if (m.kind == Motion::Kind::rotation && m.profile == Motion::Profile::constant &&
      m.angular_speed != 0)
    period = std::min(period, 2 * std::numbers::pi / std::abs(m.angular_speed));
  if (m.profile == Motion::Profile::sinusoidal) period = std::min(period, 1 / m.frequency);
  if (m.profile == Motion::Profile::table) period = std::min(period, m.times.back());
  if (period == kUnbounded && !by_time) return 0;
  return std::min(end, m.start + period);
}

// The case's own motions, then what each stage starts.
std::vector<Path> paths_of(const Case& c) {
  std::vector<Path> paths(1);
  const auto lengthen = [](Path& path, const Motion& m, double end, bool by_time) {
    path.length = std::max(path.length, first_period(m, end, by_time));
  };
  const bool all_by_time = std::ranges::none_of(c.stages, ends_on_event);
  for (const MotionFrame& frame : c.model.frames)
    for (const Motion& m : frame.motions) lengthen(paths[0], m, c.duration, all_by_time);
  for (const Boundary& b : c.model.boundaries)
    for (const Motion& m : b.motions) lengthen(paths[0], m, c.duration, all_by_time);
  std::set<std::string> removed;
  for (const Stage& stage : c.stages) {
    removed.insert(stage.remove.begin(), stage.remove.end());
    Path path;
    path.removed = removed;
    path.name = fmt::format(" in stage \"{}\"", stage.name);
    for (const Stage::StartedMotion& m : stage.motions) {
      const double end = m.ends_with_stage ? stage.max_duration : c.duration;
      lengthen(path, m.motion, std::min(end, c.duration),
               m.ends_with_stage ? !ends_on_event(stage) : all_by_time);
      if (m.frame >= 0)
        path.frames.emplace_back(m.frame, m.motion);
      else
        path.boundaries.emplace_back(m.boundary, m.motion);
    }
    if (path.length > 0) paths.push_back(std::move(path));
  }
  return paths;
}

// Starts frames at the poses that the coordinates of free frames give in `machine`, which is
// without_particles().
void start_fixed(Solver& solver, const Case& c, const std::shared_ptr<const Model>& machine) {
  Solver whole(machine, 0);
  for (const FrameStart& start : c.frame_starts) whole.start_frame(start);
  const std::vector<FrameState> frames = whole.frames();
  for (FrameStart start : c.frame_starts) {
    start.position = frames[index(start.frame)].position;
    start.orientation = frames[index(start.frame)].orientation;
    solver.start_frame(start);
  }
}

void follow(const Case& c, const std::shared_ptr<const Model>& machine, const Path& path,
            BoundaryPairs& pairs) {
  Model model = with_fixed_frames(c);
  model.timestep = path.length / kSamples;
  if (!path.name.empty()) {
    for (MotionFrame& frame : model.frames) frame.motions.clear();
    for (Boundary& boundary : model.boundaries) boundary.motions.clear();
  }
  Solver solver(std::move(model));
  start_fixed(solver, c, machine);
  for (const auto& [frame, motion] : path.frames) solver.add_frame_motion(frame, motion);
  for (const auto& [boundary, motion] : path.boundaries) solver.add_motion(boundary, motion);
  for (int k = 0; k < kSamples; ++k) {
    solver.step();
    pairs.check(solver.boundaries(),
                fmt::format("{:.3g} s after the start{}", solver.time(), path.name), &path);
  }
}

// How far motors can take an axis: to their targets, or to its stops; a turn where there are none.
std::pair<double, double> reach_of(const Case& c, int frame, int number) {
  const Joint& axis = c.model.frames[index(frame)].free->joints[index(number)];
  std::vector<const Motor*> motors;
  for (const Motor& d : axis.motors) motors.push_back(&d);
  for (const Stage& stage : c.stages)
    for (const Stage::StageMotor& d : stage.motors)
      if (d.frame == frame && d.axis == number) motors.push_back(&d.motor);
  double low = 0, high = 0;
  const double turn = axis.kind == Joint::Kind::rotation ? 2 * std::numbers::pi : 0;
  for (const Motor* d : motors) {
    const double end = d->target       ? *d->target
                       : d->speed >= 0 ? std::min(axis.upper, turn)
                                       : std::max(axis.lower, -turn);
    low = std::min(low, end);
    high = std::max(high, end);
  }
  return {std::max(low, axis.lower), std::min(high, axis.upper)};
}

void drive_through(const Case& c, const std::shared_ptr<const Model>& machine, int frame,
                   BoundaryPairs& pairs) {
  const MotionFrame& f = c.model.frames[index(frame)];
  for (std::size_t axis = 0; axis < f.free->joints.size(); ++axis) {
    const auto [low, high] = reach_of(c, frame, static_cast<int>(axis));
    if (!(high > low)) continue;
    for (int k = 0; k <= kSamples; ++k) {
      Solver solver(machine, 0);
      for (const FrameStart& start : c.frame_starts)
        if (start.frame < frame) solver.start_frame(start);
      FrameStart at;
      at.frame = frame;
      at.orientation =
          f.parent < 0 ? Quat::Identity() : solver.frames()[index(f.parent)].orientation;
      at.coordinates.assign(f.free->joints.size(), 0);
      at.rates = at.coordinates;
      at.coordinates[axis] = low + (high - low) * k / kSamples;
      solver.start_frame(at);
      const bool turns = f.free->joints[axis].kind == Joint::Kind::rotation;
      pairs.check(
          solver.boundaries(),
          turns ? fmt::format("with \"{}\" at {:.3g} deg", f.name, at.coordinates[axis] * kRadToDeg)
                : fmt::format("with \"{}\" at {:.3g} mm", f.name, 1e3 * at.coordinates[axis]));
    }
  }
}

// The first of the free frames that carry a free one, itself if none does.
int first_body(const Case& c, int frame) {
  int first = frame;
  while ((frame = free_frame(c.model.frames, frame)) >= 0) {
    first = frame;
    frame = c.model.frames[index(frame)].parent;
  }
  return first;
}

// Couplings move other bodies with it, so that it cannot be moved alone.
bool is_coupled(const Case& c, int frame) {
  const int first = first_body(c, frame);
  return std::ranges::any_of(c.model.couplings, [&](const Coupling& coupling) {
    return first_body(c, coupling.a) == first || first_body(c, coupling.b) == first;
  });
}

void check_boundaries(const Case& c) {
  BoundaryPairs pairs(c);
  if (pairs.none()) return;
  const auto machine = std::make_shared<const Model>(without_particles(c));
  Solver start(with_fixed_frames(c));
  start_fixed(start, c, machine);
  pairs.check(start.boundaries(), "at the start", nullptr, true);
  for (const Path& path : paths_of(c))
    if (path.length > 0) follow(c, machine, path, pairs);
  for (std::size_t f = 0; f < c.model.frames.size(); ++f)
    if (c.model.frames[f].free && !is_coupled(c, static_cast<int>(f)))
      drive_through(c, machine, static_cast<int>(f), pairs);
}

double smallest_edge(const Case& c, int particle) {
  const int shape = c.model.particles[index(particle)].shape;
  return c.model.shapes[index(shape)].box.minCoeff();
}

// Of an entry of Case::placed. A program may have added it to a case that was read.
std::string place_of_particle(const Case& c, std::size_t entry) {
  return entry < c.particle_places.size() ? c.particle_places[entry] : c.source + ": particles";
}

void check_particles_in_boundaries(const Case& c) {
  Solver solver(std::make_shared<const Model>(without_particles(c)), 0);
  for (const FrameStart& start : c.frame_starts) solver.start_frame(start);
  for (std::size_t i = 0; i < c.placed.size(); ++i) {
    const Case::InitialParticle& p = c.placed[i];
    const int shape = c.model.particles[index(p.particle)].shape;
    const double depth = kMaxInitialOverlap * smallest_edge(c, p.particle);
    const auto wall = solver.obstacle(shape, p.position, p.orientation, -depth);
    if (!wall) continue;
    throw InputError(fmt::format(
        "{}: particle {} lies more than {:.3g} mm inside boundary \"{}\"; expected a free place",
        place_of_particle(c, i), p.particle, 1e3 * depth, c.model.boundaries[index(*wall)].name));
  }
}

bool overlap_deeper(const Shape& a, const Shape& b, const Pose& b_in_a, double depth) {
  return std::ranges::any_of(a.parts, [&](const ConvexPart& mine) {
    return std::ranges::any_of(b.parts, [&](const ConvexPart& other) {
      const double apart = (mine.center - b_in_a * other.center).norm();
      if (apart > mine.bounding_radius + other.bounding_radius - depth) return false;
      return part_overlap(mine, other, b_in_a, depth).has_value();
    });
  });
}

void check_particles_in_particles(const Case& c) {
  struct Body {
    std::size_t entry;  // of Case::placed
    const Shape* shape;
    Mat3 rotation;  // part axes -> world
    Vec3 position;
    double start, end;  // along x, m
  };
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < c.placed.size(); ++i) {
    const Case::InitialParticle& p = c.placed[i];
    const Shape& shape = c.model.shapes[index(c.model.particles[index(p.particle)].shape)];
    bodies.push_back({i, &shape, (p.orientation * shape.shape_from_body).toRotationMatrix(),
                      p.position, p.position.x() - shape.bounding_radius,
                      p.position.x() + shape.bounding_radius});
  }
  std::ranges::stable_sort(bodies, {}, &Body::start);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size() && bodies[j].start < bodies[i].end; ++j) {
      const bool ordered = bodies[i].entry < bodies[j].entry;
      const Body &a = bodies[ordered ? i : j], &b = bodies[ordered ? j : i];
      const Vec3 offset = b.position - a.position;
      if (offset.norm() > a.shape->bounding_radius + b.shape->bounding_radius) continue;
      const int first = c.placed[a.entry].particle, second = c.placed[b.entry].particle;
      const double depth =
          kMaxInitialOverlap * std::min(smallest_edge(c, first), smallest_edge(c, second));
      const Pose b_in_a{a.rotation.transpose() * b.rotation, a.rotation.transpose() * offset};
      if (!overlap_deeper(*a.shape, *b.shape, b_in_a, depth)) continue;
      throw InputError(fmt::format(
          "{}: particle {} lies more than {:.3g} mm inside particle {}; expected a free place",
          place_of_particle(c, b.entry), second, 1e3 * depth, first));
    }
  }
}

}  // namespace

void check_machine(const Case& c) {
  check_boundaries(c);
  if (c.placed.empty()) return;
  check_particles_in_boundaries(c);
  check_particles_in_particles(c);
}

struct InterferenceMonitor::Impl {
  explicit Impl(const Case& c) : pairs(c) {}
  BoundaryPairs pairs;
};

InterferenceMonitor::InterferenceMonitor(const Case& c) : impl_(std::make_unique<Impl>(c)) {}
InterferenceMonitor::~InterferenceMonitor() = default;

void InterferenceMonitor::check(const Solver& solver) {
  if (!impl_->pairs.none()) impl_->pairs.watch(solver.boundaries(), solver.time());
}

}  // namespace firn
