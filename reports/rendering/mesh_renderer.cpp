#include "reports/rendering/mesh_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "experiments/analysis/triangle_scan.h"

namespace firn {
namespace {

constexpr int kSupersampling = 2;  // samples a pixel, each way
constexpr int kNothing = -1;       // body of an empty sample

// What is nearest in every sample of a picture.
struct DepthBuffer {
  int width = 0, height = 0;
  std::vector<double> nearness;
  std::vector<int> body;
  std::vector<Eigen::Vector3f> normal;  // unit, world, of the facet

  DepthBuffer(int w, int h)
      : width(w),
        height(h),
        nearness(static_cast<std::size_t>(w) * h, -std::numeric_limits<double>::infinity()),
        body(nearness.size(), kNothing),
        normal(nearness.size(), Eigen::Vector3f::Zero()) {}
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
};

// Corners in samples (x, y) and nearness (z).
void fill_triangle(const Vec3& a, const Vec3& b, const Vec3& c, int body,
                   const Eigen::Vector3f& normal, DepthBuffer& buffer) {
  const auto by_row = [](const Vec3& p) { return Vec3(p.y(), p.x(), p.z()); };
  scan_triangle(by_row(a), by_row(b), by_row(c), buffer.height, buffer.width, 1e-9,
                [&](int y, int x, double near) {
                  const std::size_t k = buffer.at(x, y);
                  if (near <= buffer.nearness[k]) return;
                  buffer.nearness[k] = near;
                  buffer.body[k] = body;
                  buffer.normal[k] = normal;
                });
}

DepthBuffer rasterize(const Scene& scene, const View& view, int width, int height, bool shadow) {
  DepthBuffer buffer(width, height);
  const Vec3 scale(width, height, 1);
  std::vector<Vec3> world, picture;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const RenderedBody& body = scene.bodies[k];
    if (shadow && !body.casts_shadow) continue;
    const TriangleMesh& mesh = *body.placed.mesh;
    world.clear();
    picture.clear();
    for (const Vec3& v : mesh.vertices) {
      world.push_back(body.placed.pose * v);
      picture.emplace_back(view.project(world.back()).cwiseProduct(scale));
    }
    for (const auto& t : mesh.triangles) {
      const Vec3 normal = (world[t[1]] - world[t[0]]).cross(world[t[2]] - world[t[0]]).normalized();
      if (normal.dot(view.towards_viewer(world[t[0]])) <= 0) continue;
      fill_triangle(picture[t[0]], picture[t[1]], picture[t[2]], static_cast<int>(k),
                    normal.cast<float>(), buffer);
    }
  }
  return buffer;
}

// A number in 0 ... 1 that differs from sample to sample.
double noise(std::uint32_t n) {
  n = (n ^ 61u) ^ (n >> 16);
  n *= 9u;
  n ^= n >> 4;
  n *= 0x27d4eb2du;
  n ^= n >> 15;
  return n / 4294967296.0;
}

class Shader {
 public:
  Shader(const Scene& scene, const View& view, int width, int height)
      : scene_(scene),
        view_(view),
        buffer_(rasterize(scene, view, width, height, false)),
        light_view_(light_view(scene)),
        light_(rasterize(scene, light_view_, kLightSamples, kLightSamples, true)) {}

  const DepthBuffer& buffer() const { return buffer_; }

  // The color of one sample.
  Eigen::Vector3f shade(int x, int y) const {
    const std::size_t k = buffer_.at(x, y);
    const Color& background = scene_.background;
    if (buffer_.body[k] == kNothing) return {background.r, background.g, background.b};
    const RenderedBody& body = scene_.bodies[static_cast<std::size_t>(buffer_.body[k])];
    const Vec3 point = point_at(x, y), normal = buffer_.normal[k].cast<double>();
    const double open = 1 - occlusion(x, y, point, normal);
    const double lit = lit_fraction(x, y, point, normal);
    const double lambert = std::max(0.0, normal.dot(scene_.to_light)) * lit;
    const double sky = 0.5 + 0.5 * normal.z();  // more light from above
    const double diffuse = open * (0.30 + 0.27 * sky) + 0.50 * lambert;
    const Vec3 half = (scene_.to_light + view_.towards_viewer(point)).normalized();
    const double shine = 0.16 * lit * std::pow(std::max(0.0, normal.dot(half)), 24);
    Eigen::Vector3f color(body.color.r, body.color.g, body.color.b);
    // Shade turns blue, as in ice and under a sky.
    const Eigen::Vector3f tint(0.86f, 0.93f, 1.0f);
    const auto shadow = static_cast<float>(std::clamp(1.15 - diffuse, 0.0, 1.0));
    color = color.cwiseProduct(Eigen::Vector3f::Ones() + shadow * (tint - Eigen::Vector3f::Ones()));
    color =
        color * static_cast<float>(diffuse) + Eigen::Vector3f::Constant(static_cast<float>(shine));
    return is_outline(x, y) ? Eigen::Vector3f(0.62f * color) : color;
  }

 private:
  static constexpr int kLightSamples = 1024;

  // A parallel view along the light of all that casts a shadow.
  static View light_view(const Scene& scene) {
    Eigen::AlignedBox3d bounds;
    for (const RenderedBody& body : scene.bodies) {
      if (!body.casts_shadow) continue;
      for (const Vec3& v : body.placed.mesh->vertices) bounds.extend(body.placed.pose * v);
    }
    if (bounds.isEmpty()) bounds.extend(Vec3(Vec3::Zero()));
    const double size = bounds.diagonal().norm() + 1e-3;
    return View::parallel(bounds.center(), -scene.to_light, Vec3::UnitY(), size, size);
  }

  Vec3 point_at(int x, int y) const {
    return view_.unproject(Vec3((x + 0.5) / buffer_.width, (y + 0.5) / buffer_.height,
                                buffer_.nearness[buffer_.at(x, y)]));
  }

  // Alchemy ambient obscurance (McGuire et al. 2011): what stands above the plane of the facet
  // nearby keeps the sky out.
  double occlusion(int x, int y, const Vec3& point, const Vec3& normal) const {
    constexpr int kSamples = 14;
    const double radius = scene_.occlusion_radius;
    const Vec3 picture((x + 0.5) / buffer_.width, 0, buffer_.nearness[buffer_.at(x, y)]);
    const double reach = radius / view_.width_at(picture) * buffer_.width;
    const double turn = noise(static_cast<std::uint32_t>(buffer_.at(x, y)));
    double sum = 0;
    for (int k = 0; k < kSamples; ++k) {
      const double part = (k + 0.5) / kSamples, angle = 2 * std::numbers::pi * (7 * part + turn);
      const int xk = x + static_cast<int>(std::lround(reach * part * std::cos(angle)));
      const int yk = y + static_cast<int>(std::lround(reach * part * std::sin(angle)));
      if (!buffer_.inside(xk, yk) || buffer_.body[buffer_.at(xk, yk)] == kNothing) continue;
      const Vec3 to = point_at(xk, yk) - point;
      const double far = to.squaredNorm();
      if (far > radius * radius) continue;
      sum += std::max(0.0, to.dot(normal) - 0.05 * radius) / (far + 1e-4 * radius * radius) *
             radius * (1 - far / (radius * radius));
    }
    return std::min(0.85, 0.75 * sum / kSamples);
  }

  // Part of the light that reaches the point, softened over a few samples of the light's view.
  double lit_fraction(int x, int y, const Vec3& point, const Vec3& normal) const {
    if (normal.dot(scene_.to_light) <= 0) return 0;
    const double pixel = light_view_.width_at(Vec3(0, 0, 0)) / kLightSamples;
    const Vec3 p = light_view_.project(point + 3 * pixel * normal);
    const auto n = static_cast<std::uint32_t>(buffer_.at(x, y));
    int lit = 0;
    constexpr int kSamples = 8;
    for (int k = 0; k < kSamples; ++k) {
      const double r = 4 * std::sqrt((k + noise(n)) / kSamples), a = 2.4 * k + 6.3 * noise(n + 7u);
      const int xk = static_cast<int>(p.x() * kLightSamples + r * std::cos(a));
      const int yk = static_cast<int>(p.y() * kLightSamples + r * std::sin(a));
      lit += !light_.inside(xk, yk) || light_.nearness[light_.at(xk, yk)] < p.z() + 2 * pixel;
    }
    return static_cast<double>(lit) / kSamples;
  }

  // Next to another body that is nearer or farther: a thin dark line keeps them apart.
  bool is_outline(int x, int y) const {
    const int body = buffer_.body[buffer_.at(x, y)];
    return (x + 1 < buffer_.width && buffer_.body[buffer_.at(x + 1, y)] != body) ||
           (y + 1 < buffer_.height && buffer_.body[buffer_.at(x, y + 1)] != body);
  }

  const Scene& scene_;
  const View& view_;
  DepthBuffer buffer_;
  View light_view_;
  DepthBuffer light_;
};

// Lines lie a little nearer than they are, so that those along a surface show whole.
void draw_line(const RenderedLine& line, const View& view, const DepthBuffer& buffer,
               std::vector<Eigen::Vector3f>& samples) {
  const Vec3 scale(buffer.width, buffer.height, 1);
  const Vec3 a = view.project(line.from).cwiseProduct(scale);
  const Vec3 b = view.project(line.to).cwiseProduct(scale);
  const Vec3 lift = view.towards_viewer(line.from) * 1e-3;
  const double raise = view.project(line.from + lift).z() - view.project(line.from).z();
  const double half = std::max(0.5, 0.5 * line.width * buffer.width);
  const Vec3 along = b - a;
  const double length2 = along.head<2>().squaredNorm();
  const int x_first = static_cast<int>(std::floor(std::min(a.x(), b.x()) - half));
  const int x_last = static_cast<int>(std::ceil(std::max(a.x(), b.x()) + half));
  const int y_first = static_cast<int>(std::floor(std::min(a.y(), b.y()) - half));
  const int y_last = static_cast<int>(std::ceil(std::max(a.y(), b.y()) + half));
  for (int y = std::max(0, y_first); y <= std::min(buffer.height - 1, y_last); ++y) {
    for (int x = std::max(0, x_first); x <= std::min(buffer.width - 1, x_last); ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      const double t =
          length2 > 0 ? std::clamp((p - a.head<2>()).dot(along.head<2>()) / length2, 0.0, 1.0) : 0;
      if ((a.head<2>() + t * along.head<2>() - p).norm() > half) continue;
      if (a.z() + t * along.z() + raise < buffer.nearness[buffer.at(x, y)]) continue;
      samples[buffer.at(x, y)] = {line.color.r, line.color.g, line.color.b};
    }
  }
}

}  // namespace

View View::parallel(const Vec3& center, const Vec3& direction, const Vec3& up, double width,
                    double height) {
  View view;
  const Vec3 right = direction.cross(up).normalized();
  view.axes_.row(0) = right;
  view.axes_.row(1) = right.cross(direction).normalized();
  view.axes_.row(2) = -direction.normalized();
  view.eye_ = center;
  view.width_ = width;
  view.height_ = height;
  return view;
}

View View::perspective(const Vec3& eye, const Vec3& target, const Vec3& up, double width,
                       double height) {
  View view = parallel(eye, (target - eye).normalized(), up, width, height);
  view.distance_ = (target - eye).norm();
  return view;
}

View View::cropped(const Eigen::AlignedBox2d& part) const {
  View view = *this;
  const Eigen::Vector2d shift = part.center() - Eigen::Vector2d::Constant(0.5);
  view.offset_ += Eigen::Vector2d(shift.x() * width_, shift.y() * height_);
  view.width_ *= part.sizes().x();
  view.height_ *= part.sizes().y();
  return view;
}

Vec3 View::project(const Vec3& world) const {
  const Vec3 q = axes_ * (world - eye_);
  const double nearness = distance_ > 0 ? -1 / q.z() : q.z();
  const double scale = distance_ > 0 ? distance_ * nearness : 1;
  return {0.5 + (q.x() * scale - offset_.x()) / width_,
          0.5 + (q.y() * scale - offset_.y()) / height_, nearness};
}

Vec3 View::unproject(const Vec3& picture) const {
  const double z = distance_ > 0 ? -1 / picture.z() : picture.z();
  const double scale = distance_ > 0 ? -z / distance_ : 1;
  const Vec3 q(((picture.x() - 0.5) * width_ + offset_.x()) * scale,
               ((picture.y() - 0.5) * height_ + offset_.y()) * scale, z);
  return axes_.transpose() * q + eye_;
}

Vec3 View::towards_viewer(const Vec3& world) const {
  if (distance_ > 0) return (eye_ - world).normalized();
  return axes_.row(2).transpose();
}

double View::width_at(const Vec3& picture) const {
  return distance_ > 0 ? width_ / (picture.z() * distance_) : width_;
}

Image render(const Scene& scene, const View& view, int width) {
  Image image;
  image.width = width;
  image.height = std::max(1, static_cast<int>(std::lround(width * view.height_over_width())));
  const Shader shader(scene, view, image.width * kSupersampling, image.height * kSupersampling);
  const DepthBuffer& buffer = shader.buffer();
  std::vector<Eigen::Vector3f> samples(buffer.body.size());
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x) samples[buffer.at(x, y)] = shader.shade(x, y);
  }
  for (const RenderedLine& line : scene.lines) draw_line(line, view, buffer, samples);

  image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int k = 0; k < kSupersampling * kSupersampling; ++k) {
        sum += samples[buffer.at(x * kSupersampling + k % kSupersampling,
                                 y * kSupersampling + k / kSupersampling)];
      }
      sum /= kSupersampling * kSupersampling;
      auto& pixel = image.pixels[static_cast<std::size_t>(y) * image.width + x];
      for (int c = 0; c < 3; ++c) {
        pixel[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(sum[c], 0.0f, 1.0f)));
      }
    }
  }
  return image;
}

}  // namespace firn
