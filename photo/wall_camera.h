// Where the points of a plane are in a photograph: a lens with radial distortion, and the
// projective map (homography) that the corners of a box determine.
#pragma once

#include <array>
#include <vector>

#include "firn/math.h"

namespace firn {

using Vec2 = Eigen::Vector2d;

// Radial distortion as in OpenCV: a point at r from the principal point, in focal lengths, is seen
// at r (1 + k1 r^2 + k2 r^4). Lengths in pixels; the middle of the top left pixel is (0.5, 0.5).
struct Lens {
  Vec2 principal_point = Vec2::Zero();
  double focal_length = 1;
  double k1 = 0, k2 = 0;

  Vec2 distorted(const Vec2& ideal) const;
  Vec2 undistorted(const Vec2& seen) const;
  // Whether the distortion grows with r up to this distance from the principal point, pixels: only
  // there can it be undone.
  bool invertible_to(double distance) const;
};

// A point of the wall whose place in the photograph is known.
struct WallPoint {
  Vec2 pixel = Vec2::Zero();  // column and row from the top left corner of the picture
  Vec2 wall = Vec2::Zero();   // m: x to the right, z upwards
};

class WallCamera {
 public:
  // At least four points, no three of four on one line. More are fitted by least squares in pixels.
  // Throws InputError (without a place) for points that no camera in front of the wall can see so.
  WallCamera(const Lens& lens, const std::vector<WallPoint>& points);

  Vec2 pixel(const Vec2& wall) const;
  Vec2 wall(const Vec2& pixel) const;
  // Root mean square distance of the points from their fit, pixels, over the 2 n - 8 degrees of
  // freedom; 0 for four points.
  double residual() const { return residual_; }

 private:
  Lens lens_;
  Mat3 to_pixel_ = Mat3::Zero(), to_wall_ = Mat3::Zero();  // homogeneous, undistorted pixels
  double residual_ = 0;
};

}  // namespace firn
