// [[couplings]] of a case, from the file to results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/inspection/run_diagnostics.h"
#include "experiments/responses/curve_responses.h"
#include "experiments/responses/load_responses.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "tests/support/error_of.h"
#include "tests/support/replaced.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// A ram on a crank, as in docs/scenes.md, that pushes a cube along a table.
constexpr const char* kRam = R"(
[case]
duration = "1 s"
[materials.ice]
density = "917 kg/m^3"
young_modulus = "1 MPa"
[materials.steel]
density = "7800 kg/m^3"
young_modulus = "10 MPa"
[interactions.ice-steel]
static_friction = 0.1
restitution = 0.3
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "200 0 0 mm"
[[boundaries]]
name = "table"
kind = "plane"
material = "steel"
point = "0 0 -10 mm"
normal = [0, 0, 1]
[[boundaries]]
name = "ram"
kind = "box"
material = "steel"
size = "40 30 16 mm"
position = "160 0 0 mm"
motion_frame = "piston"
[[motion_frames]]
name = "crank"
[motion_frames.free]
mass = "100 g"
center = "20 0 0 mm"
inertia = "1e-5 1e-4 1e-4 kg m^2"
joints = [{ kind = "rotation", direction = [0, -1, 0], motors = [{ speed = "60 rpm", max_load = "5 N m" }] }]
[[motion_frames]]
name = "rod"
parent = "crank"
position = "40 0 0 mm"
[motion_frames.free]
mass = "50 g"
center = "100 0 0 mm"
inertia = "1e-5 1e-4 1e-4 kg m^2"
joints = [{ kind = "rotation", direction = [0, -1, 0] }]
[[motion_frames]]
name = "piston"
position = "160 0 0 mm"
[motion_frames.free]
mass = "200 g"
center = "160 0 0 mm"
inertia = "1e-4 1e-4 1e-4 kg m^2"
joints = [{ kind = "translation", direction = [1, 0, 0] }]
[[couplings]]
kind = "ball"
between = ["rod", "piston"]
position = "160 0 0 mm"
)";

constexpr const char* kMeasures = R"(
[[measure]]
kind = "load"
name = "pin"
coupling = "rod-piston"
direction = [1, 0, 0]
[[measure]]
kind = "curve"
name = "pin"
coupling = "rod-piston"
y = "force"
[[measure]]
kind = "curve"
name = "bearing"
motion_frame = "crank"
x = "coordinate"
y = "reaction_force"
)";

std::string coupling_error(const std::string& text) {
  return test::error_if_any([&] { read_case_text(text, "c.toml", "."); });
}

using test::replaced;

using CouplingCase = ResultsFolder;

TEST_F(CouplingCase, DriveARamThatPushesACube) {
  const Case c = read_case_text(std::string(kRam) + kMeasures, "c.toml", ".");
  RunOptions options;
  options.results_file = path("ram.h5");
  ASSERT_EQ(run(c, options).status, RunStatus::finished);
  const Recording recording(path("ram.h5"));
  const std::vector<double> time = recording.frame_times();
  const std::vector<double> angle = recording.series("/motion_frames/crank/coordinate"),
                            place = recording.series("/motion_frames/piston/coordinate"),
                            force = recording.series("/couplings/rod-piston/force");
  ASSERT_EQ(angle.size(), time.size());
  ASSERT_EQ(force.size(), 3 * time.size());
  double largest = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    EXPECT_NEAR(angle[i], 2 * std::numbers::pi * time[i], 1e-3);  // but for the start
    const double a = angle[i], z = 0.04 * std::sin(a);
    EXPECT_NEAR(place[i], 0.04 * std::cos(a) + std::sqrt(0.12 * 0.12 - z * z) - 0.16, 1e-9);
    largest = std::max(largest, std::abs(force[3 * i]));
  }
  EXPECT_GT(largest, 0.1);
  const std::vector<Response> loads = load_responses(recording, c);
  ASSERT_EQ(loads.size(), 2u);
  EXPECT_EQ(loads[1].name, "pin_load_peak");
  EXPECT_GT(loads[1].value[0], 0.1);
  const std::vector<Response> curves = curve_responses(recording, c);
  ASSERT_EQ(curves.size(), 4u);
  EXPECT_EQ(curves[1].name, "pin_curve_y");
  EXPECT_EQ(curves[3].name, "bearing_curve_y");
  // The bearing carries the weight of crank and rod and more.
  EXPECT_GT(*std::ranges::max_element(curves[3].value), 1);
  // The ram starts at its dead center, 10 mm before the cube, and does not come nearer.
  EXPECT_LT(largest, 20);
}

// The rod goes anywhere and turns about all axes; two balls hold it.
TEST_F(CouplingCase, HoldARodThatTurnsFreely) {
  const std::string hinged =
      "parent = \"crank\"\nposition = \"40 0 0 mm\"\n[motion_frames.free]\nmass = \"50 g\"\n"
      "center = \"100 0 0 mm\"\ninertia = \"1e-5 1e-4 1e-4 kg m^2\"\n"
      "joints = [{ kind = \"rotation\", direction = [0, -1, 0] }]\n";
  const std::string loose =
      "position = \"100 0 0 mm\"\n[motion_frames.free]\nmass = \"50 g\"\n"
      "center = \"100 0 0 mm\"\ninertia = \"1e-5 1e-4 1e-4 kg m^2\"\nfree_rotation = true\n"
      "joints = [{ kind = \"translation\", direction = [1, 0, 0] }, "
      "{ kind = \"translation\", direction = [0, 1, 0] }, "
      "{ kind = \"translation\", direction = [0, 0, 1] }]\n";
  const std::string end =
      "[[couplings]]\nkind = \"ball\"\nbetween = [\"crank\", \"rod\"]\nposition = \"40 0 0 mm\"\n";
  const auto angle_and_place = [&](const std::string& text, const std::string& file) {
    RunOptions options;
    options.results_file = path(file);
    EXPECT_EQ(run(read_case_text(text, "c.toml", "."), options).status, RunStatus::finished);
    const Recording recording(path(file));
    EXPECT_EQ(last_finite(recording.series("/diagnostics/unconverged_steps")), 0);
    return std::pair(recording.series("/motion_frames/crank/coordinate"),
                     recording.series("/motion_frames/piston/coordinate"));
  };
  const auto [angle, place] = angle_and_place(kRam, "hinged.h5");
  const auto [free_angle, free_place] =
      angle_and_place(replaced(kRam, hinged, loose) + end, "loose.h5");
  ASSERT_EQ(angle.size(), free_angle.size());
  for (std::size_t i = 0; i < angle.size(); ++i) {
    EXPECT_NEAR(free_angle[i], angle[i], 1e-4);
    const double z = 0.04 * std::sin(free_angle[i]);
    EXPECT_NEAR(free_place[i],
                0.04 * std::cos(free_angle[i]) + std::sqrt(0.12 * 0.12 - z * z) - 0.16, 1e-9);
  }
}

TEST_F(CouplingCase, StopTheRunWhereTheyCannotBeMet) {
  // The crank is longer than the rod, which is driven beyond its reach.
  const std::string coupled = "between = [\"rod\", \"piston\"]\nposition = ";
  const std::string unlimited = replaced(kRam, ", max_load = \"5 N m\"", "");
  const std::string short_rod =
      replaced(unlimited, coupled + "\"160 0 0 mm\"", coupled + "\"75 0 0 mm\"");
  const Case c = read_case_text(short_rod, "c.toml", ".");
  RunOptions options;
  options.results_file = path("short.h5");
  const RunSummary summary = run(c, options);
  EXPECT_EQ(summary.status, RunStatus::failed);
  EXPECT_THAT(summary.reason, HasSubstr("cannot meet its couplings at 0.1"));
}

// The ram with friction in the bearing of its crank and in the pin of its piston.
std::string ram_with_friction() {
  const std::string pin = "position = \"160 0 0 mm\"\n";
  const std::size_t at = std::string(kRam).rfind(pin);
  return replaced(std::string(kRam).replace(at, pin.size(),
                                            pin + "direction = [0, 1, 0]\n"
                                                  "friction_coefficient = 0.2\n"
                                                  "bearing_radius = \"4 mm\"\n"),
                  "motors = [{", "friction = \"0.01 N m\", motors = [{");
}

TEST_F(CouplingCase, ResultsHaveWhatFrictionDissipates) {
  const std::string curves = R"(
[[measure]]
kind = "curve"
name = "pin"
coupling = "rod-piston"
y = "dissipated_friction"
[[measure]]
kind = "curve"
name = "crank"
motion_frame = "crank"
x = "coordinate"
y = "dissipated_friction"
)";
  const Case c = read_case_text(ram_with_friction() + curves, "c.toml", ".");
  EXPECT_EQ(c.model.couplings[0].friction_coefficient, 0.2);
  EXPECT_EQ(c.model.couplings[0].bearing_radius, 4e-3);
  EXPECT_EQ(c.model.couplings[0].direction, Vec3::UnitY());
  const RunSummary summary = run(c, options("ram.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished);
  const Recording recording(path("ram.h5"));
  const std::vector<double> pin = recording.series("/couplings/rod-piston/dissipated_friction"),
                            crank = recording.series("/motion_frames/crank/dissipated_friction"),
                            angle = recording.series("/motion_frames/crank/coordinate");
  EXPECT_FALSE(recording.contains("/motion_frames/rod/dissipated_friction"));
  ASSERT_EQ(pin.size(), recording.frame_count());
  for (std::size_t i = 1; i < pin.size(); ++i) EXPECT_GE(pin[i], pin[i - 1] - 1e-9);
  EXPECT_GT(pin.back(), 5e-5);
  for (std::size_t i = 0; i < crank.size(); ++i) EXPECT_NEAR(crank[i], 0.01 * angle[i], 1e-5);
  const auto response = [&](const char* name) {
    const auto at = std::ranges::find(summary.responses, name, &Response::name);
    return at == summary.responses.end() ? std::vector<double>() : at->value;
  };
  EXPECT_EQ(response("rod-piston_dissipated_friction"), std::vector<double>{pin.back()});
  EXPECT_EQ(response("crank_dissipated_joint_friction"), std::vector<double>{crank.back()});
  EXPECT_EQ(response("rod_dissipated_joint_friction"), std::vector<double>());
  EXPECT_EQ(response("pin_curve_y").back(), pin.back());
  EXPECT_EQ(response("crank_curve_y").back(), crank.back());
}

TEST_F(CouplingCase, EnergiesOfItsPartsBalance) {
  const Case c = read_case_text(ram_with_friction(), "c.toml", ".");
  ASSERT_EQ(run(c, options("ram.h5")).status, RunStatus::finished);
  const Recording recording(path("ram.h5"));
  std::vector<double> sum(recording.frame_count(), 0);
  const auto add = [&](const std::string& name, double sign) {
    const std::vector<double> values = recording.series("/energy/" + name);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += sign * values[i];
    return values.back();
  };
  for (const char* name :
       {"free_bodies_kinetic", "free_bodies_gravitational", "free_bodies_elastic",
        "boundary_contacts_elastic", "dissipated_joint_damping", "dissipated_boundary_contacts"})
    add(name, 1);
  const double friction = add("dissipated_joint_friction", 1), work = add("free_bodies_work", -1);
  EXPECT_NEAR(friction,
              recording.series("/couplings/rod-piston/dissipated_friction").back() +
                  recording.series("/motion_frames/crank/dissipated_friction").back(),
              1e-12);
  EXPECT_GT(work, friction);
  for (const double value : sum) EXPECT_NEAR(value, sum[0], 1e-3 * work);
  const FreeBodyBalance balance = free_body_balance(recording).value();
  const auto [low, high] = std::ranges::minmax(sum);
  EXPECT_NEAR(balance.change, high - low, 1e-12);
  EXPECT_GE(balance.turned_over, work);
  EXPECT_EQ(free_body_warning(balance), "");
}

TEST(CouplingReader, RefusesFrictionThatHasNoUse) {
  const auto with = [](const std::string& from, const std::string& to) {
    return coupling_error(replaced(ram_with_friction(), from, to));
  };
  const std::string ball = "kind = \"ball\"\n", direction = "direction = [0, 1, 0]\n",
                    coefficient = "friction_coefficient = 0.2\n",
                    radius = "bearing_radius = \"4 mm\"\n";
  EXPECT_EQ(coupling_error(ram_with_friction()), "");
  EXPECT_EQ(with(ball, "kind = \"hinge\"\n"), "");
  EXPECT_EQ(with(coefficient + radius, "friction = \"1 N mm\"\n"), "");
  EXPECT_THAT(with(direction, ""), HasSubstr("direction"));
  EXPECT_THAT(with(radius, ""), HasSubstr("bearing_radius"));
  EXPECT_THAT(with(coefficient, ""), HasSubstr("expected a friction_coefficient with it"));
  EXPECT_THAT(with(coefficient + radius, ""), HasSubstr("no use without friction"));
  EXPECT_THAT(with(coefficient, "friction_coefficient = -1\n"), HasSubstr("is negative"));
  EXPECT_THAT(with(ball, "kind = \"slot\"\n"), HasSubstr("bearing_radius"));
  EXPECT_THAT(with(ball, "kind = \"weld\"\n"), HasSubstr("c.toml:"));
  EXPECT_THAT(with(coefficient, coefficient + "friction = \"1 N\"\n"), HasSubstr("friction"));
  const std::string curve =
      "[[measure]]\nkind = \"curve\"\nname = \"a\"\ny = \"dissipated_friction\"\n";
  EXPECT_THAT(coupling_error(std::string(kRam) + curve + "coupling = \"rod-piston\"\n"),
              HasSubstr("without friction"));
  EXPECT_THAT(coupling_error(std::string(kRam) + curve + "motion_frame = \"rod\"\n"),
              HasSubstr("without friction"));
}

TEST(CouplingReader, RefusesWhatTiesNothingInOneLine) {
  const auto with = [](const std::string& from, const std::string& to) {
    return coupling_error(replaced(kRam, from, to));
  };
  const std::string between = "between = [\"rod\", \"piston\"]\nposition = \"160 0 0 mm\"\n",
                    ball = "kind = \"ball\"\n";
  EXPECT_EQ(coupling_error(kRam), "");
  EXPECT_THAT(with("\"rod\", \"piston\"", "\"rod\", \"pistol\""),
              HasSubstr("unknown motion frame \"pistol\""));
  EXPECT_THAT(with("\"rod\", \"piston\"", "\"rod\", \"rod\""), HasSubstr("two bodies"));
  EXPECT_EQ(coupling_error(std::string(kRam) + kMeasures), "");
  EXPECT_THAT(coupling_error(replaced(std::string(kRam) + kMeasures, "coupling = \"rod-piston\"",
                                      "coupling = \"rod-crank\"")),
              HasSubstr("unknown coupling \"rod-crank\""));
  EXPECT_EQ(with("\"rod\", \"piston\"", "\"rod\", \"world\""), "");
  EXPECT_THAT(with(ball, "kind = \"spring\"\n"), HasSubstr("c.toml:"));
  EXPECT_THAT(with(ball, "kind = \"slot\"\n"), HasSubstr("direction"));
  EXPECT_THAT(with(ball, "kind = \"gear\"\n"), HasSubstr("position"));
  const auto geared = [&](const std::string& keys) {
    return coupling_error(replaced(replaced(kRam, ball, ""), between, keys));
  };
  EXPECT_EQ(geared("kind = \"gear\"\nbetween = [\"crank\", \"rod\"]\nratio = -2\n"), "");
  EXPECT_EQ(geared("kind = \"gear\"\nbetween = [\"crank\", \"piston\"]\nratio = \"3 mm/rad\"\n"),
            "");
  EXPECT_THAT(geared("kind = \"gear\"\nbetween = [\"crank\", \"piston\"]\nratio = 3\n"),
              HasSubstr("ratio"));
  EXPECT_THAT(geared("kind = \"gear\"\nbetween = [\"crank\", \"world\"]\nratio = 3\n"),
              HasSubstr("without joints"));
  EXPECT_THAT(
      geared("kind = \"gear\"\nbetween = [\"crank\", \"rod\"]\nratio = 2\njoints = [0, 1]\n"),
      HasSubstr("joint 1 of \"rod\""));
  const std::string cam = "kind = \"cam\"\nbetween = [\"crank\", \"piston\"]\n";
  EXPECT_EQ(geared(cam + "angles = [\"0 deg\", \"90 deg\", \"180 deg\", \"270 deg\"]\n"
                         "lifts = [\"0 mm\", \"5 mm\", \"9 mm\", \"5 mm\"]\n"),
            "");
  EXPECT_THAT(geared(cam + "angles = [\"0 deg\", \"90 deg\", \"180 deg\", \"360 deg\"]\n"
                           "lifts = [\"0 mm\", \"5 mm\", \"9 mm\", \"5 mm\"]\n"),
              HasSubstr("span a turn"));
  EXPECT_THAT(geared(cam + "angles = [\"0 deg\", \"90 deg\", \"180 deg\", \"270 deg\"]\n"
                           "lifts = [\"1 mm\", \"5 mm\", \"9 mm\", \"5 mm\"]\n"),
              AllOf(HasSubstr("at the angle 0"), StartsWith("c.toml:")));
}

}  // namespace
}  // namespace firn
