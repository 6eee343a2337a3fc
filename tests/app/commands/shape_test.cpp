// firn shape: facts of meshes, sound and unsound.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "experiments/results/results_file.h"
#include "tests/app/program.h"
#include "tests/support/small_cases.h"

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
  EXPECT_EQ(facts["watertight"], true);
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
  EXPECT_NEAR(facts["stiffness_length"], 20e-3, 1e-9);  // the middle edge
  EXPECT_NEAR(facts["stiffness"], 20e3, 1e-3);          // E L
}

// An L of 20 x 20 x 10 mm, 5 mm thick.
std::vector<Triangle> angle_bar() {
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {20, 0}, {20, 5},
                                                      {5, 5}, {5, 20}, {0, 20}};
  const auto at = [&](int i, double z) -> std::array<double, 3> {
    return {outline[i % 6][0], outline[i % 6][1], z};
  };
  std::vector<Triangle> triangles;
  for (int i = 0; i < 6; ++i) {
    triangles.push_back({at(i, 0), at(i + 1, 0), at(i + 1, 10)});
    triangles.push_back({at(i, 0), at(i + 1, 10), at(i, 10)});
  }
  for (const auto& [a, b, c] :
       std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    triangles.push_back({at(a, 10), at(b, 10), at(c, 10)});
    triangles.push_back({at(c, 0), at(b, 0), at(a, 0)});
  }
  return triangles;
}

TEST(ShapeCommand, StatesDeviationReasonAndThinnestPart) {
  const Folder folder;
  folder.write("l.stl", stl(angle_bar()));
  const Outcome o = folder.firn({"shape", "l.stl", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json facts = json::parse(o.out);
  EXPECT_EQ(facts["convex_parts"].size(), 2U);
  EXPECT_NEAR(facts["rounding"], 0.2e-3, 1e-9);  // 2 % of the smallest edge
  EXPECT_NEAR(facts["thinnest_part"], 5e-3, 1e-6);
  EXPECT_LT(facts["deviation_relative"], 0.02);
  EXPECT_EQ(facts["deviation_reason"], "edges rounded");
  const Outcome one = folder.firn({"shape", "l.stl", "--max-parts", "1"});
  EXPECT_THAT(one.out, HasSubstr("max_parts = 1 reached"));
  EXPECT_EQ(folder.firn({"shape", "l.stl", "--max-parts", "65"}).status, 2);
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
  EXPECT_EQ(json::parse(o.out)["watertight"], false);
  EXPECT_EQ(json::parse(o.out)["defects"]["open_edges"], 3);
  EXPECT_EQ(lines(o.err), 1U);
  EXPECT_THAT(o.err, HasSubstr("open.stl"));
}

TEST(ShapeCommand, StatesAndAppliesWhatRepairsAMesh) {
  const Folder folder;
  auto open = box(10, 10, 10);
  open.pop_back();
  folder.write("open.stl", stl(open));
  const Outcome refused = folder.firn({"shape", "open.stl"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.out, HasSubstr("fills holes with 1 facet"));
  EXPECT_THAT(refused.err, HasSubstr("--repair-to FILE.stl writes it repaired"));
  EXPECT_EQ(folder.firn({"shape", "open.stl", "--repair-to", "whole.stl"}).status, 0);
  const Outcome whole = folder.firn({"shape", "whole.stl", "--json"});
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_NEAR(json::parse(whole.out)["volume"], 1e-6, 1e-11);
  EXPECT_EQ(json::parse(whole.out)["repair"]["needed"], false);
  // A lone triangle is beyond repair.
  folder.write("lone.stl", stl({open[0]}));
  const Outcome lone = folder.firn({"shape", "lone.stl", "--repair-to", "none.stl"});
  EXPECT_EQ(lone.status, 2);
  EXPECT_EQ(lines(lone.err), 1U) << lone.err;
  EXPECT_THAT(lone.err, HasSubstr("cannot be repaired: "));
}

TEST(ShapeCommand, OverlappingCubesAreRefusedWithTrianglesAndPlace) {
  const Folder folder;
  auto both = box(20, 20, 20);
  for (Triangle t : box(20, 20, 20)) {
    for (auto& corner : t) corner[0] += 10;
    both.push_back(t);
  }
  const Outcome o = folder.firn({"shape", folder.write("both.stl", stl(both)), "--json"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(json::parse(o.out)["defects"]["overlapping_shells"], 1);
  EXPECT_EQ(json::parse(o.out)["defects"]["nested_shells"], 0);
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr("1 pair of shells that overlap (triangles "));
}

TEST(ShapeCommand, WritesTheUnionOfOverlappingCubesOnRequest) {
  const Folder folder;
  auto both = box(20, 20, 20);
  for (Triangle t : box(20, 20, 20)) {
    for (auto& corner : t) corner[0] += 10;
    both.push_back(t);
  }
  folder.write("both.stl", stl(both));
  EXPECT_THAT(folder.firn({"shape", "both.stl"}).err,
              HasSubstr("--united FILE.stl writes their union"));
  const Outcome united = folder.firn({"shape", "both.stl", "--united", "one.stl", "--json"});
  ASSERT_EQ(united.status, 0) << united.err;
  EXPECT_NEAR(json::parse(united.out)["union"]["volume"], 12e-6, 1e-11);
  const Outcome one = folder.firn({"shape", "one.stl", "--json"});
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_NEAR(json::parse(one.out)["volume"], 12e-6, 1e-11);
  EXPECT_EQ(json::parse(one.out)["convex_parts"].size(), 1U);
  // A mesh without conflicts, a mesh with a hole and a shell that crosses itself have no union.
  EXPECT_EQ(folder.firn({"shape", "one.stl", "--united", "two.stl"}).status, 2);
  both.pop_back();
  folder.write("open.stl", stl(both));
  const Outcome open = folder.firn({"shape", "open.stl", "--united", "none.stl"});
  EXPECT_EQ(open.status, 2);
  EXPECT_EQ(lines(open.err), 1U) << open.err;
  auto crossed = box(10, 10, 10);
  for (Triangle& t : crossed)
    for (auto& corner : t)
      if (corner == std::array<double, 3>{10, 10, 10}) corner = {5, 5, -1};
  folder.write("crossed.stl", stl(crossed));
  const Outcome crossing = folder.firn({"shape", "crossed.stl", "--united", "none.stl"});
  EXPECT_EQ(crossing.status, 2);
  EXPECT_EQ(lines(crossing.err), 1U) << crossing.err;
  EXPECT_THAT(crossing.err, HasSubstr("cannot be united: a shell crosses itself"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "none.stl"));
}

TEST(ShapeCommand, FreeBodyOfOverlappingCubesNeedsItsMass) {
  const Folder folder;
  const auto outcome = [&](double shift, const std::string& keys) {
    auto both = box(20, 20, 20);
    for (Triangle t : box(20, 20, 20)) {
      for (auto& corner : t) corner[0] += shift;
      both.push_back(t);
    }
    folder.write("both.stl", stl(both));
    return folder.firn(
        {"shape", folder.write("case.toml", std::string(two_boxes) +
                                                "\n[[boundaries]]\nname = \"both\"\n"
                                                "material = \"plastic\"\nkind = \"mesh\"\n"
                                                "file = \"both.stl\"\nlength_unit = \"mm\"\n"
                                                "position = \"1 1 1 m\"\nmotion_frame = \"cup\"\n"
                                                "[[motion_frames]]\nname = \"cup\"\n"
                                                "[motion_frames.free]\nfree_rotation = true\n" +
                                                keys)});
  };
  EXPECT_EQ(outcome(50, "density = \"900 kg/m^3\"\n").status, 0);
  const Outcome refused = outcome(10, "density = \"900 kg/m^3\"\n");
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(lines(refused.err), 1U) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("expected mass, center and inertia"));
  const Outcome stated = outcome(10,
                                 "mass = \"0.1 kg\"\ncenter = \"1 1 1 m\"\n"
                                 "inertia = \"1e-3 1e-3 1e-3 kg m^2\"\n");
  EXPECT_EQ(stated.status, 0) << stated.err;
  EXPECT_THAT(stated.out, HasSubstr("1 pair of shells that overlap"));
}

TEST(ShapeCommand, ReadsObjFiles) {
  const Folder folder;
  const Outcome o = folder.firn({"shape",
                                 folder.write("tetra.obj",
                                              "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\n"
                                              "f 1 2 4\nf 2 3 4\nf 3 1 4\n"),
                                 "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NEAR(json::parse(o.out)["volume"], 1e-6 / 6, 1e-12);
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
  EXPECT_THAT(o.err, HasSubstr("open.stl --repair-to FIXED.stl repairs what it can"));
  text.replace(text.find("\"mm\""), 4, "\"cm\"");
  const Outcome in_cm = folder.firn({"run", folder.write("cm.toml", text)});
  EXPECT_EQ(in_cm.status, 2);
  EXPECT_THAT(in_cm.err, HasSubstr("open.stl --length-unit cm --repair-to FIXED.stl"));
}

TEST(ShapeCommand, ABoundaryWithATurnedTriangleNamesTheRepair) {
  const Folder folder;
  std::vector<Triangle> turned = box(100, 80, 60);
  std::swap(turned.back()[0], turned.back()[1]);
  folder.write("turned.stl", stl(turned));
  const Outcome wall = folder.firn({"shape", "turned.stl", "--boundary"});
  EXPECT_EQ(wall.status, 2);
  EXPECT_EQ(lines(wall.err), 1U) << wall.err;
  EXPECT_THAT(wall.err, HasSubstr("; firn shape turned.stl --repair-to FIXED.stl repairs"));
  const std::string text = std::string(two_boxes) +
                           "[[boundaries]]\nname = \"bin\"\nmaterial = \"plastic\"\n"
                           "kind = \"mesh\"\nfile = \"turned.stl\"\nlength_unit = \"mm\"\n";
  const Outcome in_case = folder.firn({"run", folder.write("case.toml", text)});
  EXPECT_EQ(in_case.status, 2);
  EXPECT_EQ(lines(in_case.err), 1U) << in_case.err;
  EXPECT_THAT(in_case.err, HasSubstr("turned.stl --repair-to FIXED.stl repairs what it can"));
  EXPECT_EQ(folder.firn({"shape", "turned.stl", "--repair-to", "FIXED.stl"}).status, 0);
  EXPECT_EQ(folder.firn({"shape", "FIXED.stl", "--boundary"}).status, 0);
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

// A case with a cup of water-thick walls in it: facts of every boundary, and a picture.
std::string case_with_cup(const std::string& keys) {
  std::string text = two_boxes;
  text.replace(text.find("young_modulus = \"2 GPa\""), 0, "density = \"1000 kg/m^3\"\n");
  return text +
         "\n[[boundaries]]\nname = \"cup\"\nmaterial = \"plastic\"\nkind = \"container\"\n"
         "position = \"100 0 10 mm\"\nsection = \"rectangular\"\n" +
         keys;
}

TEST(ShapeCommand, BoundariesOfACase) {
  const Folder folder;
  const std::string text = case_with_cup("wall = \"5 mm\"\nfloor = \"10 mm\"\n");
  const Outcome o = folder.firn({"shape", folder.write("case.toml", text), "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json facts = json::parse(o.out)["boundaries"];
  ASSERT_EQ(facts.size(), 2U);
  EXPECT_EQ(facts[0], (json{{"name", "floor"}, {"kind", "plane"}}));
  EXPECT_EQ(facts[1]["kind"], "container");
  EXPECT_EQ(facts[1]["closed"], true);
  // 95 x 95 x 130 mm around 85 x 85 x 120 mm.
  const double volume = 95e-3 * 95e-3 * 130e-3 - 85e-3 * 85e-3 * 120e-3;
  EXPECT_NEAR(facts[1]["volume"], volume, 1e-12);
  EXPECT_NEAR(facts[1]["mass"], 1000 * volume, 1e-9);
  EXPECT_NEAR(facts[1]["at_start"]["min"][0], 52.5e-3, 1e-9);
  EXPECT_NEAR(facts[1]["at_start"]["min"][2], 0, 1e-9);
  const Outcome table = folder.firn({"shape", "case.toml"});
  EXPECT_THAT(table.out, HasSubstr("cup\n  kind                  container\n"));
  EXPECT_THAT(table.out, HasSubstr("closed"));
}

TEST(ShapeCommand, OneBoundaryOfACase) {
  const Folder folder;
  folder.write("case.toml", case_with_cup("wall = \"5 mm\"\nfloor = \"10 mm\"\n"));
  const Outcome cup = folder.firn({"shape", "case.toml", "--boundary", "cup", "--json"});
  ASSERT_EQ(cup.status, 0) << cup.err;
  EXPECT_EQ(json::parse(cup.out)["name"], "cup");
  const Outcome text = folder.firn({"shape", "case.toml", "--boundary", "cup"});
  EXPECT_TRUE(text.out.starts_with("cup\n")) << text.out;
  EXPECT_THAT(text.out, testing::Not(HasSubstr("floor\n")));
  const Outcome wrong = folder.firn({"shape", "case.toml", "--boundary", "cap"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("did you mean \"cup\"?"));
  const Outcome none = folder.firn({"shape", "case.toml", "--boundary"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("expected one of floor, cup"));
  const Outcome plane =
      folder.firn({"shape", "case.toml", "--boundary", "floor", "--picture", "floor.svg"});
  EXPECT_EQ(plane.status, 2);
  EXPECT_THAT(plane.err, HasSubstr("half-space without a mesh"));
  EXPECT_FALSE(folder.contains("floor.svg"));
}

// Open surfaces are boundaries, and so are closed ones that face inwards: containers.
TEST(ShapeCommand, MeshFilesAsBoundaries) {
  const Folder folder;
  std::vector<Triangle> open = box(100, 80, 60);
  open.erase(open.begin(), open.begin() + 2);
  folder.write("open.stl", stl(open));
  const Outcome body = folder.firn({"shape", "open.stl"});
  EXPECT_EQ(body.status, 2);
  const Outcome wall = folder.firn({"shape", "open.stl", "--boundary", "--json"});
  ASSERT_EQ(wall.status, 0) << wall.err;
  const json facts = json::parse(wall.out);
  EXPECT_EQ(facts["triangles"], 10);
  EXPECT_EQ(facts["convex_parts"], 5);
  EXPECT_EQ(facts["closed"], false);
  const Outcome text = folder.firn({"shape", "open.stl", "--boundary", "--thickness", "5 mm"});
  EXPECT_THAT(text.out, HasSubstr("open, 4 free edges"));
  std::vector<Triangle> inward = box(100, 80, 60);
  for (auto& triangle : inward) std::swap(triangle[1], triangle[2]);
  folder.write("inward.stl", stl(inward));
  const Outcome container = folder.firn({"shape", "inward.stl", "--boundary"});
  ASSERT_EQ(container.status, 0) << container.err;
  EXPECT_THAT(container.out, HasSubstr("closed, faces inwards: bodies are inside"));
  const Outcome thin = folder.firn({"shape", "open.stl", "--boundary", "--thickness", "0 mm"});
  EXPECT_EQ(thin.status, 2);
  const Outcome alone = folder.firn({"shape", "open.stl", "--thickness", "1 mm"});
  EXPECT_EQ(alone.status, 2);
}

// The container of a closed mesh that faces inwards keeps a cube inside, on all sides.
TEST(ShapeCommand, AnInwardMeshHoldsBodies) {
  const Folder folder;
  std::vector<Triangle> inward = box(60, 60, 60);
  for (auto& triangle : inward) std::swap(triangle[1], triangle[2]);
  folder.write("inward.stl", stl(inward));
  std::string text = two_boxes;
  text.erase(text.find("[[boundaries]]"));
  text.replace(text.find("0 0 0.012 m"), 11, "30 30 14 mm");
  text.erase(text.rfind("[[particles]]"));
  text.replace(text.find("\"50 ms\""), 7, "\"0.3 s\"");
  text +=
      "velocity = \"1 0.4 0.2 m/s\"\n[[boundaries]]\nname = \"bin\"\nmaterial = \"plastic\"\n"
      "kind = \"mesh\"\nfile = \"inward.stl\"\nlength_unit = \"mm\"\n[output]\nframe_interval = "
      "\"10 ms\"\n";
  folder.write("bin.toml", text);
  const Outcome o = folder.firn({"run", "bin.toml", "-o", "bin.h5", "--quiet"});
  ASSERT_EQ(o.status, 0) << o.err;
  const Recording recording((folder.path() / "bin.h5").string());
  double farthest = 0;
  for (std::size_t f = 0; f < recording.frame_times().size(); ++f) {
    const Frame frame = recording.frame(f);
    for (const double x : frame.position[0]) {
      EXPECT_GT(x, 0.009);
      EXPECT_LT(x, 0.051);
      farthest = std::max(farthest, x);
    }
  }
  EXPECT_GT(farthest, 0.045);  // it came to a wall
}

TEST(ShapePictureLong, PictureOfOneBoundary) {
  const Folder folder;
  folder.write("case.toml", case_with_cup(""));
  const Outcome o =
      folder.firn({"shape", "case.toml", "--boundary", "cup", "--picture", "cup.svg"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(read_text(folder.path() / "cup.svg"), HasSubstr("of two boxes, at the start"));
  folder.write("box.stl", stl(box(10, 10, 10)));
  const Outcome mesh = folder.firn({"shape", "box.stl", "--boundary", "--picture", "box.svg"});
  EXPECT_EQ(mesh.status, 0) << mesh.err;
  EXPECT_TRUE(folder.contains("box.svg"));
}

TEST(ShapePictureLong, PictureOfACase) {
  const Folder folder;
  const Outcome o = folder.firn(
      {"shape", folder.write("case.toml", case_with_cup("")), "--picture", "scene.svg"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string drawn = read_text(folder.path() / "scene.svg");
  EXPECT_THAT(drawn, HasSubstr("cup"));
  EXPECT_THAT(drawn, HasSubstr("2 of 2 bodies"));
  const Outcome wrong = folder.firn({"shape", "case.toml", "--picture", "scene.bmp"});
  EXPECT_EQ(wrong.status, 2);
  const Outcome mesh =
      folder.firn({"shape", folder.write("box.stl", stl(box(1, 1, 1))), "--picture", "scene.svg"});
  EXPECT_EQ(mesh.status, 2);
  EXPECT_THAT(mesh.err, HasSubstr("--picture"));
}

TEST(ShapeCommand, ImpossibleMachinePartsAreRefusedByFileLineAndKey) {
  const Folder folder;
  folder.write("case.toml", case_with_cup("walls = \"5 mm\"\n"));
  const Outcome unknown = folder.firn({"shape", "case.toml"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("unknown key; did you mean \"wall\"?"));
  std::string text = case_with_cup("");
  text.replace(text.find("container"), 9, "auger");
  text.replace(text.find("section = \"rectangular\""), 23, "shaft_diameter = \"0.1 m\"");
  folder.write("case.toml", text);
  const Outcome o = folder.firn({"shape", "case.toml"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr("case.toml:49: boundaries.cup.shaft_diameter: is 100 mm; expected"));
}

}  // namespace
}  // namespace firn::cli
