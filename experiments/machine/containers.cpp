// Trough, chute, container, drum, platen and trap door box.
#include <algorithm>
#include <cmath>

#include "experiments/machine/dimension_checks.h"
#include "experiments/machine/parts.h"

namespace firn {
namespace {

std::vector<Point2> rectangle(double width, double height) {
  return {{width / 2, -height / 2},
          {width / 2, height / 2},
          {-width / 2, height / 2},
          {-width / 2, -height / 2}};
}

// The band between two closed outlines of as many corners, each counter-clockwise.
void add_band(Section& section, const std::vector<Point2>& inner,
              const std::vector<Point2>& outer) {
  for (std::size_t i = 0; i < inner.size(); ++i) {
    const std::size_t next = (i + 1) % inner.size();
    section.add({outer[i], outer[next], inner[next], inner[i]});
  }
}

// What a closed outline encloses, in two halves: an end of a drum with many lifters has more sides
// than a part may have internal faces.
void add_inside(Section& section, const std::vector<Point2>& outline) {
  const auto half = static_cast<std::ptrdiff_t>(outline.size() / 2);
  section.add({outline.begin(), outline.begin() + half + 1});
  std::vector<Point2> rest(outline.begin() + half, outline.end());
  rest.push_back(outline.front());
  section.add(rest);
}

// Corners of a ring's inside and outside.
struct Ring {
  std::vector<Point2> inner, outer;
};
Ring round_ring(double diameter, double wall) {
  // Flats of the same wall: the outer corners lie farther out by 1 / cos.
  return {circle(diameter / 2, kCircle),
          circle(diameter / 2 + wall / std::cos(std::numbers::pi / kCircle), kCircle)};
}
Ring square_ring(double width, double height, double wall) {
  return {rectangle(width, height), rectangle(width + 2 * wall, height + 2 * wall)};
}

Point2 point_at(double radius, double angle) {
  return Point2(radius * std::cos(angle), radius * std::sin(angle));
}

// Half the angle of the flat on which a lifter stands; 0 without lifters.
double lifter_flat(const Drum& d) {
  if (d.lifters <= 0) return 0;
  const double radius = d.diameter / 2, half = d.lifter_thickness / 2;
  require(half < radius * std::sin(std::numbers::pi / d.lifters) && d.lifter_thickness < radius,
          "lifter_thickness",
          fmt::format("leaves no room between {} lifters; expected less", d.lifters));
  const double flat = std::asin(half / radius);
  require(std::hypot(radius * std::cos(flat) - d.lifter_height, half) > half &&
              d.lifter_height < 0.9 * radius,
          "lifter_height", "reaches the axis; expected less");
  return flat;
}

// The wall of a drum, with a flat for each lifter between two corners of the circle, and `strips`
// flats from one lifter to the next.
struct DrumRing {
  Ring ring;
  int strips = 0;
};
DrumRing drum_ring(const Drum& d) {
  const double radius = d.diameter / 2, flat = lifter_flat(d);
  const int spans = std::max(d.lifters, 1);
  const double span = 2 * std::numbers::pi / spans - 2 * flat;
  DrumRing drum;
  drum.strips =
      std::max(1, static_cast<int>(std::ceil(kCircle * span / (2 * std::numbers::pi) - 1e-9)));
  for (int k = 0; k < spans; ++k) {
    for (int i = 0; i <= drum.strips; ++i) {
      if (d.lifters == 0 && i == drum.strips) continue;
      const double angle = 2 * std::numbers::pi * k / spans + flat + span * i / drum.strips;
      drum.ring.inner.push_back(point_at(radius, angle));
      drum.ring.outer.push_back(point_at(radius + d.wall, angle));
    }
  }
  return drum;
}

void add_lifters(Section& section, const Drum& d, const DrumRing& drum) {
  const int spans = std::max(d.lifters, 1);
  const std::vector<Point2>& corners = drum.ring.inner;
  for (int k = 0; k < d.lifters; ++k) {
    const std::size_t first = k * (drum.strips + 1),
                      before = (first + corners.size() - 1) % corners.size();
    const double angle = 2 * std::numbers::pi * k / spans;
    const Point2 inwards = -d.lifter_height * point_at(1, angle);
    section.add(
        {corners[before], corners[first], corners[first] + inwards, corners[before] + inwards});
  }
}

}  // namespace

Solid make_trough(const Trough& t) {
  require_above_zero(t.radius, "radius");
  require_above_zero(t.length, "length");
  require_above_zero(t.wall, "wall");
  require(t.angle > 0 && t.angle <= std::numbers::pi, "angle",
          fmt::format("is {}; expected up to 180 deg", in_degrees(t.angle)));
  const int strips =
      std::max(1, static_cast<int>(std::ceil(kCircle * t.angle / (2 * std::numbers::pi) - 1e-9)));
  const double outer = t.radius + t.wall / std::cos(t.angle / (2 * strips));
  const auto corner = [&](double radius, int i) {
    const double angle = t.angle * (static_cast<double>(i) / strips - 0.5);
    return Point2(radius * std::sin(angle), -radius * std::cos(angle));
  };
  Section section;
  for (int i = 0; i < strips; ++i) {
    section.add(
        {corner(outer, i), corner(outer, i + 1), corner(t.radius, i + 1), corner(t.radius, i)});
  }
  return extrude(section, stations_along_x(section, {{-t.length / 2, 0}, {t.length / 2, 0}}));
}

Solid make_chute(const Chute& c) {
  for (const auto& [value, key] : {std::pair{c.width, "width"},
                                   {c.height, "height"},
                                   {c.diameter, "diameter"},
                                   {c.wall, "wall"},
                                   {c.length, "length"},
                                   {c.bend_length, "bend_length"}}) {
    require_above_zero(value, key);
  }
  require(std::abs(c.inclination) <= 90 * kDegToRad + 1e-9, "inclination",
          fmt::format("is {}; expected -90 to 90 deg", in_degrees(c.inclination)));
  require(std::abs(c.bend) <= 120 * kDegToRad, "bend",
          fmt::format("is {}; expected -120 to 120 deg", in_degrees(c.bend)));
  const auto leg = [](double fall) { return Vec3(std::cos(fall), 0, -std::sin(fall)); };
  std::vector<Vec3> line = {Vec3::Zero(), c.length * leg(c.inclination)};
  if (c.bend != 0) line.push_back(line.back() + c.bend_length * leg(c.inclination + c.bend));
  const Ring ring =
      c.round ? round_ring(c.diameter, c.wall) : square_ring(c.width, c.height, c.wall);
  Section section;
  add_band(section, ring.inner, ring.outer);
  try {
    return extrude(section, stations_along(section, line));
  } catch (const DimensionError&) {
    throw;
  } catch (const InputError& error) {
    throw DimensionError("bend", error.what());
  }
}

Solid make_container(const Container& c) {
  for (const auto& [value, key] : {std::pair{c.diameter, "diameter"},
                                   {c.length, "length"},
                                   {c.width, "width"},
                                   {c.height, "height"},
                                   {c.wall, "wall"},
                                   {c.floor, "floor"}}) {
    require_above_zero(value, key);
  }
  const Ring ring =
      c.round ? round_ring(c.diameter, c.wall) : square_ring(c.length, c.width, c.wall);
  Section section;
  add_band(section, ring.inner, ring.outer);
  Filling filling(ring.inner.size(), {true, true});
  section.add(ring.inner);  // in one piece: things stand on it
  filling.resize(section.polygons().size(), {true, false});
  return extrude(section, stations_along_z(section, {-c.floor, 0, c.height}), filling);
}

Solid make_drum(const Drum& d) {
  for (const auto& [value, key] : {std::pair{d.diameter, "diameter"},
                                   {d.length, "length"},
                                   {d.wall, "wall"},
                                   {d.lifter_height, "lifter_height"},
                                   {d.lifter_thickness, "lifter_thickness"}}) {
    require_above_zero(value, key);
  }
  const DrumRing drum = drum_ring(d);
  const Ring& ring = drum.ring;
  Section section;
  add_band(section, ring.inner, ring.outer);
  add_inside(section, ring.inner);
  add_lifters(section, d, drum);
  // Lifters end a little before the end walls, so that the end walls stay whole discs.
  const double gap = 1e-3 * d.length, end = d.length / 2;
  Filling filling(ring.inner.size(), std::vector<bool>(5, true));
  filling.resize(ring.inner.size() + 2, {true, false, false, false, true});
  filling.resize(section.polygons().size(), {false, false, true, false, false});
  return extrude(section,
                 stations_along_x(section, {{-end - d.wall, 0},
                                            {-end, 0},
                                            {gap - end, 0},
                                            {end - gap, 0},
                                            {end, 0},
                                            {end + d.wall, 0}}),
                 filling);
}

Solid make_platen(const Platen& p) {
  for (const auto& [value, key] : {std::pair{p.diameter, "diameter"},
                                   {p.length, "length"},
                                   {p.width, "width"},
                                   {p.thickness, "thickness"}}) {
    require_above_zero(value, key);
  }
  Section section;
  section.add(p.round ? circle(p.diameter / 2, kCircle) : rectangle(p.length, p.width));
  return extrude(section, stations_along_z(section, {-p.thickness / 2, p.thickness / 2}));
}

Solid make_trap_door_box(const TrapDoorBox& b) {
  for (const auto& [value, key] : {std::pair{b.length, "length"},
                                   {b.width, "width"},
                                   {b.height, "height"},
                                   {b.wall, "wall"},
                                   {b.floor, "floor"}}) {
    require_above_zero(value, key);
  }
  require(b.door_length > 0 && b.door_length < b.length, "door_length",
          fmt::format("is {}; expected more than zero and less than the box's {}",
                      in_mm(b.door_length), in_mm(b.length)));
  const double in = b.width / 2, out = in + b.wall;
  const auto block = [](double left, double right, double low, double high) -> std::vector<Point2> {
    return {{left, low}, {right, low}, {right, high}, {left, high}};
  };
  Section section;
  Filling filling;
  for (const auto& [low, high] : {std::pair{-b.floor, 0.0}, {0.0, b.height}}) {
    section.add(block(-out, -in, low, high));
    section.add(block(in, out, low, high));
    filling.resize(section.polygons().size(), std::vector<bool>(5, true));
    section.add(block(-in, in, low, high));
    filling.push_back(low < 0 ? std::vector<bool>{true, true, false, true, true}
                              : std::vector<bool>{true, false, false, false, true});
  }
  const double end = b.length / 2, door = b.door_length / 2;
  const std::vector<Station> places = {{-end - b.wall, 0}, {-end, 0}, {-door, 0},
                                       {door, 0},          {end, 0},  {end + b.wall, 0}};
  return extrude(section, stations_along_x(section, places), filling);
}

}  // namespace firn
