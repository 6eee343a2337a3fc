// The load on the floor of a bin.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validation/verification/assemblies/bulk_cases.h"
#include "validation/verification/fixtures/bulk_scenes.h"

namespace firn::verification {
namespace {

using namespace scenes;

// A bin of square section whose walls creep upwards, so that friction on them points up and is
// used up everywhere. Loads at growing fillings.
struct Loads {
  double weight = 0, floor = 0, wall_lift = 0, wall_push = 0;  // N, means over a window
  double face_lift = 0, face_push = 0;  // N, of wall contacts of three and more points, sums
  double momentum = 0;                  // N, its growth over the window
};

// Adds the wall contacts on a face, which cannot roll.
void add_face_contacts(const Solver& solver, int first_wall, Loads& sum) {
  for (const Contact& c : solver.contacts()) {
    const auto bears = [](const ContactPointInfo& point) { return point.force > 0; };
    if (c.b < first_wall || std::ranges::count_if(c.points, bears) < 3) continue;
    sum.face_lift += c.friction.z();
    sum.face_push += c.normal_force;
  }
}

std::vector<Loads> janssen_loads(double wall_friction, std::uint64_t seed) {
  constexpr double kWide = 6 * kDie, kCreep = 0.02, kWindow = 0.1;  // m, m/s, s
  constexpr int kStep = 70, kFillings = 8, kSamples = 100;
  Dice dice;
  dice.wall_friction = wall_friction;
  Model model = dice_model(dice);
  add_particles(model, 0, kStep * kFillings);
  add_box_of_planes(model, Vec3::Zero(), {kWide, kWide, 0});
  for (Boundary& wall : model.boundaries) wall.rigid = true;
  for (std::size_t b = 1; b < model.boundaries.size(); ++b) {
    Motion up;
    up.velocity = Vec3(0, 0, kCreep);
    model.boundaries[b].motions = {up};
  }
  model.timestep = advise_timestep(model, 7).timestep;
  Solver solver(model);
  std::vector<Loads> loads;
  for (int k = 0; k < kFillings; ++k) {
    PourOptions rain_on;
    rain_on.upper = Vec3(kWide, kWide, height_below(solver, 1) + 4 * kDie);
    rain_on.step = 0.1 * kDie;
    rain_on.batch = 7;
    rain_on.interval = 0.03;
    rain_on.seed = seed * 100 + k;
    pour(solver, k * kStep, (k + 1) * kStep, rain_on);
    run(solver, 0.15);
    const auto momentum = [&] {
      double sum = 0;
      for (const Vec3& v : solver.particles().velocity) sum += die_mass(dice) * v.z();
      return sum;
    };
    const double before = momentum(), start = solver.time();
    solver.clear_boundary_loads();
    Loads l;
    for (int part = 1; part <= kSamples; ++part) {
      run(solver, kWindow / kSamples);
      if (k == kFillings - 1) add_face_contacts(solver, kStep * kFillings + 1, l);
    }
    const double window = solver.time() - start;  // each part ends at a whole step
    l.weight = (k + 1) * kStep * die_mass(dice) * kGravity;
    l.momentum = (momentum() - before) / window;
    const auto& walls = solver.boundaries();
    l.floor = -walls[0].impulse.z() / window;
    for (std::size_t b = 1; b < walls.size(); ++b) {
      l.wall_lift -= walls[b].impulse.z() / window;
      l.wall_push += std::abs(walls[b].impulse.dot(walls[b].orientation * Vec3::UnitZ())) / window;
    }
    loads.push_back(l);
  }
  return loads;
}

// Janssen (1895): F = S (1 - exp(-W / S)) of weight W, with S = rho g A D / (4 mu K).
double janssen(double weight, double saturation) {
  return saturation * (1 - std::exp(-weight / saturation));
}

// Least squares in S, by golden section.
double fit_saturation(const std::vector<std::vector<Loads>>& runs) {
  const auto misfit = [&](double s) {
    double sum = 0;
    for (const auto& loads : runs) {
      for (const Loads& l : loads) sum += std::pow(l.floor - janssen(l.weight, s), 2);
    }
    return sum;
  };
  double low = 0.1, high = 1000;
  while (high - low > 1e-6 * high) {
    const double a = low + 0.381966 * (high - low), b = low + 0.618034 * (high - low);
    (misfit(a) < misfit(b) ? high : low) = misfit(a) < misfit(b) ? b : a;
  }
  return 0.5 * (low + high);
}

// What the runs of one wall friction give, one value a seed.
struct WallRuns {
  std::vector<std::vector<Loads>> loads;        // of each filling
  std::vector<double> mobilized, deep, deeper;  // friction over push; floor loads near the end
  double unbalanced = 0;                        // largest, of the weight
  double face_lift = 0, face_push = 0;          // sums
};

WallRuns wall_runs(double friction) {
  WallRuns r;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    r.loads.push_back(janssen_loads(friction, seed));
    const std::vector<Loads>& run = r.loads.back();
    for (const Loads& l : run)
      r.unbalanced = std::max(r.unbalanced,
                              std::abs(l.floor + l.wall_lift - l.weight - l.momentum) / l.weight);
    r.mobilized.push_back(run.back().wall_lift / run.back().wall_push);
    r.face_lift += run.back().face_lift;
    r.face_push += run.back().face_push;
    r.deep.push_back(0.5 * (run[run.size() - 4].floor + run[run.size() - 3].floor));
    r.deeper.push_back(0.5 * (run[run.size() - 2].floor + run[run.size() - 1].floor));
  }
  return r;
}

// Root mean square over the fillings of the mean over the seeds, of which the theory is, off
// Janssen's curve.
double janssen_misfit(const WallRuns& r, double saturation) {
  const std::size_t fillings = r.loads[0].size();
  double square = 0;
  for (std::size_t k = 0; k < fillings; ++k) {
    std::vector<double> off;
    off.reserve(r.loads.size());
    for (const auto& loads : r.loads)
      off.push_back(loads[k].floor - janssen(loads[k].weight, saturation));
    square += std::pow(mean(off), 2);
  }
  return std::sqrt(square / static_cast<double>(fillings));
}

// `used_up`: share of the friction on the walls that must act.
void check_walls(double friction, double used_up, const WallRuns& r, double saturation,
                 std::vector<Check>& checks) {
  const std::string at = fmt::format("wall friction {}: ", friction);
  const double weight = r.loads[0].back().weight;
  checks.push_back({.what = at + "floor + walls minus weight and momentum, largest difference",
                    .measured = r.unbalanced,
                    .expected = 1e-3,
                    .bound = Bound::at_most});
  checks.push_back({.what = at + "friction on the walls / push on them",
                    .measured = mean(r.mobilized),
                    .expected = used_up * friction,
                    .bound = Bound::at_least});
  checks.push_back({.what = at + "the same on faces of dice, which do not roll",
                    .measured = r.face_lift / r.face_push,
                    .expected = 0.98 * friction,
                    .bound = Bound::at_least});
  checks.push_back({.what = at + "largest of a seed, no more than Coulomb's",
                    .measured = *std::max_element(r.mobilized.begin(), r.mobilized.end()),
                    .expected = friction * (1 + 1e-6),
                    .bound = Bound::at_most});
  checks.push_back(
      {.what = at + "mean floor load off Janssen's curve, root mean square / saturation",
       .measured = janssen_misfit(r, saturation) / saturation,
       .expected = 0.1,
       .bound = Bound::at_most});
  const SampleStatistics deep = sample_statistics(r.deep), deeper = sample_statistics(r.deeper);
  checks.push_back(
      {.what = at + "growth of the floor load over the last quarter of the filling",
       .measured = deeper.mean - deep.mean,
       .expected = janssen(0.9375 * weight, saturation) - janssen(0.6875 * weight, saturation),
       .tolerance = 4 * std::hypot(deep.error(), deeper.error()),
       .bound = Bound::absolute,
       .unit = "N"});
}

std::vector<Check> janssen_case() {
  std::vector<Check> checks;
  std::vector<double> pressure_ratio;
  double saturation_of_weight = 0;
  // Rough walls roll some of the dice along (see the remark), and S is judged to 10 %.
  for (const auto& [friction, used_up] : {std::pair{0.25, 0.95}, std::pair{0.5, 0.9}}) {
    const WallRuns runs = wall_runs(friction);
    const double s = fit_saturation(runs.loads);
    saturation_of_weight = s / runs.loads[0].back().weight;
    // S = (rho g A) (D / 4) / (mu K) with the friction measured on the walls for mu; rho g A =
    // weight / height, height from the bulk fraction.
    const double line_weight = 0.58 * 1000 * kGravity * std::pow(6 * kDie, 2);
    pressure_ratio.push_back(line_weight * 6 * kDie / 4 / (mean(runs.mobilized) * s));
    check_walls(friction, used_up, runs, s, checks);
  }
  checks.push_back({.what = "ratio of pressures K, wall friction 0.25",
                    .measured = pressure_ratio[0],
                    .expected = 0.6,
                    .tolerance = 0.4,
                    .bound = Bound::absolute});
  checks.push_back({.what = "saturation / weight of the column at wall friction 0.5",
                    .measured = saturation_of_weight,
                    .expected = 0.4,
                    .bound = Bound::at_most});
  checks.push_back({.what = "K at wall friction 0.5 / K at 0.25",
                    .measured = pressure_ratio[1] / pressure_ratio[0],
                    .expected = 1.25,
                    .tolerance = 0.25,
                    .bound = Bound::absolute});
  return checks;
}

}  // namespace

std::vector<VerificationCase> silo_cases() {
  return {
      {.name = "bulk.janssen",
       .title = "Load on the floor of a bin saturates",
       .reference = "Janssen 1895: F = S (1 - exp(-W / S)), S = rho g A D / (4 mu K); Coulomb; "
                    "equilibrium of the column",
       .remark =
           "560 dodecahedra, friction 0.4, in eight fillings; square section of 6 diameters. The "
           "walls creep upwards at 2 cm/s, so that friction on them is used up, as the formula "
           "assumes (after Bertho et al. 2003); 6 seeds at each of two wall frictions. Rough walls "
           "roll dice along on their corners and edges: there friction points sideways or stays "
           "below its limit, on faces it does not. With dice that cannot turn (inertia times 1e7) "
           "no contact sticks and friction points up within 0.1 %; what is then missing, 1 to 2.5 "
           "%, is the stretch of friction springs behind a growing push. S is the one number "
           "fitted. Floor + walls = weight + momentum holds to the step at which "
           "the sums begin and end, 1e-3. Janssen takes K for a constant over the section and "
           "the height: 10 % of S about the curve, for the mean over the seeds. K is that of the "
           "friction measured on the walls. It must lie between the active and the "
           "isotropic state; with wall friction it grows, by Mohr's circle 1 to 1.5 times "
           "between the two walls at internal frictions above 28 degrees. rho from a bulk fraction "
           "of 0.58 (bulk.dice), which cancels in the ratio. 80 s of one core.",
       .tier = Tier::full,
       .run = janssen_case}};
}

}  // namespace firn::verification
