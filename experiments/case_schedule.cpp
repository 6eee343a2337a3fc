#include "experiments/case_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "experiments/case_boundaries.h"
#include "experiments/case_shapes.h"
#include "experiments/placement.h"

namespace firn {
namespace {

// Bodies put down at random without touching stop finding room at about this solid fraction.
constexpr double kDensestPour = 0.3;

// Beyond what any machine simulates: a slip of the keyboard, caught before memory runs out.
constexpr int kMostParticles = 10'000'000;

// The stream of random numbers of [[particles]], beside those of the fills, which count from 0.
constexpr std::uint64_t kPlacedStream = ~std::uint64_t{0};

// Equal bodies in rows along the world's axes.
struct Grid {
  std::array<int, 3> count{1, 1, 1};
  Vec3 spacing = Vec3::Zero();  // m
};

Grid read_grid(const TomlTable& t) {
  Grid grid;
  if (!t.has("grid")) {
    if (t.has("spacing")) t.fail("spacing", "has no meaning here; expected a grid beside it");
    return grid;
  }
  grid.count = t.counts("grid");
  const double total = 1.0 * grid.count[0] * grid.count[1] * grid.count[2];
  if (total > kMostParticles) {
    t.fail("grid", fmt::format("makes {:.0f} bodies; expected at most {}", total, kMostParticles));
  }
  grid.spacing = t.vector("spacing", dimension::length);
  return grid;
}

// What the seed decides about a placed body.
struct Chance {
  Vec3 scatter = Vec3::Zero();  // m, half widths about the position
  double turn = 0;              // rad, half width about `axis`
  Vec3 axis = Vec3::UnitZ();    // unit, world
  bool any_orientation = false;
};

Chance read_chance(const TomlTable& t) {
  Chance chance;
  chance.scatter = t.vector("scatter", dimension::length, "0 0 0 m");
  if (chance.scatter.minCoeff() < 0) {
    t.fail("scatter", "has a component below zero; expected half widths of at least zero");
  }
  chance.any_orientation = t.boolean("random_orientation", false);
  if (t.has("turn")) {
    chance.turn = t.quantity("turn", dimension::angle, Sign::non_negative);
    if (!t.has("turn_axis")) t.set("turn_axis", toml::array{0, 0, 1});
    chance.axis = t.direction("turn_axis");
  } else if (t.has("turn_axis")) {
    t.fail("turn_axis", "has no meaning here; expected a turn beside it");
  }
  return chance;
}

// Each body has a stream of its own, and draws the same numbers whatever the table asks for.
void disturb(Case::Placed& p, const Chance& chance, std::uint64_t seed) {
  RandomStream random(seed, kPlacedStream, static_cast<std::uint64_t>(p.particle));
  const auto about_zero = [&] { return 2 * random.uniform() - 1; };
  const double x = about_zero(), y = about_zero(), z = about_zero(), turn = about_zero();
  const Quat any = random.uniform_rotation();
  p.position += chance.scatter.cwiseProduct(Vec3(x, y, z));
  if (chance.any_orientation) p.orientation = any;
  if (chance.turn > 0) {
    p.orientation = Quat(Eigen::AngleAxisd(chance.turn * turn, chance.axis)) * p.orientation;
    p.orientation.normalize();
  }
}

}  // namespace

std::vector<Case::Placed> read_particles(const TomlTable& root, Model& model, std::uint64_t seed) {
  std::vector<Case::Placed> placed;
  for (const TomlTable& t : root.tables("particles")) {
    t.allow({"shape", "position", "orientation", "velocity", "angular_velocity", "tag", "grid",
             "spacing", "scatter", "turn", "turn_axis", "random_orientation"});
    const Particle particle{shape_index(t, "shape", model.shapes), t.integer("tag", 0, 0)};
    Case::Placed first;
    first.position = t.vector("position", dimension::length);
    first.orientation = t.orientation("orientation");
    first.velocity = t.vector("velocity", dimension::velocity, "0 0 0 m/s");
    first.angular_velocity =
        t.vector("angular_velocity", dimension::angular_velocity, "0 0 0 rad/s");
    const Grid grid = read_grid(t);
    const Chance chance = read_chance(t);
    for (int i = 0; i < grid.count[0]; ++i) {
      for (int j = 0; j < grid.count[1]; ++j) {
        for (int k = 0; k < grid.count[2]; ++k) {
          Case::Placed p = first;
          p.particle = static_cast<int>(model.particles.size());
          p.position += Vec3(i, j, k).cwiseProduct(grid.spacing);
          disturb(p, chance, seed);
          model.particles.push_back(particle);
          placed.push_back(p);
        }
      }
    }
  }
  return placed;
}

std::vector<Fill> read_fills(const TomlTable& root, const std::vector<Shape>& shapes) {
  std::vector<Fill> fills;
  for (const TomlTable& t : root.tables("fills")) {
    t.allow({"shape", "count", "tag", "region_min", "region_max", "start", "interval", "batch",
             "velocity", "random_orientation"});
    Fill fill;
    const Shape& shape = shapes[shape_index(t, "shape", shapes)];
    fill.shape = shape.name;
    fill.count = read_count(t);
    fill.tag = t.integer("tag", 0, 0);
    fill.region_min = t.vector("region_min", dimension::length);
    fill.region_max = t.vector("region_max", dimension::length);
    if ((fill.region_max - fill.region_min).minCoeff() <= 0) {
      t.fail("region_max", "is not beyond region_min along every axis; expected a box");
    }
    fill.start = t.quantity("start", dimension::time, Sign::non_negative, "0 s");
    fill.interval = t.quantity("interval", dimension::time, Sign::non_negative, "0 s");
    fill.batch = t.integer("batch", 0, 0);
    fill.velocity = t.vector("velocity", dimension::velocity, "0 0 0 m/s");
    fill.random_orientation = t.boolean("random_orientation", true);
    check_fill(t, fill, shape);
    fills.push_back(fill);
  }
  return fills;
}

int read_count(const TomlTable& table) {
  return static_cast<int>(table.integer64("count", 1, kMostParticles));
}

void check_fill(const TomlTable& table, const Fill& fill, const Shape& shape) {
  const bool batches = fill.batch > 0 && fill.batch < fill.count;
  if (batches && fill.interval == 0) {
    table.fail("interval", fmt::format("is zero for batches of {} out of {}; expected a time above "
                                       "zero between them",
                                       fill.batch, fill.count));
  }
  if (fill.interval > 0 && fill.batch == 0) {
    table.fail("batch",
               "is zero although there is an interval; expected the number of particles "
               "in a batch");
  }
  const Vec3 region = fill.region_max - fill.region_min;
  const int at_once = batches ? fill.batch : fill.count;
  const double solid = at_once * shape.volume, room = region.prod();
  if (region.minCoeff() < shape.box.minCoeff() || solid > kDensestPour * room) {
    table.fail(
        "count",
        fmt::format(
            "{} of \"{}\" at once, {:.4g} L, do not fit a region of {:.4g} x {:.4g} x {:.4g} m, of "
            "which random placement fills {:.0f} % at most ({:.4g} L); expected fewer or a larger "
            "region",
            at_once, shape.name, 1e3 * solid, region.x(), region.y(), region.z(),
            100 * kDensestPour, 1e3 * kDensestPour * room));
  }
}

std::vector<Outlet> read_outlets(const TomlTable& root) {
  std::vector<Outlet> outlets;
  for (const TomlTable& t : root.tables("outlets")) {
    t.allow({"name", "point", "normal"});
    Outlet outlet;
    outlet.name = t.string("name");
    if (std::ranges::count(outlets, outlet.name, &Outlet::name)) {
      t.fail("name", fmt::format("\"{}\" is taken already; expected another name", outlet.name));
    }
    outlet.point = t.vector("point", dimension::length);
    outlet.normal = t.direction("normal");
    outlets.push_back(outlet);
  }
  return outlets;
}

std::vector<Stage> read_stages(const TomlTable& root, const std::vector<Boundary>& boundaries) {
  std::vector<Stage> stages;
  for (const TomlTable& t : root.tables("stages")) {
    t.allow({"name", "until", "max_duration", "min_duration", "rest_kinetic_energy", "rest_hold",
             "remove", "motions"});
    Stage stage;
    stage.name = t.string("name");
    if (std::ranges::count(stages, stage.name, &Stage::name)) {
      t.fail("name", fmt::format("\"{}\" is taken already; expected another name", stage.name));
    }
    stage.max_duration = t.quantity("max_duration", dimension::time, Sign::positive);
    stage.min_duration = t.quantity("min_duration", dimension::time, Sign::non_negative, "0 s");
    if (stage.max_duration < stage.min_duration) {
      t.fail("min_duration", fmt::format("is {} s, above max_duration of {} s; expected less",
                                         stage.min_duration, stage.max_duration));
    }
    const std::string until = t.choice("until", {"time", "at_rest", "empty"}, "time");
    if (until == "empty") stage.until = Stage::Until::empty;
    if (until == "at_rest") {
      stage.until = Stage::Until::at_rest;
      stage.rest_kinetic_energy =
          t.quantity("rest_kinetic_energy", dimension::energy, Sign::positive, "1e-6 J");
      stage.rest_hold = t.quantity("rest_hold", dimension::time, Sign::positive, "0.05 s");
    } else {
      for (const char* key : {"rest_kinetic_energy", "rest_hold"}) {
        if (t.has(key)) t.fail(key, "has no meaning here; expected until = \"at_rest\" beside it");
      }
    }
    stage.remove = t.strings("remove");
    for (const std::string& name : stage.remove) boundary_index(t, "remove", name, boundaries);
    for (const TomlTable& m : t.tables("motions")) {
      const std::string name = m.string("boundary");
      boundary_index(m, "boundary", name, boundaries);
      stage.start_motions.emplace_back(name, read_motion(m, true));
    }
    stages.push_back(std::move(stage));
  }
  return stages;
}

}  // namespace firn
