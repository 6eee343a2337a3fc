// [[bonds]] of case files, and what results files and responses say of them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/process/insertion.h"
#include "experiments/case_reader/process/sintering.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "experiments/inspection/contact_inspection.h"
#include "experiments/results/bond_results.h"
#include "experiments/run/run.h"
#include "experiments/storage/hdf5_file.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"
#include "tests/support/results_mutations.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kBodies = R"(
[case]
duration = "0.5 s"
steps_per_loading = 6
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
poisson_ratio = 0.33
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "1 mm"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
normal = [0, 0, 1]
# An edge that a row of cubes falls across.
[[boundaries]]
name = "edge"
kind = "box"
material = "ice"
size = "20 100 30 mm"
position = "37.5 0 15 mm"
)";

constexpr const char* kBridge = R"(
width = "4 mm"
height = "3 mm"
length = "5 mm"
tensile_strength = "60 kPa"
shear_strength = "60 kPa"
)";

std::string source(int batches = 2) {
  return std::string(kBodies) + R"(
[[inlets]]
name = "mold"
shape = "cube"
position = "0 0 100 mm"
grid = [4, 1, 1]
spacing = "25 1 1 mm"
rotation_jitter = "1 deg"
interval = "0.2 s"
batches = )" +
         std::to_string(batches) + "\n";
}
std::string joined(const std::string& more = "source = \"mold\"") {
  return source() + "[[bonds]]\nname = \"bridges\"\n" + more + kBridge;
}

Case read(const std::string& text) { return read_case_text(text, "bonds.toml", "."); }
std::string complaint(const std::string& text) {
  return test::error_of([&] { read(text); });
}

TEST(BondCase, NeighborsOfEachBatchAreJoined) {
  const Case c = read(joined());
  ASSERT_EQ(c.model.bonds.size(), 6u);
  const int pairs[6][2] = {{0, 1}, {1, 2}, {2, 3}, {4, 5}, {5, 6}, {6, 7}};
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(c.model.bonds[k].a, pairs[k][0]);
    EXPECT_EQ(c.model.bonds[k].b, pairs[k][1]);
  }
  ASSERT_EQ(c.model.beams.size(), 1u);
  const BeamLaw& law = c.model.beams[0];
  EXPECT_DOUBLE_EQ(law.young_modulus, 1e7);  // the ice's
  EXPECT_DOUBLE_EQ(law.shear_modulus, 1e7 / 2.66);
  EXPECT_DOUBLE_EQ(law.section.half_width, 2e-3);
  EXPECT_DOUBLE_EQ(law.section.half_height, 1.5e-3);
  // Turned by chance, joined as they stand: nothing is strained.
  Solver solver(c.model);
  EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
}

// A bar of 40 mm in two pieces of unequal length, drawn in axes that have their origin anywhere.
std::string pieces(const std::string& more) {
  return std::string(kBodies) + R"(
[shapes.short]
kind = "convex"
material = "ice"
vertices = ["5 2 1 mm", "5 22 1 mm", "5 2 21 mm", "5 22 21 mm", "20 2 1 mm", "20 22 1 mm", "20 2 21 mm", "20 22 21 mm"]
[shapes.long]
kind = "convex"
material = "ice"
vertices = ["20 2 1 mm", "20 22 1 mm", "20 2 21 mm", "20 22 21 mm", "45 2 1 mm", "45 22 1 mm", "45 2 21 mm", "45 22 21 mm"]
[[inlets]]
name = "mold"
shape = ["short", "long"]
position = "0 0 150 mm"
grid = [3, 1, 1]
spacing = "60 1 1 mm"
interval = "0.2 s"
batches = 2
)" + more +
         R"(
[[bonds]]
name = "middle"
inlet = "mold"
)" + kBridge;
}

TEST(BondCase, PiecesOfAPlaceAreJoinedAsTheyAreDrawn) {
  for (const char* jitter : {"", "random_orientation = true",
                             "position_jitter = \"3 3 3 mm\"\nrotation_jitter = \"5 deg\""}) {
    SCOPED_TRACE(jitter);
    for (const int seed : {1, 2, 3}) {
      const Case c =
          read_case_text(pieces(jitter), "bonds.toml", ".", {{"case.seed", std::to_string(seed)}});
      ASSERT_EQ(c.model.particles.size(), 12u);
      ASSERT_EQ(c.model.bonds.size(), 6u);
      for (int place = 0; place < 6; ++place) {
        const int first = 2 * place;
        EXPECT_EQ(c.model.bonds[index(place)].a, first);
        EXPECT_EQ(c.model.bonds[index(place)].b, first + 1);
        EXPECT_EQ(shape_of(c.model, first).name, "short");
        EXPECT_EQ(shape_of(c.model, first + 1).name, "long");
        const Inlet& inlet = c.inlets.front();
        const InletPose a = inlet_pose(inlet, index(first % 6), first, c.seed),
                        b = inlet_pose(inlet, index(first % 6 + 1), first + 1, c.seed);
        // Drawn 20 mm apart along x; 15 and 25 mm long.
        EXPECT_LT((b.position - a.position - a.orientation * Vec3(20e-3, 0, 0)).norm(), 1e-15);
        EXPECT_TRUE(a.orientation.coeffs() == b.orientation.coeffs());
        const Vec3 center = (15 * a.position + 25 * b.position) / 40;
        const Vec3 off = center - inlet.positions[index(place % 3)];
        EXPECT_LE(off.cwiseAbs().maxCoeff(), *jitter == 'p' ? 3e-3 : 1e-15);
      }
      EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
      Solver solver(c.model);
    }
  }
}

// Kolmogorov's test of 600 factors has its 99.9 % point at 1.95 / sqrt(600).
TEST(BondCase, StrengthsScatterByWeibullsDistribution) {
  const auto factors = [](double modulus, int seed) {
    const Case c = read_case_text(
        pieces("") + "weibull_modulus = " + std::to_string(modulus) + "\n", "bonds.toml", ".",
        {{"case.seed", std::to_string(seed)}, {"inlets.mold.batches", "200"}});
    EXPECT_EQ(read_case_text(c.resolved, "again", ".").model.bonds.back().strength,
              c.model.bonds.back().strength);
    std::vector<double> all;
    for (const Bond& bond : c.model.bonds) all.push_back(bond.strength);
    return all;
  };
  for (const double modulus : {0.7, 2.0, 10.0}) {
    std::vector<double> all = factors(modulus, 4);
    ASSERT_EQ(all.size(), 600u);
    EXPECT_EQ(all, factors(modulus, 4));
    EXPECT_NE(all, factors(modulus, 5));
    std::ranges::sort(all);
    double largest = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double scaled = all[k] * std::tgamma(1 + 1 / modulus),
                   below = 1 - std::exp(-std::pow(scaled, modulus));
      largest = std::max(largest, std::abs(below - (static_cast<double>(k) + 0.5) / 600));
    }
    EXPECT_LT(largest, 1.95 / std::sqrt(600.0)) << modulus;
  }
  for (const Bond& bond : read(pieces("")).model.bonds) EXPECT_EQ(bond.strength, 1);
  for (const char* wrong : {"0", "-3", "0.4", "1001", "nan"})
    EXPECT_THAT(complaint(pieces("") + "weibull_modulus = " + wrong + "\n"),
                HasSubstr("weibull_modulus"))
        << wrong;
}

TEST(BondCase, PiecesAreRefusedByName) {
  const auto with = [](const std::string& shape) {
    std::string text = pieces("");
    const std::string given = R"(shape = ["short", "long"])";
    return text.replace(text.find(given), given.size(), "shape = " + shape);
  };
  EXPECT_THAT(complaint(with(R"(["short", "shrot"])")),
              testing::AllOf(HasSubstr("bonds.toml:"), HasSubstr("shape"), HasSubstr("\"shrot\"")));
  EXPECT_THAT(complaint(with(R"(["short"])")), HasSubstr("fewer than two pieces"));
  EXPECT_THAT(complaint(with("[]")), HasSubstr("fewer than two pieces"));
  EXPECT_THAT(complaint(with(R"(["short", "long", "short"])")),
              HasSubstr("shape: lists \"short\" twice, at the same place"));
  EXPECT_THAT(complaint(with("[3, 4]")), HasSubstr("expected an array of strings"));
  EXPECT_THAT(complaint(with("3")), HasSubstr("shape"));
}

TEST(BondCase, PairsGoByNumberOrTag) {
  const std::string bodies = std::string(kBodies) + R"(
[[particles]]
shape = "cube"
position = "0 0 60 mm"
tag = 7
[[particles]]
shape = "cube"
position = "25 0 60 mm"
tag = 9
)";
  const std::string head = "[[bonds]]\nname = \"b\"\n";
  for (const char* who : {"pairs = [[0, 1]]", "tags = [[7, 9]]"}) {
    const Case c = read(bodies + head + who + kBridge);
    ASSERT_EQ(c.model.bonds.size(), 1u) << who;
    EXPECT_EQ(c.model.bonds[0].b, 1);
  }
  EXPECT_THAT(complaint(bodies + head + "pairs = [[0, 2]]" + kBridge), HasSubstr("exactly one"));
  EXPECT_THAT(complaint(bodies + head + "tags = [[7, 8]]" + kBridge), HasSubstr("exactly one"));
  EXPECT_THAT(complaint(bodies + head + "pairs = [[0, 0]]" + kBridge), HasSubstr("with itself"));
  EXPECT_THAT(complaint(bodies + head + "pairs = [0, 1]" + kBridge), HasSubstr("pairs of whole"));
  EXPECT_THAT(complaint(bodies + head + kBridge),
              HasSubstr("expected exactly one of inlet, pairs"));
}

// What an audit adds up is what moves the bodies.
TEST(BondCase, AuditsCountBondsAmongTheForces) {
  const Case c = read(std::string(kBodies) + R"(
[[particles]]
shape = "cube"
position = "0 0 60 mm"
velocity = "0 0.1 0 m/s"
grid = [2, 1, 1]
spacing = "25 0 0 mm"
angular_velocity = "3 2 1 rad/s"
[[bonds]]
name = "b"
pairs = [[0, 1]]
)" + kBridge);
  Solver solver(c.model);
  for (const Case::InitialParticle& p : c.placed)
    solver.insert(p.particle, p.position, p.orientation, p.velocity, p.angular_velocity);
  for (int k = 0; k < 50; ++k) solver.step();
  ASSERT_TRUE(solver.bond(0).acts);
  ASSERT_GT(solver.bond(0).load.force.norm(), 0);
  for (const int particle : {0, 1}) {
    const ForceBalance b = force_balance(solver, particle);
    EXPECT_LT(b.force_error, 1e-9 * b.scale);
    EXPECT_LT(b.sum_mismatch, 1e-12 * b.scale);
    EXPECT_LT(b.moment_error, 1e-9 * solver.load(particle).moment.norm());
  }
}

TEST(BondCase, MistakesAreReportedInOneLine) {
  EXPECT_THAT(complaint(joined("inlet = \"mould\"")), HasSubstr("is not an inlet"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\nposition = \"0 0 40 mm\"")),
              HasSubstr("mm off particle 0; expected neighbors"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\nheight_direction = [1, 0, 0]")),
              HasSubstr("along the bridge"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\nmold = \"floor\"")),
              HasSubstr("together with a mold"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\ndamping_ratio = 2")), HasSubstr("from 0 to 1"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\nradius = \"2 mm\"")), HasSubstr("either width"));
  // Bodies far from each other.
  std::string apart = joined();
  apart.replace(apart.find("\"25 1 1 mm\""), 11, "\"90 1 1 mm\"");
  const std::string line = complaint(apart);
  EXPECT_THAT(line, HasSubstr("bonds.bridges.length"));
  EXPECT_THAT(line, HasSubstr("expected neighbors"));
  EXPECT_EQ(line.find('\n'), line.npos);
}

TEST(BondCase, AreLeftOutWhenNotEnabled) {
  const Case c = read(joined("inlet = \"mold\"\nenabled = false"));
  EXPECT_TRUE(c.model.bonds.empty());
  EXPECT_EQ(c.model.timestep, read(source()).model.timestep);
}

TEST(BondCase, AMoldGivesSectionAndLength) {
  const std::string text = std::string(kBodies) + R"(
[shapes.crescent]
kind = "crescent"
material = "ice"
rounding = "1 mm"
[[boundaries]]
name = "tray"
kind = "mold"
material = "ice"
position = "0 0 200 mm"
notch_width = "5 mm"
notch_depth = "3 mm"
pitch = "25 mm"
clearance = "1 mm"
[[inlets]]
name = "mold"
shape = "crescent"
grid = [8, 1, 1]
spacing = "25 1 1 mm"
position = "-87.5 0 172.944 mm"
orientation = [0.7071067811865476, 0, 0, 0.7071067811865476]
[[bonds]]
name = "bridges"
inlet = "mold"
mold = "tray"
position = "0 0 6 mm"
tensile_strength = "1 MPa"
shear_strength = "1 MPa"
)";
  const Case c = read(text);
  ASSERT_EQ(c.model.bonds.size(), 7u);
  const BeamLaw& law = c.model.beams[0];
  EXPECT_NEAR(2 * law.section.half_width, 5e-3, 1e-12);
  EXPECT_NEAR(2 * law.section.half_height, 3e-3, 1e-12);
  EXPECT_NEAR(law.length, 25e-3 - 20.574e-3 - 2e-3, 1e-9);
}

// By hand at -10 C, after 8 h, R = 1 mm: p = 259.9 Pa, D = 1.963e-5 m^2/s, kT = 3.6332e-21 J, so
// that 20 gamma Omega^2 p D / (kT)^2 = 8.97e-19 m^3/s.
TEST(Sintering, NecksGrowByHobbsAndMasonsLaw) {
  const StorageConditions store{8 * 3600.0, 263.15, 1e-3};
  const double x = sintered_neck_radius(store);
  EXPECT_NEAR(x, std::pow(8.97e-19 * 1e-6 * 8 * 3600, 0.2), 2e-3 * x);
  for (const double factor : {0.01, 3.0, 48.0}) {
    EXPECT_NEAR(sintered_neck_radius({factor * store.time, store.temperature, 1e-3}),
                x * std::pow(factor, 0.2), 1e-12 * x);
    EXPECT_NEAR(sintered_neck_radius({store.time, store.temperature, factor * 1e-3}),
                x * std::pow(factor, 0.4), 1e-12 * x);
  }
  double colder = x;
  for (const double temperature : {258.0, 253.0, 243.0, 223.0}) {
    const double now = sintered_neck_radius({store.time, temperature, 1e-3});
    EXPECT_LT(now, colder);
    colder = now;
  }
}

// A stack of three cubes, the uppermost 1 mm above the second, and one that stands alone.
std::string stack(const std::string& bonds) {
  std::string text = kBodies;
  for (const char* place : {"0 0 9.99", "0 0 29.97", "0 0 50.97", "-40 0 9.99"})
    text += std::string("[[particles]]\nshape = \"cube\"\nposition = \"") + place + " mm\"\n";
  return text + "[[bonds]]\nname = \"necks\"\ncontacts = true\ntensile_strength = \"1 MPa\"\n" +
         "shear_strength = \"1 MPa\"\n" + bonds;
}

TEST(Sintering, JoinsBodiesThatTouchAtTheirContacts) {
  const Case c = read(stack("radius = \"2 mm\"\n"));
  ASSERT_EQ(c.model.bonds.size(), 1u);
  const Bond& bond = c.model.bonds[0];
  EXPECT_EQ(bond.a, 0);
  EXPECT_EQ(bond.b, 1);
  const BeamLaw& law = c.model.beams[0];
  // As stiff as a circle between two half-spaces.
  EXPECT_NEAR(law.young_modulus * law.section.area / law.length, 1e7 * 2e-3 / (1 - 0.33 * 0.33),
              1e-6);
  // In the middle of the two faces, across them, and free of stress.
  EXPECT_NEAR(std::abs((bond.axes_a * Vec3::UnitX()).z()), 1, 1e-9);
  Solver solver(c.model);
  for (const Case::InitialParticle& p : c.placed)
    solver.insert(p.particle, p.position, p.orientation, p.velocity, p.angular_velocity);
  solver.step();
  const BondState state = solver.bond(0);
  ASSERT_TRUE(state.acts);
  EXPECT_NEAR(state.middle.z(), 19.98e-3, 2e-5);
  EXPECT_LT(state.middle.head<2>().norm(), 1e-6);
  EXPECT_LT(state.forces.force.norm(), 1e-3);
  EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
}

// However a cube stands on another, and however thin the neck is: they overlap by 0.3 mm, more than
// the neck is wide.
TEST(Sintering, JoinsBodiesInAnyPosition) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int member = 0; member < 40; ++member) {
    SCOPED_TRACE(member);
    Eigen::Vector4d q;
    for (double& value : q) value = normal(random);
    const Quat turn = Quat(q[0], q[1], q[2], q[3]).normalized();
    // The lowest corner of the core of the cube of 20 mm, rounded by 1 mm, from its center, mm.
    const Vec3 up = turn.conjugate() * Vec3::UnitZ();
    const Vec3 corner = turn * Vec3(-9 * up.array().sign());
    const double x = 7 * uniform(random) - corner.x(), y = 7 * uniform(random) - corner.y();
    const double neck = std::pow(10, -1.5 + 1.5 * uniform(random));  // mm
    const std::string text =
        std::string(kBodies) +
        fmt::format(
            "[[particles]]\nshape = \"cube\"\nposition = \"0 0 9.99 mm\"\n"
            "[[particles]]\nshape = \"cube\"\nposition = \"{} {} {} mm\"\n"
            "orientation = [{}, {}, {}, {}]\n"
            "[[bonds]]\nname = \"necks\"\ncontacts = true\nradius = \"{} mm\"\n"
            "tensile_strength = \"1 MPa\"\nshear_strength = \"1 MPa\"\n",
            x, y, 19.99 + 1 - corner.z() - 0.3, turn.w(), turn.x(), turn.y(), turn.z(), neck);
    const Case c = read(text);
    EXPECT_GE(c.model.bonds.size(), 1u);
    EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
  }
}

TEST(Sintering, StorageGivesTheRadius) {
  const std::string store = "storage_time = \"8 h\"\ntemperature = \"-10 degC\"\n";
  const Case c = read(stack(store + "curvature_radius = \"1 mm\"\n"));
  EXPECT_DOUBLE_EQ(c.model.beams[0].section.half_width,
                   sintered_neck_radius({8 * 3600.0, 263.15, 1e-3}));
  EXPECT_THAT(complaint(stack(store)), HasSubstr("curvature_radius"));
  EXPECT_THAT(complaint(stack(store + "curvature_radius = \"1 um\"\n")),
              HasSubstr("beyond half of the curvature_radius"));
  EXPECT_THAT(complaint(stack(store + "radius = \"1 mm\"\n")), HasSubstr("either a radius"));
  EXPECT_THAT(complaint(stack("radius = \"1 mm\"\ntemperature = \"260 K\"\n")),
              HasSubstr("one of the two"));
  EXPECT_THAT(complaint(stack("")), HasSubstr("either a radius"));
  EXPECT_THAT(complaint(stack("storage_time = \"8 h\"\ntemperature = \"1 degC\"\n"
                              "curvature_radius = \"1 mm\"\n")),
              HasSubstr("is 1 degC; expected one from -100 degC"));
  EXPECT_THAT(complaint(stack("radius = \"1 mm\"\nposition = \"0 0 1 mm\"\n")),
              HasSubstr("not a key of bonds at contacts"));
  EXPECT_THAT(complaint(joined("inlet = \"mold\"\nstorage_time = \"1 h\"")),
              HasSubstr("contacts = true"));
  std::string alone = stack("radius = \"1 mm\"\n");
  alone.replace(alone.find("0 0 29.97"), 9, "0 9 59.97");
  alone.replace(alone.find("0 0 50.97"), 9, "0 0 99.97");
  EXPECT_THAT(complaint(alone), HasSubstr("no two bodies touch"));
}

class BondRun : public ResultsFolder {};

// However thin the necks are: some of the contacts of crescents are between the rims of a dish.
TEST_F(BondRun, PiledCrescentsAreJoinedAtAllContacts) {
  const std::string scene = R"(
[case]
duration = "0.4 s"
steps_per_loading = 6
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "crescent"
material = "ice"
rounding = "1 mm"
[[boundaries]]
name = "floor"
kind = "container"
material = "ice"
diameter = "170 mm"
height = "300 mm"
wall = "5 mm"
floor = "5 mm"
)";
  const std::string pour = R"(
[[fills]]
shape = "cube"
count = 30
region_min = "-55 -55 10 mm"
region_max = "55 55 290 mm"
velocity = "0 0 -0.5 m/s"
)";
  for (const char* seed : {"1", "2"}) {
    SCOPED_TRACE(seed);
    const std::string file = std::string("piled") + seed + ".h5";
    ASSERT_EQ(
        run(read_case_text(scene + pour, "c.toml", path(""), {{"case.seed", seed}}), options(file))
            .status,
        RunStatus::finished);
    std::size_t count = 0;
    for (const char* radius : {"1 um", "0.1 mm", "2 mm"}) {
      const Case c = read_case_text(
          scene + "[initial_state]\nfile = \"" + file +
              "\"\n[[bonds]]\nname = \"necks\"\ncontacts = true\nradius = \"" + radius +
              "\"\ntensile_strength = \"1 MPa\"\nshear_strength = \"1 MPa\"\n",
          "stored.toml", path(""));
      if (count == 0) count = c.model.bonds.size();
      EXPECT_GE(count, 30u);
      EXPECT_EQ(c.model.bonds.size(), count) << radius;
    }
  }
}

// Two pairs fly, spin and swing in their bonds. From a frame on the way, with the bonds that held,
// they move as they did without a stop.
TEST_F(BondRun, BondsOfAnInitialStateKeepTheirStrain) {
  const std::string bond =
      "width = \"4 mm\"\nheight = \"3 mm\"\nlength = \"5 mm\"\ntensile_strength = \"9 GPa\"\n"
      "shear_strength = \"9 GPa\"\ndamping_ratio = 0.01\n";
  const std::string head = std::string(kBodies) + "[output]\nframe_interval = \"1 ms\"\n";
  std::string flying = head;
  int tag = 0;
  for (const char* spin : {"3 40 -20 rad/s", "-30 5 10 rad/s"}) {
    for (const char* x : {"0", "25"}) {
      flying += "[[particles]]\nshape = \"cube\"\ntag = " + std::to_string(tag) +
                "\nposition = \"" + x + (tag < 2 ? " -200" : " -400") +
                " 900 mm\"\nangular_velocity = \"" + spin + "\"\n";
      ++tag;
    }
  }
  const std::string first = flying + "[[bonds]]\nname = \"b\"\npairs = [[0, 1], [2, 3]]\n" +
                            "weibull_modulus = 10\n" + bond;
  const Case begun = read_case_text(first, "c.toml", path(""), {{"case.duration", "0.1 s"}});
  ASSERT_EQ(run(begun, options("first.h5")).status, RunStatus::finished);
  const auto from = [&](const std::string& more, const std::string& table) {
    return head + "[initial_state]\nfile = \"first.h5\"\ntime = \"0.06 s\"\n" + more + table;
  };
  const std::string taken = "[[bonds]]\nname = \"b\"\ninitial_state = true\n";
  const Case c =
      read_case_text(from("", taken + bond), "c.toml", path(""), {{"case.duration", "0.04 s"}});
  ASSERT_EQ(c.model.bonds.size(), 2u);
  for (const Bond& held : c.model.bonds)
    EXPECT_EQ(held.strength, begun.model.bonds[index(held.a / 2)].strength);
  EXPECT_NE(c.model.bonds[0].strength, 1);
  EXPECT_THAT(c.start, Not(HasSubstr("left behind")));
  EXPECT_EQ(read_case_text(c.resolved, "again", path("")).resolved, c.resolved);
  ASSERT_EQ(run(c, options("second.h5")).status, RunStatus::finished);
  const Recording one(path("first.h5")), two(path("second.h5"));
  const Frame a = one.frame(one.frame_count() - 1), b = two.frame(two.frame_count() - 1);
  const std::vector<double> times = one.frame_times();
  const double start =
      *std::ranges::min_element(times, {}, [](double time) { return std::abs(time - 0.06); });
  const double late = times.back() - start - two.frame_times().back();  // s, of the first run
  const double swing = two.series("/energy/elastic").front();
  EXPECT_GT(swing, 1e-6);  // J, in the bonds at the start
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double there = a.position[i][k] - late * a.velocity[i][k];
      EXPECT_NEAR(there, b.position[i][k], 5e-6) << i;
    }
  }

  // Without the table, with one body of a pair, with another bond.
  EXPECT_THAT(read_case_text(from("", ""), "c.toml", path("")).start,
              HasSubstr("2 bonds that held there are left behind"));
  const Case half = read_case_text(from("tags = [0, 2, 3]\n", taken + bond), "c.toml", path(""));
  ASSERT_EQ(half.model.bonds.size(), 1u);
  EXPECT_EQ(half.model.bonds[0].a, 1);
  EXPECT_EQ(half.model.bonds[0].b, 2);
  const auto refusal = [&](const std::string& table) {
    return test::error_of([&] { read_case_text(from("", table), "c.toml", path("")); });
  };
  std::string longer = bond;
  longer.replace(longer.find("5 mm"), 4, "6 mm");
  EXPECT_THAT(refusal(taken + longer),
              HasSubstr("length: is 6 mm long, and the bonds of [initial_state] are 5 mm"));
  EXPECT_THAT(refusal("[[bonds]]\nname = \"c\"\ninitial_state = true\n" + bond),
              HasSubstr("no bond \"c\" of [initial_state] holds"));
  EXPECT_THAT(refusal(taken + "position = \"0 0 1 mm\"\n" + bond), HasSubstr("position"));
  EXPECT_THAT(refusal(taken + "pairs = [[0, 1]]\n" + bond), HasSubstr("expected exactly one"));
  EXPECT_THAT(refusal(taken + "weibull_modulus = 5\n" + bond), HasSubstr("keep their scatter"));
}

// The length of a neck follows from its radius. A case need not state it.
TEST_F(BondRun, NecksOfAnInitialStateKeepTheirLength) {
  for (const char* radius : {"0.3 mm", "1.7 mm"}) {
    const std::string section = std::string("radius = \"") + radius + "\"\n";
    const Case first = read(stack(section));
    ASSERT_EQ(run(read_case_text(stack(section), "c.toml", path(""), {{"case.duration", "0.01 s"}}),
                  options("stack.h5"))
                  .status,
              RunStatus::finished);
    const Case c = read_case_text(
        std::string(kBodies) +
            "[initial_state]\nfile = \"stack.h5\"\n[[bonds]]\nname = \"necks\"\n" +
            "initial_state = true\ntensile_strength = \"1 MPa\"\nshear_strength = \"1 MPa\"\n" +
            section,
        "c.toml", path(""));
    ASSERT_EQ(c.model.bonds.size(), first.model.bonds.size());
    EXPECT_EQ(c.model.beams[0].length, first.model.beams[0].length);
    EXPECT_EQ(c.model.beams[0].section.area, first.model.beams[0].section.area);
    EXPECT_EQ(read_case_text(c.resolved, "again", path("")).resolved, c.resolved);
  }
}

// What broke had reached its own strength, and hardly more.
TEST_F(BondRun, EachBondBreaksAtItsOwnStrength) {
  std::string text = joined("inlet = \"mold\"\nweibull_modulus = 2");
  const Case c = read(text);
  ASSERT_EQ(run(c, options("scatter.h5")).status, RunStatus::finished);
  const std::vector<BondOutcome> outcomes = bond_outcomes(Recording(path("scatter.h5")));
  ASSERT_EQ(outcomes.size(), c.model.bonds.size());
  int broken = 0;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    if (!outcomes[k].is_broken()) continue;
    ++broken;
    const double strength = 60e3 * c.model.bonds[k].strength;
    EXPECT_GT(outcomes[k].stress, strength);
    EXPECT_LT(outcomes[k].stress, 1.2 * strength + 5e3);
  }
  EXPECT_GT(broken, 1);
}

// The row breaks at one time or another; stages begin before, between and after.
TEST_F(BondRun, BreaksAreCountedSinceEachStage) {
  for (const char* duration : {"0.05 s", "0.13 s", "0.16 s", "0.3 s", "9 s"}) {
    SCOPED_TRACE(duration);
    const std::string stages = "[[stages]]\nname = \"fall\"\nmax_duration = \"" +
                               std::string(duration) +
                               "\"\n[[stages]]\nname = \"all at rest\"\nmax_duration = \"9 s\"\n";
    const RunSummary summary = run(read(joined() + stages), options("stages.h5"));
    ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
    const auto response = [&](const std::string& name) {
      for (const Response& r : summary.responses)
        if (r.name == name) return r.value;
      return std::vector<double>{};
    };
    const Recording recording(path("stages.h5"));
    const std::vector<StageRecord> begun = recording.stages();
    const std::vector<double> breaks = response("bond_breaks"),
                              since = response("bonds_broken_count_since_all_at_rest");
    ASSERT_FALSE(breaks.empty());
    ASSERT_EQ(since.size(), 1u);
    EXPECT_TRUE(response("bonds_broken_count_since_fall").empty());
    if (begun.size() < 2) {
      EXPECT_TRUE(std::isnan(since[0]));
      continue;
    }
    double later = 0;
    for (const double time : breaks) later += time >= begun[1].start ? 1 : 0;
    EXPECT_EQ(since[0], later);
  }
}

// Two rows of cubes fall across an edge: some bridges break. Interrupted on the way, the file is
// the same.
TEST_F(BondRun, BreaksAreKeptAndResumedBitForBit) {
  const Case c = read(joined());
  const std::string whole = path("whole.h5"), parts = path("parts.h5"),
                    folder = directory_.string();
  const RunSummary summary = run(c, options("whole.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;

  std::atomic<bool> stop = false;
  RunOptions interrupted = options("parts.h5");
  interrupted.interrupt = &stop;
  interrupted.each_step = [&](const Solver& solver, bool) { stop = solver.time() > 0.15; };
  ASSERT_EQ(run(c, interrupted).status, RunStatus::interrupted);
  ASSERT_EQ(resume(parts, options("parts.h5")).status, RunStatus::finished);

  const Recording one(whole), other(parts);
  const std::vector<BondOutcome> a = bond_outcomes(one), b = bond_outcomes(other);
  ASSERT_EQ(a.size(), 6u);
  int broken = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].mode, b[k].mode);
    EXPECT_EQ(a[k].name, "bridges");
    if (std::isnan(a[k].time)) continue;
    ++broken;
    EXPECT_EQ(a[k].time, b[k].time);
    EXPECT_EQ(a[k].position, b[k].position);
    EXPECT_GT(a[k].stress, 60e3);
  }
  EXPECT_GT(broken, 0);
  EXPECT_EQ(one.series("/energy/dissipated_bonds"), other.series("/energy/dissipated_bonds"));
  EXPECT_EQ(one.series("/energy/kinetic"), other.series("/energy/kinetic"));
  EXPECT_GT(one.series("/energy/dissipated_bonds").back(), 0);

  const auto response = [&](const std::string& name) {
    for (const Response& r : summary.responses)
      if (r.name == name) return r.value;
    return std::vector<double>{};
  };
  EXPECT_EQ(response("bonds_count"), std::vector<double>{6});
  EXPECT_EQ(response("bonds_broken_count"), std::vector<double>{static_cast<double>(broken)});
  EXPECT_EQ(response("bond_breaks").size(), static_cast<std::size_t>(broken));

  // A bridge is drawn between its bodies while it holds.
  const Frame first = one.frame(1);
  const std::vector<BondBox> bridges = intact_bonds_at(c, a, one.frame_times()[1], first);
  ASSERT_EQ(bridges.size(), 3u);
  EXPECT_NEAR(bridges[0].position.x(), 0.5 * (first.position[0][0] + first.position[1][0]), 1e-4);
  export_csv(one, folder);
  export_vtk(one, folder, {});
  EXPECT_TRUE(std::filesystem::exists(folder + "/bonds.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/bonds.pvd"));
}

// Cubes that come frozen to a ceiling in two batches of two, and the floor below.
std::string frozen_cubes(const std::string& bond, const std::string& more = "") {
  std::string text = kBodies;
  text.resize(text.find("# An edge"));
  return text + R"([[boundaries]]
name = "ceiling"
kind = "box"
material = "ice"
size = "100 100 10 mm"
position = "0 0 150 mm"
[[inlets]]
name = "mold"
shape = "cube"
position = "0 0 134 mm"
grid = [2, 1, 1]
spacing = "25 1 1 mm"
interval = "0.2 s"
batches = 2
)" + more +
         "[[bonds]]\nname = \"frozen\"\n" + bond + kBridge;
}
constexpr const char* kToCeiling = R"(
inlet = "mold"
boundary = "ceiling"
position = "0 0 9 mm"
direction = [0, 0, 1]
lifetime = "50 ms"
)";

TEST(FrozenCase, EachBodyOfAnInletIsJoinedToTheBoundary) {
  const Case c = read(frozen_cubes(kToCeiling));
  ASSERT_EQ(c.model.bonds.size(), 4u);
  for (int k = 0; k < 4; ++k) {
    const Bond& bond = c.model.bonds[index(k)];
    EXPECT_EQ(bond.a, k);
    EXPECT_EQ(bond.b, 4 + 1);  // the second boundary
    EXPECT_LT((bond.end_a - Vec3(0, 0, 6.5e-3)).norm(), 1e-12);
    EXPECT_NEAR(end_on_boundary(c.model, bond).z(), 145.5e-3, 1e-12);
  }
  EXPECT_DOUBLE_EQ(c.model.beams[0].lifetime, 0.05);
  EXPECT_DOUBLE_EQ(c.model.beams[0].young_modulus, 1e7);  // the ice's
  EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
  EXPECT_EQ(read(joined()).model.beams[0].lifetime, std::numeric_limits<double>::infinity());
}

// On the floor, by number; the axis is along gravity.
TEST(FrozenCase, ParticlesStandOnTheBoundary) {
  const std::string text = std::string(kBodies) + R"(
[[particles]]
shape = "cube"
position = "-60 0 10 mm"
[[particles]]
shape = "cube"
position = "-20 0 10 mm"
[[bonds]]
name = "frozen"
particles = [1]
boundary = "floor"
position = "0 0 -9 mm"
)" + kBridge;
  const Case c = read(text);
  ASSERT_EQ(c.model.bonds.size(), 1u);
  const Bond& bond = c.model.bonds[0];
  EXPECT_EQ(bond.a, 1);
  EXPECT_LT((bond.axes_a * Vec3::UnitX() + Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((end_on_boundary(c.model, bond) - Vec3(-20e-3, 0, -1.5e-3)).norm(), 1e-12);
  EXPECT_EQ(read_case_text(c.resolved, "again", ".").resolved, c.resolved);
  const auto with = [&](const char* particles) {
    std::string changed = text;
    return changed.replace(changed.find("particles = [1]"), 15, particles);
  };
  EXPECT_THAT(complaint(with("particles = [2]")),
              HasSubstr("no body of [[particles]] has the number 2; expected exactly one"));
  EXPECT_THAT(complaint(with("particles = [1, 1]")), HasSubstr("joins 1 twice"));
  EXPECT_THAT(complaint(with("particles = []")), HasSubstr("is empty; expected numbers"));
  EXPECT_THAT(complaint(with("tags = [[0, 1]]")), HasSubstr("expected inlet or particles"));
  EXPECT_THAT(complaint(with("")), HasSubstr("expected exactly one of inlet, particles"));
}

TEST(FrozenCase, BoundariesThatMoveAreRefusedInOneLine) {
  const auto refusal = [](const std::string& more, const std::string& boundary = "belt") {
    std::string text = frozen_cubes(kToCeiling, R"([[boundaries]]
name = "belt"
kind = "box"
material = "ice"
size = "100 100 10 mm"
position = "0 0 190 mm"
)" + more);
    text.replace(text.find("boundary = \"ceiling\""), 20, "boundary = \"" + boundary + "\"");
    return complaint(text);
  };
  using testing::MatchesRegex;
  EXPECT_THAT(
      refusal("[[boundaries.motions]]\nkind = \"translation\"\nvelocity = \"1 0 0 m/s\"\n"),
      MatchesRegex("bonds.toml:[0-9]+: bonds.frozen.boundary: \"belt\" has motions; expected "
                   "one without motion frame and motions, which no stage moves or removes"));
  EXPECT_THAT(refusal("motion_frame = \"carrier\"\n[[motion_frames]]\nname = \"carrier\"\n"),
              HasSubstr("\"belt\" is on the motion frame \"carrier\"; expected"));
  const std::string stage = "[[stages]]\nname = \"melt\"\nmax_duration = \"0.1 s\"\n";
  EXPECT_THAT(refusal(stage + "remove_boundaries = [\"belt\"]\n"),
              HasSubstr("\"belt\" is removed by the stage \"melt\""));
  EXPECT_THAT(refusal(stage + "[[stages.motions]]\nboundary = \"belt\"\nkind = \"translation\"\n"
                              "velocity = \"1 0 0 m/s\"\n"),
              HasSubstr("\"belt\" is moved by the stage \"melt\""));
  EXPECT_THAT(refusal("", "roof"), HasSubstr("bonds.frozen.boundary"));
}

TEST(FrozenCase, KeysThatDoNotFitAreRefused) {
  const auto refusal = [](const std::string& keys) {
    return complaint(frozen_cubes("inlet = \"mold\"\n" + keys));
  };
  EXPECT_THAT(refusal("direction = [0, 0, 1]"),
              HasSubstr("bonds.frozen.direction: is a key of bonds to a boundary"));
  EXPECT_THAT(refusal("particles = [0]"), HasSubstr("expected boundary with it"));
  EXPECT_THAT(refusal("boundary = \"ceiling\"\nmold = \"ceiling\""),
              HasSubstr("expected a radius, or width and height"));
  EXPECT_THAT(refusal("boundary = \"ceiling\"\nposition = \"0 0 9 mm\"\n"
                      "direction = [0, 0, 1]\nheight_direction = [0, 0, 1]"),
              HasSubstr("runs along the bridge from particle 0 to boundary \"ceiling\""));
  // Downwards, where the ceiling is not.
  EXPECT_THAT(refusal("boundary = \"ceiling\"\n"), HasSubstr("mm off boundary \"ceiling\""));
  EXPECT_THAT(refusal("boundary = \"ceiling\"\nlifetime = \"0 s\"\nposition = \"0 0 9 mm\"\n"
                      "direction = [0, 0, 1]"),
              HasSubstr("bonds.frozen.lifetime"));
  std::string weightless = frozen_cubes("inlet = \"mold\"\nboundary = \"ceiling\"\n");
  weightless.replace(weightless.find("duration"), 8, "gravity = \"0 0 0 m/s^2\"\nduration");
  EXPECT_THAT(complaint(weightless), HasSubstr("missing in a case without gravity"));
}

// Each batch hangs for the lifetime, then falls; the same when interrupted while bonds hold.
TEST_F(BondRun, BondsEndAfterTheirLifetimeAndAreNotBroken) {
  const Case c = read(frozen_cubes(kToCeiling));
  const RunSummary summary = run(c, options("whole.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  std::atomic<bool> stop = false;
  RunOptions interrupted = options("parts.h5");
  interrupted.interrupt = &stop;
  interrupted.each_step = [&](const Solver& solver, bool) { stop = solver.time() > 0.22; };
  ASSERT_EQ(run(c, interrupted).status, RunStatus::interrupted);
  ASSERT_EQ(resume(path("parts.h5"), options("parts.h5")).status, RunStatus::finished);

  const Recording one(path("whole.h5")), other(path("parts.h5"));
  const std::vector<BondOutcome> outcomes = bond_outcomes(one), resumed = bond_outcomes(other);
  ASSERT_EQ(outcomes.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const BondOutcome& bond = outcomes[k];
    EXPECT_EQ(bond.mode, "lifetime");
    EXPECT_FALSE(bond.is_broken());
    EXPECT_EQ(bond.b, -1 - 1);
    EXPECT_EQ(bodies_text(c.model, bond), fmt::format("particle {} and boundary \"ceiling\"", k));
    EXPECT_NEAR(bond.time - one.insert_time()[k], 0.05, 0.51 * c.model.timestep);
    EXPECT_TRUE(std::isnan(bond.stress));
    EXPECT_NEAR(bond.position.z(), 143e-3, 1e-4);
    EXPECT_EQ(bond.time, resumed[k].time);
    EXPECT_EQ(bond.position, resumed[k].position);
  }
  for (const char* series : {"/energy/kinetic", "/energy/dissipated_bonds"})
    EXPECT_EQ(one.series(series), other.series(series));
  EXPECT_GT(one.series("/energy/dissipated_bonds").back(), 0);
  const auto response = [&](const std::string& name) {
    for (const Response& r : summary.responses)
      if (r.name == name) return r.value;
    return std::vector<double>{};
  };
  EXPECT_EQ(response("bonds_count"), std::vector<double>{4});
  EXPECT_EQ(response("bonds_broken_count"), std::vector<double>{0});
  EXPECT_EQ(response("bonds_broken_by_mode"), std::vector<double>(4, 0));
  EXPECT_TRUE(response("bond_breaks").empty());

  // Drawn between cube and ceiling while it holds.
  const std::vector<double> times = one.frame_times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto within = [&](double from, double to) {
      return times[i] > from + 1e-4 && times[i] < to - 1e-4;
    };
    const std::size_t drawn = intact_bonds_at(c, outcomes, times[i], one.frame(i)).size();
    if (within(0, 0.05) || within(0.2, 0.25)) {
      EXPECT_EQ(drawn, 2u) << times[i];
    }
    if (within(0.05, 0.2) || within(0.25, 1)) {
      EXPECT_EQ(drawn, 0u) << times[i];
    }
  }
  export_csv(one, directory_.string());
  export_vtk(one, directory_.string(), {});
  EXPECT_THAT(test::read_text(path("bonds.csv")), HasSubstr("0,frozen,0,-2,lifetime,0.0"));

  // A file whose boundaries the case does not have.
  std::filesystem::copy_file(path("parts.h5"), path("damaged.h5"));
  test::ResultsMutator(path("damaged.h5"), [](std::size_t) {
    return std::size_t{0};
  }).overwrite("/bonds/b", 1, 1, -3);
  EXPECT_THAT(test::error_of([&] { read_case(Recording(path("damaged.h5"))); }),
              HasSubstr("/bonds/b: entry 1 is -3; expected -2 or more"));
}

}  // namespace
}  // namespace firn
