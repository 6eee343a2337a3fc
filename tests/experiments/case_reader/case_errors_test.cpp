// Mistakes in a case: the message names file, line, key and what is expected.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "tests/experiments/case_reader/two_cubes_case.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

using two_cubes::error_of;
using two_cubes::error_of_set;
using two_cubes::kTwoCubes;
using two_cubes::read;
using two_cubes::with;

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
      {"seed = 7", "sede = 7", "c.toml:4: case.sede: unknown key; did you mean \"seed\"?"},
      {"seed = 7", "seed = 7.5",
       "c.toml:4: case.seed: is the bare number 7.5; expected a whole number of at least 0"},
      {"seed = 7", "duration = \"2 s\"",
       "c.toml:4: TOML: Error while parsing key-value pair: cannot redefine existing string "
       "'duration'; expected valid TOML"},
      {"[output]", "[ouptut]", "c.toml:82: ouptut: unknown key; did you mean \"output\"?"},
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

TEST(Case, MeasurementsAreNamed) {
  EXPECT_EQ(error_of("name = \"n\"\nresponse = \"r\"\nstatus = \"measured\"\nvalue = \"1 N\"\n"),
            "c.toml:3: status: is a key of a measurement file; expected a case file (firn run)");
}

TEST(Case, UnknownReferencesAreNamed) {
  const std::vector<BadInput> bad = {
      {"material = \"ice\"", "material = \"iec\"",
       "c.toml:26: shapes.cube.material: unknown material \"iec\"; did you mean \"ice\"?"},
      {"shape = \"cube\"", "shape = \"cubes\"",
       "c.toml:31: particles.0.shape: unknown shape \"cubes\"; did you mean \"cube\"?"},
      {"remove_boundaries = [\"lid\"]", "remove_boundaries = [\"lit\"]",
       "c.toml:75: stages.open.remove_boundaries: unknown boundary \"lit\"; did you mean \"lid\"?"},
      {"boundary = \"floor\"", "boundary = \"flor\"",
       "c.toml:78: stages.open.motions.0.boundary: unknown boundary \"flor\"; did you mean "
       "\"floor\"?"},
      {"[interactions.plastic-ice]", "[interactions.plastik-ice]",
       "c.toml:19: interactions.plastik-ice: joins no two known materials; did you mean "
       "\"plastic-ice\"?"},
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
      {"density = \"916.7 kg/m^3\"", "", ""},  // the cube's mass is given
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
    const std::string message = test::error_of([&] { motion.fail("speed", "is wrong"); });
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
            "--set shapes.cube.sise=1 m: shapes.cube.sise: unknown key; did you mean \"size\"?");
  EXPECT_EQ(error_of_set("shapes.cub.size=1 m"),
            "--set shapes.cub.size=1 m: shapes.cub.kind: missing; expected one of box, sphere, "
            "crescent, convex, mesh, compound");
  EXPECT_EQ(error_of_set("shape.cube.size=1 m"),
            "--set shape.cube.size=1 m: shape: unknown key; did you mean \"shapes\"?");
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
            "--set case..x=2: not a path; expected keys joined by dots, such as "
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

}  // namespace
}  // namespace firn
