// Meshes in OBJ files, and what repairs a mesh.
#include "experiments/meshes/obj_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/mesh_repair.h"
#include "experiments/meshes/wall_solids.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A box of 1 x 2 x 3, with a group, a texture, a quad a side, and indices of all three kinds.
constexpr const char* kBox = R"(# box
mtllib none.mtl
o box
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 0
v 0 0 3
v 1 0 3 0.5 0.5 0.5
v 1 2 3
v 0 2 3
vt 0 0
vn 0 0 1
g sides
f 4 3 2 1
f 5/1 6/1 7/1 8/1
f 1//1 2//1 6//1 5//1
f -7/1/1 -6/1/1 -2/1/1 -3/1/1
f 3 4 8 7
f 4 1 5 8
)";

class ObjFile : public ResultsFolder {
 protected:
  TriangleMesh read(const std::string& text) const {
    std::ofstream(path("x.OBJ"), std::ios::binary) << text;
    return read_mesh_file(path("x.OBJ"), 1e-3).mesh;
  }
  std::string error_of(const std::string& text) const {
    return test::error_of([&] { read(text); }).substr(path("").size());
  }
};

TEST_F(ObjFile, GivesASoundSolidInMeters) {
  const TriangleMesh mesh = read(kBox);
  EXPECT_TRUE(inspect(mesh).is_valid()) << inspect(mesh).to_message();
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_NEAR(mass_properties(mesh).volume, 6e-9, 1e-18);
}

// The library multiplies digits by powers of ten that overflow.
TEST_F(ObjFile, ReadsNumbersOfAnyLength) {
  const std::string tenth = "0." + std::string(400, '0') + "1e400";
  const TriangleMesh mesh = read("v " + tenth + " 0 0E30040780\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_DOUBLE_EQ(mesh.vertices[0].x(), 0.1e-3);
  EXPECT_EQ(mesh.vertices[0].z(), 0);
}

TEST_F(ObjFile, RefusesVerticesThatDependOnBlanks) {
  EXPECT_THAT(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nv\f1 1 1\nf 1 2 3\n"),
              HasSubstr("has 4 or 3 vertices"));
}

TEST_F(ObjFile, SaysOnWhichLineWhatIsWrong) {
  EXPECT_EQ(error_of("v 0 0 0\nv 1 zero 0\n"),
            "x.OBJ:2: \"zero\" is not a coordinate; expected \"v X Y Z\"");
  EXPECT_EQ(error_of("v 0 0\n"), "x.OBJ:1: \"\" is not a coordinate; expected \"v X Y Z\"");
  EXPECT_EQ(error_of("v nan 0 0\n"), "x.OBJ:1: \"nan\" is not a coordinate; expected \"v X Y Z\"");
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(error_of(three + "f 1 2\n"), "x.OBJ:4: a face of 2 corners; expected at least three");
  EXPECT_EQ(error_of(three + "f 1 2 4\n"), "x.OBJ:4: vertex 4 is not there; 3 came before");
  EXPECT_EQ(error_of(three + "f 1 2 0\n"), "x.OBJ:4: vertex 0 is not there; 3 came before");
  EXPECT_EQ(error_of(three + "f 1 2 three\n"),
            "x.OBJ:4: \"three\" is not a vertex; expected its number");
  EXPECT_EQ(error_of(three), "x.OBJ: holds no triangles; expected a mesh");
  EXPECT_EQ(error_of(three + "f 1 1 2\n"),
            "x.OBJ: has triangles without area alone; expected a mesh");
  EXPECT_THAT(error_of(three + "v 1e12 0 0\nf 1 2 4\n"),
              HasSubstr("x.OBJ: vertex 4 has the corner"));
}

TEST(MeshRepair, FindsNothingWrongWithABox) {
  const MeshRepair r = repair(box_mesh(Vec3(1, 2, 3)));
  EXPECT_FALSE(r.needed());
  EXPECT_TRUE(r.is_repairable());
  EXPECT_EQ(r.sentence(), "nothing to repair");
  EXPECT_EQ(r.parts, 1);
}

TEST(MeshRepair, FillsAHole) {
  TriangleMesh mesh = box_mesh(Vec3(1, 2, 3));
  mesh.triangles.pop_back();
  const MeshRepair r = repair(mesh);
  EXPECT_EQ(r.disconnected_edges, 3);
  EXPECT_EQ(r.added, 1);
  EXPECT_TRUE(r.is_repairable()) << r.left.to_message();
  EXPECT_NEAR(mass_properties(r.mesh).volume, 6, 1e-5);
  EXPECT_THAT(r.sentence(), HasSubstr("fills holes with 1 facet, "));
  EXPECT_THAT(r.sentence(), HasSubstr("; then it is closed"));
}

TEST(MeshRepair, TurnsFacetsRoundAndDropsThoseWithoutArea) {
  TriangleMesh mesh = box_mesh(Vec3(1, 2, 3));
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  const auto [a, b, c] = mesh.triangles[0];
  mesh.triangles.push_back({a, a, b});
  const MeshRepair r = repair(mesh);
  EXPECT_EQ(r.reversed, 1);
  EXPECT_EQ(r.degenerate, 1);
  EXPECT_TRUE(r.is_repairable()) << r.left.to_message();
  EXPECT_NEAR(mass_properties(r.mesh).volume, 6, 1e-5);
  // All of them: what is left has the right side out.
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(mass_properties(repair(mesh).mesh).volume, 6, 1e-5);
}

// A sphere with two rows of facets without area at its poles: admesh prints remarks on it.
TEST(MeshRepair, TakesTheAnswerApartFromRemarks) {
  TriangleMesh mesh;
  constexpr int n = 60;
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k < n; ++k) {
      const double t = std::numbers::pi * i / n, p = 2 * std::numbers::pi * k / n;
      mesh.vertices.emplace_back(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t));
    }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) {
      const int a = i * n + k, b = i * n + (k + 1) % n, c = a + n, d = b + n;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
  const MeshRepair r = repair(mesh);
  EXPECT_GT(r.degenerate, 0);
  EXPECT_GT(r.mesh.triangles.size(), 6000u);
  for (const Vec3& v : r.mesh.vertices) EXPECT_LT(std::abs(v.norm() - 1), 1e-5);
}

TEST(MeshRepair, GivesUpOnALoneTriangle) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  mesh.triangles = {{0, 1, 2}};
  const MeshRepair r = repair(mesh);
  EXPECT_FALSE(r.is_repairable());
  EXPECT_THAT(r.sentence(), HasSubstr("no repair is possible: "));
}

}  // namespace
}  // namespace firn
