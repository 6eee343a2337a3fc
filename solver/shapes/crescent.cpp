#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/shapes/shape_builder.h"

namespace firn {
namespace {

constexpr double kInch = 0.0254;

// A point of the outline, in the plane of chord and depth.
using Point = Eigen::Vector2d;  // m: x, z

void check(const CrescentParameters& p) {
  const auto refuse = [](const std::string& what) { throw InputError("the crescent's " + what); };
  if (!(p.chord > 0 && p.width > 0 && p.depth > 0)) {
    refuse("chord, width or depth is not above zero; expected three lengths");
  }
  if (!(p.tip_height > 0 && p.tip_height < p.depth)) {
    refuse(
        "tip is not between zero and its depth; expected a tip wall above zero and lower than the "
        "body");
  }
  if (!(p.depth - p.tip_height <= p.chord / 2)) {
    refuse("arc is deeper than half its chord; expected depth - tip up to chord / 2");
  }
  if (!(p.top_concavity_depth >= 0 && p.top_concavity_depth < p.depth)) {
    refuse("dish is not between zero and its depth; expected a shallower one");
  }
  if (!(p.draft >= 0 && p.width / 2 > p.depth * std::tan(p.draft))) {
    refuse("draft is negative or closes its sides; expected a smaller angle");
  }
  if (!(p.facets >= 20 && p.facets <= 200000)) refuse("facets lie outside 20 ... 200000");
  if (!(p.parts >= 1 && p.parts <= 64)) refuse("parts lie outside 1 ... 64");
  if (!(p.arc_segments >= 1 && p.arc_segments <= 200)) refuse("arc_segments lie outside 1 ... 200");
}

// Strips of the mesh: `along` the chord, `across` the width; 4 (along + 1)(across + 1) - 4 facets.
// An even number along puts a corner on the deepest point of the arc.
struct Strips {
  int along = 0, across = 0;
};

Strips strips_for(int facets) {
  Strips best;
  double best_miss = std::numeric_limits<double>::infinity(), best_aspect = best_miss;
  const double product = facets / 4.0 + 1;  // (along + 1)(across + 1)
  for (int across = 1; across == 1 || across + 1 <= std::sqrt(product); ++across) {
    const int along =
        2 * std::max(1, static_cast<int>(std::lround((product / (across + 1) - 1) / 2)));
    // Facets not much longer than wide, but a coarse mesh spends them on the arc.
    const double aspect = static_cast<double>(along) / across;
    const bool sensible = across == 1 ? along <= 12 : along >= 8 && aspect >= 2 && aspect <= 5;
    if (!sensible) continue;
    const double miss = std::abs(4.0 * (along + 1) * (across + 1) - 4 - facets);
    const double squareness = std::abs(std::log(aspect / 2.8));
    if (miss < best_miss || (miss == best_miss && squareness < best_aspect)) {
      best = {along, across};
      best_miss = miss;
      best_aspect = squareness;
    }
  }
  return best;
}

// The circular bottom from tip (-chord/2, -tip) through (0, -depth) to (chord/2, -tip).
struct Arc {
  explicit Arc(const CrescentParameters& p)
      : sagitta(p.depth - p.tip_height),
        radius((p.chord * p.chord / 4 + sagitta * sagitta) / (2 * sagitta)),
        center_z(radius - p.depth),
        half_angle(std::atan2(p.chord / 2, radius - sagitta)) {}

  // Corner i of `count` equal segments, at distance r from the center.
  Point corner(int i, int count, double r) const {
    const double angle = half_angle * (2.0 * i / count - 1);
    return {r * std::sin(angle), center_z - r * std::cos(angle)};
  }

  // Corners of `count` segments, the ends on the tips and the others so far out that the polygon
  // holds the same area as the one of `reference` segments with every corner on the arc.
  std::vector<Point> polygon(int count, int reference) const {
    const double theta = 2 * half_angle / count, theta_reference = 2 * half_angle / reference;
    // (count - 2) r^2 + 2 R r = R^2 * target; each term is twice an area over sin(theta)
    const double target = reference * std::sin(theta_reference) / std::sin(theta);
    double r = radius;
    if (count == 2) r = radius * target / 2;
    if (count > 2) r = radius * (std::sqrt(1 + (count - 2) * target) - 1) / (count - 2);
    std::vector<Point> corners;
    for (int i = 0; i <= count; ++i) {
      corners.push_back(corner(i, count, i == 0 || i == count ? radius : r));
    }
    return corners;
  }

  double sagitta, radius, center_z, half_angle;
};

double top_height(const CrescentParameters& p, double x) {
  return -p.top_concavity_depth * (1 - 4 * x * x / (p.chord * p.chord));
}

// The concave top as `count` straight segments between the tips; the inner corners are moved down
// so that the area is that of `reference` segments with every corner on the parabola. A single
// segment is level at the mean height.
std::vector<Point> top_polygon(const CrescentParameters& p, int count, int reference) {
  // A chord of length s over a parabola of second derivative c holds c s^3 / 12 more.
  const double curvature = 8 * p.top_concavity_depth / (p.chord * p.chord);
  const double step = p.chord / count, reference_step = p.chord / reference;
  const double excess = curvature * p.chord / 12 * (step * step - reference_step * reference_step);
  const double shift = count == 1 ? excess / p.chord : excess / ((count - 1) * step);
  std::vector<Point> corners;
  for (int i = 0; i <= count; ++i) {
    const double x = p.chord * (static_cast<double>(i) / count - 0.5);
    const bool tip = i == 0 || i == count;
    corners.emplace_back(x, top_height(p, x) - (tip && count > 1 ? 0 : shift));
  }
  return corners;
}

// Surface across the outline from a to b, the body on the left.
HalfSpace strip(const Point& a, const Point& b, bool internal = false) {
  const Point along = (b - a).normalized();
  const Vec3 normal(along.y(), 0, -along.x());
  return {normal, normal.dot(Vec3(a.x(), 0, a.y())), internal};
}

// The pieces that lie in a half at least in part, of `count` along the chord: first and one past
// the last.
std::pair<int, int> half_range(CrescentParameters::Half half, int count) {
  return {half == CrescentParameters::Half::right ? count / 2 : 0,
          half == CrescentParameters::Half::left ? (count + 1) / 2 : count};
}

std::vector<std::vector<HalfSpace>> pieces_of(const CrescentParameters& p) {
  const int along = strips_for(p.facets).along;
  const auto bottom = Arc(p).polygon(std::min(p.arc_segments, along), along);
  const auto top = top_polygon(p, p.parts, along);
  // What bounds every piece: the arc, the tip walls and the sides.
  std::vector<HalfSpace> common;
  for (std::size_t i = 1; i < bottom.size(); ++i) common.push_back(strip(bottom[i - 1], bottom[i]));
  common.push_back({Vec3::UnitX(), p.chord / 2, false});
  common.push_back({-Vec3::UnitX(), p.chord / 2, false});
  const double cosine = std::cos(p.draft), sine = std::sin(p.draft);
  common.push_back({Vec3(0, cosine, -sine), p.width / 2 * cosine, false});
  common.push_back({Vec3(0, -cosine, -sine), p.width / 2 * cosine, false});

  std::vector<HalfSpace> tops;
  tops.reserve(p.parts);
  for (int i = 0; i < p.parts; ++i) tops.push_back(strip(top[i + 1], top[i]));
  if (p.half == CrescentParameters::Half::left) common.push_back({Vec3::UnitX(), 0, false});
  if (p.half == CrescentParameters::Half::right) common.push_back({-Vec3::UnitX(), 0, false});
  const auto [first, end] = half_range(p.half, p.parts);
  std::vector<std::vector<HalfSpace>> pieces(p.parts, common);
  for (int i = first; i < end; ++i) pieces[i].push_back(tops[i]);
  for (int i = first + 1; i < end; ++i) {
    // A cut holds the seam of two tops and halves their angle, so that the two tops still meet on
    // it after both were moved inwards.
    const Vec3 up = (tops[i - 1].normal + tops[i].normal).normalized();
    const Vec3 right(up.z(), 0, -up.x());
    const double offset = right.dot(Vec3(top[i].x(), 0, top[i].y()));
    pieces[i - 1].push_back({right, offset, true});
    pieces[i].push_back({-right, -offset, true});
  }
  return {pieces.begin() + first, pieces.begin() + end};
}

}  // namespace

TriangleMesh crescent_mesh(const CrescentParameters& p) {
  check(p);
  const auto [along, across] = strips_for(p.facets);
  const auto [first, last] = half_range(p.half, along);  // `along` is even
  const Arc arc(p);
  TriangleMesh mesh;
  // Vertices by side (0: top, 1: bottom), then along the chord, then across the width.
  const auto vertex = [across = across, first = first, last = last](int side, int i, int j) {
    return (side * (last - first + 1) + i - first) * (across + 1) + j;
  };
  for (int side = 0; side < 2; ++side) {
    for (int i = first; i <= last; ++i) {
      const double x = p.chord * (static_cast<double>(i) / along - 0.5);
      const Point point = side ? arc.corner(i, along, arc.radius) : Point(x, top_height(p, x));
      const double half_width = p.width / 2 + point.y() * std::tan(p.draft);
      for (int j = 0; j <= across; ++j) {
        mesh.vertices.emplace_back(point.x(), half_width * (2.0 * j / across - 1), point.y());
      }
    }
  }
  const auto quad = [&mesh](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int i = first; i < last; ++i) {
    for (int j = 0; j < across; ++j) {
      quad(vertex(0, i, j), vertex(0, i + 1, j), vertex(0, i + 1, j + 1), vertex(0, i, j + 1));
      quad(vertex(1, i, j), vertex(1, i, j + 1), vertex(1, i + 1, j + 1), vertex(1, i + 1, j));
    }
    quad(vertex(1, i, 0), vertex(1, i + 1, 0), vertex(0, i + 1, 0), vertex(0, i, 0));
    quad(vertex(1, i + 1, across), vertex(1, i, across), vertex(0, i, across),
         vertex(0, i + 1, across));
  }
  for (int j = 0; j < across; ++j) {
    quad(vertex(1, first, j), vertex(0, first, j), vertex(0, first, j + 1),
         vertex(1, first, j + 1));
    quad(vertex(1, last, j), vertex(1, last, j + 1), vertex(0, last, j + 1), vertex(0, last, j));
  }
  return mesh;
}

Shape make_crescent(const CrescentParameters& p, const ShapeOptions& options) {
  TriangleMesh mesh = crescent_mesh(p);
  const MassProperties integrals = mass_properties(mesh);
  Shape shape = begin_shape(std::move(mesh), integrals, options);
  const auto pieces = pieces_of(p);
  if (!(options.rounding >= 0)) {
    shape.rounding = default_rounding(pieces, shape.mesh, shape.box.minCoeff());
  }
  for (const auto& piece : pieces) add_part(shape, piece);
  compute_bounding_radius(shape);
  const int parts = static_cast<int>(pieces.size());
  for (int i = 0; i < parts; ++i) {
    std::uint64_t mask = 0;
    for (int j = std::max(i - 1, 0); j <= std::min(i + 1, parts - 1); ++j) {
      mask |= std::uint64_t{1} << j;
    }
    shape.part_neighbors.push_back(mask);
  }
  const Deviation deviation = measure_deviation(shape);
  shape.surface_deviation = deviation.largest();
  shape.deviation_reason = deviation.rounding > deviation.surplus
                               ? "edges rounded, flat segments of the arc"
                               : "flat segments of the dish and the arc";
  return shape;
}

NamedCrescent named_crescent(const std::string& name, const CrescentParameters& base) {
  constexpr double kMass = 13.7e-3;   // kg, weighed
  constexpr double kDensity = 916.7;  // kg/m^3, of ice
  NamedCrescent result;
  CrescentParameters& p = result.parameters;
  p = base;
  p.chord = 2.4 * kInch;
  p.width = 0.81 * kInch;
  p.depth = 0.54 * kInch;
  if (name == "table1") return result;
  if (name == "table1-mass-override") {
    result.mass = kMass;
    return result;
  }
  if (name != "mass-matched") {
    throw InputError("no crescent is named \"" + name +
                     "\"; expected \"table1\", \"mass-matched\" or \"table1-mass-override\"");
  }
  // The volume is smooth and nearly linear in the depth: the secant rule meets it in a few steps.
  const auto surplus = [&p](double depth) {
    p.depth = depth;
    return mass_properties(crescent_mesh(p)).volume * kDensity - kMass;
  };
  double previous = p.depth, depth = 1.3 * p.depth;
  double previous_surplus = surplus(previous);
  for (int i = 0; i < 20; ++i) {
    const double now = surplus(depth);
    if (std::abs(now) <= 1e-13 * kMass || now == previous_surplus) break;
    const double next = depth - now * (depth - previous) / (now - previous_surplus);
    previous = depth;
    previous_surplus = now;
    depth = next;
  }
  return result;
}

}  // namespace firn
