#include "reports/rendering/heap_picture.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "firn/math.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_heap.h"

namespace firn {
namespace {

HeapPicture ramp_picture(const TriangleMesh& mesh) {
  HeapPicture picture;
  picture.title = "a ramp's picture";
  picture.setup = synthetic::drained_box();
  picture.particles = {{&mesh, {}}};
  picture.particle_size = 20.57e-3;
  picture.mean_volume = 14.9e-6;
  picture.width = 500;
  return picture;
}

std::string drawn(const HeapPicture& picture) {
  const std::string file = test::scratch_path("heap.svg");
  std::filesystem::remove(file);
  draw_heap(picture, file);
  return test::read_text(file);
}

TEST(HeapPicture, CarriesTheMeasuredAngles) {
  const TriangleMesh mesh = synthetic::ramp(std::tan(12.5 * M_PI / 180), 0, 10e-3);
  HeapPicture picture = ramp_picture(mesh);
  const std::string open = drawn(picture);
  EXPECT_NE(open.find("12.5° ± 0.7°"), std::string::npos);
  EXPECT_NE(open.find("0.0° ± 0.7°"), std::string::npos);  // the empty ledge
  EXPECT_NE(open.find("x / mm"), std::string::npos);
  picture.door_open = false;
  EXPECT_EQ(drawn(picture).find("°"), std::string::npos);
}

TEST(HeapPicture, OtherFormatsAreRefused) {
  const TriangleMesh mesh = synthetic::ramp(0.2, 0);
  EXPECT_THROW(draw_heap(ramp_picture(mesh), "heap.gif"), InputError);
}

}  // namespace
}  // namespace firn
