// Cameras in front of a wall, drawn at random.
#include "photo/wall_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/support/error_of.h"
#include "tests/support/heap_photograph.h"

namespace firn {
namespace {

using synthetic::Random;
using testing::HasSubstr;

Vec2 drawn_wall_point(Random& random) {
  return {random.uniform(-0.3, 0.3), random.uniform(0, 0.25)};
}

std::vector<WallPoint> seen_points(const synthetic::TestCamera& camera,
                                   const std::vector<Vec2>& on_wall) {
  const double front = -synthetic::drained_box().box.y() / 2;
  std::vector<WallPoint> points;
  for (const Vec2& p : on_wall) points.push_back({camera.pixel({p.x(), front, p.y()}), p});
  return points;
}

std::string refusal(const std::vector<WallPoint>& points) {
  return test::error_if_any([&] { WallCamera(Lens{}, points); });
}

const std::vector<Vec2> kCorners{{-0.3, 0}, {0.3, 0}, {0.3, 0.25}, {-0.3, 0.25}};

TEST(WallCamera, CornersDetermineEveryPointOfTheWall) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    const synthetic::TestCamera camera = synthetic::random_session(random).camera;
    std::vector<Vec2> on_wall = kCorners;
    for (int more = k % 5; more > 0; --more) on_wall.push_back(drawn_wall_point(random));
    const WallCamera found(camera.lens, seen_points(camera, on_wall));
    EXPECT_LT(found.residual(), 1e-6);
    for (int n = 0; n < 10; ++n) {
      const Vec2 p = drawn_wall_point(random);
      const Vec2 pixel = seen_points(camera, {p}).front().pixel;
      EXPECT_LT((found.pixel(p) - pixel).norm(), 1e-6);
      EXPECT_LT((found.wall(pixel) - p).norm(), 1e-9);
    }
  }
}

TEST(WallCamera, DistortionIsUndone) {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    const double f = random.uniform(500, 4000);
    const Lens lens{{800, 500}, f, random.uniform(-0.2, 0.3), random.uniform(-0.05, 0.1)};
    if (!lens.invertible_to(950)) continue;
    const Vec2 seen(random.uniform(0, 1600), random.uniform(0, 1000));
    EXPECT_LT((lens.distorted(lens.undistorted(seen)) - seen).norm(), 1e-8);
  }
  EXPECT_FALSE((Lens{{800, 500}, 800, -0.4, 0}.invertible_to(950)));
  EXPECT_TRUE((Lens{{800, 500}, 800, -0.1, 0}.invertible_to(950)));
}

// More points than four: the residual is the error with which they were read, and their fit is
// nearer to the truth than that of four.
TEST(WallCamera, MorePointsAverageTheirErrors) {
  Random random(3);
  double squares = 0, of_four = 0, of_all = 0;
  const int cameras = 100;
  for (int k = 0; k < cameras; ++k) {
    const synthetic::TestCamera camera = synthetic::random_session(random).camera;
    std::vector<Vec2> on_wall = kCorners;
    for (int more = 0; more < 16; ++more) on_wall.push_back(drawn_wall_point(random));
    std::vector<WallPoint> points = seen_points(camera, on_wall);
    for (WallPoint& p : points) {
      const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
      p.pixel += 3 * std::sqrt(3.0) * Vec2(u, v);  // standard deviation 3 pixels
    }
    const WallCamera all(camera.lens, points);
    const WallCamera four(camera.lens, {points.begin(), points.begin() + 4});
    squares += all.residual() * all.residual() / cameras;
    const Vec2 p(0.1, 0.1), pixel = seen_points(camera, {p}).front().pixel;
    of_four += (four.wall(pixel) - p).squaredNorm();
    of_all += (all.wall(pixel) - p).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares), 3, 0.25);
  EXPECT_LT(of_all, 0.7 * of_four);
}

// Of the 24 ways to give four pixels to four corners one is right.
TEST(WallCamera, OnlyTheRightOrderOfCornersIsAccepted) {
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    const std::vector<WallPoint> right =
        seen_points(synthetic::random_session(random).camera, kCorners);
    std::array<std::size_t, 4> order{0, 1, 2, 3};
    int accepted = 0;
    do {
      std::vector<WallPoint> points = right;
      for (std::size_t c = 0; c < 4; ++c) points[c].pixel = right[order[c]].pixel;
      const std::string message = refusal(points);
      const bool is_right = order == std::array<std::size_t, 4>{0, 1, 2, 3};
      EXPECT_EQ(message.empty(), is_right);
      EXPECT_EQ(message.find("expected") != std::string::npos, !is_right) << message;
      accepted += message.empty();
    } while (std::next_permutation(order.begin(), order.end()));
    EXPECT_EQ(accepted, 1);
  }
}

TEST(WallCamera, PointsOnALineAreRefused) {
  const std::vector<WallPoint> line{{{100, 500}, {-0.3, 0}},
                                    {{300, 500}, {-0.1, 0}},
                                    {{500, 500}, {0.1, 0}},
                                    {{700, 300}, {0.3, 0.2}}};
  EXPECT_THAT(refusal(line), HasSubstr("too many lie on one line"));
  const std::vector<WallPoint> same(4, WallPoint{{100, 100}, {0, 0}});
  EXPECT_NE(refusal(same), "");
}

}  // namespace
}  // namespace firn
