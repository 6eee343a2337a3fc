// firn shape: facts of meshes, sound and unsound.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tests/cli/cases.h"
#include "tests/cli/program.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

using Triangle = std::array<std::array<double, 3>, 3>;

// A box from the origin to (x, y, z), twelve triangles facing outwards.
std::vector<Triangle> box(double x, double y, double z) {
  const auto corner = [&](int i) -> std::array<double, 3> {
    return {i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0};
  };
  std::vector<Triangle> triangles;
  constexpr std::array<std::array<int, 4>, 6> faces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    triangles.push_back({corner(f[0]), corner(f[1]), corner(f[2])});
    triangles.push_back({corner(f[0]), corner(f[2]), corner(f[3])});
  }
  return triangles;
}

std::string stl(const std::vector<Triangle>& triangles) {
  std::string text = "solid test\n";
  for (const Triangle& t : triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& c : t) {
      text += "vertex " + std::to_string(c[0]) + ' ' + std::to_string(c[1]) + ' ' +
              std::to_string(c[2]) + '\n';
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid test\n";
}

TEST(ShapeCommand, FactsOfABox) {
  const Folder folder;
  const Outcome o = folder.firn({"shape", folder.write("box.stl", stl(box(10, 20, 40))), "--json",
                                 "--density", "1000 kg/m^3", "--young-modulus", "1 MPa"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json facts = json::parse(o.out);
  EXPECT_EQ(facts["triangles"], 12);
  EXPECT_EQ(facts["sound"], true);
  EXPECT_EQ(facts["convex_parts"].size(), 1U);
  EXPECT_NEAR(facts["volume"], 8e-6, 1e-12);  // 10 x 20 x 40 mm
  EXPECT_NEAR(facts["mass"], 8e-3, 1e-9);
  EXPECT_NEAR(facts["centroid"][0], 5e-3, 1e-9);
  EXPECT_NEAR(facts["centroid"][2], 20e-3, 1e-9);
  // Principal inertia of a box: m (b^2 + c^2) / 12, whatever the order of the axes.
  std::vector<double> inertia = facts["inertia"];
  std::sort(inertia.begin(), inertia.end());
  EXPECT_NEAR(inertia[0], 8e-3 * (1e-4 + 4e-4) / 12, 1e-12);
  EXPECT_NEAR(inertia[1], 8e-3 * (1e-4 + 16e-4) / 12, 1e-12);
  EXPECT_NEAR(inertia[2], 8e-3 * (4e-4 + 16e-4) / 12, 1e-12);
  EXPECT_NEAR(facts["size_for_stiffness"], 20e-3, 1e-9);  // the middle edge
  EXPECT_NEAR(facts["stiffness"], 20e3, 1e-3);            // E L
}

TEST(ShapeCommand, LengthUnitOfTheMesh) {
  const Folder folder;
  folder.write("box.stl", stl(box(1, 1, 1)));
  const Outcome o = folder.firn({"shape", "box.stl", "--json", "--length-unit", "in"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NEAR(json::parse(o.out)["volume"], 0.0254 * 0.0254 * 0.0254, 1e-12);
  const Outcome wrong = folder.firn({"shape", "box.stl", "--length-unit", "kg"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--length-unit"));
}

TEST(ShapeCommand, OpenMeshIsRefusedWithItsDefects) {
  const Folder folder;
  auto open = box(10, 10, 10);
  open.pop_back();
  const Outcome o = folder.firn({"shape", folder.write("open.stl", stl(open)), "--json"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(json::parse(o.out)["sound"], false);
  EXPECT_EQ(json::parse(o.out)["defects"]["open_edges"], 3);
  EXPECT_EQ(lines(o.err), 1U);
  EXPECT_THAT(o.err, HasSubstr("open.stl"));
}

TEST(ShapeCommand, InsideOutMeshIsRefused) {
  const Folder folder;
  auto turned = box(10, 10, 10);
  for (Triangle& t : turned) std::swap(t[0], t[1]);
  const Outcome o = folder.firn({"shape", folder.write("turned.stl", stl(turned)), "--json"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(json::parse(o.out)["defects"]["inside_out"], true);
}

TEST(ShapeCommand, CaseWithAnUnsoundMeshIsRefusedInOneLine) {
  const Folder folder;
  auto open = box(10, 10, 10);
  open.pop_back();
  folder.write("open.stl", stl(open));
  std::string text = two_boxes;
  const std::string drawn = "kind = \"box\"\nsize = \"20 20 20 mm\"";
  text.replace(text.find(drawn), drawn.size(),
               "kind = \"mesh\"\nfile = \"open.stl\"\nlength_unit = \"mm\"");
  const Outcome o = folder.firn({"run", folder.write("case.toml", text)});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr("shapes.cube"));
}

TEST(ShapeCommand, ShapesOfACase) {
  const Folder folder;
  const Outcome o = folder.firn({"shape", folder.write("case.toml", two_boxes), "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json facts = json::parse(o.out);
  ASSERT_EQ(facts["shapes"].size(), 1U);
  EXPECT_EQ(facts["shapes"][0]["name"], "cube");
  EXPECT_NEAR(facts["shapes"][0]["mass"], 916.7 * 8e-6, 1e-9);
}

}  // namespace
}  // namespace firn::cli
