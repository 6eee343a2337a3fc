// What spoils a run: rounding, stiffness or time step, energies that do not balance, joints that do
// not converge.
#include "experiments/inspection/run_diagnostics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "experiments/case_reader/read_case.h"
#include "tests/support/replaced.h"
#include "tests/support/results_folder.h"

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

TEST(FreeBodyBalance, ChangesStandOut) {
  EXPECT_THAT(free_body_warning({0.045, 1.5}),
              HasSubstr("energy balance of free bodies changes by 0.045 J, 3 % of the 1.5 J"));
  EXPECT_EQ(free_body_warning({0.029, 1.5}), "");
  EXPECT_EQ(free_body_warning({0, 0}), "");
  EXPECT_EQ(free_body_warning({1e-12, 1e-12}), "");  // rounding
}

// A mass of 10 g that swings on a spring at 10 000 rad/s, and a cube that nothing touches.
constexpr const char* kOscillator = R"(
[case]
duration = "50 ms"
timestep = "0.01 ms"
gravity = "0 0 0 m/s^2"
[numerics]
allow_unstable_timestep = true
[materials.ice]
density = "917 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 500 mm"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
normal = [0, 0, 1]
[[motion_frames]]
name = "slide"
[motion_frames.free]
mass = "10 g"
center = "0 0 0 m"
inertia = "1e-6 1e-6 1e-6 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [1, 0, 0]
stiffness = "1e6 N/m"
spring_reference = "1 mm"
[output]
frame_interval = "1 ms"
)";

using RunWarnings = ResultsFolder;

TEST_F(RunWarnings, AreThereWhereEnergiesOfFreeBodiesDoNotBalance) {
  // The energy of a spring changes by the fraction (w dt)^2 / 4 within a period.
  const auto run_with = [&](const std::string& timestep) {
    const Case c = read_case_text(test::replaced(kOscillator, "0.01 ms", timestep), "c.toml", ".");
    EXPECT_EQ(run(c, options("swing.h5")).status, RunStatus::finished);
    return c;
  };
  const Case fine = run_with("0.01 ms");
  {
    const Recording recording(path("swing.h5"));
    const FreeBodyBalance balance = free_body_balance(recording).value();
    EXPECT_GT(balance.turned_over, 0.4);
    EXPECT_GT(balance.change, 5e-4 * balance.turned_over);
    EXPECT_TRUE(run_warnings(recording, fine).empty());
    EXPECT_EQ(joint_convergence(recording).steps, 5000);
    EXPECT_EQ(joint_convergence(recording).unconverged, 0);
  }
  const Case coarse = run_with("0.1 ms");
  const Recording recording(path("swing.h5"));
  const std::vector<RunWarning> warnings = run_warnings(recording, coarse);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].subject, "energy of free bodies");
  EXPECT_THAT(warnings[0].text, HasSubstr("energy balance of free bodies changes by 0."));
  EXPECT_THAT(warnings[0].text, HasSubstr("a smaller time step"));
}

TEST(JointConvergence, StepsWithoutItStandOut) {
  EXPECT_EQ(convergence_warning({0, 5000}), "");
  const std::string warning = convergence_warning({12, 5000});
  EXPECT_THAT(warning, HasSubstr("did not converge in 12 of 5000 steps"));
  EXPECT_THAT(warning, HasSubstr("likely cause: a motor"));
  EXPECT_EQ(warning.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace firn
