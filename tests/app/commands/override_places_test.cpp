// Files that set keys of a case: sweeps, optimizations, studies and validation suites. A key that
// the case lacks and a value that it refuses are reported at their lines of the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

// A file with KEY for the key of the case.
struct FileWithKey {
  const char* command;
  const char* place;  // that sets the key
  std::string text;
  const char* header = nullptr;        // path of the table `set`, if no key of its table follows
  const char* values_place = nullptr;  // of a list with the values; null: that of the key
};

const std::string suite_variant = R"([[experiments.variants]]
name = "heavier"
set = { "materials.ice.density" = "1833.4 kg/m^3" }
)";
const std::string suite_comparison = R"([[comparisons]]
name = "choices"
kind = "numerical_variants"
experiment = "e"
responses = ["present_mass"]
)";

const std::string study_budget = R"([budget]
center_replicates = 3
design_points = 8
replicates_per_point = 2
[[targets]]
response = "peak_normal_force"
value = "6 N"
uncertainty = "0.3 N"
)";
const std::string study_parameter = R"([[parameters]]
name = "b"
keys = ["interactions.ice-ice.restitution"]
min = 0.1
max = 0.2
)";
const std::string whole_study = "[study]\nname = \"c\"\ncase = \"case.toml\"\n" + study_budget;

const FileWithKey files_with_keys[] = {
    {"sweep", "vary.a.keys", R"([sweep]
name = "s"
case = "case.toml"
[[vary]]
name = "b"
keys = ["materials.ice.density"]
values = ["900 kg/m^3", "1800 kg/m^3"]
[[vary]]
name = "a"
keys = ["interactions.ice-ice.restitution", "KEY"]
values = [0.1, 0.2]
)",
     nullptr, "vary.a.values"},
    {"sweep", "sweep.set", R"([sweep]
name = "s"
case = "case.toml"
set = { "KEY" = 0.1 }
[[vary]]
name = "a"
keys = ["interactions.ice-ice.restitution"]
values = [0.1, 0.2]
)",
     "sweep.set"},
    {"optimize", "parameters.a.keys", R"([optimization]
name = "o"
case = "case.toml"
maximize = "present_mass"
runs = 34
replicates_per_design = 2
confirmation_replicates = 4
[[parameters]]
name = "a"
keys = ["KEY"]
min = 0.1
max = 0.2
)"},
    {"optimize", "optimization.set", R"([optimization]
name = "o"
case = "case.toml"
maximize = "present_mass"
runs = 34
replicates_per_design = 2
confirmation_replicates = 4
set = { "KEY" = 0.1 }
[[parameters]]
name = "a"
keys = ["interactions.ice-ice.restitution"]
min = 0.1
max = 0.2
)",
     "optimization.set"},
    {"calibrate", "parameters.a.keys", whole_study + R"([[parameters]]
name = "a"
keys = [
  "interactions.ice-ice.static_friction",
  "KEY",
]
min = 0.1
max = 0.2
)"},
    {"calibrate", "parameters.a.keys", whole_study + study_parameter + R"([[parameters]]
name = "a"
keys = ["KEY"]
choices = [0.1, 0.2]
)",
     nullptr, "parameters.a.choices"},
    {"calibrate", "experiments.e.set",
     "[study]\nname = \"c\"\n" + study_budget + study_parameter + R"([[experiments]]
name = "e"
case = "case.toml"
set = { "KEY" = 0.1 }
)",
     "experiments.set"},
    {"calibrate", "numerics.n.set", whole_study + study_parameter + R"([[numerics]]
name = "n"
set = { "KEY" = 0.1 }
)",
     "numerics.set"},
    {"calibrate", "low_fidelity.set", whole_study + study_parameter + R"([low_fidelity]
set = { "KEY" = 0.1 }
)",
     "low_fidelity.set"},
    {"validate", "parameter_sets.p.set", R"([suite]
name = "v"
[[parameter_sets]]
name = "p"
set = { "KEY" = 0.1 }
[[experiments]]
name = "e"
case = "case.toml"
)" + suite_variant + suite_comparison,
     "parameter_sets.set"},
    {"validate", "experiments.e.set", R"([suite]
name = "v"
[[experiments]]
name = "e"
case = "case.toml"
set = { "KEY" = 0.1 }
)" + suite_variant + suite_comparison,
     "experiments.set"},
    {"validate", "experiments.e.variants.v.set", R"([suite]
name = "v"
[[experiments]]
name = "e"
case = "case.toml"
[[experiments.variants]]
name = "v"
set = { "KEY" = 0.1 }
)" + suite_comparison,
     "experiments.variants.set"}};

// Comment lines and empty lines between the lines of a text.
std::string with_more_lines(const std::string& text, std::mt19937_64& random) {
  std::string longer;
  for (std::size_t at = 0; at < text.size();) {
    for (std::size_t more = random() % 4; more > 0; --more)
      longer += random() % 2 == 0 ? "\n" : "# a comment\n";
    const std::size_t end = text.find('\n', at) + 1;
    longer += text.substr(at, end - at);
    at = end;
  }
  return longer;
}

// The line of the first `part` of a text.
std::size_t line_of_part(const std::string& text, const std::string& part) {
  const std::size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(at, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

// Runs the command with a file of this text between further lines. Expects status 2 and one line,
// which names `place` at the line of the first `part` and then ends as `problem`.
void expect_refusal_at(const Folder& folder, const char* command, const std::string& content,
                       const std::string& part, const std::string& place,
                       const std::string& problem, std::mt19937_64& random) {
  const std::string text = with_more_lines(content, random);
  const std::string file = "file" + std::to_string(random()) + ".toml";
  folder.write(file, text);
  const Outcome o =
      folder.firn({command, file, "--no-cache", "--progress", "none", "-o", file + ".out"});
  EXPECT_EQ(o.status, 2) << content;
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr(file + ":" + std::to_string(line_of_part(text, part)) + ": " +
                               place + ": the case case.toml " + problem))
      << content;
  EXPECT_THAT(o.err, Not(HasSubstr("--set")));
}

// The same for the file with this key, at the place of the key.
void expect_refusal(const Folder& folder, const FileWithKey& kind, const std::string& key,
                    const std::string& problem, std::mt19937_64& random) {
  expect_refusal_at(folder, kind.command, test::replaced(kind.text, "KEY", key), '"' + key + '"',
                    kind.place, problem, random);
}

TEST(OverridePlaces, AKeyThatTheCaseLacksIsReportedAtItsLine) {
  // The materials of a pair in either order.
  const std::vector<std::string> known = {"materials.ice.density",
                                          "materials.plastic.young_modulus",
                                          "interactions.ice-ice.static_friction",
                                          "interactions.plastic-ice.restitution", "case.duration"};
  std::mt19937_64 random(6);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  for (const FileWithKey& kind : files_with_keys)
    for (int k = 0; k < 3; ++k) {
      const std::string& key = known[random() % known.size()];
      const std::size_t name = key.rfind('.') + 1;
      std::string wrong = key;
      wrong.erase(name + random() % (key.size() - name), 1);
      expect_refusal(folder, kind, wrong,
                     "has no key \"" + wrong + "\"; did you mean \"" + key.substr(name) + "\"?",
                     random);
    }
}

TEST(OverridePlaces, AValueThatTheCaseRefusesIsReportedAtItsLine) {
  std::mt19937_64 random(7);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  for (const FileWithKey& kind : files_with_keys) {
    // Not a path: the key is wrong.
    expect_refusal(folder, kind, "case..duration", "does not take \"case..duration\" = ", random);
    const bool in_list = kind.values_place != nullptr;
    expect_refusal_at(folder, kind.command, test::replaced(kind.text, "KEY", "case.gravity"),
                      in_list ? "[0.1" : "\"case.gravity\"",
                      in_list ? kind.values_place : kind.place,
                      "does not take \"case.gravity\" = ", random);
  }
}

// Forms of the table `set`. HEADER: its path; PATH, VALUE: of one of its entries.
const std::string set_forms[] = {"set = { \"case.duration\" = \"20 ms\", \"PATH\" = VALUE }\n",
                                 "[HEADER]\n\"case.duration\" = \"20 ms\"\n\"PATH\" = VALUE\n",
                                 "[HEADER]\ncase.duration = \"20 ms\"\nPATH = VALUE\n",
                                 "set.\"case.duration\" = \"20 ms\"\nset.\"PATH\" = VALUE\n",
                                 "set.case.duration = \"20 ms\"\nset.PATH = VALUE\n"};

TEST(OverridePlaces, AnEntryOfSetIsReportedAtItsLineInEveryForm) {
  std::mt19937_64 random(8);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const struct {
    std::string path, value, problem;
  } entries[] = {{"materials.ice.densty", "\"900 kg/m^3\"",
                  "has no key \"materials.ice.densty\"; did you mean \"density\"?"},
                 {"interactions.ice-plastic.restitution", "7",
                  "does not take \"interactions.ice-plastic.restitution\" = 7: "}};
  for (const FileWithKey& kind : files_with_keys) {
    if (kind.header == nullptr) continue;
    for (const std::string& form : set_forms)
      for (const auto& [path, value, problem] : entries) {
        const bool with_header = form.starts_with("[");
        std::string set = with_header ? test::replaced(form, "HEADER", kind.header) : form;
        set = test::replaced(test::replaced(set, "PATH", path), "VALUE", value);
        expect_refusal_at(folder, kind.command,
                          test::replaced(kind.text, "set = { \"KEY\" = 0.1 }\n", set), path,
                          kind.place, problem, random);
      }
  }
}

TEST(OverridePlaces, AnEntryOfAListIsReportedAtItsLine) {
  std::mt19937_64 random(9);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const std::string swept = R"([sweep]
name = "s"
case = "case.toml"
[[vary]]
name = "a"
keys = [
  "interactions.ice-ice.restitution",
  "interactions.ice-plastic.restitution",
]
values = [
  0.1,
  0.2,
  0.3,
]
)";
  expect_refusal_at(folder, "sweep", test::replaced(swept, "plastic.rest", "plastic.ret"),
                    "interactions.ice-plastic", "vary.a.keys",
                    "has no key \"interactions.ice-plastic.retitution\"; ", random);
  expect_refusal_at(folder, "sweep", test::replaced(swept, "0.3", "7"), "7,", "vary.a.values",
                    "does not take \"interactions.ice-ice.restitution\" = 7: ", random);
  const std::string refined = R"([suite]
name = "v"
[[experiments]]
name = "e"
case = "case.toml"
[experiments.refine]
material = "ice"
stiffness = [
  "2 MPa",
  "1e-4 Pa",
]
)" + suite_comparison;
  expect_refusal_at(folder, "validate", refined, "1e-4 Pa", "experiments.e.refine.stiffness",
                    "does not take \"materials.ice.young_modulus\" = \"0.0001 Pa\": ", random);
}

// A list or a table is the value.
TEST(OverridePlaces, APartOfAValueIsReportedAtItsLine) {
  std::mt19937_64 random(10);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const std::string head = "[sweep]\nname = \"s\"\ncase = \"case.toml\"\n";
  expect_refusal_at(folder, "sweep", head + R"([[vary]]
name = "ice"
keys = ["materials.ice"]
values = [
  { density = "900 kg/m^3", young_modulus = "1 MPa" },
  { density = "900 kg/m^3", young_modulus = "1 MPa", nu = 0.3 },
]
)",
                    "nu = 0.3", "vary.ice.values", "does not take \"materials.ice\" = ", random);
  expect_refusal_at(folder, "sweep", head + R"([sweep.set]
"case.duration" = "20 ms"
particles = [
  { shape = "cube", position = "0 0 12 mm" },
  { shape = "cube", positoin = "0 0 40 mm" },
]
)",
                    "positoin", "sweep.set", "does not take \"particles\" = ", random);
  expect_refusal_at(folder, "sweep", head + R"([sweep.set]
"boundaries.floor.normal" = [
  0,
  "one",
  1,
]
)",
                    "\"one\"", "sweep.set", "does not take \"boundaries.floor.normal\" = ", random);
  // A table with a header continues the path.
  expect_refusal_at(folder, "sweep", head + R"([sweep.set."materials.ice"]
density = "900 kg/m^3"
nu = 0.3
)",
                    "nu = 0.3", "sweep.set",
                    "has no key \"materials.ice.nu\"; did you mean \"poisson_ratio\"?", random);
}

// The case has the key; the table that becomes its value has an unknown one.
TEST(OverridePlaces, AnUnknownKeyInAValueIsNamed) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  folder.write("s.toml", R"([sweep]
name = "s"
case = "case.toml"
set = { "materials.ice" = { density = "900 kg/m^3", young_modulus = "1 MPa", nu = 0.3 } }
)");
  const Outcome o = folder.firn({"sweep", "s.toml", "--no-cache", "--progress", "none"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr("s.toml:4: sweep.set: the case case.toml does not take "
                               "\"materials.ice\" = "));
  EXPECT_THAT(o.err, HasSubstr(": materials.ice.nu: unknown key; did you mean \"poisson_ratio\"?"));
}

}  // namespace
}  // namespace firn::cli
