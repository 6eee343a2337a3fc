#include "reports/rendering/mesh_renderer.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_heap.h"

namespace firn {
namespace {

TEST(View, UnprojectUndoesProject) {
  const View parallel =
      View::parallel(Vec3(0, 0, 1), Vec3(1, 2, -1).normalized(), Vec3::UnitZ(), 2, 1);
  const View perspective = View::perspective(Vec3(0, -3, 2), Vec3(0, 0, 0), Vec3::UnitZ(), 2, 1);
  for (const View& view : {parallel, perspective}) {
    for (const Vec3& p : {Vec3(0.1, 0.2, 0.3), Vec3(-0.4, 0.1, 0)}) {
      EXPECT_LT((view.unproject(view.project(p)) - p).norm(), 1e-12);
    }
  }
}

TEST(View, PerspectiveShrinksWithDistance) {
  const View view = View::perspective(Vec3(0, -2, 0), Vec3::Zero(), Vec3::UnitZ(), 1, 1);
  EXPECT_NEAR(view.project(Vec3(0.25, 0, 0)).x(), 0.75, 1e-12);  // the target's distance: true size
  EXPECT_NEAR(view.project(Vec3(0.25, 2, 0)).x(), 0.625, 1e-12);  // twice as far: half as large
  EXPECT_GT(view.project(Vec3(0, 0, 0)).z(), view.project(Vec3(0, 1, 0)).z());
}

// A point has the place in the part that it has in the whole, and pictures of parts are undone,
// too.
TEST(View, PartsShowWhatTheWholeShows) {
  const View parallel =
      View::parallel(Vec3(0, 0, 1), Vec3(1, 2, -1).normalized(), Vec3::UnitZ(), 2, 1);
  const View perspective = View::perspective(Vec3(0, -3, 2), Vec3(0, 0, 0), Vec3::UnitZ(), 2, 1);
  const Eigen::AlignedBox2d box(Eigen::Vector2d(0.1, -0.2), Eigen::Vector2d(0.4, 0.7));
  const Eigen::AlignedBox2d inner(Eigen::Vector2d(0.5, 0.25), Eigen::Vector2d(1, 0.5));
  for (const View& view : {parallel, perspective}) {
    const View part = view.cropped(box), twice = part.cropped(inner);
    EXPECT_NEAR(part.height_over_width(), view.height_over_width() * 0.9 / 0.3, 1e-12);
    for (const Vec3& p : {Vec3(0.1, 0.2, 0.3), Vec3(-0.4, 0.1, 0)}) {
      const Vec3 whole = view.project(p), cut = part.project(p);
      EXPECT_NEAR(box.min().x() + 0.3 * cut.x(), whole.x(), 1e-12);
      EXPECT_NEAR(box.min().y() + 0.9 * cut.y(), whole.y(), 1e-12);
      EXPECT_EQ(cut.z(), whole.z());
      EXPECT_NEAR(0.5 + 0.5 * twice.project(p).x(), cut.x(), 1e-12);
      EXPECT_LT((part.unproject(cut) - p).norm(), 1e-12);
      EXPECT_LT((twice.unproject(twice.project(p)) - p).norm(), 1e-12);
    }
  }
}

// A red cube of 0.5 m before a green wall, seen along +y in a frame of 1 m.
Image cube_before_wall(bool with_cube, const Color& background = {1, 1, 1}) {
  const TriangleMesh cube = synthetic::box_mesh({0.5, 0.5, 0.5});
  const TriangleMesh wall = synthetic::box_mesh({0.9, 0.1, 0.9});
  Scene scene;
  scene.background = background;
  scene.bodies.push_back({{&wall, {Mat3::Identity(), Vec3(0, 1, 0)}}, {0, 1, 0}});
  if (with_cube) scene.bodies.push_back({{&cube, {}}, {1, 0, 0}});
  return render(scene, View::parallel(Vec3::Zero(), Vec3::UnitY(), Vec3::UnitZ(), 1, 1), 40);
}

TEST(Render, NearerBodiesHideFartherOnes) {
  const Image image = cube_before_wall(true);
  ASSERT_EQ(image.width, 40);
  ASSERT_EQ(image.height, 40);
  const auto at = [&](int x, int y) { return image.pixels[static_cast<std::size_t>(y * 40 + x)]; };
  EXPECT_GT(at(20, 20)[0], 3 * at(20, 20)[1]);  // cube
  EXPECT_GT(at(5, 20)[1], 3 * at(5, 20)[0]);    // wall
  EXPECT_EQ(at(0, 0)[0], 255);                  // background
  EXPECT_GT(cube_before_wall(false).pixels[20 * 40 + 20][1], 100);
}

TEST(Render, FacesTurnedToTheLightAreBrighter) {
  const TriangleMesh cube = synthetic::box_mesh({1, 1, 1});
  Scene scene;
  scene.bodies.push_back({{&cube, {}}, {0.5f, 0.5f, 0.5f}});
  const auto brightness = [&](const Vec3& to_light) {
    scene.to_light = to_light.normalized();
    const View view = View::parallel(Vec3::Zero(), Vec3::UnitY(), Vec3::UnitZ(), 0.5, 0.5);
    return render(scene, view, 8).pixels[8 * 4 + 4][0];
  };
  EXPECT_GT(brightness(Vec3(0, -1, 0.2)), brightness(Vec3(0, -0.2, 1)) + 20);
}

TEST(Render, ShadowsFallAwayFromTheLight) {
  const TriangleMesh floor = synthetic::box_mesh({2, 2, 0.1}),
                     cube = synthetic::box_mesh({0.4, 0.4, 0.4});
  Scene scene;
  scene.to_light = Vec3(-1, 0, 1).normalized();
  scene.bodies.push_back({{&floor, {Mat3::Identity(), Vec3(0, 0, -0.05)}}, {0.6f, 0.6f, 0.6f}});
  scene.bodies.push_back({{&cube, {Mat3::Identity(), Vec3(0, 0, 0.2)}}, {0.6f, 0.6f, 0.6f}});
  const Image image =
      render(scene, View::parallel(Vec3::Zero(), -Vec3::UnitZ(), Vec3::UnitY(), 2, 2), 100);
  const auto at_x = [&](double x) {
    return image.pixels[static_cast<std::size_t>(50 * 100 + 50 * (1 + x))][0];
  };
  EXPECT_GT(at_x(-0.4), at_x(0.4) + 30);  // the shadow reaches from 0.2 to 0.6
  EXPECT_NEAR(at_x(-0.8), at_x(0.8), 2);
}

}  // namespace
}  // namespace firn
