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
#include "experiments/text/toml_document.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

// Line numbers matter below: the text starts with line 1.
const std::string kTwoCubes = R"([case]
name = "two cubes"
duration = "1 s"
seed = 7

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
poisson_ratio = 0.33

[materials.plastic]
young_modulus = "2 GPa"

[interactions.ice-ice]
static_friction = 0.2
dynamic_friction = 0.1
restitution = 0.3

[interactions.plastic-ice]
static_friction = 0.3
restitution = 0.3

[shapes.cube]
kind = "box"
size = "0.1 0.1 0.1 m"
material = "ice"
mass = "1 kg"
rounding = "0.1 mm"

[[particles]]
shape = "cube"
position = "0 0 0.2 m"
velocity = "0 0 -1 m/s"

[[particles]]
shape = "cube"
position = "0 0 40 cm"
orientation = [0.6, 0, 0.8, 0]
tag = 3

[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
normal = [0, 0, 2]
rigid = true

[[boundaries]]
name = "lid"
material = "plastic"
kind = "box"
size = "1 1 0.1 m"
position = "0 0 1 m"

[[boundaries.motions]]
kind = "rotation"
axis = [0, 1, 0]
center = "0.5 0 1 m"
angular_velocity = "30 rpm"
stop = "0.5 s"

[[outlets]]
name = "side"
point = "1 0 0 m"
normal = [1, 0, 0]

[[stages]]
name = "settle"
end_when = "settled"
max_duration = "0.5 s"

[[stages]]
name = "open"
max_duration = "0.5 s"
remove_boundaries = ["lid"]

[[stages.motions]]
boundary = "floor"
kind = "translation"
velocity = "0 0 -1 m/s"

[output]
frame_interval = "1 ms"
)";

// The text with its first `from` replaced; a test that replaces nothing would prove nothing.
std::string with(const std::string& from, const std::string& to, std::string text = kTwoCubes) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

Case read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_case_text(text, "c.toml", ".", overrides);
}

std::string error_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  try {
    read(text, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of_set(const std::string& override_text) {
  return error_of(kTwoCubes, {parse_override(override_text)});
}

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
    try {
      read(given(quarter / steps, false));
      ADD_FAILURE() << steps << " steps were accepted";
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr("case.timestep"));
      EXPECT_THAT(e.what(),
                  testing::HasSubstr(fmt::format("expected at most {:.4g} s", quarter / 3)));
    }
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

TEST(Case, SuggestionsNameTheLikelyKey) {
  const std::vector<std::string_view> keys = {"static_friction",  "dynamic_friction",
                                              "restitution",      "rolling_resistance",
                                              "restick_velocity", "shape"};
  for (const auto& [word, wanted] : {std::pair{"friction", "static_friction"},
                                     {"static_frction", "static_friction"},
                                     {"restituton", "restitution"},
                                     {"velocity", "restick_velocity"},
                                     {"rolling", "rolling_resistance"},
                                     {"shapes", "shape"},
                                     {"dynamic_frction", "dynamic_friction"}})
    EXPECT_EQ(nearest(word, keys), wanted) << word;
  // Words of other programs.
  const std::vector<std::string_view> mesh = {"kind", "material", "mass", "file", "length_unit"};
  EXPECT_EQ(nearest("units", mesh), "length_unit");
  EXPECT_EQ(nearest("mesh", mesh), "file");
  EXPECT_EQ(nearest("mu", keys), "static_friction");
  EXPECT_EQ(nearest("cor", keys), "restitution");
  // Where the key that means it is none of the table, and words without anything in common.
  for (const char* word : {"mu", "budget", "", "x"}) EXPECT_EQ(nearest(word, mesh), std::nullopt);
  EXPECT_EQ(suggestion("budget", mesh), "expected one of kind, material, mass, file, length_unit");
  EXPECT_EQ(suggestion("mas", mesh), "the nearest known one is \"mass\"");
  EXPECT_EQ(suggestion("budget", std::vector<std::string_view>(50, "key")).substr(0, 26),
            "expected one of key, key, ");
  EXPECT_THAT(suggestion("budget", std::vector<std::string_view>(50, "key")),
              testing::EndsWith(", key, ..."));
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
  EXPECT_THROW(
      {
        try {
          read_case_text(c.resolved, "r.toml", "/nowhere");
        } catch (const InputError& error) {
          EXPECT_NE(std::string(error.what())
                        .find("t.stl\" has changed; expected the content with "
                              "SHA-256 "),
                    std::string::npos)
              << error.what();
          throw;
        }
      },
      InputError);
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

struct BadInput {
  std::string from, to, message;
};

TEST(Case, WrongKeysAndTypesAreNamed) {
  const std::vector<BadInput> bad = {
      {"duration = \"1 s\"", "duration = 1",
       "c.toml:3: case.duration: is the bare number 1; expected a time, such as \"1 ms\""},
      {"duration = \"1 s\"", "duration = \"1 kg\"",
       "c.toml:3: case.duration: \"1 kg\" is a mass; expected a time, such as \"1 ms\""},
      {"duration = \"1 s\"", "duration = \"1 sek\"",
       "c.toml:3: case.duration: \"1 sek\": unknown unit \"sek\" (nearest: s, deg, rev); expected "
       "a "
       "time, such as \"1 ms\""},
      {"duration = \"1 s\"\n", "",
       "c.toml:1: case.duration: missing; expected a time, such as \"1 ms\""},
      {"duration = \"1 s\"", "duration = \"0 s\"",
       "c.toml:3: case.duration: is \"0 s\"; expected a time above zero"},
      {"duration = \"1 s\"", "duration = \"inf s\"",
       "c.toml:3: case.duration: \"inf s\" is not finite; expected a time, such as \"1 ms\""},
      {"seed = 7", "sede = 7",
       "c.toml:4: case.sede: unknown key; the nearest known one is "
       "\"seed\""},
      {"seed = 7", "seed = 7.5",
       "c.toml:4: case.seed: is the bare number 7.5; expected a whole number of at least 0"},
      {"seed = 7", "duration = \"2 s\"",
       "c.toml:4: TOML: Error while parsing key-value pair: cannot redefine existing string "
       "'duration'; expected valid TOML"},
      {"[output]", "[ouptut]",
       "c.toml:82: ouptut: unknown key; the nearest known one is "
       "\"output\""},
      {"size = \"0.1 0.1 0.1 m\"", "size = \"0.1 0.1 m\"",
       "c.toml:25: shapes.cube.size: cannot read \"0.1 0.1 m\"; expected three numbers and the "
       "unit of a length, such as \"0 0 0.2 m\""},
      {"rigid = true", "rigid = 1",
       "c.toml:46: boundaries.floor.rigid: is the bare number 1; expected true or false"},
      {"remove_boundaries = [\"lid\"]", "remove_boundaries = \"lid\"",
       "c.toml:75: stages.open.remove_boundaries: is \"lid\"; expected an array of strings"},
      {"[[stages]]\nname = \"settle\"", "[stages]\nname = \"settle\"",
       "c.toml:72: TOML: Error while parsing table header: cannot redefine existing table 'stages' "
       "as array-of-tables; expected "
       "valid TOML"},
  };
  for (const BadInput& b : bad) EXPECT_EQ(error_of(with(b.from, b.to)), b.message);
}

TEST(Case, WrongValuesAreNamed) {
  const std::vector<BadInput> bad = {
      {"916.7 kg/m^3", "-1 kg/m^3",
       "c.toml:7: materials.ice.density: is \"-1 kg/m^3\"; expected a density above zero"},
      {"mass = \"1 kg\"", "mass = \"0 kg\"",
       "c.toml:27: shapes.cube.mass: is \"0 kg\"; expected a mass above zero"},
      {"0.1 0.1 0.1 m", "0.1 0 0.1 m",
       "c.toml:25: shapes.cube.size: is \"0.1 0 0.1 m\"; expected three lengths above zero"},
      {"poisson_ratio = 0.33", "poisson_ratio = 0.6",
       "c.toml:9: materials.ice.poisson_ratio: is 0.6; expected a number above -1 and up to 0.5"},
      {"restitution = 0.3", "restitution = 0",
       "c.toml:17: interactions.ice-ice.restitution: is 0; expected a number above 0 and up to 1"},
      {"restitution = 0.3", "restitution = 1.1",
       "c.toml:17: interactions.ice-ice.restitution: is 1.1; expected a number above 0 and up to "
       "1"},
      {"restitution = 0.3", "restitution = 0.3\nadhesion_stiffness_fraction = 1",
       "c.toml:18: interactions.ice-ice.adhesion_stiffness_fraction: is 1; expected a number from "
       "0 "
       "to below 1"},
      {"restitution = 0.3",
       "restitution = 0.3\nadhesion_force = \"1 mN\"\nminimum_unloading_ratio = 0",
       "c.toml:19: interactions.ice-ice.minimum_unloading_ratio: is 0; expected a number above 0 "
       "together with "
       "adhesion, which acts while a contact is loaded"},
      {"restitution = 0.3", "restitution = nan",
       "c.toml:17: interactions.ice-ice.restitution: is nan; expected a finite number"},
      {"dynamic_friction = 0.1", "dynamic_friction = 0.21",
       "c.toml:16: interactions.ice-ice.dynamic_friction: is 0.21, above the static friction 0.2; "
       "expected at most as much"},
      {"static_friction = 0.2", "static_friction = -0.2",
       "c.toml:15: interactions.ice-ice.static_friction: is -0.2; expected a number of at least "
       "0"},
      {"orientation = [0.6, 0, 0.8, 0]", "orientation = [0.6, 0, 0.9, 0]",
       "c.toml:38: particles.1.orientation: has norm 1.081665; expected a unit quaternion [w, x, "
       "y, z]"},
      {"orientation = [0.6, 0, 0.8, 0]", "orientation = [1, 0, 0]",
       "c.toml:38: particles.1.orientation: has 3 entries; expected a unit quaternion [w, x, y, "
       "z]"},
      {"normal = [0, 0, 2]", "normal = [0, 0, 0]",
       "c.toml:45: boundaries.floor.normal: has length 0; expected a direction [x, y, z] that is "
       "not "
       "zero"},
      {"stop = \"0.5 s\"", "start = \"1 s\"\nstop = \"0.5 s\"",
       "c.toml:61: boundaries.lid.motions.0.stop: is 0.5 s, not after the start at 1 s; expected a "
       "later time"},
      {"rounding = \"0.1 mm\"", "rounding = \"60 mm\"",
       "c.toml:28: shapes.cube.rounding: nothing is left of a convex part rounded by 60 mm; "
       "expected "
       "less than half of its thickness; left out, the rounding follows from the shape"},
  };
  for (const BadInput& b : bad) {
    const std::string message = error_of(with(b.from, b.to));
    EXPECT_EQ(message, b.message);
  }
}

TEST(Case, UnknownReferencesAreNamed) {
  const std::vector<BadInput> bad = {
      {"material = \"ice\"", "material = \"iec\"",
       "c.toml:26: shapes.cube.material: unknown material \"iec\"; the nearest known one is "
       "\"ice\""},
      {"shape = \"cube\"", "shape = \"cubes\"",
       "c.toml:31: particles.0.shape: unknown shape \"cubes\"; the nearest known one is \"cube\""},
      {"remove_boundaries = [\"lid\"]", "remove_boundaries = [\"lit\"]",
       "c.toml:75: stages.open.remove_boundaries: unknown boundary \"lit\"; the nearest known one "
       "is \"lid\""},
      {"boundary = \"floor\"", "boundary = \"flor\"",
       "c.toml:78: stages.open.motions.0.boundary: unknown boundary \"flor\"; the nearest known "
       "one "
       "is \"floor\""},
      {"[interactions.plastic-ice]", "[interactions.plastik-ice]",
       "c.toml:19: interactions.plastik-ice: joins no two known materials; the nearest pair is "
       "\"plastic-ice\""},
      {"[interactions.plastic-ice]", "[interactions.rubber]",
       "c.toml:19: interactions.rubber: joins no two known materials; expected two materials of "
       "the case, joined by a dash"},
      {"[interactions.plastic-ice]", "[interactions.plastic-plastic]",
       "c.toml:14: interactions: shape \"cube\" can meet boundary \"floor\", but nothing is said "
       "about \"ice-plastic\"; expected a table [interactions.ice-plastic]"},
      {"[interactions.ice-ice]", "[interactions.ice-plastic]",
       "c.toml:19: interactions.plastic-ice: is given twice, once in each order; expected one "
       "table a pair"},
      {"name = \"lid\"", "name = \"floor\"",
       "c.toml:49: boundaries.1.name: \"floor\" is taken already; expected another name"},
      {"name = \"lid\"", "name = \"a/b\"",
       "c.toml:49: boundaries.\"a/b\".name: is \"a/b\"; expected a name without slashes"},
      {"density = \"916.7 kg/m^3\"", "", "no error"},  // the cube's mass is given
      {"young_modulus = \"0.01 GPa\"", "",
       "c.toml:26: shapes.cube.material: \"ice\" has no young_modulus; expected one, or a "
       "stiffness of the shape"},
      {"young_modulus = \"2 GPa\"", "",
       "c.toml:50: boundaries.lid.material: \"plastic\" has no young_modulus; expected one, or a "
       "stiffness of the boundary, or rigid = true"},
  };
  for (const BadInput& b : bad) EXPECT_EQ(error_of(with(b.from, b.to)), b.message);
  EXPECT_EQ(error_of("[case]\nduration = \"1 s\"\n[materials.ice]\n"),
            "c.toml:1: particles: the case has none; expected [[particles]], [[fills]], "
            "[[inlets]], [initial_state] or [experiment]");
  EXPECT_EQ(error_of(kTwoCubes + "[shapes.a]\nkind = \"compound\"\nmaterial = \"ice\"\n"
                                 "components = [{shape = \"a\"}]\n"),
            "c.toml:87: shapes.a.components.0.shape: \"a\" contains itself; expected another "
            "shape");
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

// Messages name elements of lists as --set takes them: by name, by index where no name is unique.
TEST(Case, PathsOfMessagesNameElements) {
  std::mt19937 random(11);
  const std::vector<std::string> names = {"floor",
                                          "lid",
                                          "a wall",
                                          "1",
                                          "12x",
                                          "x\"y",
                                          "back\\slash",
                                          "a.b",
                                          "#3",
                                          "ö",
                                          "-",
                                          "true",
                                          std::string(70, 'n'),
                                          "a = b",
                                          "'",
                                          "[0]"};
  const auto quoted = [](const std::string& name) {
    std::string text;
    for (const char c : name)
      text += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return "\"" + text + "\"";
  };
  for (int member = 0; member < 200; ++member) {
    std::vector<std::string> list;
    const std::size_t count = 1 + random() % 4;
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
      list.push_back(names[random() % names.size()]);
      text += fmt::format("[[walls]]\nname = {}\n[[walls.motions]]\nspeed = {}\n",
                          quoted(list.back()), i);
    }
    const std::size_t chosen = random() % count;
    TomlDocument document(text, "c.toml");
    const TomlTable wall = TomlTable::root(document).tables("walls")[chosen];
    const TomlTable motion = wall.tables("motions")[0];
    std::string message;
    try {
      motion.fail("speed", "is wrong");
    } catch (const InputError& error) {
      message = error.what();
    }
    const std::string& name = list[chosen];
    const bool unique = std::ranges::count(list, name) == 1 && name != "1" && name.size() < 60;
    const std::string start = fmt::format("c.toml:{}: ", 4 * chosen + 4);
    ASSERT_THAT(message, testing::StartsWith(start));
    const std::string path =
        message.substr(start.size(), message.rfind(": is wrong") - start.size());
    EXPECT_EQ(path.starts_with(fmt::format("walls.{}.", chosen)), !unique) << path;
    // --set finds the same element by it.
    document.apply({{path, "77"}});
    EXPECT_EQ(motion.number("speed"), 77) << path;
  }
}

TEST(Case, WrongOverridesAreNamed) {
  EXPECT_EQ(error_of_set("shapes.cube.sise=1 m"),
            "--set shapes.cube.sise=1 m: shapes.cube.sise: unknown key; the nearest known one is "
            "\"size\"");
  EXPECT_EQ(error_of_set("shapes.cub.size=1 m"),
            "--set shapes.cub.size=1 m: shapes.cub.kind: missing; expected one of box, sphere, "
            "crescent, convex, mesh, compound");
  EXPECT_EQ(error_of_set("shape.cube.size=1 m"),
            "--set shape.cube.size=1 m: shape: unknown key; the nearest known one is \"shapes\"");
  EXPECT_EQ(error_of_set("case.duration=2"),
            "--set case.duration=2: case.duration: is the bare number 2; expected a time, such as "
            "\"1 ms\"");
  EXPECT_EQ(error_of_set("boundaries.2.material=ice"),
            "--set boundaries.2.material=ice: boundaries.2: no such element; expected one of 0 "
            "(\"floor\"), 1 (\"lid\")");
  EXPECT_EQ(
      error_of_set("boundaries.lid.size=1 m"),
      "--set boundaries.lid.size=1 m: boundaries.lid.size: cannot read \"1 m\"; expected three "
      "numbers and the unit of a length, such as \"0 0 0.2 m\"");
  EXPECT_EQ(error_of_set("case.duration.x=2"),
            "--set case.duration.x=2: case.duration: is a value; expected a table on the way to "
            "the key");
  EXPECT_EQ(error_of_set("case..x=2"),
            "--set case..x: not a path; expected keys joined by dots, such as "
            "interactions.ice-ice.restitution");
}

// Whatever a slip of the keyboard makes of a case: it is read, or refused with one line.
TEST(Case, MutatedTextsNeverCrash) {
  const std::string pieces = "\"'[]{}=.#\n\t 0123456789-+eEmkgsxyz_\\\x01\xc2\xb5\xff";
  const std::string base = kTwoCubes + R"(
[shapes.c]
kind = "crescent"
material = "ice"
variant = "custom"
[shapes.d]
kind = "convex"
material = "ice"
vertices = ["0 0 0 m", "1 0 0 m", "0 1 0 m", "0 0 1 m"]
[[fills]]
shape = "c"
count = 3
region_min = "0 0 0 m"
region_max = "1 1 1 m"
)";
  std::mt19937_64 random(1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int refused = 0;
  for (int round = 0; round < 600; ++round) {
    std::string text = base;
    for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
      const std::size_t at = below(text.size()), length = 1 + below(6);
      switch (below(3)) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, 1, pieces[below(pieces.size())]);
          break;
        default:
          text.insert(at, text.substr(below(text.size()), 4 * length));
      }
    }
    try {
      read(text);
    } catch (const InputError& error) {
      ++refused;
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with("c.toml:")) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
  EXPECT_GT(refused, 300);
}

class DrainedReposeCase : public testing::Test {
 protected:
  static std::string shipped() {
    std::ifstream in(FIRN_SOURCE_DIR "/cases/drained_repose/case.toml");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::string error_of_set(const std::string& text) {
    return error_of(shipped(), {parse_override(text)});
  }
};

TEST_F(DrainedReposeCase, BuildsTheBox) {
  const Case c = read(shipped());
  ASSERT_TRUE(c.drained_repose);
  const double length = 23.5 * 0.0254, depth = 5.5 * 0.0254, door = 5.75 * 0.0254;
  EXPECT_TRUE(c.drained_repose->box.isApprox(Vec3(length, depth, 12.4 * 0.0254)));
  EXPECT_DOUBLE_EQ(c.drained_repose->door_width, door);
  EXPECT_EQ(c.model.particles.size(), 880u);
  EXPECT_NEAR(c.model.shapes[0].mass, 13.7e-3, 1e-9);
  std::vector<std::string> names;
  for (const Boundary& b : c.model.boundaries) names.push_back(b.name);
  EXPECT_EQ(names, (std::vector<std::string>{"wall left", "wall right", "wall front", "wall back",
                                             "floor left", "floor right", "door"}));
  // Walls face inwards at the sides of the box.
  const Boundary& left = c.model.boundaries[0];
  EXPECT_TRUE(left.origin.isApprox(Vec3(-length / 2, 0, 0)));
  EXPECT_TRUE((left.orientation * Vec3::UnitZ()).isApprox(Vec3::UnitX()));
  // Floor and door are flush at z = 0 and meet at the lips.
  double floor_end = -1, door_start = 1;
  for (const std::size_t i : {4u, 6u}) {
    const Boundary& b = c.model.boundaries[i];
    double top = -1;
    for (const Vec3& v : b.mesh.vertices) {
      top = std::max(top, (b.origin + v).z());
      if (i == 4) floor_end = std::max(floor_end, (b.origin + v).x());
      if (i == 6) door_start = std::min(door_start, (b.origin + v).x());
    }
    EXPECT_NEAR(top, 0, 1e-15);
  }
  EXPECT_NEAR(floor_end, -door / 2, 1e-15);
  EXPECT_NEAR(door_start, -door / 2, 1e-15);
  ASSERT_EQ(c.stages.size(), 2u);
  EXPECT_EQ(c.stages[0].name, "fill");
  EXPECT_EQ(c.stages[1].name, "drain");
  EXPECT_EQ(c.stages[1].remove, std::vector<std::string>{"door"});
  ASSERT_EQ(c.outlets.size(), 1u);
  EXPECT_LT(c.outlets[0].point.z(), -c.drained_repose->floor_thickness);
  ASSERT_EQ(c.fills.size(), 1u);
  EXPECT_EQ(c.fills[0].velocity, Vec3(0, 0, -0.5));
  EXPECT_EQ(read(c.resolved).resolved, c.resolved);
}

TEST_F(DrainedReposeCase, DoorsThatMove) {
  const auto opened = [](const std::string& opening) {
    return read(shipped(),
                {{"experiment.door_opening", opening}, {"experiment.door_speed", "2 m/s"}});
  };
  const Case dropped = opened("drop");
  const Stage drop = dropped.stages.at(1), slide = opened("slide").stages.at(1);
  EXPECT_TRUE(drop.remove.empty());
  EXPECT_EQ(dropped.model.boundaries.at(drop.motions.at(0).boundary).name, "door");
  EXPECT_EQ(drop.motions.at(0).motion.velocity, Vec3(0, 0, -2));
  // A sliding door stops once it is out of the box: depth and overhangs of the floor at 2 m/s.
  EXPECT_EQ(slide.motions.at(0).motion.velocity, Vec3(0, 2, 0));
  EXPECT_NEAR(slide.motions.at(0).motion.stop, (5.5 * 0.0254 + 0.02) / 2, 1e-12);
  EXPECT_EQ(error_of_set("experiment.door_speed=1 m/s"),
            "--set experiment.door_speed=1 m/s: experiment.door_speed: has no meaning for a door "
            "that vanishes; expected door_opening = \"drop\" or \"slide\" with it");
}

TEST_F(DrainedReposeCase, ImpossibleSetupsNameTheirNumbers) {
  EXPECT_EQ(error_of_set("experiment.door_width=24 in"),
            "--set experiment.door_width=24 in: experiment.door_width: is 0.6096 m, not narrower "
            "than the box of 0.5969 m; expected a door with a ledge on both sides");
  EXPECT_EQ(error_of_set("experiment.fill.count=0"),
            "--set experiment.fill.count=0: experiment.fill.count: is the bare number 0; expected "
            "a whole number of at least 1");
  EXPECT_EQ(error_of_set("experiment.fill.count=1200"),
            "--set experiment.fill.count=1200: experiment.fill.count: is 1200: 17.93 L of \"cube\" "
            "do not fit a box of 26.26 L, of which a bed can fill 64 % at most; expected at most "
            "1124");
  const std::string text = shipped();
  const auto line = 1 + std::count(text.begin(), text.begin() + text.find("count = 880"), '\n');
  EXPECT_EQ(error_of_set("experiment.fill.pour_height=0.3 m"),
            fmt::format("c.toml:{}: experiment.fill.count: 880 of \"cube\" at once (60.96 x 20.57 "
                        "x 17.81 mm, 13.15 L in all) do not "
                        "fit a region of 0.5969 x 0.1397 x 0.3 m, of which random placement fills "
                        "30 % at most (7.505 L); expected fewer or a larger region",
                        line));
  EXPECT_EQ(error_of_set("experiment.end_margin=210 mm"),
            "--set experiment.end_margin=210 mm: experiment.end_margin: leaves nothing to fit a "
            "line to: the margins of 0.21 m and 0.025 m meet on the ledge of 0.2254 m; expected "
            "smaller margins");
  // A window narrower than two cubes has no angle: known before the run.
  EXPECT_EQ(error_of_set("experiment.end_margin=170 mm"),
            "--set experiment.end_margin=170 mm: experiment.end_margin: leaves 0.03042 m of the "
            "ledge of 0.2254 m to fit a line to, less than two particle sizes (0.04115 m, shape "
            "\"cube\"); expected smaller margins, a longer box or a narrower door");
  EXPECT_EQ(error_of_set("experiment.fill.shape=cub"),
            "--set experiment.fill.shape=cub: experiment.fill.shape: unknown shape \"cub\"; the "
            "nearest known one is \"cube\"");
  EXPECT_EQ(error_of_set("experiment.dor_width=1 in"),
            "--set experiment.dor_width=1 in: experiment.dor_width: unknown key; the nearest known "
            "one is \"door_width\"");
  EXPECT_EQ(error_of_set("experiment.kind=drained"),
            "--set experiment.kind=drained: experiment.kind: is \"drained\"; expected one of "
            "drained_repose");
}

TEST(CaseFile, ExampleOfTheManualIsACase) {
  std::ifstream in(FIRN_SOURCE_DIR "/docs/case-files.md");
  const std::string manual{std::istreambuf_iterator<char>(in), {}};
  const std::size_t first = manual.find("```toml\n") + 8;
  const Case c = read(manual.substr(first, manual.find("```", first) - first));
  EXPECT_EQ(c.model.particles.size(), 1u);
}

TEST(CaseFile, MissingFileIsNamed) {
  try {
    read_case("nowhere/none.toml");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "nowhere/none.toml: cannot be opened: No such file or directory; expected a case file");
  }
}

TEST(CaseFile, OldPathOfAShippedFileNamesTheNewOne) {
  const test::ScratchFolder folder("moved");
  std::filesystem::create_directories(folder.path() / "cases/slope");
  std::ofstream(folder / "cases/slope/case.toml") << "[case]\n";
  try {
    read_case(folder / "experiments/slope/case.toml");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), (folder / "experiments/slope/case.toml") + ": has moved to " +
                                (folder / "cases/slope/case.toml") + "; expected a case file");
  }
}

}  // namespace
}  // namespace firn
