// One body on a plate: closed forms, and what the responses must not depend on.
#include "experiments/responses/single_body_responses.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "experiments/case_reader/read_case.h"
#include "tests/support/bench_run.h"

namespace firn {
namespace {

constexpr double kGravity = 9.81;

std::string number(double value) { return fmt::format("{}", value); }

// --- the tracks alone ---------------------------------------------------------------------------

// A plate that leans over by 1 deg a second, on which a body starts to slide at 10 deg with 2 mm/s.
BoundaryTrack steady_slide() {
  BoundaryTrack track;
  for (int k = 0; k <= 300; ++k) {
    const double t = 0.1 * k;
    track.time.push_back(t);
    track.inclination.push_back(t / kRadToDeg);
    track.distance.push_back(t < 10 ? 0 : 2e-3 * (t - 10));
    track.turn.push_back(0);
  }
  return track;
}

Measure slip_measure() {
  Measure m;
  m.slip = 1.05e-3;  // between two frames
  m.run = 20e-3;
  m.tip_angle = 20 / kRadToDeg;
  return m;
}

TEST(SlipOf, InterpolatesTheInclinationBetweenFrames) {
  const SlipResult r = measure_slip(steady_slide(), slip_measure());
  EXPECT_EQ(r.end, SlipResult::End::slid);
  EXPECT_NEAR(r.angle * kRadToDeg, 10.525, 1e-9);
  EXPECT_NEAR(r.resolution * kRadToDeg, 0.1, 1e-9);
}

TEST(SlipOf, ABodyThatTurnsOverBeforeTheRunTips) {
  BoundaryTrack track = steady_slide();
  for (std::size_t k = 150; k < track.turn.size(); ++k) track.turn[k] = 25 / kRadToDeg;  // at 10 mm
  EXPECT_EQ(measure_slip(track, slip_measure()).end, SlipResult::End::tipped);
  track = steady_slide();
  for (std::size_t k = 250; k < track.turn.size(); ++k) track.turn[k] = 25 / kRadToDeg;  // at 30 mm
  EXPECT_EQ(measure_slip(track, slip_measure()).end, SlipResult::End::slid);
}

TEST(SlipOf, ABodyThatStaysHolds) {
  Measure m = slip_measure();
  m.slip = 1;
  EXPECT_EQ(measure_slip(steady_slide(), m).end, SlipResult::End::at_rest);
  EXPECT_EQ(measure_slip(BoundaryTrack{}, m).end, SlipResult::End::at_rest);
}

TEST(SlideOf, AParabolaHasItsTimeAndAcceleration) {
  BoundaryTrack track;
  for (int k = 0; k <= 100; ++k) {
    const double t = 0.01 * k;
    track.time.push_back(t);
    track.distance.push_back(0.5 * 2.0 * t * t);
  }
  Measure m;
  m.from = 0.01;
  m.to = 0.36;
  const SlideResult r = measure_slide(track, m);
  ASSERT_TRUE(r.passed);
  EXPECT_NEAR(r.time, 0.6 - 0.1, 1e-12);  // both marks are frames
  EXPECT_NEAR(r.acceleration, 2, 1e-9);
  EXPECT_NEAR(r.distance, 1, 1e-12);
  m.to = 1.01;
  EXPECT_FALSE(measure_slide(track, m).passed);
}

TEST(ReboundOf, TheHighestTakeOffCounts) {
  // Falls for 0.2 s, and takes off with 0.3, 0.5 and 0.1 m/s, each after a frame of contact.
  const Vec3 g(0, 0, -kGravity);
  FallTrack track;
  double t = 0, v = 0;
  const auto frame = [&] {
    track.time.push_back(t);
    track.velocity.push_back(Vec3(0.2, 0, v));
  };
  frame();
  for (double next : {0.3, 0.5, 0.1, 0.0}) {
    for (int k = 0; k < 20; ++k) {
      t += 0.01;
      v -= 0.01 * kGravity;
      frame();
    }
    t += 0.01;
    v = next;
    frame();
  }
  const ReboundResult r = measure_rebound(track, g);
  EXPECT_TRUE(r.landed);
  EXPECT_NEAR(r.impact_speed, 0.2 * kGravity, 1e-12);
  EXPECT_NEAR(r.take_off_speed, 0.5, 1e-12);
  track.velocity[1] = Vec3::Zero();  // lay on something
  EXPECT_FALSE(measure_rebound(track, g).landed);
}

// --- the plate that tilts -----------------------------------------------------------------------

const std::string kFriction = "interactions.ice-plastic.static_friction";

// What the rate w adds: from the angle of friction phi on, the body gains g w t / cos(phi), and has
// moved by x after (6 x cos(phi) / (g w))^(1/3).
double overshoot(double friction, double rate, double slip) {
  return std::cbrt(6 * slip * rate * rate * std::cos(std::atan(friction)) / kGravity);
}

BenchRun tilt(std::vector<Override> more = {}, const std::string& file = "tilt/case.toml") {
  more.emplace_back("output.frame_interval", "2 ms");
  return run_bench(file, more);
}

TEST(Tilt, TheCubeSlidesAtTheAngleOfFrictionAndWhatTheRateAdds) {
  for (const auto& [friction, degrees_a_second] :
       {std::pair{0.1, 4.0}, std::pair{0.1, 16.0}, std::pair{0.3, 16.0}}) {
    const BenchRun r = tilt(
        {{kFriction, number(friction)},
         {"boundaries.plate.motions.0.angular_velocity", number(degrees_a_second) + " deg/s"}});
    EXPECT_EQ(r.value("slid"), 1);
    EXPECT_EQ(r.value("tipped"), 0);
    EXPECT_FALSE(r.has("tip_angle"));
    const double expected =
        std::atan(friction) + overshoot(friction, degrees_a_second / kRadToDeg, 2e-3);
    // A body near its angle of friction creeps (docs/contact.md): up to 0.3 mm a second here.
    EXPECT_NEAR(r.value("slide_angle"), expected * kRadToDeg, 0.1) << friction;
  }
}

TEST(Tilt, NothingButTheFrictionOnThePlateMatters) {
  const auto with = [](const std::string& key, const char* value) {
    return tilt({{kFriction, "0.1"},
                 {"boundaries.plate.motions.0.angular_velocity", "24 deg/s"},
                 {key, value}})
        .value("slide_angle");
  };
  // All but the last within what creep does, which the swing after the landing decides.
  constexpr double kCreep = 0.1;  // deg
  const double before = with("case.seed", "1");
  EXPECT_NEAR(with("case.seed", "9"), before, kCreep);
  EXPECT_NEAR(with("interactions.ice-plastic.restitution", "0.7"), before, kCreep);
  EXPECT_NEAR(with("materials.ice.young_modulus", "1 MPa"), before, kCreep);
  EXPECT_NEAR(with(kFriction, "0.15"), before + 2.8, 0.2);
  EXPECT_EQ(with("interactions.ice-ice.static_friction", "0.7"), before);  // no such contact
}

TEST(Tilt, TheSeedTurnsAndPlacesTheCube) {
  const Case a = read_case(FIRN_SOURCE_DIR "/cases/tilt/case.toml");
  const Case b = read_case(FIRN_SOURCE_DIR "/cases/tilt/case.toml", {{"case.seed", "2"}});
  EXPECT_GT(a.placed[0].orientation.angularDistance(b.placed[0].orientation), 0.1);
  EXPECT_NE(a.placed[0].position.x(), b.placed[0].position.x());
  EXPECT_EQ(a.placed[0].position.z(), b.placed[0].position.z());
}

TEST(Tilt, TheSledSlidesAsOneCubeDoes) {
  const BenchRun r =
      tilt({{kFriction, "0.1"}, {"boundaries.plate.motions.0.angular_velocity", "16 deg/s"}},
           "tilt/sled.toml");
  EXPECT_NEAR(r.value("slide_angle"),
              (std::atan(0.1) + overshoot(0.1, 16 / kRadToDeg, 2e-3)) * kRadToDeg, 0.1);
}

// The whole scene turned about an axis through the origin.
TEST(Tilt, ATurnedSceneGivesTheSameAngle) {
  const std::string file = FIRN_SOURCE_DIR "/cases/tilt/case.toml";
  const std::vector<Override> plain = {{kFriction, "0.1"},
                                       {"boundaries.plate.motions.0.angular_velocity", "16 deg/s"},
                                       {"particles.0.scatter", "0 0 0 mm"},
                                       {"particles.0.rotation_jitter_axis", "[0, 0, 1]"}};
  const Quat q(Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()));
  const auto bare = [&](const Vec3& v) {
    const Vec3 w = q * v;
    return fmt::format("[{}, {}, {}]", w.x(), w.y(), w.z());
  };
  const auto with_unit = [&](const Vec3& v, const char* unit) {
    const Vec3 w = q * v;
    return fmt::format("{} {} {} {}", w.x(), w.y(), w.z(), unit);
  };
  const Case c = read_case(file, plain);
  const Quat cube = q * Quat(0.7253744, -0.6883546, 0, 0);
  std::vector<Override> turned = plain;
  for (const Override& o : std::vector<Override>{
           {"case.gravity", with_unit({0, 0, -kGravity}, "m/s^2")},
           {"boundaries.plate.normal", bare(Vec3::UnitZ())},
           {"boundaries.plate.motions.0.axis", bare(Vec3::UnitY())},
           {"particles.0.position", with_unit({0, 0, 9.88}, "mm")},
           {"particles.0.orientation",
            fmt::format("[{}, {}, {}, {}]", cube.w(), cube.x(), cube.y(), cube.z())},
           {"particles.0.rotation_jitter_axis", bare(Vec3::UnitZ())},
           {"outlets.0.point", with_unit({200, 0, 0}, "mm")},
           {"outlets.0.normal", bare(Vec3::UnitX())}}) {
    turned.push_back(o);
  }
  const BenchRun first = run_case(c), second = run_case(read_case(file, turned));
  EXPECT_NEAR(first.value("slide_angle"), second.value("slide_angle"), 0.01);
}

TEST(Tilt, ATallBoxTipsOverItsEdge) {
  // 20 mm wide, 40 mm tall: tan = 1/2. Placed without turns, so that it tips over one edge.
  const BenchRun r = tilt({{kFriction, "1"},
                           {"shapes.cube",
                            "{ kind = \"box\", size = \"20 20 40 mm\", material = "
                            "\"ice\", rounding = \"0.1 mm\" }"},
                           {"particles.0.orientation", "[1, 0, 0, 0]"},
                           {"particles.0.position", "0 0 20 mm"},
                           {"particles.0.turn", "0 deg"},
                           {"materials.ice.young_modulus", "1 MPa"},
                           {"boundaries.plate.motions.0.angular_velocity", "16 deg/s"}});
  EXPECT_EQ(r.value("slid"), 0);
  EXPECT_EQ(r.value("tipped"), 1);
  EXPECT_FALSE(r.has("slide_angle"));
  // Once it tips, its own speed soon outruns the plate's.
  EXPECT_GT(r.value("tip_angle"), std::atan(0.5) * kRadToDeg);
  EXPECT_NEAR(r.value("tip_angle"), std::atan(0.5) * kRadToDeg, 2.5);
}

// --- the plate that stands at an angle ----------------------------------------------------------

TEST(Slide, TimeAndAccelerationFollowTheDynamicFriction) {
  for (double friction : {0.1, 0.3}) {
    const BenchRun r = run_bench("slide/case.toml",
                                 {{"interactions.ice-plastic.dynamic_friction", number(friction)}});
    const double angle = 30 / kRadToDeg;
    const double a = kGravity * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_EQ(r.value("passed"), 1);
    EXPECT_NEAR(r.value("sliding_acceleration"), a, 0.005 * a);
    const double time = std::sqrt(2 * 0.32 / a) - std::sqrt(2 * 0.02 / a);
    EXPECT_NEAR(r.value("slide_time"), time, 0.005 * time);
  }
}

TEST(Slide, ACubeThatHoldsPassesNoMark) {
  const BenchRun r =
      run_bench("slide/case.toml", {{kFriction, "0.7"},
                                    {"interactions.ice-plastic.dynamic_friction", "0.7"},
                                    {"stages.slide.max_duration", "0.2 s"}});
  EXPECT_EQ(r.value("passed"), 0);
  EXPECT_FALSE(r.has("slide_time"));
  EXPECT_LT(r.value("slide_distance"), 1e-3);
}

TEST(Slide, ALaunchedCubeStopsWhereItsEnergyIsSpent) {
  // On a level plate, v^2 / (2 mu g).
  const BenchRun r =
      run_bench("slide/case.toml", {{"boundaries.plate.normal", "[0, 0, 1]"},
                                    {"particles.0.orientation", "[0.7253744, -0.6883546, 0, 0]"},
                                    {"particles.0.position", "0 0 9.88 mm"},
                                    {"particles.0.velocity", "1 0 0 m/s"},
                                    {"particles.0.rotation_jitter_axis", "[0, 0, 1]"},
                                    {"stages.slide.max_duration", "0.6 s"}});
  const double way = 1 / (2 * 0.3 * kGravity);
  EXPECT_NEAR(r.value("slide_distance"), way, 0.01 * way);
}

// --- the fall -----------------------------------------------------------------------------------

// Restitution of the law as it is, without weight: the floor lets a contact that opens keep a
// thousandth of its loading force, which adds a little to e (docs/verification.md, impacts).
double law_restitution(double e) {
  // Work given back over work done: unloading along K / e^2 to the floor, then along it to zero.
  constexpr double kFloor = 0.001;
  const double unloaded = (1 - kFloor * 1) / (1 / (e * e) - kFloor);  // part of s until the floor
  const double left = 1 - unloaded;
  const double back = (1 + kFloor * left) * unloaded / 2 + kFloor * left * left / 2;
  return std::sqrt(2 * back);
}

TEST(Bounce, TheSphereGivesTheRestitutionOfTheLaw) {
  for (double e : {0.3, 0.7}) {
    const BenchRun r =
        run_bench("bounce/sphere.toml", {{"interactions.ice-plastic.restitution", number(e)},
                                         {"materials.ice.young_modulus", "1 GPa"},
                                         {"case.duration", "0.2 s"}});
    EXPECT_EQ(r.value("landed"), 1);
    EXPECT_NEAR(r.value("drop_height"), 0.1, 3 * r["drop_height"].uncertainty[0]);
    // Gravity takes a little more than the frames resolve while the dent is left behind.
    const double law = law_restitution(e);
    EXPECT_NEAR(r.value("restitution"), law, 0.01 * law);
    EXPECT_NEAR(r.value("rebound_height"), law * law * 0.1, 0.02 * law * law * 0.1);
  }
}

TEST(Bounce, FrictionDoesNotMatterToTheSphere) {
  const auto bounced = [](const char* friction) {
    return run_bench("bounce/sphere.toml", {{kFriction, friction}, {"case.duration", "0.2 s"}})
        .value("restitution");
  };
  EXPECT_NEAR(bounced("0"), bounced("0.8"), 1e-9);
}

TEST(Bounce, CubesBounceLessThanTheirRestitutionAndScatter) {
  const BenchRun r = run_bench("bounce/case.toml", {{"particles.0.grid", "[3, 2, 1]"}});
  EXPECT_EQ(r.value("landed"), 1);
  const Response& each = r["restitution_each"];
  ASSERT_EQ(each.value.size(), 6u);
  double mean = 0;
  for (double e : each.value) mean += e / 6;
  EXPECT_NEAR(r.value("restitution"), mean, 1e-12);
  EXPECT_LT(mean, 0.3);
  EXPECT_GT(r["restitution"].uncertainty[0], 0.01);
}

TEST(BodyResponses, AreTheSameWhenMeasuredAgain) {
  const BenchRun r = run_bench("bounce/case.toml",
                               {{"particles.0.grid", "[2, 1, 1]"}, {"case.duration", "0.2 s"}});
  ASSERT_EQ(r.responses.size(), r.measured_again.size());
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    EXPECT_EQ(r.responses[i].name, r.measured_again[i].name);
    EXPECT_EQ(r.responses[i].value, r.measured_again[i].value);
  }
}

TEST(BodyResponses, AMeasureSeesItsTagAndCarriesItsName) {
  const BenchRun r = run_bench("bounce/sphere.toml", {{"particles.0.tag", "4"},
                                                      {"measure.0.tag", "4"},
                                                      {"measure.0.name", "ball"},
                                                      {"case.duration", "0.2 s"}});
  EXPECT_TRUE(r.has("ball_restitution"));
  EXPECT_FALSE(r.has("restitution"));
}

}  // namespace
}  // namespace firn
