#include "validation/comparison/data_provenance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "tests/support/sample_records.h"

namespace firn {
namespace {

using testing::HasSubstr;

DataIdentity angle(double value, double uncertainty, const std::string& experiment = "",
                   const std::string& unit = "deg") {
  return {experiment, {"angle_of_repose"}, true, value, uncertainty, unit};
}

TEST(SameData, AreFoundWhateverTheyAreCalled) {
  const DataIdentity data = angle(10, 0.97, "paper, section 3.3");
  EXPECT_TRUE(same_data(data, angle(10, 0.97)));
  EXPECT_TRUE(same_data(data, angle(10.01, 0.97)));
  EXPECT_TRUE(same_data(data, angle(10.01, 0.5, "my garage")));
  EXPECT_TRUE(same_data(data, angle(40, 1, "Paper: Section 3.3!")));  // the same experiment
  const double radian = 3.14159265358979323846 / 180;
  EXPECT_TRUE(same_data(data, angle(10 * radian, 0.97 * radian, "my garage", "rad")));
  DataIdentity renamed = angle(10, 0.97, "my garage");
  renamed.responses = {"slope"};
  EXPECT_TRUE(same_data(data, renamed));
  // Another quantity, another experiment, a value that contradicts.
  renamed.value = 11;
  EXPECT_FALSE(same_data(data, renamed));
  EXPECT_FALSE(same_data(data, angle(10.4, 0.9, "another laboratory")));
  EXPECT_FALSE(same_data(data, angle(15, 0.9)));
  EXPECT_FALSE(same_data(data, angle(10, 0.9, "another laboratory", "s")));
  // One that does not say which experiment it is of may be the same.
  EXPECT_THAT(same_data(data, angle(10.4, 0.9)).value(), HasSubstr("state their `experiment`"));
}

TEST(SameData, HoldsForRandomMembersAndBothWays) {
  std::mt19937_64 bits(31);
  for (int trial = 0; trial < 2000; ++trial) {
    const double value = std::pow(10, 6 * uniform_half_open(bits) - 3) * (trial % 2 == 0 ? 1 : -1);
    const double u = std::abs(value) * 0.3 * uniform_half_open(bits);
    const DataIdentity a = angle(value, u, "one");
    const double noise = 1 + 0.004 * (2 * uniform_half_open(bits) - 1);
    const DataIdentity rounded = angle(value * noise, u * 1.1, trial % 3 == 0 ? "" : "two");
    EXPECT_TRUE(same_data(a, rounded)) << value;
    EXPECT_TRUE(same_data(rounded, a)) << value;
    const DataIdentity other = angle(value + 3 * (std::abs(value) + u), u, "two");
    EXPECT_FALSE(same_data(a, other)) << value;
    EXPECT_FALSE(same_data(other, a)) << value;
  }
}

TEST(SameData, IdentityOfAMeasurementHoldsAllItsResponses) {
  Measurement m;
  m.status = MeasurementStatus::qualitative;
  m.criteria = {{"", "max loads", "3.5", 1, 0, ""}, {"", "counts[2]", "counts[1]", 1, 0, ""}};
  EXPECT_THAT(identity_of(m, {"drained.angle_of_repose"}).responses,
              testing::IsSupersetOf({"angle_of_repose", "loads", "counts"}));
  EXPECT_FALSE(identity_of(m, {}).has_value);
}

TEST(RecordValues, AreFoundInACaseHoweverTheyGotThere) {
  const MaterialRecord record = test::calibrated_record();
  const auto values = [&](const std::string& ice, const std::string& steel) {
    return values_in_case(record,
                          "[materials.ice]\nyoung_modulus = \"10 MPa\"\n"
                          "[interactions.ice-ice]\nstatic_friction = " +
                              ice + "\n[interactions.steel-ice]\nstatic_friction = " + steel +
                              "\n");
  };
  EXPECT_THAT(values("0.1", "0.3"),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.1, 0.3, 0.01}));
  EXPECT_TRUE(has_values_of(record, values("0.1", "0.3")));
  EXPECT_TRUE(has_values_of(record, values("0.102", "0.31")));  // rounded
  EXPECT_FALSE(has_values_of(record, values("0.1", "0.2")));
  EXPECT_FALSE(has_values_of(record, values_in_case(record, "a = 1\n")));
  MaterialRecord with_ensemble = record;
  with_ensemble.ensemble->reference_sets.front().values = {0.2, 0.15};
  EXPECT_TRUE(has_values_of(with_ensemble, values("0.2", "0.15")));
  with_ensemble.ensemble->samples = {{{0.05, 0.5}, 1}};
  EXPECT_TRUE(has_values_of(with_ensemble, values("0.05", "0.5")));
}

}  // namespace
}  // namespace firn
