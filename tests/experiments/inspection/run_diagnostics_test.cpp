// What spoils the contacts of a run: rounding, stiffness or time step.
#include "experiments/inspection/run_diagnostics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace firn {
namespace {

using testing::HasSubstr;

// A run of cubes of 20 mm in good health.
ContactDiagnostics good() {
  ContactDiagnostics h;
  h.largest_overlap = 0.3e-3;
  h.edge = h.rounding_edge = 20e-3;
  h.particles = 100;
  h.rounding = 0.4e-3;
  h.expected_overlap = 0.3e-3;
  h.speed = 1;
  h.steps_per_quarter = 20;
  return h;
}

TEST(RunDiagnostics, GoodRunHasNoCause) {
  EXPECT_EQ(likely_cause(good()), ContactCause::none);
  EXPECT_EQ(contact_warning(good()), "");
  ContactDiagnostics h = good();
  h.late_contacts = 10;
  h.largest_overlap = 2e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::none);
}

TEST(RunDiagnostics, OverlapThatSpeedExplainsIsTheStiffness) {
  ContactDiagnostics h = good();
  h.largest_overlap = 5e-3;
  h.expected_overlap = 4e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::stiffness);
  h.rounding = 0.01e-3;  // whatever the rounding
  EXPECT_EQ(likely_cause(h), ContactCause::stiffness);
  EXPECT_THAT(contact_warning(h), HasSubstr("overlapped by up to 5 mm, 25 % of the smallest edge"));
  EXPECT_THAT(contact_warning(h), HasSubstr("likely cause: the stiffness"));
}

TEST(RunDiagnostics, OverlapThatSpeedDoesNotExplainIsTheRoundingOfSharpShapes) {
  ContactDiagnostics h = good();
  h.largest_overlap = 9.4e-3;
  h.rounding = 0.018e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::rounding);
  EXPECT_THAT(contact_warning(h), HasSubstr("likely cause: the rounding, 0.018 mm or 0.09 %"));
  h.rounding = 0.5e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::stiffness);
}

TEST(RunDiagnostics, FewStepsAreTheTimeStep) {
  ContactDiagnostics h = good();
  h.largest_overlap = 5e-3;
  h.expected_overlap = 4e-3;
  h.rounding = 0.01e-3;
  h.steps_per_quarter = 2;
  EXPECT_EQ(likely_cause(h), ContactCause::timestep);
  EXPECT_THAT(contact_warning(h), HasSubstr("likely cause: the time step, 2 steps"));
}

TEST(RunDiagnostics, LateContactsAlone) {
  ContactDiagnostics h = good();
  h.late_contacts = 11;
  EXPECT_EQ(likely_cause(h), ContactCause::timestep);
  EXPECT_THAT(contact_warning(h), HasSubstr("11 contacts were first seen when already deep"));
  h.rounding = 0.01e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::rounding);
  h.particles = 1000;
  EXPECT_EQ(likely_cause(h), ContactCause::none);
}

TEST(RunDiagnostics, StoppedRunIsJudgedThoughItsOverlapIsUnknown) {
  ContactDiagnostics h = good();
  h.stopped = true;
  h.largest_overlap = 0;
  h.rounding = 0.018e-3;
  h.expected_overlap = 0.1e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::rounding);
  EXPECT_THAT(contact_warning(h), HasSubstr("the overlap of two bodies passed its limit"));
  h.expected_overlap = 1e-3;
  EXPECT_EQ(likely_cause(h), ContactCause::stiffness);
}

// The cause does not depend on the size of things, and there is a sentence exactly when there is
// a cause.
TEST(RunDiagnostics, CauseDoesNotDependOnSize) {
  std::mt19937 random(3);
  const auto dice = [&random](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  };
  for (int i = 0; i < 2000; ++i) {
    ContactDiagnostics h = good();
    h.largest_overlap = dice(1e-5, 2e-2);
    h.rounding = dice(1e-6, 5e-3);
    h.expected_overlap = dice(1e-6, 2e-2);
    h.steps_per_quarter = dice(1, 100);
    h.late_contacts = dice(1, 1000);
    const ContactCause cause = likely_cause(h);
    EXPECT_EQ(contact_warning(h).empty(), cause == ContactCause::none);
    EXPECT_EQ(contact_warning(h).find('\n'), std::string::npos);
    for (double* length :
         {&h.largest_overlap, &h.edge, &h.rounding, &h.rounding_edge, &h.expected_overlap})
      *length *= 64;
    EXPECT_EQ(likely_cause(h), cause);
  }
}

TEST(DeviationWarning, NamesDeviationAndReason) {
  Shape shape;
  shape.name = "cup";
  shape.box = Vec3(0.02, 0.03, 0.04);
  shape.surface_deviation = 0.3e-3;
  shape.deviation_reason = "edges rounded";
  EXPECT_EQ(deviation_warning(shape), "");
  shape.surface_deviation = 0.5e-3;
  EXPECT_THAT(deviation_warning(shape),
              HasSubstr("shape cup: the contact parts deviate by 0.5 mm from the mesh (2.5 % of "
                        "the smallest edge; edges rounded); a smaller rounding reduces it"));
  // A rounding that the case states is meant to round.
  EXPECT_EQ(deviation_warning(shape, true), "");
  shape.surface_deviation = 1.1e-3;
  EXPECT_THAT(deviation_warning(shape, true), HasSubstr("5.5 % of the smallest edge"));
  shape.surface_deviation = 0.5e-3;
  shape.deviation_reason = "hulls of the parts over concave surface";
  EXPECT_THAT(deviation_warning(shape, true), HasSubstr("check with firn shape"));
  shape.surface_deviation = 0.1e-3;
  shape.deviation_reason = "max_parts = 3 reached";
  EXPECT_THAT(deviation_warning(shape), HasSubstr("max_parts = 3 reached"));
}

TEST(EnergyAccount, GainsStandOut) {
  EXPECT_THAT(energy_warning({0.56, 125}), HasSubstr("gains 0.56 J, 0.45 % of the 125 J"));
  EXPECT_EQ(energy_warning({0.1, 125}), "");
  EXPECT_EQ(energy_warning({0, 0}), "");
  EXPECT_EQ(energy_warning({1e-12, 1e-12}), "");  // rounding
}

}  // namespace
}  // namespace firn
