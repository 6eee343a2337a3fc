#include "photo/heap_photo.h"

#include <fmt/core.h>

#include <cmath>
#include <optional>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "experiments/analysis/sample_statistics.h"
#include "firn/math.h"

namespace firn {
namespace {

constexpr int kDraws = 200;  // of the camera
constexpr std::uint64_t kSeed = 20261126;

// Throws InputErrors of the camera with the place of the key `corners`.
WallCamera camera_of(const PhotoSetup& setup, const Lens& lens,
                     const std::vector<WallPoint>& corners, const char* more = "") {
  try {
    return WallCamera(lens, corners);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: corners: {}{}", setup.file, e.what(), more));
  }
}

// Cameras that the setup's uncertainties make as likely as the stated one.
std::vector<WallCamera> possible_cameras(const PhotoSetup& setup, const Lens& lens) {
  std::vector<WallCamera> cameras;
  std::mt19937_64 random(kSeed);
  const auto normal = [&] { return normal_deviate_half_open(random); };
  for (int draw = 0; draw < kDraws; ++draw) {
    Lens drawn = lens;
    drawn.k1 += setup.k1_uncertainty * normal();
    const double tilt = setup.level_uncertainty * normal();
    const Eigen::Rotation2Dd level(tilt);
    std::vector<WallPoint> corners = setup.corners;
    for (WallPoint& c : corners) {
      c.pixel += setup.pixel_uncertainty * Vec2(normal(), normal());
      c.wall += setup.position_uncertainty * Vec2(normal(), normal());
      c.wall = level * c.wall;
    }
    cameras.push_back(camera_of(setup, drawn, corners,
                                "; they do so when moved by their uncertainties: expected smaller "
                                "ones"));
  }
  return cameras;
}

void check_corners(const PhotoSetup& setup, const Photograph& photo, const WallCamera& camera) {
  double scale = 0;  // pixels of a meter, in the mean
  for (const WallPoint& c : setup.corners) {
    if (c.pixel.x() < 0 || c.pixel.y() < 0 || c.pixel.x() > photo.width ||
        c.pixel.y() > photo.height) {
      throw InputError(fmt::format(
          "{}: corners: the pixel [{:.6g}, {:.6g}] is outside of {}, which has {} x {} pixels; "
          "expected one of it",
          setup.file, c.pixel.x(), c.pixel.y(), photo.file, photo.width, photo.height));
    }
    const Vec2 e(1e-6, 0);
    scale += (camera.pixel(c.wall + e) - camera.pixel(c.wall)).norm() / e.x() /
             static_cast<double>(setup.corners.size());
  }
  constexpr double kMostDeviations = 4;
  const double expected = std::hypot(setup.pixel_uncertainty, scale * setup.position_uncertainty);
  if (camera.residual() > kMostDeviations * expected + 1e-6) {
    throw InputError(
        fmt::format("{}: corners: deviate by {:.3g} pixels from what a camera can see, where their "
                    "uncertainties are {:.3g}; expected places and pixels of the same corners",
                    setup.file, camera.residual(), expected));
  }
}

PhotoSlope measure_slope(const Photograph& photo, const Photograph* background,
                         const WallCamera& camera, const PhotoSetup& setup,
                         const PhotoLedge& ledge) {
  const double d = setup.particle_size;
  const RectifiedLedge seen(photo, background, camera, setup, ledge);
  PhotoSlope slope{ledge, {}, seen.outline(), seen.threshold(), seen.contrast(), 0};
  slope.lines = outline_slope(slope.outline, ledge, d);
  slope.lines.robust_uncertainty = slope.lines.least_squares_uncertainty =
      outline_roughness(slope.lines, d);
  const double shift = setup.threshold_uncertainty;
  if (shift > 0) {
    const HeapSlope low = outline_slope(seen.outline(-shift), ledge, d);
    const HeapSlope high = outline_slope(seen.outline(shift), ledge, d);
    slope.threshold_shift = (high.robust_angle - low.robust_angle) / 2;
  }
  return slope;
}

// Mean angle of a heap when its outlines are mapped to the wall by another camera.
double angle_by(const PhotoAngle& heap, const WallCamera& used, const WallCamera& other,
                double particle_size) {
  double sum = 0;
  for (const PhotoSlope& slope : heap.slopes) {
    std::vector<Vec2> outline;
    for (const Vec2& p : slope.outline) outline.push_back(other.wall(used.pixel(p)));
    sum += outline_slope(outline, slope.ledge, particle_size).robust_angle;
  }
  return sum / static_cast<double>(heap.slopes.size());
}

}  // namespace

double HeapPhotoResult::scatter() const {
  if (heaps.size() == 1) return heaps.front().roughness;
  std::vector<double> angles;
  for (const PhotoAngle& heap : heaps) angles.push_back(heap.angle);
  return standard_deviation(angles);
}

double HeapPhotoResult::uncertainty() const {
  return std::hypot(scatter() / std::sqrt(static_cast<double>(heaps.size())), systematic);
}

WallCamera wall_camera(const PhotoSetup& setup, int width, int height) {
  return camera_of(setup, setup.lens(width, height), setup.corners);
}

HeapPhotoResult measure_heap_photos(const PhotoSetup& setup, std::size_t photos,
                                    const std::function<Photograph(std::size_t)>& load) {
  HeapPhotoResult result;
  result.setup = setup;
  std::optional<Photograph> background;
  std::optional<WallCamera> camera;
  std::vector<WallCamera> others;
  std::vector<double> angles(kDraws, 0.0);  // mean of the heaps by each of them
  const double heaps = static_cast<double>(photos);
  int width = 0, height = 0;
  const auto check_size = [&](const Photograph& photo) {
    if (photo.width == width && photo.height == height) return;
    throw InputError(fmt::format(
        "{}: has {} x {} pixels, and the first photograph {} x {}; expected a camera that stays",
        photo.file, photo.width, photo.height, width, height));
  };
  for (std::size_t k = 0; k < photos; ++k) {
    const Photograph photo = load(k);
    if (!camera) {
      width = photo.width;
      height = photo.height;
      camera = wall_camera(setup, width, height);
      check_corners(setup, photo, *camera);
      result.corner_residual = camera->residual();
      others = possible_cameras(setup, setup.lens(width, height));
      if (!setup.background.empty()) {
        background = read_photograph(setup.background);
        check_size(*background);
      }
    }
    check_size(photo);
    PhotoAngle heap;
    heap.file = photo.file;
    heap.hash = photo.hash;
    double squares = 0, shift = 0;
    const double n = static_cast<double>(setup.ledges.size());
    for (const PhotoLedge& ledge : setup.ledges) {
      heap.slopes.push_back(
          measure_slope(photo, background ? &*background : nullptr, *camera, setup, ledge));
      const PhotoSlope& slope = heap.slopes.back();
      heap.angle += slope.lines.robust_angle / n;
      squares += std::pow(slope.lines.robust_uncertainty, 2);
      shift += slope.threshold_shift / n;
    }
    heap.roughness = std::sqrt(squares) / n;
    result.threshold_uncertainty += std::abs(shift) / heaps;
    result.angle += heap.angle / heaps;
    for (std::size_t draw = 0; draw < others.size(); ++draw)
      angles[draw] += angle_by(heap, *camera, others[draw], setup.particle_size) / heaps;
    result.heaps.push_back(std::move(heap));
  }
  result.camera_uncertainty = standard_deviation(angles);
  result.systematic = std::hypot(result.camera_uncertainty, result.threshold_uncertainty);
  return result;
}

}  // namespace firn
