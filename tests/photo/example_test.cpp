// The photograph that is shipped with its setup, cases/photo: it is rendered, so that its angle is
// known. FIRN_WRITE_EXAMPLE=FOLDER renders it again
// into a file.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "experiments/system/output_file.h"
#include "tests/photo/picture_files.h"
#include "tests/support/heap_photograph.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kParticle = 20.57e-3, kAngle = 24;

struct Example {
  TriangleMesh cube = synthetic::crescent();
  std::vector<PlacedMesh> left, right, bodies;
  synthetic::PhotoSession session;

  Example(const Example&) = delete;
  Example() {
    left = synthetic::ledge_heap(cube, kParticle, -1, kAngle, 40e-3, 3);
    right = synthetic::ledge_heap(cube, kParticle, 1, kAngle, 40e-3, 4);
    bodies = left;
    bodies.insert(bodies.end(), right.begin(), right.end());
    const double front = -synthetic::drained_box().box.y() / 2;
    session.camera = synthetic::TestCamera::at({0.12, front - 2.2, 0.2}, {0.01, front, 0.11}, 0.012,
                                               3.0, -0.6, 1200, 640);
    session.style.ice = 215;
    session.style.background = 58;
    session.style.gradient = 0.2;
    session.style.blur = 0.9;
    session.style.noise = 4;
    session.style.glares = {{{520, 300}, 90, 25}, {{300, 430}, 6, 120}};
  }
  Photograph photo() const {
    return synthetic::photograph_of(bodies, session.camera, session.style);
  }
  double outline_angle(const std::vector<PlacedMesh>& heap, Side side) const {
    return outline_slope(heap, ledge_of(synthetic::drained_box(), side, kParticle), kParticle)
        .robust_angle;
  }
};

TEST(PhotoExample, IsThePictureOfAHeapWhoseAngleIsKnown) {
  const Example example;
  const Photograph rendered = example.photo();
  if (const char* folder = std::getenv("FIRN_WRITE_EXAMPLE")) {
    write_file(fs::path(folder) / "heap.jpg", test::jpeg_bytes(rendered, 80));
    for (const WallPoint& c : synthetic::setup_of(example.session.camera, kParticle).corners)
      std::printf("  { pixel = [%.0f, %.0f], x = \"%g mm\", z = \"%g mm\" },\n", c.pixel.x(),
                  c.pixel.y(), 1e3 * c.wall.x(), 1e3 * c.wall.y());
    std::printf("%g %g\n", example.outline_angle(example.left, Side::left),
                example.outline_angle(example.right, Side::right));
  }
  const fs::path folder = fs::path(FIRN_SOURCE_DIR) / "cases/photo";
  const Photograph shipped = read_photograph((folder / "heap.jpg").string());
  ASSERT_EQ(shipped.width, rendered.width);
  ASSERT_EQ(shipped.height, rendered.height);
  double difference = 0;
  for (std::size_t k = 0; k < shipped.rgb.size(); ++k)
    difference += std::abs(static_cast<double>(shipped.rgb[k]) - rendered.rgb[k]) /
                  static_cast<double>(shipped.rgb.size());
  EXPECT_LT(difference, 5);  // levels: compression and noise

  const PhotoSetup setup = read_photo_setup((folder / "setup.toml").string());
  const PhotoSetup exact = synthetic::setup_of(example.session.camera, kParticle);
  ASSERT_EQ(setup.corners.size(), exact.corners.size());
  for (std::size_t k = 0; k < exact.corners.size(); ++k) {
    EXPECT_LT((setup.corners[k].pixel - exact.corners[k].pixel).norm(), 1);
    EXPECT_LT((setup.corners[k].wall - exact.corners[k].wall).norm(), 0.1e-3);
  }
  const HeapPhotoResult result = synthetic::measured(shipped, setup);
  EXPECT_LT(std::abs(result.angle - kAngle), 2 * result.uncertainty());
  EXPECT_LT(result.systematic, 0.5);
}

}  // namespace
}  // namespace firn
