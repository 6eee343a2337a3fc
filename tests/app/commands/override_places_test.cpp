// Files that set keys of a case: sweeps, optimizations, studies and validation suites. A key that
// the case lacks is reported at its line of the file.
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

const FileWithKey files_with_keys[] = {{"sweep", "vary.a.keys", R"([sweep]
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
)"},
                                       {"sweep", "sweep.set", R"([sweep]
name = "s"
case = "case.toml"
set = { "KEY" = 0.1 }
[[vary]]
name = "a"
keys = ["interactions.ice-ice.restitution"]
values = [0.1, 0.2]
)"},
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
set = { "KEY" = 0.1 }
maximize = "present_mass"
runs = 34
replicates_per_design = 2
confirmation_replicates = 4
[[parameters]]
name = "a"
keys = ["interactions.ice-ice.restitution"]
min = 0.1
max = 0.2
)"},
                                       {"calibrate", "parameters.a.keys", R"([study]
name = "c"
case = "case.toml"
[budget]
center_replicates = 3
design_points = 8
replicates_per_point = 2
[[parameters]]
name = "a"
keys = ["KEY"]
min = 0.1
max = 0.2
[[targets]]
response = "peak_normal_force"
value = "6 N"
uncertainty = "0.3 N"
)"},
                                       {"validate", "parameter_sets.p.set", R"([suite]
name = "v"
[[parameter_sets]]
name = "p"
set = { "KEY" = 0.1 }
[[experiments]]
name = "e"
case = "case.toml"
)" + suite_variant + suite_comparison},
                                       {"validate", "experiments.e.set", R"([suite]
name = "v"
[[experiments]]
name = "e"
case = "case.toml"
set = { "KEY" = 0.1 }
)" + suite_variant + suite_comparison},
                                       {"validate", "experiments.e.variants.v.set", R"([suite]
name = "v"
[[experiments]]
name = "e"
case = "case.toml"
[[experiments.variants]]
name = "v"
set = { "KEY" = 0.1 }
)" + suite_comparison}};

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

std::size_t line_of_key(const std::string& text, const std::string& key) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(text.find('"' + key + '"'));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

// Writes the file with this key between further lines, and runs its command. Expects status 2 and
// one line, which names the place of the key and then ends as `problem`.
void expect_refusal(const Folder& folder, const FileWithKey& kind, const std::string& key,
                    const std::string& problem, std::mt19937_64& random) {
  const std::string text = test::replaced(with_more_lines(kind.text, random), "KEY", key);
  const std::string file = "file" + std::to_string(random()) + ".toml";
  folder.write(file, text);
  const Outcome o =
      folder.firn({kind.command, file, "--no-cache", "--progress", "none", "-o", file + ".out"});
  EXPECT_EQ(o.status, 2) << kind.command;
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr(file + ":" + std::to_string(line_of_key(text, key)) + ": " +
                               kind.place + ": the case case.toml " + problem));
  EXPECT_THAT(o.err, Not(HasSubstr("--set")));
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

// The second key is not a path.
TEST(OverridePlaces, AValueThatTheCaseRefusesIsReportedAtItsLine) {
  std::mt19937_64 random(7);
  const Folder folder;
  folder.write("case.toml", two_boxes);
  for (const FileWithKey& kind : files_with_keys)
    for (const std::string key : {"case.gravity", "case..duration"})
      expect_refusal(folder, kind, key, "does not take \"" + key + "\" = ", random);
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
