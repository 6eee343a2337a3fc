#include "reports/documents/case_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "experiments/case_reader/read_case.h"
#include "reports/replay/replay_data.h"
#include "tests/reports/browser.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kHead = R"(
[case]
name = "machine"
duration = "0.5 s"
[materials.ice]
density = "917 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
dynamic_friction = 0.1
restitution = 0.3
)";

std::string vector_text(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> any(-size, size);
  const double x = any(random), y = any(random), z = any(random);
  return fmt::format("{:.4f} {:.4f} {:.4f}", x, y, z);
}

std::string axis_text(std::mt19937& random) {
  std::string text = vector_text(random, 1);
  for (std::size_t at = 0; (at = text.find(' ', at)) != text.npos; at += 2)
    text.replace(at, 1, ", ");
  return "[" + text + "]";
}

// One or two motions of random kinds and schedules.
std::string motions(std::mt19937& random) {
  std::uniform_real_distribution<double> any(0, 1);
  std::string list;
  const int count = 1 + static_cast<int>(random() % 2);
  for (int k = 0; k < count; ++k) {
    const double start = 0.2 * any(random);
    const std::string when = fmt::format("start = \"{:.3f} s\", stop = \"{:.3f} s\"", start,
                                         start + 0.01 + 0.2 * any(random));
    std::string kind;
    switch (random() % 3) {
      case 0:
        kind = fmt::format("kind = \"translation\", velocity = \"{} m/s\"", vector_text(random, 1));
        break;
      case 1:
        kind = fmt::format(
            "kind = \"rotation\", axis = {}, center = \"{} m\", angular_velocity = \"{:.1f} "
            "deg/s\"",
            axis_text(random), vector_text(random, 0.3), 400 * any(random) - 200);
        break;
      default:
        kind = fmt::format(
            "kind = \"pendulum\", axis = {}, center = \"{} m\", amplitude = \"{:.1f} deg\", "
            "frequency = \"{:.1f} Hz\"",
            axis_text(random), vector_text(random, 0.3), 60 * any(random), 1 + 5 * any(random));
    }
    list += fmt::format("{}{{ {}, {} }}", k ? ", " : "", kind, when);
  }
  return list;
}

// A frame on a frame, boundaries on both and on none, motions of all of them and of a stage.
std::string random_machine(unsigned seed) {
  std::mt19937 random(seed);
  std::string text = kHead;
  text += fmt::format(
      "[[motion_frames]]\nname = \"base\"\nposition = \"{} m\"\nmotions = [{}]\n"
      "[[motion_frames]]\nname = \"arm\"\nparent = \"base\"\nposition = \"{} m\"\nmotions = [{}]\n",
      vector_text(random, 0.2), motions(random), vector_text(random, 0.2), motions(random));
  const char* frames[] = {"", "motion_frame = \"base\"\n", "motion_frame = \"arm\"\n"};
  for (int b = 0; b < 3; ++b)
    text += fmt::format(
        "[[boundaries]]\nname = \"part {}\"\nmaterial = \"ice\"\nkind = \"box\"\nposition = \"{} "
        "m\"\nsize = \"20 10 30 mm\"\n{}motions = [{}]\n",
        b, vector_text(random, 0.2), frames[b], motions(random));
  text +=
      "[shapes.ball]\nkind = \"sphere\"\nradius = \"5 mm\"\nmaterial = \"ice\"\n"
      "[[particles]]\nshape = \"ball\"\nposition = \"0 0 2 m\"\n";
  text +=
      "[[stages]]\nname = \"first\"\nmax_duration = \"0.2 s\"\n"
      "[[stages]]\nname = \"second\"\nmax_duration = \"0.3 s\"\nremove = [\"part 0\"]\n";
  text += fmt::format("[[stages.motions]]\nmotion_frame = \"arm\"\n{}\n",
                      "kind = \"translation\"\nvelocity = \"0.1 0.2 0 m/s\"");
  return text;
}

// The prescribed poses are those of the simulation, which sums them up step by step.
TEST(ScenePoses, AreThoseOfTheSimulation) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const Case c = read_case_text(
        random_machine(seed), "machine.toml", ".",
        {{"case.timestep", "\"1 ms\""}, {"numerics.allow_unstable_timestep", "true"}});
    const ScenePoses poses = scene_poses(c);
    ASSERT_EQ(poses.stages.size(), 2u);
    ASSERT_EQ(poses.tracks.bodies, 4u);
    EXPECT_NEAR(poses.tracks.time.back(), 0.5, 1e-12);

    Solver solver(c.model);
    Motion started = c.stages[1].motions.at(0).motion;
    std::size_t frame = 0;
    for (int step = 0; step <= 500; ++step) {
      const double t = step * c.model.timestep;
      if (step == 200) {
        started.start += t;
        started.stop += t;
        solver.add_frame_motion(c.stages[1].motions[0].frame, started);
      }
      while (frame < poses.tracks.time.size() && poses.tracks.time[frame] < t - 1e-9) ++frame;
      if (frame < poses.tracks.time.size() && std::abs(poses.tracks.time[frame] - t) < 1e-9) {
        for (std::size_t b = 0; b < 3; ++b) {
          const auto& p = poses.tracks.position[frame * 4 + 1 + b];
          const auto& q = poses.tracks.orientation[frame * 4 + 1 + b];
          if (b == 0 && t >= 0.2) {
            EXPECT_TRUE(std::isnan(p[0])) << t;
            continue;
          }
          const BoundaryState& now = solver.boundaries()[b];
          EXPECT_LT((Vec3(p[0], p[1], p[2]) - now.position).norm(), 2e-6) << b << " at " << t;
          EXPECT_LT(Quat(q[0], q[1], q[2], q[3]).angularDistance(now.orientation), 2e-5)
              << b << " at " << t;
        }
      }
      solver.step();
    }
    EXPECT_GT(frame, 50u);
  }
}

TEST(ScenePoses, HaveTheFirstBatches) {
  const std::string text = std::string(kHead) +
                           "[shapes.cube]\nkind = \"box\"\nsize = \"20 20 20 mm\"\nmaterial = "
                           "\"ice\"\n[[fills]]\nshape = \"cube\"\ncount = 30\nbatch = 8\ninterval "
                           "= \"0.1 s\"\nregion_min = \"0 0 0 m\"\nregion_max = \"0.2 0.2 0.2 "
                           "m\"\n[[particles]]\nshape = \"cube\"\nposition = \"0 0 1 m\"\n";
  const ScenePoses poses = scene_poses(read_case_text(text, "fill.toml", "."));
  EXPECT_EQ(poses.problem, "");
  ASSERT_EQ(poses.particles.size(), 9u);
  for (const ScenePoses::Body& body : poses.particles) {
    if (body.batch < 0) continue;
    EXPECT_TRUE((body.position.array() > 0.01).all() && (body.position.array() < 0.19).all());
  }
}

TEST(ScenePoses, StateWhyParticlesAreMissing) {
  const std::string text = std::string(kHead) +
                           "[shapes.cube]\nkind = \"box\"\nsize = \"20 20 20 mm\"\nmaterial = "
                           "\"ice\"\n[[fills]]\nshape = \"cube\"\ncount = 12\nregion_min = \"0 0 "
                           "0 m\"\nregion_max = \"70 70 70 mm\"\n";
  const Case c = read_case_text(text, "fill.toml", ".");
  EXPECT_THAT(scene_poses(c).problem, HasSubstr("impossible fill"));
  EXPECT_THAT(case_page(c).html(), HasSubstr("impossible fill"));
}

// However far away a plane's point is, and however far a particle falls, a plane is drawn about as
// large as the scene.
TEST(ScenePlanes, AreBoundedByTheScene) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    const double size = std::pow(10, 1.5 * any(random));  // of the scene, in 0.1 m
    const std::string text =
        std::string(kHead) +
        fmt::format(
            "[shapes.cube]\nkind = \"box\"\nsize = \"{0:.5f} {0:.5f} {0:.5f} m\"\nmaterial = "
            "\"ice\"\n[[boundaries]]\nname = \"wall\"\nmaterial = \"ice\"\nkind = \"plane\"\n"
            "point = \"{1} m\"\nnormal = {2}\n",
            0.01 * size, vector_text(random, 5), axis_text(random)) +
        (i % 2 ? fmt::format("[[boundaries]]\nname = \"box\"\nmaterial = \"ice\"\nkind = "
                             "\"box\"\nposition = \"0 0 {0:.5f} m\"\nsize = \"{0:.5f} {0:.5f} "
                             "{0:.5f} m\"\n",
                             0.1 * size)
               : std::string()) +
        "[[particles]]\nshape = \"cube\"\nposition = \"0 0 0 m\"\n";
    const Case c = read_case_text(text, "planes.toml", ".");
    PoseTracks tracks;
    tracks.bodies = 1 + c.model.boundaries.size();
    for (int k = 0; k < 100; ++k) {  // at rest, and then far below
      tracks.time.push_back(0.01 * k);
      for (std::size_t b = 0; b < tracks.bodies; ++b) {
        tracks.position.push_back({0, 0, k < 97 ? 0.0f : -1e4f});
        tracks.orientation.push_back({1, 0, 0, 0});
      }
    }
    const Eigen::AlignedBox3d extent = replay::scene_extent(c, tracks);
    EXPECT_TRUE(extent.contains(Vec3(Vec3::Zero())));
    const double diagonal = extent.diagonal().norm();
    EXPECT_LT(diagonal, 0.5 * size);
    const TriangleMesh mesh = replay::plane_rectangle(c.model.boundaries.front(), extent);
    ASSERT_EQ(mesh.triangles.size(), 2U);
    for (const Vec3& a : mesh.vertices) {
      EXPECT_EQ(a.z(), 0);
      for (const Vec3& b : mesh.vertices) EXPECT_LT((a - b).norm(), 1.8 * diagonal);
    }
  }
}

// Boundaries are shown where they are in the first frame, wherever that is.
TEST(SceneExtent, ContainsBoundariesInTheFirstFrame) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1, 1);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Case c =
        read_case_text(random_machine(seed), "machine.toml", ".", {{"case.timestep", "2 us"}});
    PoseTracks tracks = scene_poses(c).tracks;
    const std::size_t particles = tracks.bodies - c.model.boundaries.size();
    std::vector<Vec3> corners;
    for (std::size_t b = 0; b < c.model.boundaries.size(); ++b) {
      const Vec3 place(any(random), any(random), any(random));
      const Quat turn = Quat(any(random), any(random), any(random), any(random)).normalized();
      const bool there = b > 0 || seed % 2 == 0;
      auto& position = tracks.position[particles + b];
      for (int k = 0; k < 3; ++k)
        position[index(k)] = there ? static_cast<float>(place[k]) : std::nanf("");
      tracks.orientation[particles + b] = {
          static_cast<float>(turn.w()), static_cast<float>(turn.x()), static_cast<float>(turn.y()),
          static_cast<float>(turn.z())};
      for (const Vec3& v : c.model.boundaries[b].mesh.vertices)
        if (there) corners.push_back(place + turn * v);
    }
    const Eigen::AlignedBox3d extent = replay::scene_extent(c, tracks);
    Eigen::AlignedBox3d wanted;
    for (const Vec3& corner : corners) wanted.extend(corner);
    // Only the particle, a ball of 5 mm at (0, 0, 2) m, adds to the boundaries.
    EXPECT_LT((extent.min() - wanted.min().cwiseMin(Vec3(-0.01, -0.01, 1.99))).norm(), 1e-3);
    EXPECT_LT((extent.max() - wanted.max().cwiseMax(Vec3(0.01, 0.01, 2.01))).norm(), 1e-3);
  }
}

TEST(SceneExtent, ContainsRegionsOnRequestAndWithoutParticles) {
  const std::string fill =
      "[[fills]]\nshape = \"ball\"\ncount = 5\nregion_min = \"3 3 3 m\"\nregion_max = \"4 4 4 "
      "m\"\n[[inlets]]\nname = \"mold\"\nshape = \"ball\"\nposition = \"-5 0 0 m\"\n";
  const Case c =
      read_case_text(random_machine(2) + fill, "machine.toml", ".", {{"case.timestep", "2 us"}});
  PoseTracks tracks;  // only the particle that is placed, and the boundaries
  tracks.bodies = 1 + c.model.boundaries.size();
  tracks.time = {0};
  tracks.position.assign(tracks.bodies, {0, 0, 0});
  tracks.orientation.assign(tracks.bodies, {1, 0, 0, 0});
  const Vec3 high(4, 4, 4), low(-5, 0, 0);
  EXPECT_FALSE(replay::scene_extent(c, tracks).contains(high));
  EXPECT_TRUE(replay::scene_extent(c, tracks, true).contains(high));
  EXPECT_TRUE(replay::scene_extent(c, tracks, true).contains(low));
  tracks.position[0][0] = std::nanf("");
  EXPECT_TRUE(replay::scene_extent(c, tracks).contains(high));
  EXPECT_TRUE(replay::scene_extent(c, tracks).contains(low));
}

// The camera of the page looks at the middle of the extent.
TEST(CasePage, BeginsWithTheExtentOfTheScene) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: the scene is not drawn";
  const Case c = read_case_text(
      random_machine(3) +
          "[[fills]]\nshape = \"ball\"\ncount = 5\nregion_min = \"1 1 1 m\"\nregion_max = \"1.2 "
          "1.3 1.4 m\"\n",
      "machine.toml", ".", {{"case.timestep", "2 us"}});
  page::Page page = case_page(c);
  page.add_script(R"(
const look = () => {
  if (document.querySelector('.replay').dataset.ready !== 'yes') return setTimeout(look, 20);
  document.title = new URLSearchParams(FirnReplayViews.states()[0]).get('view').replaceAll(',', ' ');
};
look();
)");
  const test::ScratchFolder folder("case-page");
  page.write(folder / "page.html");
  const std::string dom = document_of(folder / "page.html");
  std::istringstream title(dom.substr(dom.find("<title>") + 7));
  double azimuth = 0, elevation = 0, distance = 0, x = 0, y = 0, z = 0;
  title >> azimuth >> elevation >> distance >> x >> y >> z;
  ASSERT_FALSE(title.fail()) << dom.substr(dom.find("<title>"), 200);
  const Eigen::AlignedBox3d extent = replay::scene_extent(c, scene_poses(c).tracks, true);
  EXPECT_LT((Vec3(x, y, z) - extent.center()).norm(), 1e-3 * (1 + extent.center().norm()));
  EXPECT_GT(distance, 0.5 * extent.diagonal().norm());
}

TEST(CasePage, NamesWhatTheCaseDeclares) {
  std::string text = random_machine(7) +
                     "[[sensors]]\nname = \"exit <1>\"\npoint = \"0 0 0 m\"\nnormal = [0, 0, 1]\n"
                     "[[outlets]]\nname = \"floor\"\npoint = \"0 0 -1 m\"\nnormal = [0, 0, -1]\n";
  const Case c = read_case_text(text, "machine.toml", ".", {{"case.timestep", "2 us"}});
  const std::string html = case_page(c).html();
  for (const char* word : {"machine", "part 0", "second", "arm", "ice on ice", "id=\"replay-case\"",
                           "<dt>time step</dt><dd>2 us</dd>"})
    EXPECT_THAT(html, HasSubstr(word));
  EXPECT_THAT(html, Not(HasSubstr("exit <1>")));
}

TEST(SceneMarkers, ShowEveryKindOfCoupling) {
  const auto body = [](const std::string& name, const std::string& place, const char* joint) {
    return fmt::format(
        "[[motion_frames]]\nname = \"{0}\"\nposition = \"{1} mm\"\n[motion_frames.free]\nmass = "
        "\"100 g\"\ncenter = \"{1} mm\"\ninertia = \"1e-4 1e-4 1e-4 kg m^2\"\njoints = [{{ kind = "
        "\"{2}\", direction = [0, 0, "
        "1] }}]\n",
        name, place, joint);
  };
  const auto tie = [](const std::string& kind, const std::string& more) {
    return fmt::format(
        "[[couplings]]\nname = \"the {0}\"\nkind = \"{0}\"\nbetween = [\"wheel\", \"rack\"]\n{1}\n",
        kind, more);
  };
  const std::string at = "position = \"10 20 30 mm\"\n", along = "direction = [0, 3, 0]\n";
  const std::string text =
      kHead +
      std::string(
          "[shapes.ball]\nkind = \"sphere\"\nradius = \"5 mm\"\nmaterial = \"ice\"\n"
          "[[particles]]\nshape = \"ball\"\nposition = \"0 0 2 m\"\n") +
      body("wheel", "0 0 0", "rotation") + body("rack", "100 0 0", "translation") +
      tie("ball", at) + tie("weld", at) + tie("hinge", at + along) + tie("slot", at + along) +
      tie("gear", "ratio = \"5 mm/rad\"") +
      tie("cam",
          "angles = [\"0 deg\", \"90 deg\", \"180 deg\", \"270 deg\"]\nlifts = "
          "[\"0 mm\", \"1 mm\", \"2 mm\", \"1 mm\"]");
  std::vector<replay::Json> markers;
  for (const replay::Json& marker : replay::markers_json(read_case_text(text, "tied.toml", ".")))
    if (marker.at("kind") == "coupling") markers.push_back(marker);
  ASSERT_EQ(markers.size(), 6u);
  const char* names[] = {"the ball, ball", "the weld, weld",          "the hinge, hinge",
                         "the slot, slot", "the gear, gear 5 mm/rad", "the cam, cam"};
  const char* forms[] = {"point", "point", "axis", "axis", "line", "line"};
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(markers[k].at("name"), names[k]);
    EXPECT_EQ(markers[k].at("form"), forms[k]);
    if (k < 4) {
      EXPECT_NEAR(markers[k].at("point").at(1).get<double>(), 0.02, 1e-12);
    }
  }
  EXPECT_TRUE(markers[2].at("turns"));
  EXPECT_FALSE(markers[3].at("turns"));
  EXPECT_EQ(markers[2].at("direction"), replay::Json({0.0, 1.0, 0.0}));
  EXPECT_NEAR(markers[4].at("high").at(0).get<double>(), 0.1, 1e-12);
}

}  // namespace
}  // namespace firn
