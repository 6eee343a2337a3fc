// The icemaker's cases as they are shipped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/case_reader/read_case.h"
#include "experiments/measurements/measurement.h"
#include "experiments/results/results_file.h"
#include "experiments/run/driver.h"
#include "experiments/run/interference_check.h"
#include "experiments/run/run.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

std::string shipped(const std::string& name) {
  return std::string(FIRN_SOURCE_DIR) + "/cases/icemaker/" + name + ".toml";
}

double value(const RunSummary& summary, const std::string& name) {
  for (const Response& r : summary.responses)
    if (r.name == name) return r.value.at(0);
  return std::nan("");
}

class IcemakerCases : public ResultsFolder {
 protected:
  RunSummary run_case(const std::string& name, const std::vector<Override>& overrides = {}) {
    return run(read_case(shipped(name), overrides), options("run.h5"));
  }
  std::vector<StageRecord> stages() const { return Recording(path("run.h5")).stages(); }
};
using IcemakerCasesLong = IcemakerCases;

TEST_F(IcemakerCases, EveryCaseIsWholeAndReadsAgainFromItsResolvedText) {
  for (const char* name :
       {"harvest", "harvest_bridged", "bucket_pull", "bucket_pull_paddle", "auger_half",
        "auger_full", "auger_compression", "auger_press", "arm_binding", "arm_linkage",
        "arm_clearance", "glass_impact", "platen_test", "full_cycle", "frozen_mold"}) {
    const Case c = read_case(shipped(name));
    EXPECT_EQ(read_case_text(c.resolved, "again.toml", "/").resolved, c.resolved) << name;
    EXPECT_EQ(c.identity, case_identity(c.resolved)) << name;
  }
}

TEST_F(IcemakerCases, PaddleIsOnTheArm) {
  const Case c = read_case(shipped("bucket_pull_paddle"));
  ASSERT_EQ(c.model.boundaries.back().name, "paddle");
  EXPECT_EQ(c.model.frames.at(static_cast<std::size_t>(c.model.boundaries.back().frame)).name,
            "arm");
}

TEST_F(IcemakerCases, PlatensReachABreakingForceAtTheirSpeed) {
  // At 0.1 GPa, so that it takes a tenth of the way.
  const RunSummary summary =
      run_case("platen_test", {{"materials.ice.young_modulus", "0.1 GPa"},
                               {"motion_frames.upper.motions.0.velocity", "0 0 -50 mm/s"}});
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  EXPECT_EQ(stages().at(0).end_reason, "force");
  // Most of it, or all, by one patch a side; and by both sides.
  EXPECT_GT(value(summary, "peak_normal_force"), 0.9 * 1227.7);
  EXPECT_LT(value(summary, "peak_normal_force"), 1.02 * 1227.7);
  EXPECT_NEAR(value(summary, "largest_compressive_load"), value(summary, "peak_normal_force"),
              0.05 * 1227.7);
}

// A cube falls 0.25 m into the container: v sqrt(m K) would be its force on a rigid plane.
TEST_F(IcemakerCases, GlassIsHitByWhatFallsIntoIt) {
  const RunSummary summary =
      run_case("glass_impact", {{"case.duration", "0.4 s"}, {"sources.outlet.batches", "1"}});
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  EXPECT_EQ(value(summary, "container_count"), 1);
  const double rigid = std::sqrt(2 * 9.81 * 0.25 * 0.0137 * 205740);
  EXPECT_GT(value(summary, "container_contact_force_peak"), 0.2 * rigid);
  EXPECT_LT(value(summary, "container_contact_force_peak"), 1.1 * rigid);
  // A container 22 times as heavy as a cube: the paper's measure is as much smaller.
  const double share = value(summary, "container_particle_mass_times_acceleration") /
                       value(summary, "container_contact_force_peak");
  EXPECT_GT(share, 0.3 * 0.0137 / 0.3);
  EXPECT_LT(share, 3 * 0.0137 / 0.3);
}

TEST_F(IcemakerCasesLong, HarvestIsStoppedByTheArmAndNothingIsLost) {
  const RunSummary summary = run_case("harvest");
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  EXPECT_EQ(stages().at(0).end_reason, "switch \"full\"");
  EXPECT_GE(value(summary, "mold_batches"), 8);
  EXPECT_LE(value(summary, "mold_batches"), 24);
  EXPECT_EQ(value(summary, "lost_count"), 0);
  EXPECT_GE(value(summary, "arm_coordinate_end"), 25 * M_PI / 180);
  // The bucket can be pulled out from there.
  const Case pull =
      read_case(shipped("bucket_pull_from"), {{"initial_state.file", path("run.h5")}});
  EXPECT_EQ(static_cast<double>(pull.placed.size()), value(summary, "present_count"));
  EXPECT_EQ(pull.frame_starts.size(), 4u);
  EXPECT_NO_THROW(check_machine(pull));
}

TEST_F(IcemakerCasesLong, ArmBindsWithAWallThatIsHighOverItsBarAndRough) {
  const auto end_of_push = [&](const char* height, const char* friction) {
    const RunSummary summary =
        run_case("arm_binding", {{"boundaries.bucket.back_height", height},
                                 {"boundary_contacts.arm-bucket.static_friction", friction}});
    EXPECT_EQ(summary.status, RunStatus::finished) << summary.reason;
    return value(summary, "drawer_coordinate_end");
  };
  EXPECT_NEAR(end_of_push("99.6 mm", "0.1"), 0, 1e-4);
  EXPECT_NEAR(end_of_push("99.8 mm", "0.1"), 0, 1e-4);
  EXPECT_GT(end_of_push("99.8 mm", "0.5"), 0.07);
}

// Columns of the bucket that no blade of the auger reaches, from 1.
std::vector<int> columns_left_of_the_auger(const Case& c) {
  const auto auger = std::ranges::find(c.model.boundaries, "auger", &Boundary::name);
  double start = std::numeric_limits<double>::infinity();
  for (const Vec3& corner : auger->mesh.vertices)
    start = std::min(start, (auger->origin + auger->orientation * corner).x());
  const TagRule& rule = c.tag_rules.at(0);
  const double width = (rule.region_max.x() - rule.region_min.x()) / rule.bins;
  std::vector<int> columns;
  for (int k = 0; k < rule.bins; ++k)
    if (rule.region_min.x() + (k + 1) * width <= start) columns.push_back(rule.first + k);
  return columns;
}

TEST_F(IcemakerCases, TheColumnLeftOfTheBladesIsLeftOfTheBlades) {
  const std::string folder = std::string(FIRN_SOURCE_DIR) + "/cases/";
  const Case c = read_case(folder + "icemaker/auger_full.toml");
  ASSERT_EQ(columns_left_of_the_auger(c), (std::vector<int>{1}));
  const Measurement m = read_measurement(folder + "measurements/columns_in_the_container.toml");
  const auto criterion = std::ranges::find_if(m.criteria, [](const Criterion& one) {
    return one.statement.find("left of the auger's blades") != std::string::npos;
  });
  ASSERT_NE(criterion, m.criteria.end());
  EXPECT_EQ(criterion->rhs, "container_count_by_column[1]");
}

}  // namespace
}  // namespace firn
