// Mold, ejector and stripper.
#include <algorithm>
#include <cmath>

#include "experiments/machine/dimension_checks.h"
#include "experiments/machine/parts.h"

namespace firn {
namespace {

double arc_radius(const CrescentParameters& cube) {
  const double sagitta = cube.depth - cube.tip_height;
  return (cube.chord * cube.chord / 4 + sagitta * sagitta) / (2 * sagitta);
}

// The mold across its row, axes y and z: the shell below the arc, and what the webs fill of it.
struct MoldSection {
  Section section;
  std::vector<bool> web;  // [polygon]
};

// Where the arc's polygon is at this y, from its first corner to its last one.
double arc_height(const std::vector<Point2>& arc, double y) {
  const auto next = std::ranges::find_if(arc.begin() + 1, arc.end() - 1,
                                         [y](const Point2& p) { return p.x() >= y; });
  const Point2 &a = *(next - 1), &b = *next;
  return a.y() + (y - a.x()) / (b.x() - a.x()) * (b.y() - a.y());
}

// The polygon between `left` and `right`, the arc and the level `top`.
std::vector<Point2> web_polygon(const std::vector<Point2>& arc, double left, double right,
                                double top) {
  std::vector<Point2> corners = {{left, arc_height(arc, left)}};
  for (const Point2& p : arc) {
    if (p.x() > left && p.x() < right) corners.push_back(p);
  }
  corners.emplace_back(right, arc_height(arc, right));
  corners.emplace_back(right, top);
  corners.emplace_back(left, top);
  return corners;
}

MoldSection mold_section(const Mold& m, double rim, double notch) {
  constexpr int kStrips = 24;
  const double inner = arc_radius(m.cube) + m.clearance, outer = inner + m.wall;
  const double half_angle = std::acos(-rim / inner);
  std::vector<Point2> arc, back;
  for (int i = 0; i <= kStrips; ++i) {
    const double angle = half_angle * (2.0 * i / kStrips - 1);
    arc.emplace_back(inner * std::sin(angle), -inner * std::cos(angle));
    back.emplace_back(outer * std::sin(angle), -outer * std::cos(angle));
  }
  const double edge = std::sqrt(outer * outer - rim * rim);
  back.front() = {-edge, rim};
  back.back() = {edge, rim};
  MoldSection result;
  for (int i = 0; i < kStrips; ++i) {
    result.section.add({back[i], back[i + 1], arc[i + 1], arc[i]});
    result.web.push_back(false);
  }
  const double end = arc.back().x(), half = m.notch_width / 2;
  if (m.notch_width > 0) {
    result.section.add(web_polygon(arc, -half, half, notch));
    for (const auto& side :
         {web_polygon(arc, -end, -half, rim), web_polygon(arc, half, end, rim)}) {
      // Cut at the floor of the channel, so that all pieces meet side to side.
      result.section.add(clip_polygon(side, notch, false));
      result.section.add(clip_polygon(side, notch, true));
    }
  } else {
    result.section.add(web_polygon(arc, -end, end, rim));
  }
  result.web.resize(result.section.polygons().size(), true);
  return result;
}

void check(const Mold& m, double rim, double half_width_at_rim) {
  require(m.cube.tip_height > 0 && m.cube.tip_height < m.cube.depth &&
              m.cube.depth - m.cube.tip_height <= m.cube.chord / 2,
          "depth", "and tip make no arc of the chord; expected tip < depth <= tip + chord / 2");
  require(m.clearance >= 0, "clearance", "is below zero; expected zero or more");
  require(m.freeboard >= 0, "freeboard", "is below zero; expected zero or more");
  require(
      rim < 0, "freeboard",
      fmt::format("lifts the rim to the axis of the arc, {} above the water line; expected less",
                  in_mm(m.freeboard - rim)));
  require_above_zero(m.wall, "wall");
  const double deepest = m.cube.depth + m.clearance + m.wall;
  require(m.cube.width / 2 + m.clearance > deepest * std::tan(m.cube.draft), "draft",
          fmt::format("closes the cavity before its floor, {} below the water line; expected a "
                      "smaller angle",
                      in_mm(deepest)));
  require(m.pitch > 2 * half_width_at_rim, "pitch",
          fmt::format("is {}, and a cavity {} wide at the rim; expected more, for a web between",
                      in_mm(m.pitch), in_mm(2 * half_width_at_rim)));
  require(m.notch_width >= 0 && m.notch_width < m.cube.chord / 2, "notch_width",
          "is not between zero and half the chord; expected a narrower channel");
  require(
      m.notch_depth >= 0 && m.notch_depth < 0.75 * (m.cube.depth - m.cube.tip_height),
      "notch_depth",
      "is not between zero and three quarters of the arc's depth; expected a shallower channel");
}

}  // namespace

double water_line(const CrescentParameters& cube) { return cube.depth - arc_radius(cube); }

Solid make_mold(const Mold& m) {
  const double water = water_line(m.cube), rim = water + m.freeboard;
  const double lean = std::tan(m.cube.draft);
  // Half the width of a cavity: at + lean * z.
  const double at = m.cube.width / 2 + m.clearance - lean * water;
  check(m, rim, at + lean * rim);
  const auto [section, web] = mold_section(m, rim, water - m.notch_depth);
  const double last = (m.cavities - 1) / 2.0 * m.pitch;  // x of the last cavity
  const double end = last + at + lean * rim + m.wall;
  std::vector<Station> places = {{-end, 0}};
  for (int k = 0; k < m.cavities; ++k) {
    const double middle = k * m.pitch - last;
    places.push_back({middle - at, -lean});
    places.push_back({middle + at, lean});
  }
  places.push_back({end, 0});
  Filling filling;
  for (const bool only_webs : web) {
    std::vector<bool>& layers = filling.emplace_back();
    for (std::size_t j = 0; j + 1 < places.size(); ++j) layers.push_back(!only_webs || j % 2 == 0);
  }
  return extrude(section, stations_along_x(section, places), filling);
}

Solid make_ejector(const Ejector& e) {
  const double radius = e.shaft_diameter / 2;
  require_above_zero(e.shaft_diameter, "shaft_diameter");
  require_above_zero(e.blade_width, "blade_width");
  require(e.blade_thickness > 0 && e.blade_thickness < e.shaft_diameter, "blade_thickness",
          fmt::format("is {}; expected more than zero and less than the shaft's {}",
                      in_mm(e.blade_thickness), in_mm(e.shaft_diameter)));
  require(e.tip_radius > radius, "tip_radius",
          fmt::format("is {}, inside the shaft; expected more than {}", in_mm(e.tip_radius),
                      in_mm(radius)));
  require(e.pitch > e.blade_width, "pitch",
          fmt::format("is {}; expected more than the blades' width of {}", in_mm(e.pitch),
                      in_mm(e.blade_width)));
  const double last = (e.blades - 1) / 2.0 * e.pitch;  // x of the last blade
  require(e.shaft_length / 2 > last + e.blade_width / 2, "shaft_length",
          fmt::format("is {}; expected more than the row of blades, {}", in_mm(e.shaft_length),
                      in_mm(2 * last + e.blade_width)));
  // The shaft has a flat as wide as the blade is thick, on which the blade stands.
  constexpr int kRest = 16;
  const double flat = std::asin(e.blade_thickness / e.shaft_diameter);
  std::vector<Point2> shaft;
  for (int i = 0; i <= kRest; ++i) {
    const double angle = flat + (2 * std::numbers::pi - 2 * flat) * i / kRest;
    shaft.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  const Point2 below = shaft.back(), above = shaft.front();
  Section section;
  section.add(shaft);
  section.add({below, {e.tip_radius, below.y()}, {e.tip_radius, above.y()}, above});
  std::vector<Station> places = {{-e.shaft_length / 2, 0}};
  for (int k = 0; k < e.blades; ++k) {
    for (const double side : {-0.5, 0.5}) {
      places.push_back({k * e.pitch - last + side * e.blade_width, 0});
    }
  }
  places.push_back({e.shaft_length / 2, 0});
  Filling filling(2);
  for (std::size_t j = 0; j + 1 < places.size(); ++j) {
    filling[0].push_back(true);
    filling[1].push_back(j % 2 == 1);
  }
  return extrude(section, stations_along_x(section, places), filling);
}

Solid make_stripper(const Stripper& s) {
  require_above_zero(s.thickness, "thickness");
  require(s.finger_width > 0 && s.finger_width < s.pitch, "finger_width",
          fmt::format("is {}; expected more than zero and less than the pitch of {}, so that a "
                      "blade passes between",
                      in_mm(s.finger_width), in_mm(s.pitch)));
  require(s.far > s.near, "far",
          fmt::format("is {}; expected more than near, {}", in_mm(s.far), in_mm(s.near)));
  require(s.apron > 0 && s.apron < s.far - s.near, "apron",
          fmt::format("is {}; expected more than zero and less than the fingers' {}",
                      in_mm(s.apron), in_mm(s.far - s.near)));
  require(s.slope >= 0 && s.slope < 80 * kDegToRad, "slope",
          "is not between 0 and 80 deg; expected a slope that cubes slide down");
  const double depth = s.thickness / std::cos(s.slope);
  const auto top = [&](double y) { return s.height - (y - s.near) * std::tan(s.slope); };
  const auto slab = [&](double from, double to) -> std::vector<Point2> {
    return {{from, top(from) - depth}, {to, top(to) - depth}, {to, top(to)}, {from, top(from)}};
  };
  Section section;
  section.add(slab(s.near, s.far - s.apron));
  section.add(slab(s.far - s.apron, s.far));
  std::vector<Station> places;
  for (int k = 0; k <= s.blades; ++k) {
    for (const double side : {-0.5, 0.5}) {
      places.push_back({(k - s.blades / 2.0) * s.pitch + side * s.finger_width, 0});
    }
  }
  Filling filling(2);
  for (std::size_t j = 0; j + 1 < places.size(); ++j) {
    filling[0].push_back(j % 2 == 0);
    filling[1].push_back(true);
  }
  return extrude(section, stations_along_x(section, places), filling);
}

}  // namespace firn
