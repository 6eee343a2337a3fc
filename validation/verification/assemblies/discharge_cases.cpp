// What runs out of a slot.
#include <fmt/format.h>

#include <cmath>

#include "validation/verification/assemblies/bulk_cases.h"
#include "validation/verification/fixtures/bulk_scenes.h"

namespace firn::verification {
namespace {

using namespace scenes;

// A flat-bottomed bin with a slot over its whole depth. Panels close the slot; nested ones, so that
// one filling serves every width.
struct Slots {
  double wide = 20 * kDie, deep = 4 * kDie;                               // m
  std::vector<double> widths = {5 * kDie, 6 * kDie, 7 * kDie, 9 * kDie};  // m, ascending
  std::vector<std::vector<int>> doors;                                    // to remove, by width
};

Dice balls() {
  Dice d;
  d.faces = 0;
  d.friction = d.wall_friction = 0.3;
  d.hardness = 3000;
  return d;
}

Model slot_model(Slots& slots, int particles) {
  Model model = dice_model(balls());
  add_particles(model, 0, particles);
  for (int axis = 0; axis < 2; ++axis) {
    const double half = 0.5 * (axis == 0 ? slots.wide : slots.deep);
    add_plane(model, -half * Vec3::Unit(axis), Vec3::Unit(axis));
    add_plane(model, half * Vec3::Unit(axis), -Vec3::Unit(axis));
  }
  const double thick = 0.5 * kDie;
  const auto panel = [&](double from, double to) {
    const int b = add_panel(model, fmt::format("floor {:.3f}", from), {from, -slots.deep, -thick},
                            {to, slots.deep, 0}, 0.02 * kDie);
    model.boundaries[b].rigid = true;
    return b;
  };
  double inner = 0;
  for (const double width : slots.widths) {
    const double outer = width / 2;
    if (inner == 0) {
      slots.doors.push_back({panel(-outer, outer)});
    } else {
      slots.doors.push_back({panel(-outer, -inner), panel(inner, outer)});
    }
    inner = outer;
  }
  panel(-slots.wide, -inner);
  panel(inner, slots.wide);
  model.timestep = advise_timestep(model, 7).timestep;
  return model;
}

Solver filled(const Model& model, const Slots& slots, std::uint64_t seed) {
  Solver solver(model);
  const int count = static_cast<int>(model.particles.size());
  const Vec3 room(slots.wide / 2 - 0.5 * kDie, slots.deep / 2 - 0.5 * kDie, 0);
  const double tall = count * 4 * kDie * kDie * kDie / (slots.wide * slots.deep);
  scatter(solver, 0, count, Vec3(-room.x(), -room.y(), 0.6 * kDie), Vec3(room.x(), room.y(), tall),
          seed);
  run(solver, std::sqrt(2 * tall / kGravity) + 0.3);
  return solver;
}

// Mass that has passed the slot, by time; bodies leave the simulation below it.
struct Discharge {
  std::vector<double> time, mass;             // s, kg, every `kEvery`
  double rate(double from, double to) const;  // kg/s between two masses
};

double Discharge::rate(double from, double to) const {
  double t[2] = {0, 0}, m[2] = {0, 0};
  for (std::size_t i = 0; i < mass.size() && m[1] < to; ++i) {
    const int end = mass[i] < from ? 0 : 1;
    t[end] = time[i];
    m[end] = mass[i];
  }
  return (m[1] - m[0]) / (t[1] - t[0]);
}

Discharge discharge(Solver solver, const Slots& slots, int width, double until) {
  for (int w = 0; w <= width; ++w) {
    for (const int door : slots.doors[w]) solver.remove_boundary(door);
  }
  const double each = solver.model().shapes[0].mass, begin = solver.time();
  Discharge out;
  double passed = 0;
  std::vector<char> counted(solver.model().particles.size(), 0);
  while (passed < until && solver.time() < begin + 10) {
    run(solver, 2e-3);
    const ParticleState now = solver.particles();
    for (std::size_t p = 0; p < counted.size(); ++p) {
      if (now.presence[p] != Presence::present) continue;
      const double z = now.position[p].z();
      if (!counted[p] && z < -0.5 * kDie) {
        counted[p] = 1;
        passed += each;
      }
      if (z < -3 * kDie) solver.remove_particle(static_cast<int>(p));
    }
    out.time.push_back(solver.time() - begin);
    out.mass.push_back(passed);
  }
  return out;
}

Solver restored(const Model& model, const std::vector<std::byte>& bytes) {
  Solver solver(model);
  solver.restore(bytes);
  return solver;
}

// Rates (kg/s) of the same discharged masses from two fillings, one value a seed.
struct DischargeRates {
  Slots slots;
  std::vector<double> low;                    // of the third slot, short filling
  std::vector<std::vector<double>> by_width;  // of all slots, tall filling
};

DischargeRates discharge_rates() {
  const double each = die_mass(balls());
  const int kShort = 1200, kTall = 2000;
  const double from = 150 * each, to = 500 * each;
  DischargeRates r;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Slots small, large;
    const Model short_model = slot_model(small, kShort), tall_model = slot_model(large, kTall);
    r.slots = small;
    r.low.push_back(discharge(filled(short_model, small, seed), small, 2, to).rate(from, to));
    const Solver full = filled(tall_model, large, seed + 10);
    const auto bytes = full.save();
    r.by_width.resize(r.slots.widths.size());
    for (int w = 0; w < static_cast<int>(r.slots.widths.size()); ++w) {
      r.by_width[w].push_back(discharge(restored(tall_model, bytes), large, w, to).rate(from, to));
    }
  }
  return r;
}

// W^(2/3) = c^(2/3) (D - k d): a straight line in D.
struct BeverlooLine {
  double slope = 0, zero = 0;  // zero: k d, m
  double rate(double width) const { return std::pow(slope * (width - zero), 1.5); }
};

BeverlooLine beverloo_line(const DischargeRates& r) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t w = 0; w < r.slots.widths.size(); ++w) {
    const double x = r.slots.widths[w], y = std::pow(mean(r.by_width[w]), 2.0 / 3);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, (sx - sy / slope) / n};  // mean D minus mean y over slope
}

std::vector<Check> discharge_case() {
  const DischargeRates rates = discharge_rates();
  std::vector<Check> checks;
  const SampleStatistics a = sample_statistics(rates.low), b = sample_statistics(rates.by_width[2]);
  checks.push_back({.what = "rate from the tall filling / from the short one",
                    .measured = b.mean / a.mean,
                    .expected = 1,
                    .tolerance = 0.03 + 4 * std::hypot(a.error() / a.mean, b.error() / b.mean),
                    .bound = Bound::absolute});
  const BeverlooLine line = beverloo_line(rates);
  for (std::size_t w = 0; w < rates.slots.widths.size(); ++w) {
    const SampleStatistics rate = sample_statistics(rates.by_width[w]);
    const double expected = line.rate(rates.slots.widths[w]);
    checks.push_back({.what = fmt::format("slot of {:.1f} d: rate compared with Beverloo's line",
                                          rates.slots.widths[w] / kDie),
                      .measured = rate.mean,
                      .expected = expected,
                      .tolerance = 0.02 * expected + 3 * rate.error(),
                      .bound = Bound::absolute,
                      .unit = "kg/s"});
  }
  checks.push_back({.what = "empty annulus k, in diameters",
                    .measured = line.zero / kDie,
                    .expected = 1.5,
                    .tolerance = 0.7,
                    .bound = Bound::absolute});
  const double density = 0.58 * 1000;
  // The empty annulus lies along all four sides.
  const double open_depth = rates.slots.deep - line.zero;
  checks.push_back(
      {.what = "C of W = C rho sqrt(g) (L - k d) (D - k d)^(3/2)",
       .measured = std::pow(line.slope, 1.5) / (density * std::sqrt(kGravity) * open_depth),
       .expected = 1.03,
       .tolerance = 0.3,
       .bound = Bound::absolute});
  return checks;
}

}  // namespace

std::vector<VerificationCase> discharge_cases() {
  return {
      {.name = "bulk.discharge",
       .title = "Discharge through a slot",
       .reference =
           "rate independent of the height of filling; Beverloo, Leniger and van de Velde "
           "1961, for a slot W = C rho sqrt(g) (L - k d) (D - k d)^(3/2), C about 1.03, k 1 to 2",
       .remark =
           "Spheres of friction 0.3 in a bin of 20 by 4 diameters; the same 350 bodies (the 150th "
           "to "
           "the 500th) from 1200 and from 2000; slots of 5 to 9 diameters. Two "
           "numbers (C and k) are fitted to the four widths. Tolerances: standard errors over 3 "
           "seeds, and 2 or 3 % for counting 350 bodies.",
       .tier = Tier::full,
       .run = discharge_case}};
}

}  // namespace firn::verification
