// firn validate, end to end, and what its suite files may not say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiments/material_records/material_database.h"
#include "tests/app/program.h"
#include "tests/support/replaced.h"
#include "tests/support/sample_records.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Two boxes come to lie on a plane: their peak force is a number, that they are there a claim.
constexpr const char* suite = R"([suite]
name = "boxes"
seeds = 6
[[parameter_sets]]
name = "as it is"
[[parameter_sets]]
name = "printed"
material = "paper-text"
[[experiments]]
name = "fall"
case = "case.toml"
[experiments.refine]
timestep = 0.5
material = "ice"
stiffness = ["2 MPa", "4 MPa"]
seeds = 1
[[experiments.variants]]
name = "heavier"
set = { "materials.ice.density" = "1833.4 kg/m^3" }
seeds = 2
[[comparisons]]
name = "mass"
kind = "value"
experiment = "fall"
measurement = "mass.toml"
[[comparisons]]
name = "claims"
kind = "criteria"
experiment = "fall"
measurement = "claims.toml"
[[comparisons]]
name = "stiffness"
kind = "stiffness_scaling"
experiment = "fall"
responses = ["peak_normal_force"]
real_modulus = "9.2 GPa"
[[comparisons]]
name = "choices"
kind = "numerical_variants"
experiment = "fall"
responses = ["present_mass"]
)";

constexpr const char* mass = R"(name = "mass of two boxes"
response = "present_mass"
values = ["0.0146 kg", "0.0147 kg", "0.0148 kg"]
status = "measured"
source = "a balance"
)";

constexpr const char* claims = R"(name = "what was seen"
status = "qualitative"
statement = "both stay"
source = "a notebook"
[[criteria]]
statement = "both stay"
lhs = "present_count"
rhs = "1.5"
rationale = "they are two"
[[criteria]]
statement = "a third comes"
lhs = "present_count"
rhs = "2.5"
rationale = "it would be three"
)";

struct Suite : Folder {
  Suite() {
    write("case.toml", two_boxes);
    write("mass.toml", mass);
    write("claims.toml", claims);
    write("suite.toml", suite);
  }
  // What `firn validate` says of the suite when `part` of it reads `other`.
  Outcome with(const std::string& part, const std::string& other) const {
    write("changed.toml", test::replaced(suite, part, other));
    return firn({"validate", "changed.toml", "-o", "changed", "--progress", "none"});
  }
};

TEST(ValidateCommand, JudgesAndGoesOnWithoutSimulatingAgain) {
  const Suite folder;
  const Outcome o = folder.firn({"validate", "suite.toml", "-o", "out", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["comparisons"].size(), 6u);  // two for both sets, two for the first alone
  const json& value = result["comparisons"][0];
  // The variant doubles the mass, and what it changes is taken for uncertainty: as much as is
  // measured could hide in that.
  EXPECT_EQ(value["verdict"], "inconclusive");
  EXPECT_EQ(value["value"]["components"][5]["name"], "heavier");
  EXPECT_NEAR(value["value"]["components"][5]["value"], 2 * 916.7 * 8e-6, 1e-5);
  EXPECT_NEAR(value["value"]["simulated"], 2 * 916.7 * 8e-6, 1e-5);
  EXPECT_EQ(value["value"]["runs"], 6);
  EXPECT_NEAR(value["value"]["measured"], 0.0147, 1e-12);
  EXPECT_EQ(value["value"]["components"][1]["name"], "time step");
  EXPECT_NEAR(value["value"]["components"][1]["value"], 0, 1e-12);
  EXPECT_TRUE(value["value"]["area_metric"].is_array());
  const json& printed = result["comparisons"][1];
  EXPECT_EQ(printed["parameter_set"], "printed");
  EXPECT_EQ(printed["value"]["components"][2]["value"], value["value"]["components"][2]["value"]);
  const json& seen = result["comparisons"][2];
  EXPECT_EQ(seen["verdict"], "inconsistent");
  EXPECT_EQ(seen["criteria"][0]["verdict"], "consistent");
  EXPECT_EQ(seen["criteria"][1]["holds_in"], 0);
  const json& soft = result["comparisons"][4]["stiffness_scaling"][0];
  EXPECT_EQ(soft["modulus"], json({1e6, 2e6, 4e6}));
  EXPECT_GT(soft["exponent"], 0.2);
  EXPECT_LT(soft["exponent"], 0.8);
  const json& choices = result["comparisons"][5]["numerical_variants"];
  ASSERT_EQ(choices.size(), 4u);  // time step, two stiffnesses, the variant
  EXPECT_EQ(choices[3]["variant"], "heavier");
  EXPECT_EQ(choices[3]["seeds"], 2);
  EXPECT_NEAR(choices[3]["after"], 2 * choices[3]["before"].get<double>(), 1e-12);
  EXPECT_EQ(result["experiments"][0]["runs"].size(), 17u);
  EXPECT_EQ(result, json::parse(read_text(folder.path() / "out/results.json")));

  const Outcome again =
      folder.firn({"validate", "suite.toml", "-o", "out", "--json", "--progress", "json"});
  EXPECT_EQ(again.out, o.out);
  EXPECT_THAT(again.err, testing::Not(HasSubstr("\"started\"")));
  // A neighbor shares what was simulated.
  const Outcome neighbor =
      folder.firn({"validate", "suite.toml", "-o", "other", "--progress", "json"});
  EXPECT_EQ(neighbor.status, 0);
  EXPECT_THAT(neighbor.err, testing::Not(HasSubstr("\"started\"")));
  EXPECT_THAT(neighbor.out, HasSubstr("a third comes"));

  EXPECT_EQ(
      folder.firn({"validate", "suite.toml", "-o", "out", "--require", "none-inconsistent"}).status,
      3);
}

TEST(ValidateCommand, TakesARecordInPlaceOfTheSets) {
  const Suite folder;
  const Outcome o =
      folder.firn({"validate", "suite.toml", "-o", "out", "--json", "--material", "paper-table-1"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["parameter_sets"].size(), 1u);
  EXPECT_EQ(result["parameter_sets"][0]["material"], "paper-table-1@1");
}

TEST(ValidateCommand, RunsAnExperimentWithSomeSetsOnly) {
  const Suite folder;
  std::string text = suite;
  const std::string at = "case = \"case.toml\"\n";
  folder.write("some.toml",
               text.replace(text.find(at), at.size(), at + "parameter_sets = [\"printed\"]\n"));
  const Outcome o = folder.firn({"validate", "some.toml", "-o", "some", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["comparisons"].size(), 4u);
  for (const json& c : result["comparisons"]) EXPECT_EQ(c["parameter_set"], "printed");
  // Numerics are looked at with the set that there is.
  EXPECT_TRUE(result["comparisons"][0]["value"]["components"][1]["value"].is_number());
  EXPECT_EQ(result["experiments"][0]["runs"].size(), 11u);
}

// The values of a record that was calibrated to the very measurement, without the record.
TEST(ValidateCommand, KnowsTheValuesOfARecordThatTheCaseHas) {
  const Suite folder;
  MaterialRecord record = test::calibrated_record("fitted");
  record.materials = {"ice", "plastic"};
  record.parameters = {
      {"ice_ice", {"interactions.ice-ice.static_friction"}, 0.17, "1", 0.02, {}, ""},
      {"ice_plastic", {"interactions.ice-plastic.static_friction"}, 0.33, "1", {}, {}, ""}};
  record.ensemble.reset();
  record.provenance.cases.front().parameters = {"ice_ice", "ice_plastic"};
  record.provenance.measurements = {{"m", "present_mass", 0.0147, 1e-4, "kg", "elsewhere"}};
  MaterialDatabase((folder.path() / "m.db").string(), MaterialDatabase::Access::write)
      .add({record});
  const auto verdict = [&](const std::string& set) {
    std::string text = suite;
    const std::string at = "name = \"as it is\"\n";
    folder.write("set.toml", text.replace(text.find(at), at.size(), at + set));
    const Outcome o = folder.firn({"validate", "set.toml", "-o", "set", "--json", "--database",
                                   "m.db", "--progress", "none"});
    EXPECT_EQ(o.status, 0) << o.err;
    return json::parse(o.out)["comparisons"][0]["verdict"].get<std::string>();
  };
  EXPECT_EQ(verdict(""), "inconclusive");
  EXPECT_EQ(verdict("set = { \"interactions.ice-ice.static_friction\" = 0.17, "
                    "\"interactions.ice-plastic.static_friction\" = 0.329 }\n"),
            "not independent");
  EXPECT_EQ(verdict("material = \"fitted\"\n"), "not independent");
}

TEST(ValidateCommand, RefusesInOneLine) {
  const Suite folder;
  const auto refused = [&](const char* part, const char* other, const char* says) {
    const Outcome o = folder.with(part, other);
    EXPECT_EQ(o.status, 2) << other;
    EXPECT_THAT(o.err, HasSubstr(says));
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  };
  refused("seeds = 6", "seeds = 0", "changed.toml:3: suite.seeds");
  refused("seeds = 6", "seds = 6", "seeds");
  refused("case = \"case.toml\"", "case = \"none.toml\"", "does not exist");
  refused("experiment = \"fall\"", "experiment = \"fly\"", "is not an experiment of this suite");
  refused("kind = \"criteria\"", "kind = \"value\"", "is qualitative");
  refused("measurement = \"mass.toml\"", "measurement = \"claims.toml\"", "is qualitative");
  refused("kind = \"value\"", "kind = \"values\"", "value");
  refused("timestep = 0.5", "timestep = 2", "expected factors between 0 and 1");
  refused("timestep = 0.5", "timestep = [0.5, 0.3]", "expected powers of 0.5");
  refused("timestep = 0.5", "timestep = [0.5, \"x\"]", "expected factors between 0 and 1");
  refused("timestep = 0.5", "timestep = [0.5,\n0.6]",
          "changed.toml:14: experiments.fall.refine.timestep: has the factor 0.6 after 0.5");
  refused("[[comparisons]]",
          "[[chosen]]\nwhat = \"a\"\nmeasurement = \"none.toml\"\n[[comparisons]]", "none.toml");
  refused("[[comparisons]]",
          "[[chosen]]\nwhat = \"a\"\nmeasurement = \"mass.toml\"\nexperiments = [\"b\"]\n"
          "[[comparisons]]",
          "\"b\" is not an experiment of this suite");
  refused("seeds = 2\n", "seeds = 2\nassumed = true\nnumerics = true\n", "does not go with");
  refused("responses = [\"present_mass\"]", "responses = [\"a\"]\nnot_comparable = \"b\"",
          "does not go with");
  refused(
      "material = \"ice\"", "material = \"snow\"",
      "changed.toml:14: experiments.fall.refine.material: \"snow\" is not a material of the case");
  refused("material = \"paper-text\"", "material = \"paper-txt\"",
          "changed.toml:8: parameter_sets.printed.material: material paper-txt: unknown");
  refused("material = \"paper-text\"", "material = \"paper-text#2\"",
          "changed.toml:8: parameter_sets.printed.material: material paper-text#2: names a sample");
  refused("material = \"paper-text\"", "material = \"ice-aluminium-friction\"",
          "changed.toml:8: parameter_sets.printed.material: material ice-aluminium-friction@1: ");
  refused("material = \"paper-text\"", "material = \"paper-text\"\nsamples = 3",
          "changed.toml:9: parameter_sets.printed.samples: paper-text@1 has no posterior ensemble");
  refused("case = \"case.toml\"", "case = \"case.toml\"\nsamples = 3",
          "changed.toml:12: experiments.fall.samples: paper-text@1 has no posterior ensemble");
  refused("case = \"case.toml\"", "case = \".\"", "changed.toml:11: experiments.fall.case: ");
  refused("\"mass.toml\"", "\"none.toml\"",
          "changed.toml:25: comparisons.mass.measurement: none.toml does not exist");
  refused("responses = [\"peak_normal_force\"]", "responses = [\"a b c\"]", "is not an operand");
  refused("responses = [\"peak_normal_force\"]", "", "is missing");
  refused("name = \"claims\"", "name = \"mass\"", "is taken already");
  refused("stiffness = [\"2 MPa\", \"4 MPa\"]", "stiffness = [\"2 m\"]", "stiffness");
  refused("seeds = 1", "seeds = 1\nparameter_sets = [\"x\"]", "parameter_sets");
  refused("case = \"case.toml\"",
          "case = \"case.toml\"\nparameter_sets = [\"printed\",\n\"print\"]",
          "changed.toml:13: experiments.fall.parameter_sets: \"print\" is none of the suite's");
  refused("name = \"heavier\"\nset = {", "name = \"heavier\"\nset_ = {", "set_");
  refused("{ \"materials.ice.density\" = \"1833.4 kg/m^3\" }", "{}", "expected what differs");
  refused("{ \"materials.ice.density\"", "{ \"materials.ice.densty\"", "densty");
  refused("responses = [\"present_mass\"]", "tolerance = \"1 kg\"", "does not go with");
  EXPECT_EQ(folder.firn({"validate", "none.toml"}).status, 2);
}

// Known after the runs alone.
TEST(ValidateCommand, AResponseThatTheCaseLacksIsReportedAtItsLine) {
  const Suite folder;
  const std::string of_one_seed = test::replaced(suite, "seeds = 6", "seeds = 1");
  const auto refused = [&](const std::string& file, const std::string& text,
                           const std::string& part, const std::string& other,
                           const std::string& says) {
    folder.write("suite.toml", of_one_seed);
    folder.write("mass.toml", mass);
    folder.write("claims.toml", claims);
    folder.write(file, test::replaced(text, part, other));
    std::filesystem::remove_all(folder.path() / "out");
    const Outcome o = folder.firn({"validate", "suite.toml", "-o", "out", "--progress", "none"});
    EXPECT_EQ(o.status, 2) << says;
    EXPECT_THAT(o.err, HasSubstr("firn: " + file + ":" + says));
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  };
  const std::string is_none = ": \"absent\" is not a response of the case; expected one of ";
  refused("suite.toml", of_one_seed, "[\"present_mass\"]", "[\"present_mass\",\n\"absent\"]",
          "42: comparisons.choices.responses" + is_none);
  refused("suite.toml", of_one_seed, "[\"peak_normal_force\"]", "[\"absent\"]",
          "35: comparisons.stiffness.responses" + is_none);
  refused("suite.toml", of_one_seed, "\"mass.toml\"", "\"mass.toml\"\nresponse = \"absent\"",
          "26: comparisons.mass.response" + is_none);
  refused("mass.toml", mass, "\"present_mass\"", "\"absent\"", "2: response" + is_none);
  refused("mass.toml", mass, "\"0.0146 kg\", \"0.0147 kg\", \"0.0148 kg\"", "\"1 N\", \"2 N\"",
          "3: values: \"present_mass\" is measured in \"N\"; expected \"kg\"");
  refused("claims.toml", claims, "\"present_count\"", "\"absent\"", "7: criteria.0.lhs" + is_none);
  refused("claims.toml", claims, "\"present_count\"", "\"a b c\"",
          "7: criteria.0.lhs: \"a b c\" is not an operand");
}

TEST(ValidateCommand, AResponseThatTheCaseLacksEndsTheSuiteAfterItsFirstRun) {
  const Suite folder;
  const std::string wrong[] = {
      test::replaced(suite, "[\"peak_normal_force\"]", "[\"absent\"]"),
      test::replaced(suite, "\"mass.toml\"", "\"mass.toml\"\nresponse = \"absent\""),
      test::replaced(suite, "[\"present_mass\"]", "[\"absent\"]")};
  for (const std::string& text : wrong) {
    folder.write("suite.toml", text);
    std::filesystem::remove_all(folder.path() / "out");
    const Outcome o = folder.firn(
        {"validate", "suite.toml", "-o", "out", "--jobs", "1", "--no-cache", "--progress", "json"});
    EXPECT_EQ(o.status, 2) << text;
    EXPECT_EQ(lines_with(o.err, "\"started\""), 1U) << o.err;
    EXPECT_THAT(o.err, HasSubstr("\"absent\" is not a response of the case"));
  }
}

TEST(ValidateCommand, RefusesAFolderOfAnotherSuite) {
  const Suite folder;
  ASSERT_EQ(folder.firn({"validate", "suite.toml", "-o", "out", "--progress", "none"}).status, 0);
  std::string text = suite;
  folder.write("other.toml", text.replace(text.find("boxes"), 5, "cubes"));
  const Outcome o = folder.firn({"validate", "other.toml", "-o", "out"});
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("another"));
}

}  // namespace
}  // namespace firn::cli
