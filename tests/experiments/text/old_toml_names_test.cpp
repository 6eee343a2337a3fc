// Renamed keys and words of TOML files: old names are read with a warning, and neither what a file
// means nor its identity depends on the names.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/measurements/bench_tests.h"
#include "experiments/measurements/measurement.h"
#include "experiments/text/toml_aliases.h"
#include "experiments/text/toml_document.h"
#include "tests/experiments/text/renamed_names.h"
#include "tests/support/error_of.h"
#include "tests/support/full_case.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using test::current_names;
using test::read_text;
using test::toml_text;
using testing::HasSubstr;

const fs::path kSource = FIRN_SOURCE_DIR;

// The text with the first name of each renamed key.
std::string old_text(const std::string& text, TomlFormat format) {
  toml::table table = toml::parse(text);
  use_first_names(format, table);
  return toml_text(table) + "\n";
}

constexpr const char* kRenamedCase = R"([case]
duration = "1 s"
timestep = "10 us"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "2 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[shapes.crescent]
kind = "crescent"
material = "ice"
variant = "table1-mass-override"
stiffness_length = "20 mm"
[shapes.own]
kind = "crescent"
material = "ice"
variant = "custom"
chord = "30 mm"
thickness = "20 mm"
depth = "18 mm"
tip_height = "5 mm"
top_concavity_depth = "1 mm"
draft = "10 deg"
facets = 100
[[particles]]
shape = "crescent"
tag = 1
position = "0 0 1 m"
rotation_jitter = "1 deg"
[[inlets]]
name = "mold"
shape = "crescent"
position = "0 1 1 m"
grid = [2, 1, 1]
spacing = "50 0 0 mm"
position_jitter = "1 1 1 mm"
rotation_jitter = "1 deg"
[[bonds]]
name = "bridge"
inlet = "mold"
height_direction = [0, 0, 1]
width = "4 mm"
height = "4 mm"
length = "1 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.3
tensile_strength = "0.7 MPa"
shear_strength = "0.7 MPa"
[[motion_frames]]
name = "carriage"
motions = [{ kind = "translation_table", direction = [1, 0, 0], times = ["0 s", "1 s"], positions = ["0 m", "1 mm"], stop = "0.1 s", period = "0.5 s" }]
[[motion_frames]]
name = "arm"
[motion_frames.free]
mass = "20 g"
center = "0 0 0 m"
inertia = "1e-5 1e-5 1e-5 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
limit_restitution = 0.2
motors = [{ speed = "1 m/s", target = "10 mm", max_load = "5 N", stop = "0.1 s", period = "0.5 s" }]
[[boundaries]]
name = "floor"
kind = "box"
material = "ice"
position = "0 0 -1 m"
size = "1 1 0.1 m"
allow_overlap_with = ["plate"]
[[boundaries.motions]]
kind = "translation"
velocity = "0 0 0 m/s"
stop = "0.1 s"
period = "0.5 s"
[[boundaries.motions]]
kind = "translation_table"
direction = [1, 0, 0]
file = "way.csv"
position_column = "way"
[[boundaries]]
name = "plate"
kind = "box"
material = "ice"
position = "0 0 -2 m"
size = "1 1 0.1 m"
motion_frame = "arm"
[[boundary_contacts]]
between = ["floor", "plate"]
stiffness = "1e5 N/m"
static_friction = 0.1
restitution = 0.5
[[stages]]
name = "all"
end_when = ["settled", "passed"]
sensor = "low"
count = 1
max_duration = "1 s"
[[stages.motions]]
boundary = "plate"
kind = "translation_table"
direction = [1, 0, 0]
file = "way.csv"
position_column = "way"
stop = "0.1 s"
period = "0.5 s"
[[stages.motors]]
motion_frame = "arm"
speed = "1 m/s"
target = "10 mm"
max_load = "5 N"
stop = "0.1 s"
period = "0.5 s"
[[sensors]]
name = "low"
point = "0 0 0 m"
normal = [0, 0, -1]
[[measure]]
kind = "sliding_onset"
boundary = "floor"
tag = 1
[output]
state_interval = "0.1 s"
)";

class OldTomlNames : public testing::Test {
 protected:
  OldTomlNames() : folder_(test::scratch_path("old-names")) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "way.csv") << "time [s],way [mm]\n0,0\n1,1\n";
  }
  ~OldTomlNames() override { fs::remove_all(folder_); }

  fs::path folder_;
};

// Notes which of the format's names occur.
class Names {
 public:
  explicit Names(TomlFormat format) : format_(format) {}
  void see(toml::table table) {
    use_first_names(format_, table);
    for (const OldNameUse& use : current_names(format_, table))
      seen_.insert(use.old_name + " " + use.name);
  }
  void expect_all_but(const std::set<std::string>& rare) const {
    for (const TomlAlias& k : renamed_keys()) expect(k.document, k.old_name, k.name, rare);
    for (const TomlAlias& w : renamed_words()) expect(w.document, w.old_name, w.name, rare);
  }

 private:
  void expect(TomlFormat format, std::string_view old_name, std::string_view name,
              const std::set<std::string>& rare) const {
    if (format != format_ || rare.contains(std::string(name))) return;
    EXPECT_TRUE(seen_.contains(fmt::format("{} {}", old_name, name)))
        << "no file that is read here has \"" << name << "\"";
  }
  TomlFormat format_;
  std::set<std::string> seen_;
};

// A key that is renamed in one table must be renamed in each that the same code reads: otherwise a
// current name stays here and changes the identity of cases.
void expect_first_names(const toml::table& table, const std::string& path) {
  static const std::set<std::string, std::less<>> current = [] {
    std::set<std::string, std::less<>> names;
    for (const TomlAlias& k : renamed_keys())
      if (k.document == TomlFormat::case_file) names.emplace(k.name);
    return names;
  }();
  for (const auto& [key, value] : table) {
    const std::string inside = path + "." + std::string(key.str());
    EXPECT_FALSE(current.contains(key.str())) << inside;
    if (const toml::table* t = value.as_table()) expect_first_names(*t, inside);
    if (const toml::array* list = value.as_array())
      for (const toml::node& element : *list)
        if (const toml::table* t = element.as_table()) expect_first_names(*t, inside);
  }
}

// The shipped cases, written with old names, are the same cases with the same identity. Each
// renamed key occurs, so that each is known to the reader under its current name.
TEST_F(OldTomlNames, CasesAreTheSame) {
  std::vector<std::pair<std::string, fs::path>> cases = {{kRenamedCase, folder_},
                                                         {test::kFullCase, folder_}};
  for (const auto& entry : fs::recursive_directory_iterator(kSource / "cases")) {
    const fs::path& file = entry.path();
    const fs::path name = file.filename();
    const bool of_machine = file.parent_path().filename() == "icemaker" &&
                            (name == "harvest_bridged.toml" || name == "auger_full.toml" ||
                             name == "bucket_pull.toml" || name == "glass_impact.toml");
    if (name == "case.toml" || of_machine) cases.emplace_back(read_text(file), file.parent_path());
  }
  ASSERT_GT(cases.size(), 14u);
  Names names(TomlFormat::case_file);
  for (const auto& [text, folder] : cases) {
    SCOPED_TRACE(folder.string());
    const Case c = read_case_text(text, "c.toml", folder.string());
    const Case old = read_case_text(old_text(text, TomlFormat::case_file), "c.toml",
                                    folder.string(), {}, {}, OldNames::accept);
    EXPECT_EQ(old.resolved, c.resolved);
    EXPECT_EQ(case_hash(old), case_hash(c));
    // From a resolved case with old names, as results files of earlier versions hold it.
    const std::string first = case_identity(c.resolved);
    EXPECT_EQ(case_identity(first), first);
    expect_first_names(toml::parse(first), "");
    const Case stored = read_case_text(first, "c.toml", ".", {}, {}, OldNames::accept);
    EXPECT_EQ(stored.resolved, c.resolved);
    EXPECT_EQ(case_hash(stored), case_hash(c));
    names.see(toml::parse(c.resolved));
  }
  names.expect_all_but({"initial_state", "relative_angular_velocity", "reference_set",
                        "applied_keys", "motor_load"});
}

TEST_F(OldTomlNames, OverridesMayUseThem) {
  const auto read = [&](const std::vector<Override>& overrides) {
    return read_case_text(kRenamedCase, "c.toml", folder_.string(), overrides, {},
                          OldNames::accept);
  };
  const std::vector<std::pair<Override, Override>> pairs = {
      {{"sources.mold.scatter", "2 2 2 mm"}, {"inlets.mold.position_jitter", "2 2 2 mm"}},
      {{"stages.all.until", "at_rest"}, {"stages.all.end_when", "settled"}},
      {{"interactions.ice-ice.unloading_floor", "0.01"},
       {"interactions.ice-ice.minimum_unloading_ratio", "0.01"}},
      {{"statistics", "{ merge = \"1 ms\" }"}, {"statistics", "{ merge_gap = \"1 ms\" }"}}};
  for (const auto& [old, current] : pairs) {
    std::vector<Override> of_old = {old}, of_current = {current};
    if (old.first == "stages.all.until") {  // keys of another event
      of_old.insert(
          of_old.end(),
          {{"stages.all", "{ name = \"all\", max_duration = \"1 s\", until = \"at_rest\" }"}});
      of_current.insert(
          of_current.end(),
          {{"stages.all", "{ name = \"all\", max_duration = \"1 s\", end_when = \"settled\" }"}});
    }
    EXPECT_EQ(read(of_old).resolved, read(of_current).resolved) << old.first;
  }
}

TEST_F(OldTomlNames, OtherFilesAreTheSame) {
  Names measurements(TomlFormat::measurement);
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kSource / "cases")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string text = read_text(entry.path());
    const toml::table table = toml::parse(text);
    const toml::array* values = table["values"].as_array();
    const bool is_form = values != nullptr && values->empty();  // nothing measured yet
    if (!table.contains("status") || is_form) continue;
    ++count;
    const Measurement now = read_measurement_text(text, entry.path().string());
    const Measurement old =
        read_measurement_text(old_text(text, TomlFormat::measurement), entry.path().string());
    EXPECT_EQ(old.sentence(), now.sentence());
    EXPECT_EQ(old.status, now.status);
    ASSERT_EQ(old.criteria.size(), now.criteria.size());
    for (std::size_t i = 0; i < now.criteria.size(); ++i) {
      EXPECT_EQ(old.criteria[i].lhs, now.criteria[i].lhs);
      EXPECT_EQ(old.criteria[i].factor, now.criteria[i].factor);
      EXPECT_EQ(old.criteria[i].observed_once_in, now.criteria[i].observed_once_in);
    }
    measurements.see(table);
  }
  EXPECT_GT(count, 10);
  measurements.expect_all_but({"digitized", "right_censored"});

  const fs::path bench = kSource / "cases/bench_tests.toml";
  toml::table table = toml::parse(read_text(bench));
  Names of_bench(TomlFormat::bench_tests);
  of_bench.see(table);
  of_bench.expect_all_but({});
  use_first_names(TomlFormat::bench_tests, table);
  toml::array& tests = *table["tests"].as_array();
  for (toml::node& test : tests) {  // paths are relative to the file
    toml::table& t = *test.as_table();
    t.insert_or_assign("case", (bench.parent_path() / *t["case"].value<std::string>()).string());
    for (toml::node& response : *t["responses"].as_array()) {
      toml::table& r = *response.as_table();
      r.insert_or_assign("measurement",
                         (bench.parent_path() / *r["measurement"].value<std::string>()).string());
    }
  }
  std::ofstream(folder_ / "bench.toml") << toml_text(table);
  const auto now = read_bench_tests(bench.string());
  const auto old = read_bench_tests((folder_ / "bench.toml").string());
  ASSERT_EQ(old.size(), now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_EQ(old[i].informs, now[i].informs);
    EXPECT_EQ(old[i].per_repeat, now[i].per_repeat);
    EXPECT_EQ(old[i].rationale, now[i].rationale);
    EXPECT_EQ(old[i].with, now[i].with);
    ASSERT_EQ(old[i].responses.size(), now[i].responses.size());
    EXPECT_EQ(old[i].responses[0].standard_uncertainty(2),
              now[i].responses[0].standard_uncertainty(2));
  }
}

// A study keeps its identity, of its keys and of the paths into cases that it gives.
TEST_F(OldTomlNames, StudiesKeepTheirIdentity) {
  const std::string old = R"([study]
name = "s"
[budget]
runs_per_point = 2
[[parameters]]
name = "p"
keys = ["sources.mold.scatter"]
[[numerics]]
set = { "case.steps_per_quarter_period" = 12, "numerics.skin" = "1 mm" }
)";
  const std::string now = R"([study]
name = "s"
[budget]
replicates_per_point = 2
[[parameters]]
name = "p"
keys = ["inlets.mold.position_jitter"]
[[numerics]]
set = { "case.steps_per_loading" = 12, "numerics.skin" = "1 mm" }
)";
  EXPECT_EQ(study_identity(old, "s.toml"), study_identity(now, "s.toml"));
  TomlDocument first(old, "s.toml");  // as earlier versions formed it
  EXPECT_EQ(study_identity(now, "s.toml"), first.text());
}

std::string warnings_of(const std::function<void()>& read) {
  testing::internal::CaptureStderr();
  read();
  return testing::internal::GetCapturedStderr();
}

TEST_F(OldTomlNames, OneLineNamesFileLineAndBothNames) {
  const std::string text = std::string(kRenamedCase) + "[numerics]\ncontact_shell = 0.07\n";
  const auto line = std::ranges::count(text, '\n');
  const std::string file = (folder_ / "warned.toml").string();
  const auto read = [&] { read_case_text(text, file, folder_.string()); };
  EXPECT_EQ(warnings_of(read),
            fmt::format("firn: warning: {}:{}: numerics.contact_shell: \"contact_shell\" is now "
                        "\"contact_margin\"; the old name is read by this version only\n",
                        file, line));
  EXPECT_EQ(warnings_of(read), "");  // a batch reads a file many times
  EXPECT_EQ(warnings_of([&] {
              read_case_text(text, file + "2", folder_.string(), {}, {}, OldNames::accept);
            }),
            "");
  EXPECT_THAT(warnings_of([&] {
                read_case_text(kRenamedCase, file, folder_.string(),
                               {{"sources.mold.scatter", "3 2 2 mm"}});
              }),
              HasSubstr("firn: warning: --set sources.mold.scatter=3 2 2 mm: "));
}

TEST_F(OldTomlNames, BothNamesAreRefused) {
  const std::string text =
      std::string(kRenamedCase) + "[numerics]\ncontact_shell = 0.07\ncontact_margin = 0.07\n";
  EXPECT_THAT(test::error_of([&] {
                read_case_text(text, "c.toml", folder_.string(), {}, {}, OldNames::accept);
              }),
              HasSubstr("numerics.contact_shell: is the old name of "
                        "\"contact_margin\", which is given as well"));
}

// Names of an included file are replaced before tables are joined.
TEST_F(OldTomlNames, IncludedFilesMayUseThem) {
  std::ofstream(folder_ / "base.toml")
      << old_text(kRenamedCase, TomlFormat::case_file) << "[numerics]\ncontact_shell = 0.07\n";
  const Case c = read_case_text(
      "include = \"base.toml\"\n[numerics]\ncontact_margin = 0.05\n[[inlets]]\nname = "
      "\"mold\"\nposition_jitter = \"3 3 3 mm\"\n",
      "c.toml", folder_.string());
  EXPECT_EQ(c.model.numerics.contact_margin, 0.05);
  ASSERT_EQ(c.inlets.size(), 1u);
  EXPECT_EQ(c.inlets[0].position_jitter, Vec3(3e-3, 3e-3, 3e-3));
}

}  // namespace
}  // namespace firn
