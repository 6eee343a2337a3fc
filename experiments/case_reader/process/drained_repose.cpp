#include "experiments/case_reader/process/drained_repose.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/materials.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/case_reader/process/insertion.h"

namespace firn {
namespace {

// Jammed packings of compact bodies hardly get denser than random close packing of spheres, 0.64.
constexpr double kDensestBed = 0.64;

struct Door {
  std::string opening;  // vanish, drop or slide
  double speed = 0;     // m/s
};

DrainedRepose read_box(const TomlTable& t) {
  DrainedRepose d;
  d.box = t.sizes("box");
  d.door_width = t.quantity("door_width", dimension::length, Sign::positive);
  if (d.door_width >= d.box.x()) {
    t.fail("door_width", fmt::format("is {:.4g} m, not narrower than the box of {:.4g} m; expected "
                                     "a door with a ledge on both sides",
                                     d.door_width, d.box.x()));
  }
  d.floor_thickness = t.quantity("floor_thickness", dimension::length, Sign::positive, "10 mm");
  d.end_margin = t.quantity("end_margin", dimension::length, Sign::non_negative, "25 mm");
  d.door_margin = t.quantity("door_margin", dimension::length, Sign::non_negative, "25 mm");
  const double ledge = (d.box.x() - d.door_width) / 2;
  if (d.end_margin + d.door_margin >= ledge) {
    t.fail(d.end_margin > d.door_margin ? "end_margin" : "door_margin",
           fmt::format("leaves nothing to fit a line to: the margins of {:.4g} m and {:.4g} m meet "
                       "on the ledge of {:.4g} m; expected smaller margins",
                       d.end_margin, d.door_margin, ledge));
  }
  d.drop_height = t.quantity("drop_height", dimension::length, Sign::positive, "0.12 m");
  if (d.drop_height <= d.floor_thickness) {
    t.fail("drop_height", fmt::format("is {:.4g} m, inside the floor of {:.4g} m; expected more",
                                      d.drop_height, d.floor_thickness));
  }
  return d;
}

Door read_door(const TomlTable& t) {
  Door door;
  door.opening = t.choice("door_opening", {"vanish", "drop", "slide"}, "vanish");
  if (door.opening != "vanish") {
    door.speed = t.quantity("door_speed", dimension::velocity, Sign::positive, "1 m/s");
  } else if (t.has("door_speed")) {
    t.fail("door_speed",
           "has no meaning for a door that vanishes; expected door_opening = "
           "\"drop\" or \"slide\" with it");
  }
  return door;
}

void add_walls(const DrainedRepose& d, int material, bool rigid, std::vector<Boundary>& walls) {
  const Vec3 half = d.box / 2;
  std::vector<Boundary> made = {
      plane_boundary("wall left", material, {-half.x(), 0, 0}, Vec3::UnitX()),
      plane_boundary("wall right", material, {half.x(), 0, 0}, -Vec3::UnitX()),
      plane_boundary("wall front", material, {0, -half.y(), 0}, Vec3::UnitY()),
      plane_boundary("wall back", material, {0, half.y(), 0}, -Vec3::UnitY()),
  };
  // The floor reaches into the walls, so that no edge of it lies where a wall begins.
  const double t = d.floor_thickness, lip = d.door_width / 2, depth = d.box.y() + 2 * t;
  const double ledge = half.x() + t - lip, middle = lip + ledge / 2;
  made.push_back(box_boundary("floor left", material, {ledge, depth, t}, {-middle, 0, -t / 2}));
  made.push_back(box_boundary("floor right", material, {ledge, depth, t}, {middle, 0, -t / 2}));
  made.push_back(box_boundary(d.door, material, {d.door_width, depth, t}, {0, 0, -t / 2}));
  for (Boundary& b : made) {
    b.rigid = rigid;
    walls.push_back(std::move(b));
  }
}

// Refuses before the run what the responses would refuse after it.
void check_ledge_window(const TomlTable& t, const DrainedRepose& d, const Shape& shape) {
  const double ledge = (d.box.x() - d.door_width) / 2, particle_size = middle_edge(shape);
  const double window = ledge - d.end_margin - d.door_margin;
  if (window >= 2 * particle_size) return;
  t.fail(d.end_margin > d.door_margin ? "end_margin" : "door_margin",
         fmt::format("leaves {:.4g} m of the ledge of {:.4g} m to fit a line to, less than two "
                     "particle sizes ({:.4g} m, shape \"{}\"); expected smaller margins, a longer "
                     "box or a narrower door",
                     window, ledge, 2 * particle_size, shape.name));
}

Fill read_fill(const TomlTable& t, const DrainedRepose& d, const std::vector<Shape>& shapes) {
  t.allow({"shape", "count", "tag", "pour_bottom", "pour_height", "batch", "interval", "drop_speed",
           "settle_energy", "settle_time", "max_duration"});
  Fill fill;
  const Shape& shape = shapes[shape_index(t, "shape", shapes)];
  fill.shape = shape.name;
  fill.count = read_count(t);
  fill.tag = t.integer("tag", 0, 1);
  const double bottom = t.quantity("pour_bottom", dimension::length, Sign::non_negative, "0 m");
  const double height = t.quantity("pour_height", dimension::length, Sign::positive, "0.8 m");
  fill.region_min = Vec3(-d.box.x() / 2, -d.box.y() / 2, bottom);
  fill.region_max = Vec3(d.box.x() / 2, d.box.y() / 2, bottom + height);
  fill.batch = t.integer("batch", 0, 0);
  fill.interval = t.quantity("interval", dimension::time, Sign::non_negative, "0 s");
  fill.velocity.z() = -t.quantity("drop_speed", dimension::velocity, Sign::non_negative, "0.5 m/s");
  const double solid = fill.count * shape.volume, box = d.box.prod();
  if (solid > kDensestBed * box) {
    t.fail("count",
           fmt::format("is {}: {:.4g} L of \"{}\" do not fit a box of {:.4g} L, of which a "
                       "bed can fill {:.0f} % at most; expected at most {}",
                       fill.count, 1e3 * solid, shape.name, 1e3 * box, 100 * kDensestBed,
                       static_cast<int>(kDensestBed * box / shape.volume)));
  }
  check_fill(t, fill, shape);
  return fill;
}

// The keys of a stage that ends at rest.
Stage read_rest(const TomlTable& t, const char* hold, const char* min_duration,
                const char* max_duration) {
  Stage stage;
  stage.end_when = {Stage::EndEvent::settled};
  stage.settle_energy = t.quantity("settle_energy", dimension::energy, Sign::positive, "1e-6 J");
  stage.settle_time = t.quantity("settle_time", dimension::time, Sign::positive, hold);
  if (min_duration) {
    stage.min_duration =
        t.quantity("min_duration", dimension::time, Sign::non_negative, min_duration);
  }
  stage.max_duration = t.quantity("max_duration", dimension::time, Sign::positive, max_duration);
  if (stage.max_duration < stage.min_duration) {
    t.fail("max_duration", fmt::format("is {} s, less than the least duration {} s; expected more",
                                       stage.max_duration, stage.min_duration));
  }
  return stage;
}

void open_door(const Door& door, const DrainedRepose& d, const std::vector<Boundary>& boundaries,
               Stage& drain) {
  if (door.opening == "vanish") {
    drain.remove = {d.door};
    return;
  }
  Motion motion;
  motion.kind = Motion::Kind::translation;
  if (door.opening == "drop") {
    motion.velocity.z() = -door.speed;
  } else {
    // Out through the back, until all of it is behind the wall.
    motion.velocity.y() = door.speed;
    motion.stop = (d.box.y() + 2 * d.floor_thickness) / door.speed;
  }
  Stage::StartedMotion& start = drain.motions.emplace_back();
  start.boundary =
      static_cast<int>(std::ranges::find(boundaries, d.door, &Boundary::name) - boundaries.begin());
  start.motion = motion;
}

}  // namespace

void read_drained_repose(const TomlTable& t, Case& c) {
  t.allow({"kind", "box", "door_width", "wall_material", "rigid_walls", "floor_thickness",
           "end_margin", "door_margin", "drop_height", "door_opening", "door_speed", "fill",
           "drain"});
  const DrainedRepose d = read_box(t);
  const int material = material_index(t, "wall_material", c.model.materials);
  const bool rigid = t.boolean("rigid_walls", false);
  if (!rigid && c.model.materials[material].young_modulus == 0) {
    t.fail("wall_material", fmt::format("\"{}\" has no young_modulus; expected one, or rigid_walls "
                                        "= true",
                                        c.model.materials[material].name));
  }
  const Door door = read_door(t);
  add_walls(d, material, rigid, c.model.boundaries);

  const TomlTable fill = t.required_table("fill");
  c.fills.push_back(read_fill(fill, d, c.model.shapes));
  check_ledge_window(t, d, *std::ranges::find(c.model.shapes, c.fills.back().shape, &Shape::name));
  Stage filling = read_rest(fill, "0.05 s", nullptr, "4 s");
  filling.name = "fill";
  const TomlTable drain = t.table("drain");
  drain.allow({"min_duration", "settle_energy", "settle_time", "max_duration"});
  // At the start of draining everything is at rest still.
  Stage draining = read_rest(drain, "0.2 s", "0.5 s", "6 s");
  draining.name = "drain";
  open_door(door, d, c.model.boundaries, draining);
  c.stages = {filling, draining};
  c.outlets.push_back({"below the door", Vec3(0, 0, -d.drop_height), -Vec3::UnitZ()});
  c.drained_repose = d;
}

}  // namespace firn
