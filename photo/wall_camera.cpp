#include "photo/wall_camera.h"

#include <Eigen/SVD>
#include <cmath>

namespace firn {
namespace {

Vec2 mapped(const Mat3& h, const Vec2& p) {
  const Vec3 q = h * p.homogeneous();
  return q.head<2>() / q.z();
}

// Shifts and scales points to mean zero and a mean distance of sqrt(2), for the conditioning of the
// linear equations (Hartley 1997).
Mat3 normalization(const std::vector<Vec2>& points) {
  const double n = static_cast<double>(points.size());
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / n;
  double distance = 0;
  for (const Vec2& p : points) distance += (p - mean).norm() / n;
  const double scale = std::sqrt(2.0) / distance;
  Mat3 t = Mat3::Identity();
  t.topLeftCorner<2, 2>() *= scale;
  t.topRightCorner<2, 1>() = -scale * mean;
  return t;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

// In the picture of a camera in front of a wall, every triangle of its points has the same
// orientation. Rows of a picture run downwards, so that the sign is the other one. Small triangles
// are left out: errors of the points can turn those over.
void check_order(const std::vector<WallPoint>& points) {
  constexpr double kSmall = 0.1;  // of the largest triangle
  double largest = 0;
  const auto for_triangles = [&](const auto& visit) {
    const std::size_t n = points.size();
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = a + 1; b < n; ++b)
        for (std::size_t c = b + 1; c < n; ++c)
          visit(turn(points[a].wall, points[b].wall, points[c].wall),
                turn(points[a].pixel, points[b].pixel, points[c].pixel));
  };
  for_triangles([&](double wall, double) { largest = std::max(largest, std::abs(wall)); });
  bool kept = largest > 0, mirrored = true;
  for_triangles([&](double wall, double seen) {
    if (std::abs(wall) <= kSmall * largest) return;
    kept = kept && wall * seen < 0;
    mirrored = mirrored && wall * seen > 0;
  });
  if (kept) return;
  throw InputError(mirrored
                       ? "are mirrored in the picture; expected x to the right and z upwards as "
                         "seen from the camera, and pixels counted from the top left"
                       : "are not in the order of their places on the wall; expected each pixel "
                         "with the x and z of the same corner");
}

// Least squares of the linear equations h x p = 0.
Mat3 linear_map(const std::vector<Vec2>& from, const std::vector<Vec2>& to) {
  const Mat3 t_from = normalization(from), t_to = normalization(to);
  const auto n = static_cast<Eigen::Index>(from.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(2 * n, 9), 9);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vec3 p = mapped(t_from, from[static_cast<std::size_t>(k)]).homogeneous();
    const Vec2 q = mapped(t_to, to[static_cast<std::size_t>(k)]);
    a.block<1, 3>(2 * k, 0) = p.transpose();
    a.block<1, 3>(2 * k, 6) = -q.x() * p.transpose();
    a.block<1, 3>(2 * k + 1, 3) = p.transpose();
    a.block<1, 3>(2 * k + 1, 6) = -q.y() * p.transpose();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeFullV);
  constexpr double kRank = 1e-6;
  if (!(svd.singularValues()(7) > kRank * svd.singularValues()(0))) {
    throw InputError(
        "do not determine the perspective, as too many lie on one line; expected four of which no "
        "three do");
  }
  const Eigen::VectorXd h = svd.matrixV().col(8);
  Mat3 map;
  map << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  return t_to.inverse() * map * t_from;
}

// Gauss-Newton on the distances in pixels, from the linear solution.
Mat3 refined_map(Mat3 h, const std::vector<Vec2>& from, const std::vector<Vec2>& to) {
  const Mat3 t_from = normalization(from);
  Mat3 g = h * t_from.inverse();
  const auto n = static_cast<Eigen::Index>(from.size());
  for (int iteration = 0; iteration < 20; ++iteration) {
    g /= g(2, 2);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2 * n, 8);
    Eigen::VectorXd error(2 * n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Vec3 p = mapped(t_from, from[static_cast<std::size_t>(k)]).homogeneous();
      const Vec3 q = g * p;
      const Vec2 seen = q.head<2>() / q.z();
      error.segment<2>(2 * k) = to[static_cast<std::size_t>(k)] - seen;
      jacobian.block<1, 3>(2 * k, 0) = p.transpose() / q.z();
      jacobian.block<1, 3>(2 * k + 1, 3) = p.transpose() / q.z();
      jacobian.block<2, 2>(2 * k, 6) = -seen * p.head<2>().transpose() / q.z();
    }
    const Eigen::VectorXd step = jacobian.colPivHouseholderQr().solve(error);
    for (Eigen::Index k = 0; k < 8; ++k) g(k / 3, k % 3) += step(k);
    if (step.norm() < 1e-12 * g.norm()) break;
  }
  return g * t_from;
}

}  // namespace

Vec2 Lens::distorted(const Vec2& ideal) const {
  const Vec2 r = (ideal - principal_point) / focal_length;
  const double s = r.squaredNorm();
  return principal_point + (1 + s * (k1 + s * k2)) * (ideal - principal_point);
}

Vec2 Lens::undistorted(const Vec2& seen) const {
  const Vec2 offset = seen - principal_point;
  const double wanted = offset.norm() / focal_length;
  if (wanted == 0) return seen;
  double r = wanted;  // Newton's method; the function grows (invertible_to())
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double s = r * r;
    const double step = (r * (1 + s * (k1 + s * k2)) - wanted) / (1 + s * (3 * k1 + 5 * s * k2));
    r -= step;
    if (std::abs(step) < 1e-14 * wanted) break;
  }
  return principal_point + (r / wanted) * offset;
}

bool Lens::invertible_to(double distance) const {
  constexpr int kSteps = 200;
  const double wanted = distance / focal_length;
  // Ideal radii grow until the seen one reaches `wanted`; each must stretch by a tenth at least.
  double r = 0;
  for (int k = 0; k <= 10 * kSteps; ++k) {
    const double s = r * r;
    if (1 + s * (3 * k1 + 5 * s * k2) < 0.1) return false;
    if (r * (1 + s * (k1 + s * k2)) >= wanted) return true;
    r += wanted / kSteps;
  }
  return false;
}

WallCamera::WallCamera(const Lens& lens, const std::vector<WallPoint>& points) : lens_(lens) {
  check_order(points);
  std::vector<Vec2> on_wall, seen;
  for (const WallPoint& p : points) {
    on_wall.push_back(p.wall);
    seen.push_back(lens.undistorted(p.pixel));
  }
  to_pixel_ = linear_map(on_wall, seen);
  if (points.size() > 4) to_pixel_ = refined_map(to_pixel_, on_wall, seen);
  if (!to_pixel_.allFinite() || std::abs(to_pixel_.determinant()) == 0)
    throw InputError("do not determine the perspective; expected the corners of a wall");
  to_wall_ = to_pixel_.inverse();
  double squares = 0;
  const double sign = (to_pixel_ * on_wall.front().homogeneous()).z();
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!((to_pixel_ * on_wall[k].homogeneous()).z() * sign > 0))
      throw InputError("cannot all be in front of a camera; expected the corners of a wall");
    squares += (mapped(to_pixel_, on_wall[k]) - seen[k]).squaredNorm();
  }
  // Which way up the wall stands at the mean of its points.
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : on_wall) middle += p / static_cast<double>(points.size());
  const double size = (on_wall.back() - on_wall.front()).norm();
  const Vec2 up = pixel(middle + Vec2(0, 1e-3 * size)) - pixel(middle);
  if (!(-up.y() > std::abs(up.x()))) {
    throw InputError(
        "make z point to a side or downwards in the picture; expected upwards: each pixel with the "
        "x and z of the same corner");
  }
  if (points.size() > 4)
    residual_ = std::sqrt(squares / (2 * static_cast<double>(points.size()) - 8));
}

Vec2 WallCamera::pixel(const Vec2& wall) const { return lens_.distorted(mapped(to_pixel_, wall)); }

Vec2 WallCamera::wall(const Vec2& pixel) const {
  return mapped(to_wall_, lens_.undistorted(pixel));
}

}  // namespace firn
