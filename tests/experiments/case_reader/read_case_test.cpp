#include "experiments/case_reader/read_case.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "tests/experiments/case_reader/two_cubes_case.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using two_cubes::error_of;
using two_cubes::kTwoCubes;
using two_cubes::read;
using two_cubes::with;

TEST(Case, ReadsEverySection) {
  const Case c = read(kTwoCubes);
  EXPECT_EQ(c.name, "two cubes");
  EXPECT_EQ(c.duration, 1);
  EXPECT_EQ(c.seed, 7u);
  EXPECT_EQ(c.frame_interval, 1e-3);
  EXPECT_EQ(c.model.gravity, Vec3(0, 0, -9.81));
  ASSERT_EQ(c.model.materials.size(), 2u);
  EXPECT_EQ(c.model.materials[0].name, "ice");
  EXPECT_EQ(c.model.materials[0].density, 916.7);
  EXPECT_DOUBLE_EQ(c.model.materials[0].young_modulus, 1e7);
  const Interaction& ice = c.model.interaction(0, 0);
  EXPECT_EQ(ice.static_friction, 0.2);
  EXPECT_EQ(ice.dynamic_friction, 0.1);
  // Given as plastic-ice, with one friction for both.
  for (const Interaction& wall : {c.model.interaction(0, 1), c.model.interaction(1, 0)}) {
    EXPECT_EQ(wall.static_friction, 0.3);
    EXPECT_EQ(wall.dynamic_friction, 0.3);
    EXPECT_EQ(wall.restick_velocity, 1e-3);
    EXPECT_EQ(wall.minimum_unloading_ratio, 1e-3);
  }
  ASSERT_EQ(c.model.shapes.size(), 1u);
  EXPECT_EQ(c.model.shapes[0].mass, 1);
  EXPECT_DOUBLE_EQ(c.model.shapes[0].stiffness, 1e6);  // E L = 1e7 Pa * 0.1 m
  ASSERT_EQ(c.placed.size(), 2u);
  EXPECT_EQ(c.placed[0].orientation.coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(c.placed[0].velocity, Vec3(0, 0, -1));
  EXPECT_DOUBLE_EQ(c.placed[1].position.z(), 0.4);
  EXPECT_DOUBLE_EQ(c.placed[1].orientation.y(), 0.8);
  EXPECT_EQ(c.model.particles[1].tag, 3);
  ASSERT_EQ(c.stages.size(), 2u);
  EXPECT_TRUE(c.stages[0].ends_on(Stage::EndEvent::settled));
  EXPECT_EQ(c.stages[1].remove, std::vector<std::string>{"lid"});
  ASSERT_EQ(c.stages[1].motions.size(), 1u);
  EXPECT_EQ(c.model.boundaries.at(c.stages[1].motions[0].boundary).name, "floor");
  ASSERT_EQ(c.outlets.size(), 1u);
  EXPECT_EQ(c.outlets[0].normal, Vec3::UnitX());
}

TEST(Case, BoundariesAreSolids) {
  const Case c = read(kTwoCubes);
  const Boundary &floor = c.model.boundaries.at(0), &lid = c.model.boundaries.at(1);
  EXPECT_EQ(floor.kind, Boundary::Kind::plane);
  EXPECT_TRUE(floor.rigid);
  EXPECT_TRUE((floor.orientation * Vec3::UnitZ()).isApprox(Vec3::UnitZ()));
  EXPECT_EQ(lid.kind, Boundary::Kind::solid);
  EXPECT_EQ(lid.origin, Vec3(0, 0, 1));
  ASSERT_EQ(lid.parts.size(), 1u);
  EXPECT_EQ(lid.parts[0].faces.size(), 6u);
  EXPECT_EQ(lid.mesh.triangles.size(), 12u);
  ASSERT_EQ(lid.motions.size(), 1u);
  EXPECT_DOUBLE_EQ(lid.motions[0].angular_speed, M_PI);
  EXPECT_EQ(lid.motions[0].stop, 0.5);
  for (const Vec3& n : {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-2, 3, 1)}) {
    const std::string text = with("[0, 0, 2]", fmt::format("[{}, {}, {}]", n.x(), n.y(), n.z()));
    const Quat q = read(text).model.boundaries[0].orientation;
    EXPECT_TRUE((q * Vec3::UnitZ()).isApprox(n.normalized(), 1e-12)) << n.transpose();
  }
}

TEST(Case, AutomaticTimeStepComesFromTheStiffestSpring) {
  // A cube on a rigid floor: K = 1e6 N/m, unloading K / 0.3^2, m = 1 kg; ice on ice has half the
  // stiffness and half the mass, so the same period.
  const Case c = read(kTwoCubes);
  EXPECT_TRUE(c.automatic_timestep);
  EXPECT_NEAR(c.model.timestep, M_PI / 2 * std::sqrt(1 / (1e6 / 0.09)) / 10, 1e-9);
  EXPECT_FALSE(c.timestep_reason.empty());
  const Case given = read(with("seed = 7", "timestep = \"10 us\""));
  EXPECT_FALSE(given.automatic_timestep);
  EXPECT_DOUBLE_EQ(given.model.timestep, 1e-5);
}

// The text of the refusal names the largest stable step, and that step is taken.
TEST(Case, UnstableTimeStepIsRefusedUnlessAllowed) {
  const double quarter = M_PI / 2 * std::sqrt(1 / (1e6 / 0.09));
  const auto given = [&](double timestep, bool allowed) {
    return with("seed = 7", fmt::format("timestep = \"{:.17g} s\"", timestep)) +
           (allowed ? "[numerics]\nallow_unstable_timestep = true\n" : "");
  };
  EXPECT_NEAR(read(given(quarter / 3.001, false)).steps_taken, 3.001, 1e-6);
  EXPECT_NEAR(read(given(quarter / 10, false)).steps_taken, 10, 1e-6);
  for (const double steps : {2.999, 2.0, 0.8}) {
    const std::string message = test::error_of([&] { read(given(quarter / steps, false)); });
    EXPECT_THAT(message, testing::HasSubstr("case.timestep")) << steps;
    EXPECT_THAT(message, testing::HasSubstr(fmt::format("expected at most {:.4g} s", quarter / 3)));
    EXPECT_NEAR(read(given(quarter / steps, true)).steps_taken, steps, 1e-6);
  }
  EXPECT_THROW(read(with("seed = 7", "steps_per_loading = 2")), InputError);
}

TEST(Case, FillsFollowPlacedParticles) {
  const std::string fills = R"(
[[fills]]
shape = "cube"
count = 5
tag = 4
region_min = "-1 -1 2 m"
region_max = "1 1 3 m"
batch = 2
interval = "0.1 s"
velocity = "0 0 -1 m/s"
)";
  const Case c = read(kTwoCubes + fills);
  ASSERT_EQ(c.model.particles.size(), 7u);
  EXPECT_EQ(c.model.particles[1].tag, 3);
  EXPECT_EQ(c.model.particles[2].tag, 4);
  ASSERT_EQ(c.fills.size(), 1u);
  EXPECT_EQ(c.fills[0].batch, 2);
  EXPECT_EQ(c.fills[0].region_max, Vec3(1, 1, 3));
  EXPECT_TRUE(c.fills[0].random_orientation);

  EXPECT_EQ(error_of(kTwoCubes + with("count = 5", "count = 0", fills)),
            "c.toml:87: fills.0.count: is the bare number 0; expected a whole number of at least "
            "1");
  EXPECT_EQ(error_of(kTwoCubes + with("1 1 3 m", "1 1 2 m", fills)),
            "c.toml:90: fills.0.region_max: is not beyond region_min along every axis; expected a "
            "box");
  EXPECT_EQ(error_of(kTwoCubes + with("batch = 2", "batch = 2000", with("5", "5000", fills))),
            "c.toml:87: fills.0.count: 2000 of \"cube\" at once (100 x 100 x 100 mm, 2000 L in "
            "all) do not fit a region of 2 x 2 x 1 m, of which random placement fills 30 % at most "
            "(1200 L); expected fewer or "
            "a larger region");
  EXPECT_EQ(error_of(kTwoCubes + with("interval = \"0.1 s\"", "", fills)),
            "c.toml:85: fills.0.interval: is zero for batches of 2 out of 5; expected a time above "
            "zero between them");
}

TEST(Case, EveryShapeKind) {
  const auto shape = [](const std::string& keys) {
    const Case c = read(kTwoCubes + "\n[shapes.x]\nmaterial = \"ice\"\n" + keys);
    return c.model.shapes.at(1);
  };
  EXPECT_NEAR(shape("kind = \"sphere\"\nradius = \"1 cm\"").mass, 916.7 * 4 / 3 * M_PI * 1e-6,
              1e-9);
  EXPECT_NEAR(shape("kind = \"crescent\"").mass, 13.7e-3, 1e-9);
  EXPECT_NEAR(shape("kind = \"crescent\"\nvariant = \"table1-mass-override\"").mass, 13.7e-3, 1e-9);
  EXPECT_NEAR(shape("kind = \"crescent\"\nvariant = \"custom\"\nchord = \"50 mm\"").box.x(), 0.05,
              1e-9);
  EXPECT_NEAR(shape("kind = \"convex\"\nvertices = [\"0 0 0 mm\", \"6 0 0 mm\", \"0 1 0 cm\", "
                    "\"0 0 10 mm\"]")
                  .volume,
              1e-7, 1e-15);
  const Shape pair = shape(
      "kind = \"compound\"\ncomponents = [{shape = \"cube\", position = \"-5 0 0 cm\"}, "
      "{shape = \"cube\", position = \"5 0 0 cm\"}]");
  EXPECT_NEAR(pair.mass, 2, 1e-12);
  EXPECT_NEAR(pair.box.x(), 0.2, 1e-12);
}

TEST(Case, MeshesAreFoundByContent) {
  const std::filesystem::path folder = test::scratch_path("case_meshes");
  std::filesystem::create_directories(folder);
  const auto write_tetrahedron = [&](double size) {
    std::ofstream out(folder / "t.stl");
    const Vec3 p[4] = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
    out << "solid t\n";
    for (const auto& t : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
      out << "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) out << "vertex " << p[i].transpose() << "\n";
      out << "endloop\nendfacet\n";
    }
    out << "endsolid t\n";
  };
  write_tetrahedron(10);
  const std::string text = kTwoCubes +
                           "[shapes.t]\nkind = \"mesh\"\nmaterial = \"ice\"\nfile = \"t.stl\"\n"
                           "length_unit = \"mm\"\n"
                           "[[boundaries]]\nname = \"t\"\nkind = \"mesh\"\nmaterial = \"plastic\"\n"
                           "file = \"t.stl\"\nlength_unit = \"mm\"\n";
  const Case c = read_case_text(text, "c.toml", folder.string());
  EXPECT_NEAR(c.model.shapes[1].volume, 1e-6 / 6, 1e-15);
  EXPECT_EQ(c.model.boundaries[2].parts.size(), 1u);  // closed and convex
  // The resolved text knows where the file lies and what was in it.
  EXPECT_EQ(read_case_text(c.resolved, "r.toml", "/nowhere").resolved, c.resolved);
  write_tetrahedron(11);
  EXPECT_THAT(test::error_of([&] { read_case_text(c.resolved, "r.toml", "/nowhere"); }),
              testing::HasSubstr("t.stl\" has changed; expected the content with SHA-256 "));
  std::filesystem::remove_all(folder);
  EXPECT_EQ(error_of(with("kind = \"box\"\nsize = \"0.1 0.1 0.1 m\"",
                          "kind = \"mesh\"\nlength_unit = \"mm\"\nfile = \"none.stl\"")),
            fmt::format("c.toml:26: shapes.cube.file: {}: cannot be opened: No such file or "
                        "directory; expected an STL "
                        "or OBJ file",
                        std::filesystem::absolute("none.stl").string()));
}

TEST(Case, ResolvedTextIsTheSameCase) {
  const Case c = read(kTwoCubes, {{"interactions.ice-ice.restitution", "0.1"}});
  const Case again = read(c.resolved);
  EXPECT_EQ(again.resolved, c.resolved);
  EXPECT_EQ(again.model.timestep, c.model.timestep);
  EXPECT_EQ(again.model.interaction(0, 0).restitution, 0.1);
  EXPECT_EQ(again.model.boundaries[1].motions[0].angular_speed,
            c.model.boundaries[1].motions[0].angular_speed);
  EXPECT_EQ(again.stages[0].settle_time, c.stages[0].settle_time);
  EXPECT_EQ(again.model.numerics.contact_margin_limit, c.model.numerics.contact_margin_limit);
  EXPECT_NE(c.resolved.find("restick_velocity"), std::string::npos);  // a default, filled in
  EXPECT_EQ(case_hash(again), case_hash(c));
  EXPECT_EQ(case_hash(c).size(), 64u);
  EXPECT_NE(case_hash(c), case_hash(read(kTwoCubes)));
}

TEST(Case, OverridesReachEveryValue) {
  EXPECT_EQ(parse_override("a.b = 1 = 2"), (Override{"a.b", "1 = 2"}));
  EXPECT_THROW(parse_override("a.b"), InputError);
  EXPECT_THROW(parse_override("=1"), InputError);
  const auto set = [](const std::string& text) { return read(kTwoCubes, {parse_override(text)}); };
  EXPECT_EQ(set("interactions.ice-ice.static_friction=0.4").model.interaction(0, 0).static_friction,
            0.4);
  EXPECT_EQ(set("shapes.cube.rounding=0.5mm").model.shapes[0].rounding, 5e-4);
  EXPECT_EQ(set("shapes.cube.rounding=\"0.5 mm\"").model.shapes[0].rounding, 5e-4);
  EXPECT_EQ(set("boundaries.0.point=0 0 -1 m").model.boundaries[0].origin.z(), -1);
  EXPECT_EQ(set("boundaries.lid.position=0 0 2 m").model.boundaries[1].origin.z(), 2);
  EXPECT_EQ(set("numerics.overlap_limit=0.25").model.numerics.overlap_limit, 0.25);
  EXPECT_EQ(set("case.seed=9000000000000000000").seed, 9000000000000000000u);
  // The file says plastic-ice.
  EXPECT_EQ(set("interactions.ice-plastic.restitution=0.5").model.interaction(0, 1).restitution,
            0.5);
  const Case turned = set("boundaries.floor.normal=[1, 0, 0]");
  EXPECT_TRUE((turned.model.boundaries[0].orientation * Vec3::UnitZ()).isApprox(Vec3::UnitX()));
}

TEST(CaseFile, ExampleOfTheManualIsACase) {
  const std::string manual = test::read_text(FIRN_SOURCE_DIR "/docs/case-files.md");
  const std::size_t first = manual.find("```toml\n") + 8;
  const Case c = read(manual.substr(first, manual.find("```", first) - first));
  EXPECT_EQ(c.model.particles.size(), 1u);
}

TEST(CaseFile, MissingFileIsNamed) {
  EXPECT_EQ(test::error_of([] { read_case("nowhere/none.toml"); }),
            "nowhere/none.toml: cannot be opened: No such file or directory; expected a case file");
}

TEST(CaseFile, OldPathOfAShippedFileNamesTheNewOne) {
  const test::ScratchFolder folder("moved");
  std::filesystem::create_directories(folder.path() / "cases/slope");
  std::ofstream(folder / "cases/slope/case.toml") << "[case]\n";
  EXPECT_EQ(test::error_of([&] { read_case(folder / "experiments/slope/case.toml"); }),
            (folder / "experiments/slope/case.toml") + ": has moved to " +
                (folder / "cases/slope/case.toml") + "; expected a case file");
}

}  // namespace
}  // namespace firn
