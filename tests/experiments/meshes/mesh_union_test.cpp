// The union of boxes, cavities and turned boxes against a count of cells.
#include "experiments/meshes/mesh_union.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "experiments/meshes/wall_solids.h"
#include "firn/mesh_conflicts.h"
#include "tests/support/dice.h"

namespace firn {
namespace {

struct Box {
  Vec3 low, high;
  bool inward = false;
};

void add(TriangleMesh& mesh, const Box& box) {
  const int first = static_cast<int>(mesh.vertices.size());
  const TriangleMesh centered = box_mesh(box.high - box.low);
  for (const Vec3& p : centered.vertices) mesh.vertices.emplace_back(p + (box.low + box.high) / 2);
  for (const auto& t : centered.triangles) {
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    if (box.inward) std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
  }
}

TriangleMesh mesh_of(const std::vector<Box>& boxes) {
  TriangleMesh mesh;
  for (const Box& box : boxes) add(mesh, box);
  return mesh;
}

bool holds(const Box& box, const Vec3& p) {
  return (p.array() > box.low.array()).all() && (p.array() < box.high.array()).all();
}

// Volume of what `inside` accepts, exact for sets whose borders lie in the planes of the boxes.
template <typename Inside>
double volume_of_cells(const std::vector<Box>& boxes, Inside&& inside) {
  std::array<std::vector<double>, 3> planes;
  for (const Box& box : boxes)
    for (std::size_t k = 0; k < 3; ++k) {
      planes[k].push_back(box.low(static_cast<int>(k)));
      planes[k].push_back(box.high(static_cast<int>(k)));
    }
  for (auto& axis : planes) std::ranges::sort(axis);
  double volume = 0;
  for (std::size_t i = 1; i < planes[0].size(); ++i)
    for (std::size_t j = 1; j < planes[1].size(); ++j)
      for (std::size_t k = 1; k < planes[2].size(); ++k) {
        const Vec3 low(planes[0][i - 1], planes[1][j - 1], planes[2][k - 1]);
        const Vec3 high(planes[0][i], planes[1][j], planes[2][k]);
        if (inside((low + high) / 2)) volume += (high - low).prod();
      }
  return volume;
}

Box random_box(Dice& dice, double size) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low(k) = dice(0, size);
    box.high(k) = box.low(k) + dice(0.2 * size, size);
  }
  return box;
}

void expect_union(const TriangleMesh& mesh, double volume, const char* what) {
  const TriangleMesh united = unite(mesh);
  EXPECT_TRUE(inspect(united).is_valid()) << what << ": " << inspect(united).to_message();
  EXPECT_TRUE(find_conflicts(united).none()) << what << ": " << find_conflicts(united).to_message();
  EXPECT_NEAR(mass_properties(united).volume, volume, 3e-6 * volume) << what;
}

TEST(MeshUnion, HoldsTheCellsOfRandomBoxes) {
  Dice dice(71);
  for (int member = 0; member < 30; ++member) {
    SCOPED_TRACE(member);
    const double size = std::pow(10.0, dice(-4, 1));  // m
    std::vector<Box> boxes(static_cast<std::size_t>(2 + member % 8));
    for (Box& box : boxes) box = random_box(dice, size);
    const double volume = volume_of_cells(boxes, [&](const Vec3& p) {
      return std::ranges::any_of(boxes, [&](const Box& box) { return holds(box, p); });
    });
    TriangleMesh mesh = mesh_of(boxes);
    expect_union(mesh, volume, "along the axes");
    const Mat3 turn = dice.turn().toRotationMatrix();
    for (Vec3& p : mesh.vertices) p = turn * p;
    expect_union(mesh, volume, "turned");
    std::ranges::reverse(mesh.triangles);
    expect_union(mesh, volume, "triangles in another order");
  }
}

TEST(MeshUnion, KeepsACavityUntilAnotherSolidFillsIt) {
  Dice dice(72);
  for (int member = 0; member < 60; ++member) {
    SCOPED_TRACE(member);
    const Box hull{Vec3::Zero(), Vec3::Constant(10)};
    const Box cavity{Vec3(1, 1, 1), Vec3(dice(2, 9), dice(2, 9), 9), true};
    Box other = random_box(dice, 7);
    const std::vector<Box> boxes = {hull, cavity, other};
    const double volume = volume_of_cells(boxes, [&](const Vec3& p) {
      return (holds(hull, p) && !holds(cavity, p)) || holds(other, p);
    });
    TriangleMesh mesh = mesh_of(boxes);
    expect_union(mesh, volume, "cavity");
    std::ranges::reverse(mesh.triangles);
    expect_union(mesh, volume, "cavity, triangles in another order");
  }
}

TEST(MeshUnion, OfShellsInOnePlaneAndInsideEachOther) {
  const Box cube{Vec3::Zero(), Vec3::Constant(0.02)};
  const Box shifted{Vec3(0.01, 0, 0), Vec3(0.03, 0.02, 0.02)};
  const Box inner{Vec3::Constant(0.005), Vec3::Constant(0.015)};
  Box inverted = shifted;
  inverted.inward = true;
  expect_union(mesh_of({cube, shifted}), 12e-6, "shifted by half");
  expect_union(mesh_of({cube, inner}), 8e-6, "one inside the other");
  expect_union(mesh_of({cube, inverted}), 12e-6, "one facing inwards");
}

TEST(MeshUnion, RefusesWhatHasNoUnion) {
  const Box cube{Vec3::Zero(), Vec3::Constant(1)};
  const Box corner{Vec3(1, 1, 0), Vec3(2, 2, 1)};
  const Box adjacent{Vec3(1, 0, 0), Vec3(2, 1, 1)};
  EXPECT_THROW(unite(mesh_of({cube, corner})), InputError) << "boxes that share an edge";
  EXPECT_THROW(unite(mesh_of({cube, adjacent})), InputError) << "boxes that share a face";
  TriangleMesh open = mesh_of({cube});
  open.triangles.pop_back();
  EXPECT_THROW(unite(open), InputError);
  TriangleMesh crossed = mesh_of({cube});
  crossed.vertices[7] = Vec3(0.2, 0.3, -0.5);  // a corner pushed out through the opposite face
  EXPECT_THROW(unite(crossed), InputError);
}

}  // namespace
}  // namespace firn
