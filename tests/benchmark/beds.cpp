#include "tests/benchmark/beds.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <optional>

namespace firn::beds {

namespace {

constexpr double kInch = 0.0254;
constexpr double kLength = 23.5 * kInch, kWidth = 5.5 * kInch, kDoor = 5.75 * kInch;  // m
constexpr double kPanel = 10e-3, kWallHeight = 1;                                     // m
constexpr double kShaftHeight = 0.1, kTurning = 4;                                    // m, rad/s

// A box of these half sizes, turned about x.
ConvexPart bar(const Vec3& center, const Vec3& half, double angle) {
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      sides.push_back({sign * Vec3::Unit(axis), half[axis], false});
  }
  const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitX()).toRotationMatrix();
  return moved(convex_part(sides, 1e-3), {turn, center});
}

// In its body axes: the shaft along x.
Boundary make_stirrer() {
  constexpr int kBlades = 12;
  Boundary b;
  b.name = "stirrer";
  b.material = scenes::kPlastic;
  b.kind = Boundary::Kind::solid;
  b.parts.push_back(bar(Vec3::Zero(), {0.5 * kLength, 8e-3, 8e-3}, 0));
  for (int k = 0; k < kBlades; ++k) {
    const double x = kLength * ((k + 0.5) / kBlades - 0.5);
    b.parts.push_back(bar({x, 0, 0}, {4e-3, 12e-3, 30e-3}, k * std::numbers::pi / 6));
  }
  return b;
}

int add_stirrer(Model& model, const Vec3& center, const Quat& orientation) {
  Boundary b = make_stirrer();
  b.name = fmt::format("stirrer {}", model.boundaries.size());
  b.origin = center;
  b.orientation = orientation;
  Motion turn;
  turn.kind = Motion::Kind::rotation;
  turn.axis = Vec3::UnitX();
  turn.center = center;
  turn.angular_speed = kTurning;
  b.motions.push_back(turn);
  model.boundaries.push_back(std::move(b));
  return static_cast<int>(model.boundaries.size()) - 1;
}

// A bed of one seed at a moment in which no cube is pinched. Tiling inserts the particles again,
// and an insertion with a large overlap is refused. Empty: no such moment within a second.
std::optional<Solver> filled_once(const Tile& t, std::uint64_t seed) {
  Solver solver(t.box.model);
  scenes::scatter(solver, 0, kCubes, t.box.lower, t.box.upper, seed);
  scenes::run(solver, 1.0);
  const double edge = t.box.model.shapes[0].box.minCoeff();
  const auto pinched = [&] {
    return std::ranges::any_of(solver.contact_overlaps(),
                               [&](double overlap) { return overlap > 0.045 * edge; });
  };
  for (int tries = 0; pinched(); ++tries) {
    if (tries == 1000) return std::nullopt;
    scenes::run(solver, 1e-3);
  }
  return solver;
}

}  // namespace

Tile tile(bool stirrer) {
  Tile t{scenes::repose_box(kCubes), stirrer, -1};
  if (stirrer)
    t.stirrer_boundary = add_stirrer(t.box.model, kShaftHeight * Vec3::UnitZ(), Quat::Identity());
  return t;
}

Solver filled(const Tile& t) {
  for (std::uint64_t seed = 1;; ++seed) {
    if (std::optional<Solver> solver = filled_once(t, seed)) return std::move(*solver);
  }
}

Tiled tiled(const Tile& t, const Solver& from, int along, int across) {
  Tiled bed;
  Model& model = bed.model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  model.timestep = t.box.model.timestep;
  model.shapes = t.box.model.shapes;
  const double pitch_x = kLength + kPanel, pitch_y = kWidth + kPanel;
  const Vec3 half(0.5 * (along * pitch_x + kPanel), 0.5 * (across * pitch_y + kPanel), 0);
  for (int x = 0; x <= along; ++x) {
    const double at = x * pitch_x - half.x();
    scenes::add_panel(model, fmt::format("wall x {}", x), {at, -half.y(), 0},
                      {at + kPanel, half.y(), kWallHeight});
  }
  for (int y = 0; y <= across; ++y) {
    const double at = y * pitch_y - half.y();
    scenes::add_panel(model, fmt::format("wall y {}", y), {-half.x(), at, 0},
                      {half.x(), at + kPanel, kWallHeight});
  }
  const auto panel = [&](const char* name, int k, double from_x, double to_x) {
    return scenes::add_panel(model, fmt::format("{} {}", name, k), {from_x, -half.y(), -kPanel},
                             {to_x, half.y(), 0});
  };
  for (int x = 0; x < along; ++x) {
    const double left = x * pitch_x - half.x(), right = left + pitch_x;
    const double middle = 0.5 * (left + right + kPanel);
    panel("left floor", x, left, middle - 0.5 * kDoor);
    bed.doors.push_back(panel("door", x, middle - 0.5 * kDoor, middle + 0.5 * kDoor));
    panel("right floor", x, middle + 0.5 * kDoor, right + kPanel);
  }
  const ParticleState& p = from.particles();
  const int tiles = along * across;
  std::vector<int> order(static_cast<std::size_t>(tiles) * kCubes);
  std::iota(order.begin(), order.end(), 0);
  scenes::Random random(5);
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    const auto k = static_cast<std::size_t>(random.uniform(0, static_cast<double>(i + 1)));
    std::swap(order[i], order[std::min(k, i)]);
  }
  const auto corner = [&](int k) {
    return Vec3((k % along + 0.5) * pitch_x + 0.5 * kPanel - half.x(),
                (k / along + 0.5) * pitch_y + 0.5 * kPanel - half.y(), 0);
  };
  for (const int k : order) {
    const int cube = k % kCubes;
    bed.position.push_back(p.position[cube] + corner(k / kCubes));
    bed.orientation.push_back(from.shape_orientation(cube));
    bed.velocity.push_back(p.velocity[cube]);
    bed.angular_velocity.push_back(p.angular_velocity[cube]);
  }
  scenes::add_particles(model, 0, static_cast<int>(order.size()));
  if (t.stirrer) {
    const BoundaryState& stirrer = from.boundaries()[t.stirrer_boundary];
    for (int k = 0; k < tiles; ++k)
      add_stirrer(model, stirrer.position + corner(k), stirrer.orientation);
  }
  return bed;
}

Solver start(const Tiled& bed, int threads) {
  Model model = bed.model;
  model.numerics.threads = threads;
  Solver solver(std::move(model));
  for (std::size_t i = 0; i < bed.position.size(); ++i) {
    solver.insert(static_cast<int>(i), bed.position[i], bed.orientation[i], bed.velocity[i],
                  bed.angular_velocity[i]);
  }
  return solver;
}

}  // namespace firn::beds
