// Photographs of synthetic heaps, rendered: a pinhole camera with a lens that distorts, in front of
// the box of synthetic::drained_box(), with blur, noise, uneven light and glare.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "photo/heap_photo.h"
#include "tests/support/synthetic_heap.h"

namespace firn::synthetic {

// Looks along its z axis; x to the right, y downwards in the picture. World: y points away from it.
struct TestCamera {
  int width = 1600, height = 1000;
  Lens lens;
  Mat3 rotation = Mat3::Identity();  // world -> camera
  Vec3 position = Vec3::Zero();      // m

  Vec3 seen(const Vec3& world) const { return rotation * (world - position); }
  Vec2 pixel_of(const Vec3& in_camera) const {
    return lens.distorted(lens.principal_point +
                          lens.focal_length / in_camera.z() * in_camera.head<2>());
  }
  Vec2 pixel(const Vec3& world) const { return pixel_of(seen(world)); }

  // From `eye` towards `target`, turned about the line of sight by `roll` (rad). The focal length
  // is a multiple of the picture's width.
  static TestCamera at(const Vec3& eye, const Vec3& target, double roll, double focal_widths,
                       double k1, int width, int height) {
    TestCamera camera;
    camera.width = width;
    camera.height = height;
    camera.position = eye;
    camera.lens = {{width / 2.0, height / 2.0}, focal_widths * width, k1, 0};
    const Vec3 forward = (target - eye).normalized();
    const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
    const Vec3 down = forward.cross(right);
    Mat3 level;
    level << right.transpose(), down.transpose(), forward.transpose();
    camera.rotation = Eigen::AngleAxisd(roll, Vec3::UnitZ()).toRotationMatrix() * level;
    return camera;
  }
};

struct Glare {
  Vec2 at;              // pixels
  double radius = 0;    // pixels
  double strength = 0;  // levels of 255 in its middle
};

struct PhotoStyle {
  double ice = 190, background = 60;  // levels
  double gradient = 0;                // of the light from left to right, part of it
  double blur = 0.6;                  // pixels, standard deviation
  double noise = 2;                   // levels, standard deviation
  std::vector<Glare> glares;
  std::uint64_t seed = 1;
};

namespace detail {

struct Canvas {
  int width, height;
  std::vector<double> depth;  // 1 / distance
  std::vector<float> shade;   // 0 to 1 of the ice; below 0: background
};

// One small triangle: what lies outside of the box is cut away.
inline void fill(const std::array<Vec3, 3>& world, const TestCamera& camera, int samples,
                 float shade, const DrainedRepose& box, Canvas& canvas) {
  std::array<Vec2, 3> p;
  std::array<double, 3> inverse;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 c = camera.seen(world[k]);
    p[k] = samples * camera.pixel_of(c);
    inverse[k] = 1 / c.z();
  }
  const Vec2 u = p[1] - p[0], v = p[2] - p[0];
  const double area = u.x() * v.y() - u.y() * v.x();
  if (area == 0) return;
  const auto [x0, x1] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
  const auto [y0, y1] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
  for (int j = std::max(0, static_cast<int>(y0)); j <= std::min<double>(canvas.height - 1, y1);
       ++j) {
    for (int i = std::max(0, static_cast<int>(x0)); i <= std::min<double>(canvas.width - 1, x1);
         ++i) {
      const Vec2 w(i + 0.5 - p[0].x(), j + 0.5 - p[0].y());
      const double b = (w.x() * v.y() - w.y() * v.x()) / area;
      const double c = (u.x() * w.y() - u.y() * w.x()) / area;
      const double a = 1 - b - c;
      constexpr double kSlack = -1e-9;
      if (a < kSlack || b < kSlack || c < kSlack) continue;
      const double near = a * inverse[0] + b * inverse[1] + c * inverse[2];
      const auto at = static_cast<std::size_t>(j) * canvas.width + i;
      if (near <= canvas.depth[at]) continue;
      const Vec3 q =
          (a * inverse[0] * world[0] + b * inverse[1] * world[1] + c * inverse[2] * world[2]) /
          near;
      if (std::abs(q.y()) > box.box.y() / 2 || std::abs(q.x()) > box.box.x() / 2 ||
          std::abs(q.x()) < box.door_width / 2 || q.z() < 0)
        continue;
      canvas.depth[at] = near;
      canvas.shade[at] = shade;
    }
  }
}

inline void blur_rows(std::vector<float>& value, int width, int height, double sigma, bool across) {
  const int half = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> weight;
  for (int k = -half; k <= half; ++k) weight.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  std::vector<float> result(value.size());
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      double sum = 0, total = 0;
      for (int k = -half; k <= half; ++k) {
        const int a = across ? i : i + k, b = across ? j + k : j;
        if (a < 0 || b < 0 || a >= width || b >= height) continue;
        const double w = weight[static_cast<std::size_t>(k + half)];
        sum += w * value[static_cast<std::size_t>(b) * width + a];
        total += w;
      }
      result[static_cast<std::size_t>(j) * width + i] = static_cast<float>(sum / total);
    }
  }
  value = std::move(result);
}

// Draws the triangles of all bodies. Bodies are a little lighter or darker than each other, and so
// are their sides.
inline void draw_bodies(const std::vector<PlacedMesh>& bodies, const TestCamera& camera,
                        int samples, Random& random, Canvas& canvas) {
  constexpr double kEdge = 15e-3;  // m, so that the lens bends edges smoothly
  const DrainedRepose box = drained_box();
  const Vec3 light = Vec3(-0.3, -0.7, 0.65).normalized();
  for (const PlacedMesh& body : bodies) {
    const double tint = random.uniform(-0.06, 0.06);
    for (const auto& t : body.mesh->triangles) {
      std::array<Vec3, 3> w;
      for (std::size_t k = 0; k < 3; ++k)
        w[k] = body.pose * body.mesh->vertices[static_cast<std::size_t>(t[k])];
      const Vec3 normal = (w[1] - w[0]).cross(w[2] - w[0]).normalized();
      const auto shade = static_cast<float>(0.82 + tint + 0.18 * normal.dot(light));
      const double longest =
          std::max({(w[1] - w[0]).norm(), (w[2] - w[1]).norm(), (w[0] - w[2]).norm()});
      const int n = std::max(1, static_cast<int>(std::ceil(longest / kEdge)));
      const auto corner = [&](int a, int b) -> Vec3 {
        return w[0] + (w[1] - w[0]) * a / n + (w[2] - w[0]) * b / n;
      };
      for (int a = 0; a < n; ++a) {
        for (int b = 0; a + b < n; ++b) {
          fill({corner(a, b), corner(a + 1, b), corner(a, b + 1)}, camera, samples, shade, box,
               canvas);
          if (a + b + 2 <= n)
            fill({corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)}, camera, samples, shade,
                 box, canvas);
        }
      }
    }
  }
}

// Levels of the pixels: means of the samples, with uneven light, glares and blur.
inline std::vector<float> pixel_levels(const Canvas& canvas, const TestCamera& camera, int samples,
                                       const PhotoStyle& style) {
  std::vector<float> level(static_cast<std::size_t>(camera.width) * camera.height, 0);
  for (int j = 0; j < canvas.height; ++j) {
    for (int i = 0; i < canvas.width; ++i) {
      const float shade = canvas.shade[static_cast<std::size_t>(j) * canvas.width + i];
      const double value = shade < 0 ? style.background : style.ice * shade;
      level[static_cast<std::size_t>(j / samples) * camera.width + i / samples] +=
          static_cast<float>(value / (samples * samples));
    }
  }
  for (int j = 0; j < camera.height; ++j) {
    for (int i = 0; i < camera.width; ++i) {
      float& value = level[static_cast<std::size_t>(j) * camera.width + i];
      value *=
          static_cast<float>(1 + style.gradient * (static_cast<double>(i) / camera.width - 0.5));
      for (const Glare& g : style.glares) {
        const double distance = (Vec2(i + 0.5, j + 0.5) - g.at).squaredNorm();
        value += static_cast<float>(g.strength * std::exp(-0.5 * distance / (g.radius * g.radius)));
      }
    }
  }
  for (const bool across : {false, true})
    blur_rows(level, camera.width, camera.height, style.blur, across);
  return level;
}

}  // namespace detail

// Two samples a pixel each way.
inline Photograph photograph_of(const std::vector<PlacedMesh>& bodies, const TestCamera& camera,
                                const PhotoStyle& style) {
  constexpr int kSamples = 2;
  detail::Canvas canvas{kSamples * camera.width, kSamples * camera.height, {}, {}};
  canvas.depth.assign(static_cast<std::size_t>(canvas.width) * canvas.height, 0);
  canvas.shade.assign(canvas.depth.size(), -1);
  Random random(style.seed);
  detail::draw_bodies(bodies, camera, kSamples, random, canvas);
  const std::vector<float> level = detail::pixel_levels(canvas, camera, kSamples, style);

  Photograph photo;
  photo.width = camera.width;
  photo.height = camera.height;
  photo.file = "heap.png";
  photo.hash = std::string(64, '0');
  photo.rgb.reserve(3 * level.size());
  const std::array<double, 3> color{0.97, 1, 1.03};
  for (const float value_of_pixel : level) {
    for (const double c : color) {
      // Nearly normal: the sum of four uniform numbers has a variance of a third.
      double noise = 0;
      for (int part = 0; part < 4; ++part) noise += random.uniform(-0.5, 0.5);
      const double value = c * value_of_pixel + style.noise * std::sqrt(3.0) * noise;
      photo.rgb.push_back(static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)));
    }
  }
  return photo;
}

// The setup of a camera in front of the box, exact: both ledges, the four corners of the front wall
// up to `height` (m).
inline PhotoSetup setup_of(const TestCamera& camera, double particle_size, double height = 0.25) {
  const DrainedRepose box = drained_box();
  PhotoSetup setup;
  setup.file = "photo.toml";
  setup.hash = std::string(64, '0');
  setup.name = "rendered heap";
  setup.response = "angle_of_repose_outline";
  setup.particle_size = particle_size;
  setup.height = height;
  for (const auto& [x, z] : {std::pair{-1.0, 0.0}, {1.0, 0.0}, {1.0, height}, {-1.0, height}}) {
    const Vec2 wall(x * box.box.x() / 2, z);
    setup.corners.push_back({camera.pixel({wall.x(), -box.box.y() / 2, wall.y()}), wall});
  }
  setup.pixel_uncertainty = 2;
  setup.position_uncertainty = 0.5e-3;
  setup.level_uncertainty = 0.3 / kRadToDeg;
  setup.focal_length = camera.lens.focal_length;
  setup.principal_point = camera.lens.principal_point;
  setup.k1 = camera.lens.k1;
  setup.k1_uncertainty = 0.01;
  setup.threshold_uncertainty = 0.1;
  for (const double sign : {-1.0, 1.0}) {
    PhotoLedge ledge{sign < 0 ? "left" : "right", sign * box.door_width / 2, sign * box.box.x() / 2,
                     fit_window(box, particle_size)};
    setup.ledges.push_back(ledge);
  }
  return setup;
}

inline HeapPhotoResult measured(const Photograph& photo, const PhotoSetup& setup) {
  return measure_heap_photos(setup, 1, [&](std::size_t) { return photo; });
}

// A place of the camera, a lens, light, blur, noise and glare drawn at random.
struct PhotoSession {
  TestCamera camera;
  PhotoStyle style;
};
inline PhotoSession random_session(Random& random, int width = 1600, int height = 1000) {
  const DrainedRepose box = drained_box();
  PhotoSession s;
  const double front = -box.box.y() / 2, away = random.uniform(2.1, 4);
  const Vec3 eye(random.uniform(-0.25, 0.25), front - away, random.uniform(0, 0.25));
  const Vec3 target(random.uniform(-0.03, 0.03), front, random.uniform(0.1, 0.16));
  // The box fills 70 to 85 % of the width.
  const double focal = random.uniform(0.7, 0.85) * (target - eye).norm() / box.box.x();
  s.camera = TestCamera::at(eye, target, random.uniform(-0.06, 0.06), focal,
                            random.uniform(-0.3, 0.3) * focal * focal, width, height);
  s.style.ice = random.uniform(150, 240);
  s.style.background = random.uniform(10, 0.5 * s.style.ice);
  s.style.gradient = random.uniform(-0.3, 0.3);
  s.style.blur = random.uniform(0.3, 2.5) * width / 1600;
  s.style.noise = random.uniform(0, 12);
  s.style.seed = static_cast<std::uint64_t>(random.uniform(0, 1e9));
  for (int k = 0; k < 3; ++k) {
    // On the ice as on what is behind it, some small and bright, some large and faint.
    const double size = random.uniform(0, 1);
    s.style.glares.push_back({{random.uniform(0, width), random.uniform(0, height)},
                              (8 + 150 * size) * width / 1600,
                              random.uniform(20, 40) + 150 * std::pow(1 - size, 4)});
  }
  return s;
}

// Draws what the setup says of its uncertainties: a user who reads corners wrongly, a lens
// calibration that is a little off, a floor that is not level.
inline void add_errors(PhotoSetup& setup, Random& random) {
  const auto normal = [&] {
    return std::sqrt(-2 * std::log(1 - random.uniform(0, 1))) *
           std::cos(2 * std::numbers::pi * random.uniform(0, 1));
  };
  const Eigen::Rotation2Dd level(setup.level_uncertainty * normal());
  for (WallPoint& c : setup.corners) {
    c.pixel += setup.pixel_uncertainty * Vec2(normal(), normal());
    c.wall = level * (c.wall + setup.position_uncertainty * Vec2(normal(), normal()));
  }
  setup.k1 += setup.k1_uncertainty * normal();
}

}  // namespace firn::synthetic
