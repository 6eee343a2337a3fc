// Shaded pictures of triangle meshes: a depth buffer with shadows, ambient occlusion and outlines.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "experiments/analysis/height_map.h"

namespace firn {

struct Color {
  float r = 0, g = 0, b = 0;  // 0 ... 1
};

// Eight bits a channel, rows from the bottom up.
struct Image {
  int width = 0, height = 0;
  std::vector<std::array<std::uint8_t, 3>> pixels;  // [height * width]
};

// Where the picture is taken from. Camera axes: x right, y up, z towards the viewer.
class View {
 public:
  // Parallel projection along `direction` (unit) of the rectangle `width` x `height` (m) around
  // `center`; `up` points up in the picture.
  static View parallel(const Vec3& center, const Vec3& direction, const Vec3& up, double width,
                       double height);
  // Central projection; `width`, `height` (m): what the picture shows at the distance of `target`.
  static View perspective(const Vec3& eye, const Vec3& target, const Vec3& up, double width,
                          double height);

  // What the rectangle `part` of this picture shows, in the coordinates of project().
  View cropped(const Eigen::AlignedBox2d& part) const;

  // x, y: 0 ... 1 across the picture; z: nearness, linear across the picture and larger for nearer.
  Vec3 project(const Vec3& world) const;
  Vec3 unproject(const Vec3& picture) const;
  Vec3 towards_viewer(const Vec3& world) const;  // unit
  // Meters per unit of picture width at this point.
  double width_at(const Vec3& picture) const;
  double height_over_width() const { return height_ / width_; }

 private:
  Mat3 axes_ = Mat3::Identity();  // world -> camera
  Vec3 eye_ = Vec3::Zero();       // m; a parallel view: the center
  double distance_ = 0;           // m from eye to target; 0: parallel
  double width_ = 1, height_ = 1;
  Eigen::Vector2d offset_ =
      Eigen::Vector2d::Zero();  // m from the view's axis to the middle of the picture
};

struct RenderedBody {
  PlacedMesh placed;
  Color color;
  bool casts_shadow = true;
};

struct RenderedLine {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // m, world
  Color color;
  double width = 0;  // of the picture's width
};

struct Scene {
  std::vector<RenderedBody> bodies;
  std::vector<RenderedLine> lines;
  Vec3 to_light = Vec3(-0.35, -0.72, 0.70).normalized();  // unit
  double occlusion_radius = 0.02;                         // m
  Color background{1, 1, 1};
};

// The picture `width` pixels wide.
Image render(const Scene& scene, const View& view, int width);

}  // namespace firn
