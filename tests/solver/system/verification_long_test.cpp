// Beds: minutes of computing, against themselves. The verification suite holds the closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <future>

#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

// 100 crescents fall into a narrow box.
Solver fill(double contact_update_fraction, double duration, std::uint64_t seed) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), 100);
  scenes::add_box_of_planes(model, Vec3::Zero(), {0.16, 0.14, 0});
  model.timestep = 1e-5;
  model.numerics.contact_update_fraction = contact_update_fraction;
  Solver solver(model);
  scenes::scatter(solver, 0, 100, Vec3::Zero(), {0.16, 0.14, 0.7}, seed);
  scenes::run(solver, duration);
  return solver;
}

// Searching for every contact at every step and searching when contacts can have changed give the
// same physics. Single trajectories part after a few impacts, so beds from the same starts are
// compared in the mean: a difference beyond three standard errors and half a percent is one of
// physics.
struct Bed {
  double kinetic = 0, gravitational = 0, dissipated = 0;  // J
};

std::vector<Bed> beds(double contact_update_fraction, double duration) {
  std::vector<std::future<Bed>> running;
  for (std::uint64_t seed = 21; seed < 27; ++seed) {
    running.push_back(std::async(std::launch::async, [=] {
      const Energy e = fill(contact_update_fraction, duration, seed).energy();
      return Bed{e.kinetic, e.gravitational, e.dissipated_normal + e.dissipated_friction};
    }));
  }
  std::vector<Bed> out;
  for (auto& bed : running) out.push_back(bed.get());
  return out;
}

void expect_alike(const std::vector<Bed>& a, const std::vector<Bed>& b, double Bed::*quantity) {
  const double n = static_cast<double>(a.size());
  double mean = 0, difference = 0, scatter = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean += a[i].*quantity / n;
    difference += (b[i].*quantity - a[i].*quantity) / n;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = b[i].*quantity - a[i].*quantity - difference;
    scatter += d * d;
  }
  const double error = std::sqrt(scatter / (n * (n - 1)));
  EXPECT_LT(error, 0.02 * mean);  // more scatter would hide a difference
  EXPECT_LT(std::abs(difference), 0.005 * mean + 3 * error)
      << "mean " << mean << ", difference " << difference << " ± " << error;
}

TEST(ContactToleranceLong, PlainPathAndDefaultAgreeOnFallingAndSettledBeds) {
  for (const double duration : {0.25, 0.7}) {
    SCOPED_TRACE(duration);
    const std::vector<Bed> plain = beds(0, duration);
    const std::vector<Bed> skipping = beds(Model{}.numerics.contact_update_fraction, duration);
    expect_alike(plain, skipping, &Bed::gravitational);
    expect_alike(plain, skipping, &Bed::dissipated);
    if (duration < 0.5) expect_alike(plain, skipping, &Bed::kinetic);
  }
}

// A settled bed keeps still and keeps its energy.
TEST(HoldLong, SettledBedStaysAsItIs) {
  Solver solver = fill(Model{}.numerics.contact_update_fraction, 1.2, 21);
  const Energy before = solver.energy();
  const std::uint64_t late_contacts = solver.diagnostics().late_contacts;
  EXPECT_LT(before.kinetic, 1e-5);
  scenes::run(solver, 0.5);
  const Energy after = solver.energy();
  EXPECT_LT(after.kinetic, 1e-6);
  EXPECT_NEAR(after.gravitational, before.gravitational, 1e-4 * before.gravitational);
  EXPECT_EQ(solver.diagnostics().late_contacts, late_contacts);

  // Contacts are no deeper than the impacts that made them (4 m/s: 0.7 mm), and few are that deep.
  std::vector<double> overlaps = solver.contact_overlaps();
  std::sort(overlaps.begin(), overlaps.end());
  ASSERT_GT(overlaps.size(), 100u);
  const double thickness = solver.model().shapes[0].box.minCoeff();
  EXPECT_LT(overlaps[overlaps.size() / 2], 0.002 * thickness);
  EXPECT_LT(overlaps[overlaps.size() * 98 / 100], 0.015 * thickness);
  EXPECT_LT(overlaps.back(), 0.05 * thickness);
}

// The same outline in 2 to 12 parts: the bed that forms does not know.
TEST(PartsLong, FallingBedDoesNotDependOnTheNumberOfParts) {
  std::vector<double> kinetic;
  for (const int parts : {2, 4, 12}) {
    CrescentParameters p = named_crescent("mass-matched", {}).parameters;
    p.parts = parts;
    Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
    scenes::add_particles(model, scenes::add_shape(model, scenes::crescent(p)), 100);
    scenes::add_box_of_planes(model, Vec3::Zero(), {0.16, 0.14, 0});
    model.timestep = 1e-5;
    Solver solver(model);
    scenes::scatter(solver, 0, 100, Vec3::Zero(), {0.16, 0.14, 0.7}, 21);
    scenes::run(solver, 0.25);
    kinetic.push_back(solver.energy().kinetic);
  }
  for (const double k : kinetic) EXPECT_NEAR(k, kinetic[0], 0.03 * kinetic[0]);
}

}  // namespace
}  // namespace firn
