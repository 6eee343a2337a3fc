// Heaps of ice cubes piled up to a plane of known slope, without any simulation: cubes in random
// attitudes are let down vertically onto a height map and stay where they first touch.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/case/case.h"

namespace firn::synthetic {

// Same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  // Half of them anyhow (uniform over all rotations, Shoemake 1992), half lying on one of the four
  // long sides, tilted by up to 20 degrees.
  Mat3 attitude() {
    constexpr double pi = std::numbers::pi, tilt = pi / 9;
    if (uniform(0, 1) < 0.5) {
      const double u = uniform(0, 1), a = uniform(0, 2 * pi), b = uniform(0, 2 * pi);
      return Quat(std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
                  std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b))
          .toRotationMatrix();
    }
    const double yaw = uniform(0, 2 * pi), pitch = uniform(-tilt, tilt);
    const double roll = uniform(-tilt, tilt) + 0.5 * pi * std::floor(uniform(0, 4));
    return (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
            Eigen::AngleAxisd(roll, Vec3::UnitX()))
        .toRotationMatrix();
  }

 private:
  std::mt19937_64 engine_;
};

// Closed box about the origin.
inline TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) {
    mesh.vertices.push_back(0.5 * Vec3(k & 1 ? size.x() : -size.x(), k & 2 ? size.y() : -size.y(),
                                       k & 4 ? size.z() : -size.z()));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// A crescent of the paper's chord and width, drawn coarsely: a circular segment (flat on top, arc
// below, blunt tips) extruded along y. Closed; about 13.7 g of ice at scale 1.
inline TriangleMesh crescent(double scale = 1) {
  const double chord = 60.96e-3, width = 20.57e-3, depth = 17.8e-3, tip = 2e-3;
  const int arc = 8;
  const double h = depth - tip, radius = (chord * chord / 4 + h * h) / (2 * h);
  std::vector<std::array<double, 2>> outline{{chord / 2, 0.0}, {-chord / 2, 0.0}};  // x, z
  for (int i = 0; i <= arc; ++i) {
    const double x = -chord / 2 + chord * i / arc;
    outline.push_back({x, -tip - (std::sqrt(radius * radius - x * x) - (radius - h))});
  }
  const int n = static_cast<int>(outline.size());
  TriangleMesh mesh;
  for (double y : {-width / 2, width / 2}) {
    for (const auto& p : outline) mesh.vertices.emplace_back(p[0], y, p[1] + 0.4 * depth);
  }
  for (int i = 1; i + 1 < n; ++i) {
    mesh.triangles.push_back({0, i, i + 1});
    mesh.triangles.push_back({n, n + i + 1, n + i});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, n + j, j});
    mesh.triangles.push_back({i, n + i, n + j});
  }
  for (Vec3& v : mesh.vertices) v *= scale;
  return mesh;
}

struct Region {
  double x_from = 0, x_to = 0, y_from = 0, y_to = 0;  // m
};

// Piles bodies of `mesh` into the region, over the floor z = 0, until no place is found any more
// where one would stay under roof(x, y) with every point. No two share a point of space.
inline std::vector<PlacedMesh> pile(const TriangleMesh& mesh, const Region& region, double cell,
                                    const std::function<double(double, double)>& roof,
                                    std::uint64_t seed) {
  constexpr int kCandidates = 12, kPatience = 50;
  const PlanGrid grid =
      PlanGrid::between(region.x_from, region.x_to, region.y_from, region.y_to, cell);
  Eigen::ArrayXXd height = Eigen::ArrayXXd::Zero(grid.nx, grid.ny);
  std::vector<PlacedMesh> bodies;
  Random random(seed);
  for (int failures = 0; failures < kPatience;) {
    // Of a few candidates, the one that comes to lie deepest under the roof: it fills a hole.
    PlacedMesh best;
    std::vector<ColumnSpan> best_spans;
    double lowest = INFINITY;
    for (int k = 0; k < kCandidates; ++k) {
      PlacedMesh body{&mesh, {}};
      body.pose.rotation = random.attitude();
      body.pose.translation.x() = random.uniform(region.x_from, region.x_to);
      body.pose.translation.y() = random.uniform(region.y_from, region.y_to);
      const std::vector<ColumnSpan> spans = column_spans(body, grid);
      double z = -INFINITY;
      for (const ColumnSpan& s : spans) z = std::max(z, height(s.i, s.j) - s.bottom);
      bool under = !spans.empty();
      for (const ColumnSpan& s : spans) {
        under = under && z + s.top <= roof(grid.x(s.i), grid.y(s.j));
      }
      const double depth = z - roof(body.pose.translation.x(), body.pose.translation.y());
      if (!under || depth >= lowest) continue;
      lowest = depth;
      body.pose.translation.z() = z;
      best = body;
      best_spans = spans;
    }
    if (best_spans.empty()) {
      ++failures;
      continue;
    }
    failures = 0;
    const double z = best.pose.translation.z();
    for (const ColumnSpan& s : best_spans) height(s.i, s.j) = std::max(height(s.i, s.j), z + s.top);
    bodies.push_back(best);
  }
  return bodies;
}

// The paper's box.
inline DrainedRepose drained_box() {
  DrainedRepose setup;
  setup.box = Vec3(0.5969, 0.1397, 0.31496);
  setup.door_width = 0.14605;
  setup.floor_thickness = 10e-3;
  setup.end_margin = setup.door_margin = 25e-3;
  return setup;
}

// The heap on one ledge (sign -1: left, +1: right), rising to the end wall at `angle` (deg) from
// `lip_height` (m) at the lip. It is cut out of a larger heap that continues beyond walls and lip,
// so that its roughness is the same everywhere.
inline std::vector<PlacedMesh> ledge_heap(const TriangleMesh& mesh, double cube_size, double sign,
                                          double angle, double lip_height, std::uint64_t seed,
                                          double tilt_y = 0) {
  const DrainedRepose setup = drained_box();
  const double lip = setup.door_width / 2, beyond = 1.5 * cube_size;
  const double from = lip - beyond, to = setup.box.x() / 2 + beyond;
  const double slope = std::tan(angle * kDegToRad);
  const double slope_y = std::tan(tilt_y * kDegToRad);
  const Region region{sign > 0 ? from : -to, sign > 0 ? to : -from, -setup.box.y() / 2 - beyond,
                      setup.box.y() / 2 + beyond};
  return pile(
      mesh, region, cube_size / 8,
      [=](double x, double y) { return lip_height + slope * (sign * x - lip) + slope_y * y; },
      seed);
}

// A solid with a plane top over the right ledge: height `rise` (m/m) times the distance from
// `toe` (m from the lip) plus `rise_y` times y, above a base of `base` (m); nothing before the toe.
inline TriangleMesh ramp(double rise, double toe, double base = 0, double rise_y = 0) {
  const DrainedRepose setup = drained_box();
  const double lip = setup.door_width / 2, end = setup.box.x() / 2, y = setup.box.y() / 2;
  TriangleMesh mesh = box_mesh({2, 2, 2});
  for (Vec3& v : mesh.vertices) {
    const bool top = v.z() > 0;
    v.x() = v.x() > 0 ? end : lip + toe;
    v.y() = v.y() > 0 ? y : -y;
    v.z() = top ? base + rise * (v.x() - lip - toe) + rise_y * v.y() : 0;
  }
  return mesh;
}

}  // namespace firn::synthetic
