#include "reports/rendering/contact_picture.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

// Two balls, one on the other, on a floor of the name "tray".
Case tower() {
  Case c;
  c.name = "tower of balls";
  const Shape ball = make_sphere(0.01, scenes::ice_options(0.004, 2e4, -1));
  c.model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(c.model, scenes::add_shape(c.model, ball), 2);
  scenes::add_plane(c.model, Vec3::Zero(), Vec3::UnitZ());
  c.model.boundaries[0].name = "tray";
  c.model.timestep = 1e-5;
  return c;
}

Solver standing(const Case& c) {
  Solver solver(c.model);
  solver.insert(0, {0, 0, 0.01}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  solver.insert(1, {0, 0, 0.03}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, 0.01);
  return solver;
}

std::string text_of(const std::string& file) {
  const std::string text = test::read_text(file);
  std::filesystem::remove(file);
  return text;
}

TEST(ContactPicture, NamesNeighborsAndTheirForces) {
  const Case c = tower();
  const Solver solver = standing(c);
  const std::string file = test::scratch_path("contacts.svg");
  draw_contacts(c, {0, -1}, take_snapshot(solver, {0, -1}, 5, "--particle"), file, 120);
  const std::string drawn = text_of(file);
  EXPECT_THAT(drawn, HasSubstr("tower of balls: particle 0"));
  for (const ContactView& v : select_contacts(solver, {0, -1})) {
    const std::string name = v.neighbor() == 2 ? "tray" : "1";
    EXPECT_THAT(drawn, HasSubstr(fmt::format("{}: {:.3g} N", name, v.contact.normal_force)));
  }
  // A pair whose first body is the boundary: the particle is drawn whole all the same.
  draw_contacts(c, {2, 0}, take_snapshot(solver, {2, 0}, 5, "--pair"), file, 120);
  const std::string pair = text_of(file);
  EXPECT_THAT(pair, HasSubstr("arrows push on particle 0"));
  EXPECT_THAT(pair, Not(HasSubstr("1: ")));
}

TEST(ContactPicture, HistoryHasAllItsAxes) {
  const Case c = tower();
  Solver solver(c.model);
  solver.insert(0, {0, 0, 0.0101}, Quat::Identity(), {0, 0, -0.5}, Vec3::Zero());
  ContactHistory history({0, 2}, 10);
  for (int i = 0; i < 500; ++i) {
    history.add_step(solver, false);
    solver.step();
  }
  const std::string file = test::scratch_path("history.svg");
  draw_history(c, {0, 2}, history.rows(), file);
  const std::string drawn = text_of(file);
  for (const char* axis : {"force / N", "work / µJ", "time / ms", "deepest overlap / µm"})
    EXPECT_THAT(drawn, HasSubstr(axis));
  EXPECT_THAT(drawn, HasSubstr("particle 0 and tray"));
}

TEST(ContactPicture, OtherFormatsAreRefused) {
  const Case c = tower();
  const Solver solver = standing(c);
  const ContactSnapshot now = take_snapshot(solver, {0, -1}, 5, "--particle");
  EXPECT_THROW(draw_contacts(c, {0, -1}, now, "contacts.gif"), InputError);
  EXPECT_THROW(draw_history(c, {0, -1}, {HistoryRow{}}, "history.gif"), InputError);
}

}  // namespace
}  // namespace firn
