#include "validation/verification/meshes.h"

#include <cmath>
#include <map>
#include <numbers>

#include "validation/verification/scenes.h"

namespace firn::verification::meshes {

namespace {

using std::numbers::pi;

// A polygon in x and y with its triangles, counter-clockwise, pulled up to the height (m).
TriangleMesh extruded(const std::vector<std::array<double, 2>>& outline,
                      const std::vector<std::array<int, 3>>& cap, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (const double z : {0.0, height}) {
    for (const auto& [x, y] : outline) mesh.vertices.push_back({x, y, z});
  }
  for (const auto& [a, b, c] : cap) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + n, b + n, c + n});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, j, j + n});
    mesh.triangles.push_back({i, j + n, i + n});
  }
  return mesh;
}

}  // namespace

TriangleMesh torus(int around, int across) {
  constexpr double ring = 10e-3, bar = 4e-3;
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / across;
      const double r = ring + bar * std::cos(b);
      mesh.vertices.push_back({r * std::cos(a), r * std::sin(a), bar * std::sin(b)});
    }
  }
  const auto at = [&](int i, int j) { return i % around * across + j % across; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh ball(int around, int up, double roughness) {
  constexpr double radius = 10e-3;
  TriangleMesh mesh;
  mesh.vertices.push_back({0, 0, radius});
  for (int j = 1; j < up; ++j) {
    for (int i = 0; i < around; ++i) {
      const double t = pi * j / up, p = 2 * pi * i / around, s = std::sin(t);
      const double r = radius * (1 + roughness * std::sin(12 * t) * std::cos(12 * p) * s * s);
      mesh.vertices.push_back(r * Vec3(s * std::cos(p), s * std::sin(p), std::cos(t)));
    }
  }
  mesh.vertices.push_back({0, 0, -radius});
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [&](int j, int i) { return 1 + (j - 1) * around + i % around; };
  for (int i = 0; i < around; ++i) {
    mesh.triangles.push_back({0, at(1, i), at(1, i + 1)});
    mesh.triangles.push_back({last, at(up - 1, i + 1), at(up - 1, i)});
  }
  for (int j = 1; j + 1 < up; ++j) {
    for (int i = 0; i < around; ++i) {
      mesh.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
    }
  }
  return mesh;
}

TriangleMesh angle_bar() {
  return extruded({{0, 0}, {20e-3, 0}, {20e-3, 5e-3}, {5e-3, 5e-3}, {5e-3, 20e-3}, {0, 20e-3}},
                  {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 10e-3);
}

TriangleMesh channel() {
  return extruded({{0, 0},
                   {20e-3, 0},
                   {20e-3, 20e-3},
                   {15e-3, 20e-3},
                   {15e-3, 5e-3},
                   {5e-3, 5e-3},
                   {5e-3, 20e-3},
                   {0, 20e-3}},
                  {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, 10e-3);
}

TriangleMesh cube(double edge, int cells) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto corner = [&](const std::array<int, 3>& at) {
    const auto [entry, fresh] = known.try_emplace(at, static_cast<int>(mesh.vertices.size()));
    if (fresh) {
      mesh.vertices.push_back(edge * (Vec3(at[0], at[1], at[2]) / cells - Vec3::Constant(0.5)));
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, cells}) {
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> place;
            place[axis] = side;
            place[(axis + 1) % 3] = i + u;
            place[(axis + 2) % 3] = j + v;
            return corner(place);
          };
          const int a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
          if (side > 0) {
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
          } else {
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({a, d, c});
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh irregular_floor(double size, int cells, std::uint64_t seed) {
  scenes::Random random(seed);
  TriangleMesh mesh;
  const double cell = size / cells;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const bool inner_x = i > 0 && i<cells, inner_y = j> 0 && j < cells;
      const double dx = inner_x ? random.uniform(-0.25, 0.25) : 0;
      const double dy = inner_y ? random.uniform(-0.25, 0.25) : 0;
      mesh.vertices.emplace_back(cell * (i + dx) - size / 2, cell * (j + dy) - size / 2, 0);
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      if (random.uniform(0, 1) < 0.5) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({a, d, c});
      }
    }
  }
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, const Vec3& factors) {
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(factors);
  return mesh;
}

}  // namespace firn::verification::meshes
