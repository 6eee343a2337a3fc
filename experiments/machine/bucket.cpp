#include <algorithm>
#include <cmath>

#include "experiments/machine/dimension_checks.h"
#include "experiments/machine/parts.h"

namespace firn {
namespace {

// The inner outline from the rim of the back wall over the floor to that of the front, axes y, z.
using Outline = std::vector<Point2>;

// Half of the floor, from the lowest point to the foot of the wall at +y.
Outline half_floor(const Bucket& b) {
  const double lean = std::tan(b.draft);
  if (b.trough_radius == 0) return {{0, 0}, {b.width / 2, 0}};
  const double sine = std::sin(b.shoulder), cosine = std::cos(b.shoulder), r = b.trough_radius;
  const int strips =
      std::max(1, static_cast<int>(std::ceil(kCircle * b.shoulder / (2 * std::numbers::pi))));
  Outline floor;
  for (int i = 0; i <= strips; ++i) {
    const double angle = b.shoulder * i / strips;
    floor.emplace_back(r * std::sin(angle), r * (1 - std::cos(angle)));
  }
  // From there along the tangent to the wall y = width / 2 + lean z.
  const double straight =
      (b.width / 2 + lean * floor.back().y() - floor.back().x()) / (cosine - lean * sine);
  require(straight > 0, "trough_radius",
          fmt::format("of {} is too wide for the bucket; expected less, or a smaller shoulder",
                      in_mm(r)));
  floor.push_back(floor.back() + straight * Point2(cosine, sine));
  return floor;
}

Outline outline_of(const Bucket& b) {
  const double lean = std::tan(b.draft);
  const Outline half = half_floor(b);
  for (const auto& [height, key] :
       {std::pair{b.back_height, "back_height"}, {b.front_height, "front_height"}}) {
    require(height > half.back().y(), key,
            fmt::format("is {}, and the floor rises to {} at the wall; expected a higher wall",
                        in_mm(height), in_mm(half.back().y())));
  }
  Outline outline = {{-b.width / 2 - lean * b.back_height, b.back_height}};
  for (auto p = half.rbegin(); p + 1 != half.rend(); ++p) outline.emplace_back(-p->x(), p->y());
  // A flat floor is one face: its middle is no corner.
  if (b.trough_radius > 0) outline.push_back(half.front());
  outline.insert(outline.end(), half.begin() + 1, half.end());
  outline.emplace_back(b.width / 2 + lean * b.front_height, b.front_height);
  return outline;
}

// Adds the points of the outline at y = +-half.
void split_at(Outline& outline, double half) {
  for (const double y : {-half, half}) {
    for (std::size_t i = 1; i < outline.size(); ++i) {
      const Point2 a = outline[i - 1], b = outline[i];
      if (a.x() < y && y < b.x()) {
        outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(i),
                       a + (y - a.x()) / (b.x() - a.x()) * (b - a));
        break;
      }
    }
  }
}

// The outline moved outwards by the wall, the rims level.
Outline offset(const Outline& inner, double wall) {
  const auto outwards = [&](std::size_t i) {  // of the stretch from i to i + 1
    const Point2 along = (inner[i + 1] - inner[i]).normalized();
    return Point2(along.y(), -along.x());
  };
  const std::size_t last = inner.size() - 1;
  Outline outer = {inner[0] + wall / outwards(0).x() * Point2(1, 0)};
  for (std::size_t i = 1; i < last; ++i) {
    const Point2 in = outwards(i - 1), middle = (in + outwards(i)).normalized();
    outer.push_back(inner[i] + wall / middle.dot(in) * middle);
  }
  outer.push_back(inner[last] + wall / outwards(last - 1).x() * Point2(1, 0));
  return outer;
}

void check(const Bucket& b) {
  for (const auto& [value, key] : {std::pair{b.length, "length"},
                                   {b.width, "width"},
                                   {b.back_height, "back_height"},
                                   {b.front_height, "front_height"},
                                   {b.wall, "wall"},
                                   {b.outlet_width, "outlet_width"},
                                   {b.outlet_height, "outlet_height"},
                                   {b.outlet_length, "outlet_length"}}) {
    require_above_zero(value, key);
  }
  require(b.draft >= 0 && b.draft < 45 * kDegToRad, "draft",
          fmt::format("is {}; expected 0 to 45 deg", in_degrees(b.draft)));
  require(b.shoulder > 0 && b.shoulder + b.draft <= 85 * kDegToRad, "shoulder",
          fmt::format("is {}; expected more than zero, and with the draft no more than 85 deg",
                      in_degrees(b.shoulder)));
  if (b.outlet != Bucket::Outlet::none) {
    require(b.outlet_width < b.width, "outlet_width",
            fmt::format("is {}; expected less than the bucket's {}", in_mm(b.outlet_width),
                        in_mm(b.width)));
  }
  if (b.outlet == Bucket::Outlet::floor) {
    require(b.outlet_length < b.length, "outlet_length",
            fmt::format("is {}; expected less than the bucket's {}", in_mm(b.outlet_length),
                        in_mm(b.length)));
  }
}

// What closes the inside at an end: whole, or what an opening up to `height` leaves of it.
void add_end(Section& section, const Outline& inner, double half, double height, bool open) {
  const auto part = [&](double from, double to) {
    Outline points;
    for (const Point2& p : inner) {
      if (p.x() >= from && p.x() <= to) points.push_back(p);
    }
    return points;
  };
  if (!open) {
    section.add(inner);
    return;
  }
  const Point2 back = inner.front(), front = inner.back();
  const auto top = [&](double y) {
    return back.y() + (y - back.x()) / (front.x() - back.x()) * (front.y() - back.y());
  };
  require(height < std::min(top(-half), top(half)), "outlet_height",
          fmt::format("is {}, and the end wall ends at {}; expected less", in_mm(height),
                      in_mm(std::min(top(-half), top(half)))));
  Outline left = part(-1e9, -half + 1e-12), right = part(half - 1e-12, 1e9);
  require(height > std::max(left.back().y(), right.front().y()), "outlet_height",
          "is below the floor at the opening's sides; expected more");
  left.emplace_back(-half, top(-half));
  right.emplace_back(half, top(half));
  // Cut at the height of the opening, so that all pieces meet side to side.
  for (const Outline& side : {left, right}) {
    section.add(clip_polygon(side, height, false));
    section.add(clip_polygon(side, height, true));
  }
  section.add({{-half, height}, {half, height}, {half, top(half)}, {-half, top(-half)}});
}

}  // namespace

Solid make_bucket(const Bucket& b) {
  check(b);
  const bool end_open = b.outlet == Bucket::Outlet::end;
  const bool floor_open = b.outlet == Bucket::Outlet::floor;
  const double half = b.outlet_width / 2;
  Outline inner = outline_of(b);
  if (end_open || floor_open) split_at(inner, half);
  const Outline outer = offset(inner, b.wall);

  // Along x: end wall, inside, perhaps the opening of the floor, end wall.
  const double lean = std::tan(b.draft), end = b.length / 2, wall = b.wall / std::cos(b.draft);
  std::vector<Station> places = {
      {-end - wall, -lean}, {-end, -lean}, {end, lean}, {end + wall, lean}};
  if (floor_open) places.insert(places.begin() + 2, {end - b.outlet_length, 0});
  const std::size_t layers = places.size() - 1;

  Section section;
  Filling filling;
  for (std::size_t i = 0; i + 1 < inner.size(); ++i) {
    section.add({outer[i], outer[i + 1], inner[i + 1], inner[i]});
    std::vector<bool>& filled = filling.emplace_back(layers, true);
    const double middle = (inner[i].x() + inner[i + 1].x()) / 2;
    if (floor_open && std::abs(middle) < half) filled[layers - 2] = false;
  }
  std::vector<bool> first(layers, false), last(layers, false);
  first.front() = last.back() = true;
  if (end_open) {
    add_end(section, inner, half, b.outlet_height, true);
    filling.resize(section.polygons().size(), last);
    // The other end, whole.
    const std::size_t before = section.polygons().size();
    add_end(section, inner, half, 0, false);
    filling.resize(before + 1, first);
  } else {
    add_end(section, inner, half, 0, false);
    first.back() = true;
    filling.push_back(first);
  }
  return extrude(section, stations_along_x(section, places), filling);
}

}  // namespace firn
