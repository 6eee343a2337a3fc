// Records in cases: what goes before what, and what a resolved case keeps of it.
#include "experiments/case_reader/material_values.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/case_reader/read_case.h"
#include "experiments/material_records/material_database.h"
#include "firn/contact_model.h"
#include "tests/support/error_of.h"
#include "tests/support/sample_records.h"

namespace firn {
namespace {

using test::calibrated_record;
using test::published_record;
using test::ScratchFolder;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

// A block over a steel floor. `head` and `laws` are what the tests vary.
std::string case_text(const std::string& head, const std::string& laws) {
  return "[case]\nname = \"c\"\nduration = \"1 ms\"\n" + head +
         "\n[materials.ice]\ndensity = \"900 kg/m^3\"\n[materials.steel]\n" + laws +
         "\n[shapes.cube]\nkind = \"box\"\nsize = \"2 2 2 cm\"\nmaterial = \"ice\"\n"
         "[[particles]]\nshape = \"cube\"\nposition = \"0 0 20 mm\"\n"
         "[[boundaries]]\nname = \"floor\"\nkind = \"plane\"\nmaterial = \"steel\"\nrigid = true\n"
         "normal = [0, 0, 1]\n";
}
const std::string restitution =
    "[interactions.steel-ice]\nrestitution = 0.4\n[interactions.ice-ice]\nrestitution = 0.4\n";
const std::string named = "[[material_records]]\nrecord = \"ice-steel\"\n";

class MaterialApplication : public testing::Test {
 protected:
  MaterialApplication() : folder_("application-" + std::string(current())) {
    MaterialDatabase database(request_.database = folder_ / "m.db",
                              MaterialDatabase::Access::write);
    database.add({published_record(), calibrated_record(), published_record("other")});
  }
  static const char* current() {
    return testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  Case read(const std::string& text, const std::vector<std::string>& records = {},
            const std::vector<Override>& overrides = {}) const {
    MaterialRequest request = request_;
    request.records = records;
    return read_case_text(text, "c.toml", ".", overrides, request);
  }
  // static and dynamic friction of cube and floor
  static double floor(const Case& c) { return c.model.interaction(0, 1).static_friction; }
  static double cubes(const Case& c) { return c.model.interaction(0, 0).static_friction; }

  ScratchFolder folder_;
  MaterialRequest request_;
};

TEST_F(MaterialApplication, ARecordFillsInWhatTheCaseLeavesOpen) {
  const Case c = read(case_text(named, restitution));
  EXPECT_EQ(floor(c), 0.3);
  EXPECT_EQ(cubes(c), 0.1);
  EXPECT_EQ(c.model.materials[0].young_modulus, 0.01e9);
  ASSERT_EQ(c.material_records.size(), 1u);
  EXPECT_EQ(c.material_records[0].record, "ice-steel@2");  // the newest
  EXPECT_THAT(
      c.material_records[0].applied_keys,
      ElementsAre("interactions.ice-ice.static_friction", "interactions.ice-ice.dynamic_friction",
                  "interactions.steel-ice.static_friction",  // as the case spells the pair
                  "materials.ice.young_modulus"));
}

// The case's own keys go before the record that it names; a parameter goes whole or not at all.
TEST_F(MaterialApplication, AnotherContactModelIsWarnedOf) {
  const Case c = read(case_text(named, restitution));
  EXPECT_EQ(c.material_records.at(0).contact_model, 2);
  ASSERT_NE(kContactModel, 2);
  EXPECT_EQ(contact_model_warning("ice-steel@2", 2),
            fmt::format("material ice-steel@2 was calibrated with contact model 2, and this build "
                        "has {}: its values may not fit; calibrate them again",
                        kContactModel));
  EXPECT_EQ(contact_model_warning("ice-steel@2", kContactModel), "");
  // A measured or printed value belongs to no contact model.
  const Case printed = read(case_text(named, restitution), {"ice-steel@1"});
  EXPECT_EQ(printed.material_records.back().contact_model, std::nullopt);
}

TEST_F(MaterialApplication, TheCasesOwnKeysGoBeforeTheRecordThatItNames) {
  const Case c =
      read(case_text(named,
                     "[interactions.ice-steel]\nrestitution = 0.4\nstatic_friction = 0.7\n"
                     "[interactions.ice-ice]\nrestitution = 0.4\nstatic_friction = 0.6\n"));
  EXPECT_EQ(floor(c), 0.7);
  EXPECT_EQ(cubes(c), 0.6);
  EXPECT_EQ(c.model.interaction(0, 0).dynamic_friction, 0.6);  // not the record's 0.1
  EXPECT_THAT(c.material_records[0].applied_keys, ElementsAre("materials.ice.young_modulus"));
  EXPECT_EQ(c.material_records[0].overridden_keys.size(), 3u);
}

TEST_F(MaterialApplication, TheCommandLineGoesBeforeTheCaseAndSetBeforeBoth) {
  const std::string laws =
      "[interactions.ice-steel]\nrestitution = 0.4\nstatic_friction = 0.7\n"
      "[interactions.ice-ice]\nrestitution = 0.4\nstatic_friction = 0.6\n";
  const Case c = read(case_text("", laws), {"ice-steel@1"});
  EXPECT_EQ(floor(c), 0.3);
  EXPECT_EQ(cubes(c), 0.1);
  const Case set = read(case_text("", laws), {"ice-steel@1"},
                        {{"interactions.steel-ice.static_friction", "0.25"}});
  EXPECT_EQ(floor(set), 0.25);
  EXPECT_EQ(cubes(set), 0.1);
  EXPECT_THAT(set.material_records[0].overridden_keys,
              ElementsAre("interactions.ice-steel.static_friction"));
}

TEST_F(MaterialApplication, ARequestGoesBeforeTheRecordOfTheCaseToo) {
  const Case c = read(case_text(named, restitution), {"other"});
  ASSERT_EQ(c.material_records.size(), 2u);
  EXPECT_EQ(c.material_records[0].record, "ice-steel@2");
  EXPECT_TRUE(c.material_records[0].applied_keys.empty());
  EXPECT_EQ(c.material_records[1].record, "other@1");
  EXPECT_EQ(c.material_records[1].applied_keys.size(), 4u);
}

TEST_F(MaterialApplication, TwoRecordsDoNotSetTheSameKey) {
  EXPECT_THAT(test::error_of([&] {
                read(case_text("", restitution), {"ice-steel", "other"});
              }),
              HasSubstr("other@1: sets interactions.ice-ice.static_friction, as ice-steel@2 does"));
  const std::string two = named + "[[material_records]]\nrecord = \"other\"\n";
  EXPECT_THAT(test::error_of([&] { read(case_text(two, restitution)); }),
              HasSubstr("c.toml:7: material_records.1.record: material other@1: sets"));
}

// What a results file keeps stands on its own: no database is asked, nothing depends on it.
TEST_F(MaterialApplication, AResolvedCaseNeedsNoDatabase) {
  const Case c = read(case_text(named + "sample = 5\n", restitution), {});
  EXPECT_EQ(c.material_records[0].selection, "sample 5");
  std::filesystem::remove(request_.database);
  const Case again = read(c.resolved);
  EXPECT_EQ(again.resolved, c.resolved);
  EXPECT_EQ(floor(again), floor(c));
  EXPECT_EQ(again.material_records[0].record, "ice-steel@2");
  EXPECT_EQ(again.material_records[0].selection, "sample 5");
  EXPECT_EQ(again.material_records[0].sha256, c.material_records[0].sha256);
  EXPECT_EQ(again.material_records[0].applied_keys, c.material_records[0].applied_keys);
  // What an override changes is no longer the record's.
  const Case changed = read(c.resolved, {}, {{"interactions.ice-steel.static_friction", "0.5"}});
  EXPECT_EQ(floor(changed), 0.5);
  EXPECT_EQ(changed.material_records[0].applied_keys.size(), 3u);
  EXPECT_THAT(changed.resolved, Not(HasSubstr("\"interactions.steel-ice.static_friction\"")));
}

TEST_F(MaterialApplication, SamplesAndAnchors) {
  const Case third = read(case_text("", restitution), {"ice-steel#3"});
  const MaterialRecord record = MaterialDatabase(request_.database).find("ice-steel").record;
  EXPECT_EQ(floor(third), chosen_values(record, parse_material_choice("ice-steel#3"))[1]);
  EXPECT_NE(floor(third), 0.3);
  EXPECT_EQ(floor(read(case_text("", restitution), {"ice-steel#answer"})), 0.3);
  EXPECT_EQ(floor(read(case_text(named + "anchor = \"answer\"\n", restitution))), 0.3);
  EXPECT_THAT(test::error_of([&] { read(case_text("", restitution), {"ice-steel@1#1"}); }),
              HasSubstr("no posterior ensemble"));
  EXPECT_THAT(test::error_of([&] { read(case_text(named + "sample = 0\n", restitution)); }),
              HasSubstr("c.toml:6: material_records.0.sample"));
  // --set chooses another one.
  EXPECT_EQ(floor(read(case_text(named + "sample = 1\n", restitution), {},
                       {{"material_records.0.sample", "3"}})),
            floor(third));
}

TEST_F(MaterialApplication, AHashPinsTheContent) {
  const std::string hash = MaterialDatabase(request_.database).find("ice-steel", 1).sha256;
  const std::string one = "[[material_records]]\nrecord = \"ice-steel@1\"\nsha256 = \"";
  EXPECT_EQ(floor(read(case_text(one + hash + "\"\n", restitution))), 0.3);
  EXPECT_THAT(
      test::error_of([&] { read(case_text(one + std::string(64, '0') + "\"\n", restitution)); }),
      HasSubstr("has the hash " + hash));
}

TEST_F(MaterialApplication, WhatDoesNotFitIsReported) {
  EXPECT_THAT(
      test::error_of([&] { read(case_text("", restitution), {"ice-polyethylene-friction-2023"}); }),
      HasSubstr("holds no value for a case whose materials are ice, steel"));
  EXPECT_THAT(
      test::error_of([&] { read(case_text("[[material_records]]\nrecord = \"nope\"\n", "")); }),
      HasSubstr("c.toml:5: material_records.0.record: material nope: unknown"));
  EXPECT_THAT(test::error_of([&] {
                read(
                    case_text("[[material_records]]\nrecord = \"ice-steel@1\"\nsha256 = \"x\"\n"
                              "sets = [\"materials.ice.poisson_ratio\"]\n",
                              restitution));
              }),
              HasSubstr("which the case does not give"));
  EXPECT_THAT(test::error_of([&] { read(case_text("material_records = 1\n", restitution)); }),
              HasSubstr("c.toml:4"));
}

// Keys about materials that the case does not have are reported, not silently ignored.
TEST_F(MaterialApplication, KeysWithoutAPlaceAreReported) {
  const std::string laws =
      "[interactions.ice-steel]\nstatic_friction = 0.1\nrestitution = 0.4\n"
      "[interactions.ice-ice]\nrestitution = 0.4\n";
  const Case c = read(case_text("", laws), {"paper-table-1"});
  EXPECT_THAT(c.material_records[0].unmatched_keys,
              ElementsAre("interactions.ice-plastic.restitution",
                          "interactions.ice-plastic.static_friction",
                          "interactions.ice-plastic.dynamic_friction"));
  EXPECT_EQ(cubes(c), 0.1);
}

// Two materials that never meet need no law of contact: some of its numbers are none.
TEST_F(MaterialApplication, NumbersOfAPairThatTheCaseHasNoLawForAreReported) {
  const auto text = [](const std::string& head) {
    std::string all = case_text(head,
                                "[interactions.ice-plastic]\nstatic_friction = 0.1\n"
                                "restitution = 0.4\n");
    for (std::size_t at; (at = all.find("steel")) != std::string::npos;)
      all.replace(at, 5, "plastic");
    return all;
  };
  const std::string record = "ice-plastic-drained-repose";
  const std::string friction = "interactions.ice-ice.static_friction";
  const Override modulus{"materials.ice.young_modulus", "0.01 GPa"};
  const Case c = read(text(""), {record}, {modulus});
  EXPECT_THAT(c.material_records[0].unmatched_keys, Contains(friction));
  EXPECT_THAT(c.material_records[0].applied_keys,
              Contains("interactions.ice-plastic.static_friction"));
  EXPECT_EQ(c.resolved.find("ice-ice"), std::string::npos);
  // With what is missing it is a law.
  const Case whole =
      read(text(""), {record}, {modulus, {"interactions.ice-ice.restitution", "0.3"}});
  EXPECT_THAT(whole.material_records[0].applied_keys, Contains(friction));
  // A case that names the record itself wants all of it.
  EXPECT_THAT(test::error_of([&] {
                read(text("[[material_records]]\nrecord = \"" + record + "\"\n"), {}, {modulus});
              }),
              HasSubstr("interactions.ice-ice.restitution"));
}

}  // namespace
}  // namespace firn
