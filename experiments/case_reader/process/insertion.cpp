#include "experiments/case_reader/process/insertion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/analysis/random_stream.h"
#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// Bodies put down at random without touching stop finding room at about this solid fraction.
constexpr double kDensestPour = 0.3;

// Beyond what any machine simulates: a slip of the keyboard, caught before memory runs out.
constexpr int kMostParticles = 10'000'000;

// Stream number of [[particles]] in the random generator; those of the fills count from 0.
constexpr std::uint64_t kPlacedStream = ~std::uint64_t{0};

// Equal bodies in rows along the world's axes.
struct Grid {
  std::array<int, 3> count{1, 1, 1};
  Vec3 spacing = Vec3::Zero();  // m
};

Grid read_grid(const TomlTable& t) {
  Grid grid;
  if (!t.has("grid")) {
    if (t.has("spacing")) t.fail("spacing", "has no meaning without a grid; expected one");
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
struct Jitter {
  Vec3 scatter = Vec3::Zero();  // m, half widths about the position
  double turn = 0;              // rad, half width about `axis`
  Vec3 axis = Vec3::UnitZ();    // unit, world
  bool any_orientation = false;
};

Jitter read_jitter(const TomlTable& t) {
  Jitter jitter;
  jitter.scatter = t.vector("position_jitter", dimension::length, "0 0 0 m");
  if (jitter.scatter.minCoeff() < 0) {
    t.fail("position_jitter", "has a component below zero; expected half widths of at least zero");
  }
  jitter.any_orientation = t.boolean("random_orientation", false);
  if (t.has("rotation_jitter")) {
    jitter.turn = t.quantity("rotation_jitter", dimension::angle, Sign::non_negative);
    if (!t.has("rotation_jitter_axis")) t.set("rotation_jitter_axis", toml::array{0, 0, 1});
    jitter.axis = t.direction("rotation_jitter_axis");
  } else if (t.has("rotation_jitter_axis")) {
    t.fail("rotation_jitter_axis", "has no meaning without a turn; expected one");
  }
  return jitter;
}

// Each body has a separate random stream and draws the same numbers whichever keys are set.
void apply_jitter(Case::InitialParticle& p, const Jitter& jitter, std::uint64_t seed) {
  RandomStream random(seed, kPlacedStream, static_cast<std::uint64_t>(p.particle));
  const auto about_zero = [&] { return 2 * random.uniform() - 1; };
  const double x = about_zero(), y = about_zero(), z = about_zero(), turn = about_zero();
  const Quat any = random.uniform_rotation();
  p.position += jitter.scatter.cwiseProduct(Vec3(x, y, z));
  if (jitter.any_orientation) p.orientation = any;
  if (jitter.turn > 0) {
    p.orientation = Quat(Eigen::AngleAxisd(jitter.turn * turn, jitter.axis)) * p.orientation;
    p.orientation.normalize();
  }
}

// By count, or by a mass that whole bodies make up to the nearest one.
int read_amount(const TomlTable& t, const Shape& shape) {
  if (!t.has("mass")) return read_count(t);
  if (t.has("count")) t.fail("mass", "is given together with count; expected one of the two");
  const double bodies = t.quantity("mass", dimension::mass, Sign::positive) / shape.mass;
  if (bodies < 0.5 || bodies > kMostParticles)
    t.fail("mass", fmt::format("makes {:.3g} bodies of {:.4g} kg; expected at least one", bodies,
                               shape.mass));
  return static_cast<int>(std::lround(bodies));
}

// The places of a grid, z first, then y, then x.
std::vector<Vec3> grid_positions(const TomlTable& t) {
  const Vec3 first = t.vector("position", dimension::length);
  const Grid grid = read_grid(t);
  std::vector<Vec3> positions;
  for (int i = 0; i < grid.count[0]; ++i)
    for (int j = 0; j < grid.count[1]; ++j)
      for (int k = 0; k < grid.count[2]; ++k)
        positions.emplace_back(first + Vec3(i, j, k).cwiseProduct(grid.spacing));
  return positions;
}

// `shape`: the body at each place, or the pieces that make it up as they are drawn.
std::vector<Inlet::Piece> read_pieces(const TomlTable& t, const std::vector<Shape>& shapes) {
  if (!t.is_list("shape"))
    return {{shapes[index(shape_index(t, "shape", shapes))].name, Vec3::Zero()}};
  std::vector<Inlet::Piece> pieces;
  Vec3 moment = Vec3::Zero();  // kg m
  double mass = 0;             // kg
  for (const std::string& name : t.strings("shape")) {
    const Shape& shape = shapes[index(shape_index(t, "shape", name, shapes))];
    if (std::ranges::find(pieces, name, &Inlet::Piece::shape) != pieces.end())
      t.fail("shape",
             fmt::format("lists \"{}\" twice, at the same place; expected each piece once", name));
    pieces.push_back({shape.name, shape.centroid});
    moment += shape.mass * shape.centroid;
    mass += shape.mass;
  }
  if (pieces.size() < 2)
    t.fail("shape", "lists fewer than two pieces; expected the name of a shape, or of its pieces");
  for (Inlet::Piece& piece : pieces) piece.offset -= moment / mass;
  return pieces;
}

void read_region(const TomlTable& t, Vec3& lower, Vec3& upper) {
  lower = t.vector("region_min", dimension::length);
  upper = t.vector("region_max", dimension::length);
  if ((upper - lower).minCoeff() <= 0)
    t.fail("region_max", "is not beyond region_min along every axis; expected a box");
}

}  // namespace

void read_particles(const TomlTable& root, Case& c) {
  Model& model = c.model;
  for (const TomlTable& t : root.tables("particles")) {
    t.allow({"shape", "position", "orientation", "velocity", "angular_velocity", "tag", "grid",
             "spacing", "position_jitter", "rotation_jitter", "rotation_jitter_axis",
             "random_orientation"});
    const Particle particle{shape_index(t, "shape", model.shapes), t.integer("tag", 0, 0)};
    Case::InitialParticle first;
    const std::vector<Vec3> positions = grid_positions(t);
    first.orientation = t.orientation("orientation");
    first.velocity = t.vector("velocity", dimension::velocity, "0 0 0 m/s");
    first.angular_velocity =
        t.vector("angular_velocity", dimension::angular_velocity, "0 0 0 rad/s");
    const Jitter jitter = read_jitter(t);
    for (const Vec3& position : positions) {
      Case::InitialParticle p = first;
      p.particle = static_cast<int>(model.particles.size());
      p.position = position;
      apply_jitter(p, jitter, c.seed);
      model.particles.push_back(particle);
      c.placed.push_back(p);
      c.particle_places.push_back(t.place());
    }
  }
}

std::vector<Fill> read_fills(const TomlTable& root, const std::vector<Shape>& shapes) {
  std::vector<Fill> fills;
  for (const TomlTable& t : root.tables("fills")) {
    t.allow({"shape", "count", "mass", "tag", "tag_mode", "region_min", "region_max", "start",
             "interval", "batch", "velocity", "random_orientation", "stage"});
    Fill fill;
    const Shape& shape = shapes[shape_index(t, "shape", shapes)];
    fill.shape = shape.name;
    fill.count = read_amount(t, shape);
    fill.tag = t.integer("tag", 0, 0);
    fill.tag_by_batch = t.choice("tag_mode", {"fill", "batch"}, "fill") == "batch";
    fill.stage = t.has("stage") ? t.string("stage") : "";
    read_region(t, fill.region_min, fill.region_max);
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
    table.fail("count", fmt::format("{} of \"{}\" at once ({:.4g} x {:.4g} x {:.4g} mm, {:.4g} L "
                                    "in all) do not fit a region "
                                    "of {:.4g} x {:.4g} x {:.4g} m, of which random placement "
                                    "fills {:.0f} % at most ({:.4g} L); expected fewer or a larger "
                                    "region",
                                    at_once, shape.name, 1e3 * shape.box.x(), 1e3 * shape.box.y(),
                                    1e3 * shape.box.z(), 1e3 * solid, region.x(), region.y(),
                                    region.z(), 100 * kDensestPour, 1e3 * kDensestPour * room));
  }
}

std::vector<Outlet> read_outlets(const TomlTable& root) {
  std::vector<Outlet> outlets;
  for (const TomlTable& t : root.tables("outlets")) {
    t.allow({"name", "point", "normal"});
    Outlet outlet;
    outlet.name = unique_table_name(t, outlets);
    outlet.point = t.vector("point", dimension::length);
    outlet.normal = t.direction("normal");
    outlets.push_back(outlet);
  }
  return outlets;
}

std::vector<Sensor> read_sensors(const TomlTable& root) {
  std::vector<Sensor> sensors;
  for (const TomlTable& t : root.tables("sensors")) {
    t.allow({"name", "region_min", "region_max", "point", "normal"});
    Sensor sensor;
    sensor.name = unique_table_name(t, sensors);
    sensor.is_box = t.has("region_min");
    if (sensor.is_box == t.has("point"))
      t.fail("point", "expected either region_min and region_max, or point and normal");
    if (sensor.is_box) {
      read_region(t, sensor.region_min, sensor.region_max);
    } else {
      sensor.point = t.vector("point", dimension::length);
      sensor.normal = t.direction("normal");
    }
    sensors.push_back(sensor);
  }
  return sensors;
}

std::vector<TagRule> read_tag_rules(const TomlTable& root) {
  std::vector<TagRule> rules;
  for (const TomlTable& t : root.tables("tag_rules")) {
    t.allow({"stage", "axis", "bins", "first", "region_min", "region_max"});
    TagRule rule;
    rule.stage = t.string("stage");
    const std::string axis = t.choice("axis", {"x", "y", "z"}, "x");
    rule.axis = axis[0] - 'x';
    rule.bins = t.integer("bins", 1, 1);
    rule.first = t.integer("first", 0, 1);
    read_region(t, rule.region_min, rule.region_max);
    rules.push_back(rule);
  }
  return rules;
}

std::vector<LimitSwitch> read_limit_switches(const TomlTable& root,
                                             const std::vector<MotionFrame>& frames) {
  std::vector<LimitSwitch> limit_switches;
  for (const TomlTable& t : root.tables("limit_switches")) {
    t.allow({"name", "motion_frame", "axis", "closes_at", "hysteresis", "hold_time"});
    LimitSwitch s;
    s.name = unique_table_name(t, limit_switches);
    s.frame = frame_index(t, "motion_frame", frames);
    s.axis = t.integer("axis", 0, 0);
    const std::optional<FreeBody>& free = frames[static_cast<std::size_t>(s.frame)].free;
    if (!free || s.axis >= static_cast<int>(free->joints.size()))
      t.fail("motion_frame", "has no such joint; expected one of a free body");
    const bool turns = free->joints[static_cast<std::size_t>(s.axis)].kind == Joint::Kind::rotation;
    const Dimension& quantity = turns ? dimension::angle : dimension::length;
    s.closes_at = t.quantity("closes_at", quantity, Sign::any);
    s.opens_at = s.closes_at -
                 t.quantity("hysteresis", quantity, Sign::non_negative, turns ? "2 deg" : "0 m");
    s.hold = t.quantity("hold_time", dimension::time, Sign::non_negative, "0 s");
    limit_switches.push_back(s);
  }
  return limit_switches;
}

std::vector<Inlet> read_inlets(const TomlTable& root, const std::vector<Shape>& shapes) {
  std::vector<Inlet> inlets;
  for (const TomlTable& t : root.tables("inlets")) {
    t.allow({"name", "shape", "position", "orientation", "grid", "spacing", "velocity",
             "position_jitter", "rotation_jitter", "rotation_jitter_axis", "random_orientation",
             "tag", "tag_mode", "start", "interval", "batches", "stage"});
    Inlet source;
    source.name = unique_table_name(t, inlets);
    source.pieces = read_pieces(t, shapes);
    source.positions = grid_positions(t);
    source.orientation = t.orientation("orientation");
    source.velocity = t.vector("velocity", dimension::velocity, "0 0 0 m/s");
    const Jitter jitter = read_jitter(t);
    source.position_jitter = jitter.scatter;
    source.rotation_jitter = jitter.turn;
    source.rotation_jitter_axis = jitter.axis;
    source.random_orientation = jitter.any_orientation;
    source.tag = t.integer("tag", 0, 0);
    source.tag_by_batch = t.choice("tag_mode", {"inlet", "batch"}, "inlet") == "batch";
    source.start = t.quantity("start", dimension::time, Sign::non_negative, "0 s");
    source.batches = t.integer("batches", 1, 1);
    source.interval = t.quantity("interval", dimension::time, Sign::non_negative, "0 s");
    if (source.batches > 1 && source.interval == 0)
      t.fail("interval", "is zero for several batches; expected the time between them");
    source.stage = t.has("stage") ? t.string("stage") : "";
    if (static_cast<double>(source.batches) * static_cast<double>(source.batch_size()) >
        kMostParticles)
      t.fail("batches", fmt::format("makes more than {} bodies; expected fewer", kMostParticles));
    inlets.push_back(source);
  }
  return inlets;
}

std::vector<int> first_inlet_particles(const Case& c) {
  std::size_t next = c.model.particles.size();
  const auto bodies = [](const Inlet& source) {
    return static_cast<std::size_t>(source.batches) * source.batch_size();
  };
  for (const Inlet& source : c.inlets) next -= bodies(source);
  std::vector<int> first;
  for (const Inlet& source : c.inlets) {
    first.push_back(static_cast<int>(next));
    next += bodies(source);
  }
  return first;
}

InletPose inlet_pose(const Inlet& source, std::size_t number, int particle, std::uint64_t seed) {
  const std::size_t pieces = source.pieces.size(), piece = number % pieces;
  Case::InitialParticle p;
  p.particle = particle - static_cast<int>(piece);  // the first piece has the place's jitter
  p.position = source.positions[number / pieces];
  p.orientation = source.orientation;
  apply_jitter(p,
               {source.position_jitter, source.rotation_jitter, source.rotation_jitter_axis,
                source.random_orientation},
               seed);
  return {p.position + p.orientation * source.pieces[piece].offset, p.orientation};
}

}  // namespace firn
