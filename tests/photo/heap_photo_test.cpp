// Angles in rendered photographs of heaps that are known.
#include "photo/heap_photo.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "experiments/measurements/measurement.h"
#include "experiments/system/output_file.h"
#include "tests/photo/picture_files.h"
#include "tests/support/error_of.h"
#include "tests/support/heap_photograph.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using synthetic::measured;
using synthetic::PhotoSession;
using synthetic::Random;
using testing::HasSubstr;

constexpr double kPhotoParticle = 20.57e-3;

// Solids with plane tops on both ledges, as steep as each other.
struct Ramps {
  TriangleMesh left, right;
  std::vector<PlacedMesh> bodies;

  Ramps(const Ramps&) = delete;
  explicit Ramps(double angle, double base = 20e-3) {
    right = synthetic::ramp(std::tan(angle / kRadToDeg), 0, base);
    left = right;
    for (Vec3& v : left.vertices) v.x() = -v.x();
    for (auto& t : left.triangles) std::swap(t[1], t[2]);
    bodies = {{&left, {}}, {&right, {}}};
  }
};

// Heaps of cubes in full size on both ledges.
struct Heaps {
  TriangleMesh cube = synthetic::crescent();
  std::vector<PlacedMesh> left, right, bodies;

  Heaps(const Heaps&) = delete;
  Heaps(double angle, std::uint64_t seed) {
    left = synthetic::ledge_heap(cube, kPhotoParticle, -1, angle, 40e-3, 2 * seed);
    right = synthetic::ledge_heap(cube, kPhotoParticle, 1, angle, 40e-3, 2 * seed + 1);
    bodies = left;
    bodies.insert(bodies.end(), right.begin(), right.end());
  }
  // By the estimator of simulations.
  double outline_angle() const {
    const auto side = [&](const std::vector<PlacedMesh>& heap, Side s) {
      return outline_slope(heap, ledge_of(synthetic::drained_box(), s, kPhotoParticle),
                           kPhotoParticle)
          .robust_angle;
    };
    return (side(left, Side::left) + side(right, Side::right)) / 2;
  }
};

// A family of photographs: the errors of the angle against what is stated.
struct Errors {
  int pictures = 0, within = 0;  // 1.96 standard deviations
  int refused = 0;               // with a message, such as glare over most of the outline
  double sum = 0, squares = 0, stated = 0;

  void add(double error, double uncertainty) {
    ++pictures;
    within += std::abs(error) <= 1.96 * uncertainty;
    sum += error;
    squares += error * error;
    stated += uncertainty * uncertainty;
  }
  double bias() const { return sum / pictures; }
  double scatter() const { return std::sqrt(squares / pictures - bias() * bias()); }
  double coverage() const { return static_cast<double>(within) / pictures; }
  std::string text() const {
    return fmt::format(
        "{} pictures and {} refused: mean error {:+.3f} deg, scatter {:.3f}, stated {:.3f}, "
        "within 95 %: {:.1f} %",
        pictures, refused, bias(), scatter(), std::sqrt(stated / pictures), 100 * coverage());
  }
};

std::optional<HeapPhotoResult> measured_unless_refused(const Photograph& photo,
                                                       const PhotoSetup& setup) {
  try {
    return measured(photo, setup);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

Errors errors_of_ramps(int pictures, std::uint64_t seed) {
  Random random(seed);
  Errors errors;
  for (int k = 0; k < pictures; ++k) {
    const PhotoSession session = synthetic::random_session(random);
    const double angle = random.uniform(6, 32);
    const Ramps ramps(angle);
    PhotoSetup setup = synthetic::setup_of(session.camera, kPhotoParticle);
    synthetic::add_errors(setup, random);
    const Photograph photo = synthetic::photograph_of(ramps.bodies, session.camera, session.style);
    if (const auto result = measured_unless_refused(photo, setup))
      errors.add(result->angle - angle, result->systematic);
    else
      ++errors.refused;
  }
  return errors;
}

struct HeapErrors {
  Errors from_plane, from_outline;
};
HeapErrors errors_of_heaps(int pictures, std::uint64_t seed) {
  Random random(seed);
  HeapErrors errors;
  for (int k = 0; k < pictures; ++k) {
    const PhotoSession session = synthetic::random_session(random);
    const double angle = random.uniform(6, 32);
    const Heaps heaps(angle, 1000 * seed + static_cast<std::uint64_t>(k));
    PhotoSetup setup = synthetic::setup_of(session.camera, kPhotoParticle);
    synthetic::add_errors(setup, random);
    const Photograph photo = synthetic::photograph_of(heaps.bodies, session.camera, session.style);
    const auto result = measured_unless_refused(photo, setup);
    if (!result) {
      ++errors.from_plane.refused;
      continue;
    }
    errors.from_plane.add(result->angle - angle, result->uncertainty());
    errors.from_outline.add(result->angle - heaps.outline_angle(), result->uncertainty());
  }
  return errors;
}

// A camera straight in front, an even light.
PhotoSession plain_session(int width = 1200) {
  PhotoSession s;
  const double front = -synthetic::drained_box().box.y() / 2;
  s.camera = synthetic::TestCamera::at({0, front - 2.5, 0.15}, {0, front, 0.12}, 0, 3.2, 0, width,
                                       width * 5 / 8);
  return s;
}

std::string refusal(const Photograph& photo, const PhotoSetup& setup) {
  return test::error_if_any([&] { measured(photo, setup); });
}

TEST(HeapPhoto, APlaneIsMeasuredExactly) {
  const PhotoSession s = plain_session();
  for (const double angle : {5.0, 12.0, 25.0, 35.0}) {
    const Ramps ramps(angle);
    const HeapPhotoResult r = measured(synthetic::photograph_of(ramps.bodies, s.camera, s.style),
                                       synthetic::setup_of(s.camera, kPhotoParticle));
    EXPECT_NEAR(r.angle, angle, 0.02);
    for (const PhotoSlope& slope : r.heaps[0].slopes) {
      EXPECT_NEAR(slope.lines.robust_angle, angle, 0.05);
      EXPECT_EQ(slope.lines.covered, 1);
    }
    EXPECT_GT(r.systematic, 0);
  }
}

TEST(HeapPhoto, PlanesUnderPerspectiveDistortionBlurNoiseAndGlare) {
  const Errors e = errors_of_ramps(12, 3);
  RecordProperty("ramps", e.text());
  EXPECT_LT(std::abs(e.bias()), 0.3) << e.text();
  EXPECT_LT(e.scatter(), 0.4) << e.text();
  EXPECT_EQ(e.refused, 0) << e.text();
  EXPECT_GE(e.within, 9) << e.text();  // fewer: one time in 1600
}

TEST(HeapPhoto, HeapsOfCubesWithinTheirUncertainty) {
  const HeapErrors e = errors_of_heaps(10, 4);
  RecordProperty("heaps", e.from_plane.text());
  EXPECT_LT(std::abs(e.from_plane.bias()), 1.2) << e.from_plane.text();
  EXPECT_GE(e.from_plane.within, 7) << e.from_plane.text();  // fewer: one time in 1000
}

TEST(HeapPhotoLong, PlanesAreMeasuredWithinTheUncertaintyOfCameraAndThreshold) {
  const Errors e = errors_of_ramps(240, 5);
  RecordProperty("ramps", e.text());
  std::puts(e.text().c_str());
  EXPECT_LT(std::abs(e.bias()), 0.05) << e.text();
  EXPECT_GE(e.coverage(), 0.91) << e.text();  // three standard errors of 240 pictures
  EXPECT_LE(e.refused, 12) << e.text();
}

TEST(HeapPhotoLong, HeapsAreMeasuredWithinTheirUncertainty) {
  const HeapErrors e = errors_of_heaps(240, 6);
  RecordProperty("from_plane", e.from_plane.text());
  RecordProperty("from_outline", e.from_outline.text());
  std::puts(("from the plane: " + e.from_plane.text()).c_str());
  std::puts(("from the outline: " + e.from_outline.text()).c_str());
  // The outline of these heaps, which needs no camera, is itself 0.22 degrees less steep than the
  // plane that they are piled up to.
  EXPECT_LT(std::abs(e.from_plane.bias() - e.from_outline.bias() + 0.22), 0.1)
      << e.from_plane.text();
  EXPECT_LT(std::abs(e.from_outline.bias()), 0.3) << e.from_outline.text();
  EXPECT_GE(e.from_plane.coverage(), 0.91) << e.from_plane.text();
  EXPECT_LE(e.from_plane.coverage(), 0.99) << e.from_plane.text();
  EXPECT_LE(e.from_plane.refused, 12) << e.from_plane.text();
}

// The scatter by wrong setups is the stated uncertainty of the camera.
TEST(HeapPhotoLong, WrongCornersScatterAsTheCameraUncertaintySays) {
  Random random(8);
  for (int k = 0; k < 3; ++k) {
    PhotoSession s = synthetic::random_session(random, 800, 500);
    s.style.glares.clear();
    s.style.noise = 1;
    const double angle = random.uniform(10, 30);
    const Ramps ramps(angle);
    const Photograph photo = synthetic::photograph_of(ramps.bodies, s.camera, s.style);
    double squares = 0, stated = 0;
    const int setups = 150;
    for (int n = 0; n < setups; ++n) {
      PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
      synthetic::add_errors(setup, random);
      const HeapPhotoResult r = measured(photo, setup);
      squares += (r.angle - angle) * (r.angle - angle) / setups;
      stated += r.camera_uncertainty * r.camera_uncertainty / setups;
    }
    EXPECT_NEAR(std::sqrt(stated / squares), 1, 0.2) << "at " << angle;
  }
}

TEST(HeapPhoto, DarkHeapsAndBackgroundsAndChannelsGiveTheSameAngle) {
  const PhotoSession s = plain_session();
  const Heaps heaps(20, 7);
  const PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
  const Photograph photo = synthetic::photograph_of(heaps.bodies, s.camera, s.style);
  const double angle = measured(photo, setup).angle;

  Photograph negative = photo;
  for (auto& level : negative.rgb) level = static_cast<std::uint8_t>(255 - level);
  PhotoSetup darker = setup;
  darker.heap_is_brighter = false;
  EXPECT_NEAR(measured(negative, darker).angle, angle, 0.02);

  for (const PhotoChannel channel : {PhotoChannel::red, PhotoChannel::green, PhotoChannel::blue}) {
    PhotoSetup other = setup;
    other.channel = channel;
    EXPECT_NEAR(measured(photo, other).angle, angle, 0.3);
  }

  // Behind the heap is a pattern that is as bright as the ice in places; a picture without the heap
  // separates them.
  const test::ScratchFolder folder("photo");
  Photograph empty = synthetic::photograph_of({}, s.camera, s.style), patterned = photo;
  for (int j = 0; j < photo.height; ++j) {
    for (int i = 0; i < photo.width; ++i) {
      const bool stripe = (i / 37 + j / 53) % 3 == 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t k = 3 * (static_cast<std::size_t>(j) * photo.width + i) + c;
        const bool ice = photo.rgb[k] > 110;
        if (stripe) empty.rgb[k] = static_cast<std::uint8_t>(c == 0 ? 200 : 60);
        if (stripe && !ice) patterned.rgb[k] = empty.rgb[k];
      }
    }
  }
  PhotoSetup with_background = setup;
  with_background.background = folder / "empty.png";
  write_file(with_background.background, test::png_bytes(empty));
  EXPECT_NEAR(measured(patterned, with_background).angle, angle, 0.3);
}

TEST(HeapPhoto, SeveralHeapsAreRepeats) {
  const PhotoSession s = plain_session();
  PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
  setup.name = "a \"heap\" \\ of\x01 ice";
  std::vector<Photograph> photos;
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const Heaps heaps(18, seed);
    photos.push_back(synthetic::photograph_of(heaps.bodies, s.camera, s.style));
  }
  const auto load = [&](std::size_t k) { return photos.at(k); };
  const HeapPhotoResult three = measure_heap_photos(setup, 3, load);
  const Measurement m = read_measurement_text(measurement_text(three), "m.toml");
  EXPECT_EQ(m.response, "angle_of_repose_outline");
  EXPECT_EQ(m.unit, "deg");
  EXPECT_EQ(m.repeats, 3);
  EXPECT_NEAR(m.value, three.angle, 1e-4);
  EXPECT_NEAR(m.standard_deviation, three.scatter(), 1e-4);
  EXPECT_NEAR(m.systematic_uncertainty, three.systematic, 1e-4);
  EXPECT_NEAR(m.standard_uncertainty(), three.uncertainty(), 1e-4);
  EXPECT_THAT(m.name, HasSubstr("a \"heap\" \\"));

  const HeapPhotoResult one = measure_heap_photos(setup, 1, load);
  const Measurement single = read_measurement_text(measurement_text(one), "m.toml");
  EXPECT_EQ(single.repeats, 1);
  EXPECT_NEAR(single.value, one.angle, 1e-4);
  EXPECT_NEAR(single.standard_uncertainty(), one.uncertainty(), 1e-4);
  EXPECT_NE(single.assumption, "");
  EXPECT_THAT(single.source, HasSubstr(std::string(64, '0')));
  EXPECT_EQ(measurement_text(one), measurement_text(measure_heap_photos(setup, 1, load)));
}

TEST(HeapPhoto, WhatIsNoHeapIsRefused) {
  const PhotoSession s = plain_session();
  const PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
  const Ramps ramps(15);
  const Photograph photo = synthetic::photograph_of(ramps.bodies, s.camera, s.style);
  EXPECT_EQ(refusal(photo, setup), "");

  const Photograph empty = synthetic::photograph_of({}, s.camera, s.style);
  EXPECT_THAT(refusal(empty, setup), HasSubstr("heap.png: slope \"left\": no heap is seen"));
  Photograph white = photo;
  std::fill(white.rgb.begin(), white.rgb.end(), std::uint8_t{255});
  EXPECT_THAT(refusal(white, setup),
              HasSubstr("no heap is seen: light and dark parts differ by 0"));

  // Strong noise alone, and light that fades from the bottom up.
  PhotoSession noisy = s;
  noisy.style.noise = 60;
  EXPECT_NE(refusal(synthetic::photograph_of({}, s.camera, noisy.style), setup), "");
  Photograph fading = empty;
  for (int j = 0; j < fading.height; ++j)
    for (int k = 0; k < 3 * fading.width; ++k)
      fading.rgb[static_cast<std::size_t>(j) * 3 * fading.width + k] =
          static_cast<std::uint8_t>(250 * j / fading.height);
  EXPECT_THAT(refusal(fading, setup), HasSubstr("% of the outline is not sharp"));

  PhotoSetup low = setup;
  low.height = 50e-3;
  EXPECT_THAT(refusal(photo, low), HasSubstr("the heap reaches the top of what is searched"));

  // A heap of which only the upper end of the slope is there.
  TriangleMesh toe = synthetic::ramp(std::tan(20 / kRadToDeg), 130e-3);
  TriangleMesh mirrored = toe;
  for (Vec3& v : mirrored.vertices) v.x() = -v.x();
  EXPECT_THAT(
      refusal(synthetic::photograph_of({{&toe, {}}, {&mirrored, {}}}, s.camera, s.style), setup),
      HasSubstr("% of the window; expected at least 50 %"));

  // Something bright far above the floor.
  TriangleMesh hanging = ramps.right, other = ramps.left;
  for (TriangleMesh* mesh : {&hanging, &other})
    for (Vec3& v : mesh->vertices) v.z() += 60e-3;
  EXPECT_THAT(
      refusal(synthetic::photograph_of({{&hanging, {}}, {&other, {}}}, s.camera, s.style), setup),
      HasSubstr("above the floor; expected a heap on z = 0"));
}

TEST(HeapPhoto, APictureThatDoesNotShowTheWholeHeapIsRefused) {
  const PhotoSession s = plain_session();
  const PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
  const Ramps ramps(25);
  const Photograph photo = synthetic::photograph_of(ramps.bodies, s.camera, s.style);
  // The part of it from a column and a row on, with the corners as they are seen there. Those of
  // the box that are outside give way to points of the wall inside.
  const auto cut = [&](int left, int top, int width, int height) {
    Photograph part;
    part.width = width;
    part.height = height;
    part.file = "cut.png";
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i)
        for (const auto level : photo.at(left + i, top + j)) part.rgb.push_back(level);
    return part;
  };
  const auto moved = [&](int left, int top, double low, double high) {
    PhotoSetup shifted = setup;
    shifted.corners.clear();
    const double front = -synthetic::drained_box().box.y() / 2;
    for (const Vec2& p : {Vec2(-0.15, low), Vec2(0.15, low), Vec2(0.15, high), Vec2(-0.15, high)})
      shifted.corners.push_back({s.camera.pixel({p.x(), front, p.y()}) - Vec2(left, top), p});
    shifted.principal_point = s.camera.lens.principal_point - Vec2(left, top);
    return shifted;
  };
  const auto column = static_cast<int>(setup.corners[0].pixel.x()) + 20;
  EXPECT_THAT(refusal(cut(column, 0, photo.width - column, photo.height), moved(column, 0, 0, 0.2)),
              HasSubstr("is outside of the photograph"));
  const auto row = static_cast<int>(s.camera.pixel({0.25, -0.07, 0.08}).y());
  EXPECT_THAT(refusal(cut(0, row, photo.width, photo.height - row), moved(0, row, 0, 0.05)),
              HasSubstr("the border of the photograph cuts the heap"));
  // A corner that is not in the picture at all.
  PhotoSetup outside = setup;
  outside.corners[1].pixel.x() = photo.width + 5;
  EXPECT_THAT(refusal(photo, outside), HasSubstr("is outside of heap.png"));
}

TEST(HeapPhoto, CornersThatContradictEachOtherAreRefused) {
  const PhotoSession s = plain_session();
  const Ramps ramps(25);
  const Photograph photo = synthetic::photograph_of(ramps.bodies, s.camera, s.style);
  PhotoSetup setup = synthetic::setup_of(s.camera, kPhotoParticle);
  const double front = -synthetic::drained_box().box.y() / 2;
  setup.corners.push_back({s.camera.pixel({0, front, 0}), {0, 0}});
  EXPECT_EQ(refusal(photo, setup), "");
  setup.corners.back().wall.x() = 60e-3;
  EXPECT_THAT(refusal(photo, setup), HasSubstr("corners: deviate by"));
  PhotoSetup far = synthetic::setup_of(s.camera, 1e-3);
  EXPECT_THAT(refusal(photo, far), HasSubstr("a particle covers"));
}

TEST(HeapPhoto, ThePictureForTheUserIsDrawn) {
  const PhotoSession s = plain_session();
  const Heaps heaps(22, 5);
  const Photograph photo = synthetic::photograph_of(heaps.bodies, s.camera, s.style);
  const HeapPhotoResult result = measured(photo, synthetic::setup_of(s.camera, kPhotoParticle));
  const test::ScratchFolder folder("photo");
  const std::string file = folder / "check.png";
  draw_heap_photo(result, 0, photo, file);
  const Photograph drawn = read_photograph(file);
  EXPECT_EQ(drawn.width, photo.width);
  EXPECT_GT(drawn.height, photo.height);
  // The fitted line is red where it should be: at the middle of the right window.
  const PhotoSlope& slope = result.heaps[0].slopes[1];
  const WallCamera camera = wall_camera(result.setup, photo.width, photo.height);
  const double middle = (slope.lines.window.from + slope.lines.window.to) / 2;
  const Vec2 p = camera.pixel(
      {slope.ledge.x(middle), slope.lines.robust.intercept + slope.lines.robust.slope * middle});
  const auto pixel =
      drawn.at(static_cast<int>(p.x()), static_cast<int>(p.y()) + drawn.height - photo.height);
  EXPECT_GT(pixel[0], 150);
  EXPECT_LT(pixel[1], 120);
  EXPECT_LT(pixel[2], 120);
  EXPECT_THROW(draw_heap_photo(result, 0, photo, folder / "check.gif"), InputError);
}

}  // namespace
}  // namespace firn
