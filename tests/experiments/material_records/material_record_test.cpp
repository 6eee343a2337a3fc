// Records: what is accepted, what is refused, and samples of an ensemble.
#include "experiments/material_records/material_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <set>

#include "experiments/case_reader/read_case.h"
#include "experiments/material_records/material_database.h"
#include "experiments/material_records/material_json.h"
#include "tests/support/error_of.h"
#include "tests/support/sample_records.h"

namespace firn {
namespace {

using test::calibrated_record;
using test::published_record;
using testing::AnyOf;
using testing::HasSubstr;

// Empty: the record is accepted.
std::string record_refusal(const MaterialRecord& r) {
  return test::error_if_any([&] { check(r); });
}
template <class Change>
std::string refusal_of(Change change, MaterialRecord r = calibrated_record()) {
  change(r);
  return record_refusal(r);
}

TEST(MaterialRecord, CompleteOnesAreAccepted) {
  EXPECT_EQ(record_refusal(published_record()), "");
  EXPECT_EQ(record_refusal(calibrated_record()), "");
}

TEST(MaterialRecord, NothingGoesWithoutProvenance) {
  using R = MaterialRecord;
  const auto without = [](auto change) { return refusal_of(change); };
  EXPECT_THAT(without([](R& r) { r.provenance.author = ""; }), HasSubstr("provenance.author"));
  EXPECT_THAT(without([](R& r) { r.provenance.date = "yesterday"; }),
              HasSubstr("provenance.date: is \"yesterday\"; expected a date"));
  EXPECT_THAT(without([](R& r) { r.provenance.date = "2026-13-01"; }),
              HasSubstr("expected a date"));
  EXPECT_THAT(without([](R& r) { r.provenance.source = ""; }), HasSubstr("provenance.source"));
  EXPECT_THAT(without([](R& r) { r.provenance.raw_data.clear(); }),
              HasSubstr("provenance.raw_data: is missing"));
  EXPECT_THAT(without([](R& r) { r.provenance.raw_data[0].sha256 = "abc"; }),
              HasSubstr("provenance.raw_data.0.sha256: is no hash"));
  EXPECT_THAT(without([](R& r) { r.provenance.program_commit = ""; }), HasSubstr("commit"));
  EXPECT_THAT(without([](R& r) { r.provenance.study = ""; }), HasSubstr("provenance.study"));
  EXPECT_THAT(without([](R& r) { r.provenance.measurements.clear(); }), HasSubstr("measurements"));
  EXPECT_THAT(without([](R& r) { r.provenance.seeds.clear(); }), HasSubstr("provenance.seeds"));
  EXPECT_THAT(without([](R& r) { r.provenance.estimators.clear(); }), HasSubstr("estimators"));
  EXPECT_THAT(without([](R& r) { r.provenance.command = ""; }), HasSubstr("provenance.command"));
  EXPECT_THAT(without([](R& r) { r.scope.clear(); }), HasSubstr("scope: is missing"));
}

TEST(MaterialRecord, ValuesThatNoCaseCouldTakeAreRefused) {
  using R = MaterialRecord;
  EXPECT_THAT(refusal_of([](R& r) { r.name = "a@2"; }), HasSubstr("name: is \"a@2\""));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[1].name = r.parameters[0].name; }),
              HasSubstr("parameters.1.name: \"" + calibrated_record().parameters[0].name +
                        "\" is taken already; expected another name"));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[0].keys[0] = "shapes.cube.size"; }),
              HasSubstr("parameters.0.keys.0: \"shapes.cube.size\" is not a key of a material"));
  EXPECT_THAT(
      refusal_of([](R& r) { r.parameters[1].keys[0] = "interactions.ice-tin.restitution"; }),
      HasSubstr("is about \"tin\", which is none of the record's materials"));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[2].unit = "mm"; }),
              HasSubstr("parameters.2.unit: is \"mm\", but young_modulus takes"));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[2].unit = "1"; }), HasSubstr("parameters.2.unit"));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[0].keys[0] = r.parameters[1].keys[0]; }),
              HasSubstr("bound twice"));
  EXPECT_THAT(refusal_of([](R& r) { r.parameters[0].value = std::nan(""); }),
              HasSubstr("parameters.0.value"));
  EXPECT_THAT(refusal_of([](R& r) { r.properties[1].statement = ""; }),
              HasSubstr("has no content"));
}

// Both ends of each range and values around them; and a value of the ensemble.
TEST(MaterialRecord, TakesTheValuesThatACaseTakes) {
  const std::string text = R"([case]
duration = "1 s"
[materials.ice]
density = "900 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
young_modulus = "1 GPa"
[interactions.ice-plastic]
static_friction = 2
dynamic_friction = 0
restitution = 0.5
minimum_unloading_ratio = 0.1
[interactions.ice-ice]
static_friction = 2
restitution = 0.5
[shapes.ball]
kind = "sphere"
radius = "1 mm"
material = "ice"
[[particles]]
shape = "ball"
position = "0 0 0 m"
)";
  const std::pair<const char*, const char*> keys[] = {
      {"materials.ice.density", "kg/m^3"},
      {"materials.ice.young_modulus", "Pa"},
      {"materials.ice.poisson_ratio", "1"},
      {"interactions.ice-plastic.static_friction", "1"},
      {"interactions.ice-plastic.dynamic_friction", "1"},
      {"interactions.ice-plastic.restitution", "1"},
      {"interactions.ice-plastic.tangential_stiffness_ratio", "1"},
      {"interactions.ice-plastic.minimum_unloading_ratio", "1"},
      {"interactions.ice-plastic.rolling_resistance", "1"},
      {"interactions.ice-plastic.restick_velocity", "m/s"},
      {"interactions.ice-plastic.adhesion_force", "N"},
      {"interactions.ice-plastic.adhesion_stiffness_fraction", "1"}};
  for (const auto& [key, unit] : keys) {
    int taken = 0, refused = 0;
    for (const double value : {-2.0, -1.0, -0.5, -0.01, 0.0, 0.01, 0.5, 0.51, 0.99, 1.0, 1.01}) {
      const std::string of_case = test::error_if_any([&] {
        read_case_text(text, "c.toml", ".", {{key, toml_value(value, unit)}});
      });
      MaterialRecord r = published_record();
      r.materials = {"ice", "plastic"};
      r.parameters = {{"one", {key}, value, unit, {}, {}, ""}};
      const std::string of_record = record_refusal(r);
      EXPECT_EQ(of_record.empty(), of_case.empty())
          << key << " = " << value << ": " << of_record << " | " << of_case;
      ++(of_record.empty() ? taken : refused);
      EXPECT_THAT(of_record, AnyOf("", HasSubstr("parameters.0.value: is")))
          << key << " = " << value;
    }
    EXPECT_GT(taken, 0) << key;
    EXPECT_GT(refused, 0) << key;
  }
  const std::string of_sample = refusal_of([](MaterialRecord& r) {
    r.ensemble->axes[1].bounds.low = -0.1;
    r.ensemble->reference_sets[0].values[1] = -0.05;
  });
  EXPECT_THAT(of_sample,
              HasSubstr("posterior_ensemble.reference_sets.0.values.1: is -0.05; expected "
                        "a number of at least 0 for static_friction"));
}

TEST(MaterialRecord, FamiliesAreConsistent) {
  using R = MaterialRecord;
  EXPECT_THAT(refusal_of([](R& r) { r.ensemble->axes[0].parameter = "x"; }),
              HasSubstr("\"x\" is not a parameter of the record"));
  EXPECT_THAT(refusal_of([](R& r) { r.ensemble->axes[0].bounds.low = 0; }),
              HasSubstr("logarithmic"));
  EXPECT_THAT(
      refusal_of([](R& r) { r.ensemble->axes[1].parameter = r.ensemble->axes[0].parameter; }),
      HasSubstr("is there twice; expected each parameter once"));
  EXPECT_THAT(refusal_of([](R& r) { r.ensemble->covariance[0][1] = 1; }),
              HasSubstr("not symmetric"));
  EXPECT_THAT(refusal_of([](R& r) {
                r.ensemble->covariance = {{1, 2}, {2, 1}};
              }),
              HasSubstr("negative variance"));
  EXPECT_THAT(refusal_of([](R& r) { r.ensemble->reference_sets[0].values[1] = 0.7; }),
              HasSubstr("posterior_ensemble.reference_sets.0.values.1: is 0.7; expected a value "
                        "within the bounds"));
  EXPECT_THAT(refusal_of([](R& r) {
                r.ensemble->samples = {{{0.1, 0.3}, 0.5}};
              }),
              HasSubstr("weigh 0.5 together"));
}

TEST(MaterialRecord, ReferencesAreReadWhole) {
  EXPECT_EQ(parse_material_choice("ice").version, 0);
  EXPECT_EQ(parse_material_choice("ice@12").version, 12);
  EXPECT_EQ(*parse_material_choice("ice#3").sample, 3u);
  EXPECT_EQ(parse_material_choice("ice@2#valley end").reference_set, "valley end");
  for (const char* bad : {"", "@1", "ice@", "ice@0", "ice@-1", "ice@1x", "ice#", "ice#0", "a b",
                          "ice@1@2", "ice#99999999999999999999"})
    EXPECT_THAT(test::error_of([&] { parse_material_choice(bad); }), HasSubstr("is not a record"))
        << bad;
}

std::vector<double> sample(const MaterialRecord& r, std::uint64_t k) {
  MaterialChoice choice;
  choice.name = r.name;
  choice.sample = k;
  return chosen_values(r, choice);
}

TEST(MaterialSample, PointValuesAnchorsAndNothingElse) {
  const MaterialRecord r = calibrated_record();
  EXPECT_EQ(chosen_values(r, parse_material_choice("ice-steel")),
            (std::vector<double>{0.1, 0.3, 0.01}));
  EXPECT_EQ(chosen_values(r, parse_material_choice("ice-steel#answer")),
            (std::vector<double>{0.1, 0.3, 0.01}));
  EXPECT_THAT(test::error_of([&] { chosen_values(r, parse_material_choice("ice-steel#end")); }),
              HasSubstr("has no reference set \"end\"; expected one of \"answer\""));
  EXPECT_THAT(test::error_of([&] { sample(published_record(), 1); }),
              HasSubstr("no posterior ensemble"));
}

// Moments of the Gaussian, whose bounds lie some deviations away, come back from the draws.
TEST(MaterialSample, GaussianHasItsMoments) {
  const MaterialRecord r = calibrated_record();
  constexpr int n = 20000;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (int k = 1; k <= n; ++k) {
    const std::vector<double> v = sample(r, static_cast<std::uint64_t>(k));
    EXPECT_EQ(v[2], 0.01);  // no part of the ensemble
    const Eigen::Vector2d x(std::log(v[0]), v[1]);
    mean += x / n;
    square += x * x.transpose() / n;
  }
  const Eigen::Matrix2d covariance = square - mean * mean.transpose();
  // Standard errors: sd / sqrt(n) of a mean, about sqrt(2 / n) of a variance; four of them.
  EXPECT_NEAR(mean[0], std::log(0.1), 4 * 0.2 / std::sqrt(n));
  EXPECT_NEAR(mean[1], 0.3, 4 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(covariance(0, 0) / 0.04, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(covariance(1, 1) / 0.0025, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(covariance(0, 1) / -0.006, 1, 4 * std::sqrt(2.0 / n) * 0.01 / 0.006);
}

TEST(MaterialSample, DrawsKeepTheBoundsAndRepeat) {
  MaterialRecord r = calibrated_record();
  r.ensemble->axes[1].bounds = {0.29, 0.31};
  for (std::uint64_t k = 1; k <= 200; ++k) {
    const std::vector<double> v = sample(r, k);
    EXPECT_GE(v[1], 0.29);
    EXPECT_LE(v[1], 0.31);
    EXPECT_EQ(v, sample(r, k));
  }
  EXPECT_NE(sample(r, 1), sample(r, 2));
  r.ensemble->axes[1].mean = 40;
  EXPECT_THAT(test::error_of([&] { sample(r, 1); }), HasSubstr("hardly reaches into the bounds"));
}

// Any run of draws has each point as often as its weight says, to within one or two draws.
TEST(MaterialSample, PointsComeByWeightAndSpreadFromTheFirst) {
  MaterialRecord r = calibrated_record();
  const std::vector<double> weights = {0.1, 0.4, 0.2, 0.3};
  for (std::size_t i = 0; i < weights.size(); ++i)
    r.ensemble->samples.push_back({{0.1, 0.1 + 0.1 * static_cast<double>(i)}, weights[i]});
  std::vector<int> count(weights.size(), 0);
  for (int k = 1; k <= 1000; ++k) {
    const double v = sample(r, static_cast<std::uint64_t>(k))[1];
    ++count[static_cast<std::size_t>(std::lround((v - 0.1) / 0.1))];
    for (std::size_t i = 0; i < weights.size(); ++i)
      EXPECT_LE(std::abs(count[i] - weights[i] * k), 3);
  }
  // The first three draws of a hundred equal points lie in different quarters of the ensemble.
  r.ensemble->samples.clear();
  for (int i = 0; i < 100; ++i) r.ensemble->samples.push_back({{0.1, 0.1 + 0.004 * i}, 0.01});
  std::set<int> quarters;
  for (std::uint64_t k = 1; k <= 3; ++k)
    quarters.insert(static_cast<int>((sample(r, k)[1] - 0.1) / 0.1));
  EXPECT_EQ(quarters.size(), 3u);
}

// ---- What ships ----

const MaterialRecord& shipped(const std::string& name) {
  for (const StoredRecord& s : shipped_materials())
    if (s.record.name == name) return s.record;
  throw std::logic_error("no shipped " + name);
}

TEST(ShippedMaterials, HaveTheirHashes) {
  EXPECT_GE(shipped_materials().size(), 11u);
  const MaterialDatabase database("");
  for (const std::string& name : database.names())
    EXPECT_TRUE(database.integrity_errors(name).empty())
        << name << ": " << database.integrity_errors(name)[0];
}

TEST(ShippedMaterials, TableOfThePaperAsPrinted) {
  const MaterialRecord& table = shipped("paper-table-1");
  const auto value = [](const MaterialRecord& r, const std::string& name) {
    return r.parameters[r.index(name)].value;
  };
  EXPECT_EQ(value(table, "density"), 916.7);
  EXPECT_EQ(value(table, "young_modulus"), 0.01);
  EXPECT_EQ(table.parameters[table.index("young_modulus")].unit, "GPa");
  EXPECT_EQ(value(table, "poisson_ratio"), 0.33);
  EXPECT_EQ(value(table, "restitution_particle_particle"), 0.3);
  EXPECT_EQ(value(table, "restitution_particle_boundary"), 0.3);
  EXPECT_EQ(value(table, "friction_particle_particle"), 0.1);
  EXPECT_EQ(value(table, "friction_particle_boundary"), 0.2);
  EXPECT_EQ(value(shipped("paper-text"), "friction_particle_boundary"), 0.3);
}

// Voigt, Reuss and Hill (1952) for hexagonal crystals, from the printed constants.
TEST(ShippedMaterials, ModulusOfIceFollowsFromItsConstants) {
  const MaterialRecord& r = shipped("ice-elasticity-gammon-1983");
  const auto c = [&](const std::string& name) {
    for (const MaterialProperty& p : r.properties)
      if (p.name == name) return *p.value;
    throw std::logic_error(name);
  };
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();
  stiffness(0, 0) = stiffness(1, 1) = c("c11");
  stiffness(0, 1) = stiffness(1, 0) = c("c12");
  stiffness(0, 2) = stiffness(2, 0) = stiffness(1, 2) = stiffness(2, 1) = c("c13");
  stiffness(2, 2) = c("c33");
  stiffness(3, 3) = stiffness(4, 4) = c("c44");
  stiffness(5, 5) = (c("c11") - c("c12")) / 2;
  const auto voigt = [](const Eigen::Matrix<double, 6, 6>& m, double shear) {
    const double a = m(0, 0) + m(1, 1) + m(2, 2), b = m(0, 1) + m(1, 2) + m(0, 2);
    const double d = m(3, 3) + m(4, 4) + m(5, 5);
    return std::pair((a + 2 * b) / 9, (a - b + shear * d) / 15);
  };
  const auto [bulk_v, shear_v] = voigt(stiffness, 3);
  const Eigen::Matrix<double, 6, 6> s = stiffness.inverse();
  const double bulk_r = 1 / (s.topLeftCorner<3, 3>().sum());
  const double shear_r =
      15 / (4 * (s(0, 0) + s(1, 1) + s(2, 2)) - 4 * (s(0, 1) + s(1, 2) + s(0, 2)) +
            3 * (s(3, 3) + s(4, 4) + s(5, 5)));
  const double bulk = (bulk_v + bulk_r) / 2, shear = (shear_v + shear_r) / 2;
  const double modulus = 9 * bulk * shear / (3 * bulk + shear);
  const double poisson = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
  EXPECT_NEAR(modulus, r.parameters[r.index("young_modulus")].value, 0.005);  // as rounded
  EXPECT_NEAR(poisson, r.parameters[r.index("poisson_ratio")].value, 0.0005);
}

}  // namespace
}  // namespace firn
