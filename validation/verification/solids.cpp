#include "validation/verification/solids.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>

#include "solver/shape.h"

namespace firn::verification {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMm = 1e-3;

using Point = Eigen::Vector2d;
using Loop = std::vector<Vec3>;

// Dimensions of a member: the first one gets the middle of each range.
class Dice {
 public:
  Dice(std::uint64_t seed, bool random) : engine_(seed), random_(random) {}
  double operator()(double low, double high) {
    if (!random_) return (low + high) / 2;
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int whole(int low, int high) { return static_cast<int>(std::floor((*this)(low, high + 0.999))); }

 private:
  std::mt19937_64 engine_;
  bool random_;
};

// A surface through loops of equally many points. The first and the last loop are joined (a ring)
// or closed, each by a fan about its mean.
TriangleMesh loft(const std::vector<Loop>& loops, bool ring) {
  TriangleMesh mesh;
  const int n = static_cast<int>(loops[0].size()), rows = static_cast<int>(loops.size());
  for (const auto& loop : loops) {
    mesh.vertices.insert(mesh.vertices.end(), loop.begin(), loop.end());
  }
  const auto at = [n, rows](int row, int k) { return row % rows * n + k % n; };
  for (int row = 0; row + (ring ? 0 : 1) < rows; ++row) {
    for (int k = 0; k < n; ++k) {
      mesh.triangles.push_back({at(row, k), at(row, k + 1), at(row + 1, k + 1)});
      mesh.triangles.push_back({at(row, k), at(row + 1, k + 1), at(row + 1, k)});
    }
  }
  for (int end = 0; end < (ring ? 0 : 2); ++end) {
    const int row = end ? rows - 1 : 0, middle = static_cast<int>(mesh.vertices.size());
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : loops[row]) mean += p / n;
    mesh.vertices.push_back(mean);
    for (int k = 0; k < n; ++k) {
      if (end) mesh.triangles.push_back({middle, at(row, k), at(row, k + 1)});
      if (!end) mesh.triangles.push_back({middle, at(row, k + 1), at(row, k)});
    }
  }
  if (mass_properties(mesh).volume < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

Loop flat(const std::vector<Point>& outline, double z) {
  Loop loop;
  for (const Point& p : outline) loop.emplace_back(p.x(), p.y(), z);
  return loop;
}

std::vector<Point> scaled(std::vector<Point> outline, double factor) {
  for (Point& p : outline) p *= factor;
  return outline;
}

TriangleMesh prism(const std::vector<Point>& outline, double height) {
  return loft({flat(outline, 0), flat(outline, height)}, false);
}

std::vector<Point> polar(int n, const std::function<double(double)>& radius) {
  std::vector<Point> outline;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n;
    outline.emplace_back(radius(angle) * std::cos(angle), radius(angle) * std::sin(angle));
  }
  return outline;
}

std::vector<Point> circle(int n, double radius) {
  return polar(n, [radius](double) { return radius; });
}

// The outline of a square of the given edge, at the angles of a circle's points.
std::vector<Point> square(int n, double edge) {
  return polar(n, [edge](double angle) {
    return edge / 2 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  });
}

// Turns a profile (radius, height) about z.
TriangleMesh turned(const std::vector<Point>& profile, int around, bool ring) {
  std::vector<Loop> loops;
  for (const Point& p : profile) loops.push_back(flat(circle(around, p.x()), p.y()));
  return loft(loops, ring);
}

// A cube, wider at the top, with a dimple in its top: part of a sphere, or a pocket with sloping
// walls.
TriangleMesh dimpled(double top, double bottom, double height, double rim, double depth, bool round,
                     double slope) {
  constexpr int n = 40;
  std::vector<Loop> loops = {flat(square(n, bottom), 0), flat(square(n, top), height),
                             flat(circle(n, rim), height)};
  if (round) {
    constexpr int kRings = 6;
    const double radius = (rim * rim + depth * depth) / (2 * depth);
    const double open = std::atan2(rim, radius - depth);
    for (int i = 1; i < kRings; ++i) {
      const double angle = open * (1 - static_cast<double>(i) / kRings);
      loops.push_back(flat(circle(n, radius * std::sin(angle)),
                           height + radius - depth - radius * std::cos(angle)));
    }
  } else {
    loops.push_back(flat(circle(n, rim - depth * slope), height - depth));
  }
  return loft(loops, false);
}

TriangleMesh gear(int teeth, double radius, double depth, double height) {
  std::vector<Point> outline;
  for (int i = 0; i < teeth; ++i) {
    for (const auto& [part, r] :
         {std::pair{0.0, radius - depth}, {0.36, radius - depth}, {0.54, radius}, {0.82, radius}}) {
      const double angle = 2 * kPi * (i + part) / teeth;
      outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
  }
  return prism(outline, height);
}

TriangleMesh star(int tips, double radius, double inner, double height) {
  return prism(
      polar(2 * tips,
            [&](double angle) { return std::lround(angle * tips / kPi) % 2 ? inner : radius; }),
      height);
}

TriangleMesh torus(double radius, double thick, int around, int across) {
  std::vector<Point> profile;
  for (int k = 0; k < across; ++k) {
    const double angle = 2 * kPi * k / across;
    profile.emplace_back(radius + thick * std::cos(angle), thick * std::sin(angle));
  }
  return turned(profile, around, true);
}

TriangleMesh ring(double outer, double inner, double height, int around) {
  return turned({{outer, 0}, {outer, height}, {inner, height}, {inner, 0}}, around, true);
}

TriangleMesh cup(double low, double high, double wall, double floor, double height) {
  return turned({{low, 0}, {high, height}, {high - wall, height}, {low - wall, floor}}, 36, false);
}

TriangleMesh bowl(double radius, double wall) {
  std::vector<Point> profile;
  constexpr int kSteps = 8;
  for (int i = 1; i <= kSteps; ++i) {
    const double angle = kPi / 2 * i / kSteps;
    profile.emplace_back(radius * std::sin(angle), -radius * std::cos(angle));
  }
  for (int i = kSteps; i >= 1; --i) {
    const double angle = kPi / 2 * i / kSteps;
    profile.emplace_back((radius - wall) * std::sin(angle), -(radius - wall) * std::cos(angle));
  }
  return turned(profile, 32, false);
}

// Ice frozen onto a finger: a cylinder with a round end, hollow from the flat one.
TriangleMesh bullet(double radius, double length, double bore, double depth) {
  std::vector<Point> profile;
  constexpr int kSteps = 6;
  const double middle = length - radius;
  profile.emplace_back(0.3 * bore, depth);
  profile.emplace_back(0.8 * bore, depth - 0.25 * bore);
  profile.emplace_back(bore, 0);
  profile.emplace_back(radius, 0);
  for (int i = 0; i < kSteps; ++i) {
    const double angle = kPi / 2 * i / kSteps;
    profile.emplace_back(radius * std::cos(angle), middle + radius * std::sin(angle));
  }
  return turned(profile, 32, false);
}

// Half a disc with sides that lean in and a shallow pan in its flat top.
TriangleMesh half_moon(double radius, double height, double lean, double pan) {
  std::vector<Point> outline;
  constexpr int kArc = 18, kChord = 8;
  for (int i = 0; i < kArc; ++i) {
    const double angle = kPi * i / kArc;
    outline.emplace_back(radius * std::cos(angle), radius * (std::sin(angle) - 0.4));
  }
  for (int i = 0; i < kChord; ++i) {
    outline.emplace_back(radius * (2.0 * i / kChord - 1), -0.4 * radius);
  }
  return loft({flat(scaled(outline, lean), 0), flat(outline, height),
               flat(scaled(outline, 0.8), height), flat(scaled(outline, 0.55), height - pan)},
              false);
}

TriangleMesh screw(double core, double thread, double pitch, int turns, int around) {
  std::vector<Loop> loops;
  const int rows = 8 * turns;
  for (int i = 0; i <= rows; ++i) {
    const double z = pitch * i / 8;
    const double fade = std::min({1.0, i / 4.0, (rows - i) / 4.0});
    loops.push_back(flat(polar(around,
                               [&](double angle) {
                                 double turn = z / pitch - angle / (2 * kPi);
                                 turn -= std::floor(turn);
                                 return core + fade * thread * (1 - std::abs(2 * turn - 1));
                               }),
                         z));
  }
  return loft(loops, false);
}

TriangleMesh banana(double bend, double thick, double angle) {
  constexpr int kRows = 18, kAcross = 16;
  std::vector<Loop> loops;
  for (int i = 0; i <= kRows; ++i) {
    const double s = 2.0 * i / kRows - 1, turn = angle / 2 * s;
    const double radius = thick * (0.35 + 0.65 * std::sqrt(1 - 0.95 * s * s));
    Loop loop;
    for (const Point& p : circle(kAcross, radius)) {
      const double r = bend + p.x();
      loop.emplace_back(r * std::cos(turn), r * std::sin(turn), p.y());
    }
    loops.push_back(loop);
  }
  return loft(loops, false);
}

TriangleMesh hourglass(double radius, double waist, double height) {
  std::vector<Point> profile;
  for (int i = 0; i <= 14; ++i) {
    const double s = 2.0 * i / 14 - 1;
    profile.emplace_back(waist + (radius - waist) * s * s, height * i / 14);
  }
  return turned(profile, 28, false);
}

TriangleMesh plate(double edge, double thick, double hole) {
  constexpr int n = 40;
  return loft({flat(square(n, edge), 0), flat(square(n, edge), thick), flat(circle(n, hole), thick),
               flat(circle(n, hole), 0)},
              true);
}

TriangleMesh cross(double arm, double width, double height) {
  const double w = width / 2;
  return prism({{arm, -w},
                {arm, w},
                {w, w},
                {w, arm},
                {-w, arm},
                {-w, w},
                {-arm, w},
                {-arm, -w},
                {-w, -w},
                {-w, -arm},
                {w, -arm},
                {w, -w}},
               height);
}

// A bar of the given outline, which four-cornered patches fill, along y.
TriangleMesh bar(const std::vector<Point>& outline, const std::vector<std::array<int, 4>>& patches,
                 double length) {
  const int n = static_cast<int>(outline.size());
  TriangleMesh mesh;
  for (const double y : {0.0, length}) {
    for (const Point& p : outline) mesh.vertices.emplace_back(p.x(), y, p.y());
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    mesh.triangles.push_back({k, next, n + next});
    mesh.triangles.push_back({k, n + next, n + k});
  }
  for (const auto& [a, b, c, d] : patches) {
    mesh.triangles.push_back({c, b, a});
    mesh.triangles.push_back({d, c, a});
    mesh.triangles.push_back({a + n, b + n, c + n});
    mesh.triangles.push_back({a + n, c + n, d + n});
  }
  if (mass_properties(mesh).volume < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

TriangleMesh angle_bar(double a, double b, double wall, double length) {
  return bar({{0, 0}, {a, 0}, {a, wall}, {wall, wall}, {wall, b}, {0, b}},
             {{0, 1, 2, 3}, {0, 3, 4, 5}}, length);
}

TriangleMesh channel(double width, double height, double wall, double length) {
  const double w = width / 2, v = w - wall;
  return bar({{-w, 0},
              {w, 0},
              {w, height},
              {v, height},
              {v, wall},
              {-v, wall},
              {-v, height},
              {-w, height}},
             {{0, 1, 4, 5}, {1, 2, 3, 4}, {0, 5, 6, 7}}, length);
}

TriangleMesh heart(double size, double cleft, double height) {
  return prism(polar(44,
                     [&](double angle) {
                       const double off = std::abs(std::remainder(angle - kPi / 2, 2 * kPi));
                       return size * (1 - cleft * std::exp(-3 * off));
                     }),
               height);
}

TriangleMesh bumpy(double radius, double bump, int around, int up) {
  std::vector<Loop> loops;
  for (int i = 1; i < up; ++i) {
    const double polar_angle = kPi * i / up;
    Loop loop;
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * kPi * k / around;
      const double fade = std::sin(polar_angle) * std::sin(polar_angle);
      const double r = radius * (1 + bump * fade * std::cos(3 * angle));
      loop.push_back(r * Vec3(std::sin(polar_angle) * std::cos(angle),
                              std::sin(polar_angle) * std::sin(angle), std::cos(polar_angle)));
    }
    loops.push_back(loop);
  }
  return loft(loops, false);
}

struct Family {
  std::string name;
  TriangleMesh (*make)(Dice& d);
};

const std::vector<Family>& families() {
  static const std::vector<Family> all = {
      {"dimpled cube",
       [](Dice& d) {
         const double edge = d(24, 36) * kMm;
         return dimpled(edge, edge * d(0.85, 1), d(16, 30) * kMm, d(3, 9) * kMm, d(2, 7) * kMm,
                        true, 0);
       }},
      {"gourmet cube",
       [](Dice& d) {
         const double edge = d(26, 36) * kMm;
         return dimpled(edge, edge * d(0.75, 0.95), d(24, 34) * kMm, edge * d(0.2, 0.38),
                        d(8, 18) * kMm, false, d(0.05, 0.2));
       }},
      {"gear",
       [](Dice& d) {
         return gear(d.whole(7, 14), d(16, 22) * kMm, d(2.5, 4) * kMm, d(6, 14) * kMm);
       }},
      {"star",
       [](Dice& d) {
         return star(d.whole(4, 8), d(16, 22) * kMm, d(8, 11) * kMm, d(6, 14) * kMm);
       }},
      {"ring", [](Dice& d) { return ring(d(18, 22) * kMm, d(10, 14) * kMm, d(6, 16) * kMm, 48); }},
      {"torus", [](Dice& d) { return torus(d(11, 15) * kMm, d(4.5, 6.5) * kMm, 48, 20); }},
      {"cup",
       [](Dice& d) {
         const double low = d(13, 17) * kMm;
         return cup(low, low * d(1.1, 1.35), d(2.5, 4.5) * kMm, d(3, 6) * kMm, d(26, 40) * kMm);
       }},
      {"bowl", [](Dice& d) { return bowl(d(16, 24) * kMm, d(3.5, 6) * kMm); }},
      {"screw",
       [](Dice& d) {
         return screw(d(6, 8) * kMm, d(1.2, 2) * kMm, d(8, 12) * kMm, d.whole(2, 3), 16);
       }},
      {"crescent",
       [](Dice& d) {
         CrescentParameters p;
         p.chord = d(48, 62) * kMm;
         p.width = d(18, 24) * kMm;
         p.depth = d(13, 20) * kMm;
         p.dish = d(0.5, 2.5) * kMm;
         return crescent_mesh(p);
       }},
      {"half moon",
       [](Dice& d) {
         return half_moon(d(15, 20) * kMm, d(14, 20) * kMm, d(0.85, 0.95), d(1, 4) * kMm);
       }},
      {"bullet",
       [](Dice& d) {
         const double radius = d(11, 15) * kMm, length = d(32, 44) * kMm;
         return bullet(radius, length, radius * d(0.35, 0.55), length * d(0.45, 0.65));
       }},
      {"tube ice",
       [](Dice& d) {
         const double outer = d(13, 19) * kMm;
         return ring(outer, outer * d(0.25, 0.5), d(22, 38) * kMm, 40);
       }},
      {"plate with hole",
       [](Dice& d) {
         const double edge = d(30, 50) * kMm;
         return plate(edge, d(2.5, 5) * kMm, edge * d(0.1, 0.35));
       }},
      {"angle bar",
       [](Dice& d) {
         return angle_bar(d(18, 30) * kMm, d(18, 30) * kMm, d(4, 8) * kMm, d(10, 40) * kMm);
       }},
      {"channel",
       [](Dice& d) {
         return channel(d(20, 30) * kMm, d(12, 25) * kMm, d(3, 6) * kMm, d(10, 40) * kMm);
       }},
      {"cross", [](Dice& d) { return cross(d(12, 20) * kMm, d(5, 10) * kMm, d(5, 15) * kMm); }},
      {"banana", [](Dice& d) { return banana(d(24, 32) * kMm, d(5, 8) * kMm, d(1.2, 2.2)); }},
      {"hourglass",
       [](Dice& d) { return hourglass(d(12, 16) * kMm, d(6, 9) * kMm, d(26, 40) * kMm); }},
      {"heart", [](Dice& d) { return heart(d(14, 20) * kMm, d(0.3, 0.55), d(8, 16) * kMm); }},
      {"lobed ball of 20000 facets",
       [](Dice& d) { return bumpy(d(14, 20) * kMm, d(0.12, 0.3), 140, 72); }}};
  return all;
}

}  // namespace

const std::vector<std::string>& solid_families() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const auto& family : families()) result.push_back(family.name);
    return result;
  }();
  return names;
}

TriangleMesh solid(const std::string& family, std::uint64_t member) {
  for (std::size_t i = 0; i < families().size(); ++i) {
    if (families()[i].name != family) continue;
    Dice dice(1000 * i + member, member > 0);
    return families()[i].make(dice);
  }
  throw std::logic_error("no family of solids is named " + family);
}

}  // namespace firn::verification
