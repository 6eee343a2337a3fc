#include "experiments/run/placement.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

// What a body sweeps out of space: the points of its mesh and of its contact parts, each with the
// radius around it, in shape axes about the center of mass.
struct Extents {
  struct Point {
    Vec3 position;      // m
    double radius = 0;  // m
  };
  std::vector<Point> points;

  explicit Extents(const Shape& shape) {
    for (const Vec3& v : shape.mesh.vertices) points.push_back({v - shape.centroid, 0});
    for (const ConvexPart& part : shape.parts)
      for (int i = 0; i < part.vertex_count; ++i)
        points.push_back({shape.shape_from_body * part.vertex(i), part.radius});
  }

  // Lower and upper corner about the center of mass, world axes, m.
  std::array<Vec3, 2> box(const Quat& orientation) const {
    const Mat3 rotation = orientation.toRotationMatrix();
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Point& point : points) {
      const Vec3 p = rotation * point.position;
      low = low.cwiseMin((p.array() - point.radius).matrix());
      high = high.cwiseMax((p.array() + point.radius).matrix());
    }
    return {low, high};
  }
};

}  // namespace

void place_start(Solver& solver, const Case& c) {
  for (const FrameStart& start : c.frame_starts) solver.start_frame(start);
  for (const Case::InitialParticle& p : c.placed)
    solver.insert(p.particle, p.position, p.orientation, p.velocity, p.angular_velocity);
}

void place_batch(Solver& solver, const Case& c, std::size_t index, std::uint64_t batch, int first,
                 int count) {
  const Fill& fill = c.fills[index];
  const int shape = solver.model().particles[static_cast<std::size_t>(first)].shape;
  const Extents extents(solver.model().shapes[static_cast<std::size_t>(shape)]);
  RandomStream random(c.seed, index, batch);
  const auto place_one = [&](int particle) {
    bool fits = false;
    for (int i = 0; i < kPlacementTries; ++i) {
      const Quat orientation =
          fill.random_orientation ? random.uniform_rotation() : Quat::Identity();
      const auto [low, high] = extents.box(orientation);
      const Vec3 from = fill.region_min - low, to = fill.region_max - high;
      const Vec3 where(random.uniform(), random.uniform(), random.uniform());
      if ((to - from).minCoeff() < 0) continue;
      fits = true;
      const Vec3 position = from + where.cwiseProduct(to - from);
      if (solver.overlaps(shape, position, orientation, 0)) continue;
      solver.insert(particle, position, orientation, fill.velocity, Vec3::Zero());
      return;
    }
    const std::string place =
        index < c.fill_places.size() ? c.fill_places[index] : c.source + ": fills";
    throw InputError(fmt::format(
        "{}: impossible fill: body {} of {} of shape \"{}\" at t = {:.6g} s {}; expected a "
        "larger region, fewer bodies or smaller batches",
        place, particle - first + 1, count, fill.shape, solver.time(),
        fits ? fmt::format("found no free place in {} tries", kPlacementTries)
             : std::string("is larger than the region in every orientation")));
  };
  for (int i = 0; i < count; ++i) place_one(first + i);
}

}  // namespace firn
