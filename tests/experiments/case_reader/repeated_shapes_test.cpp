// A case that is read again and again, as in a batch, has the shapes of a case that is read once.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

void put(std::string& out, const void* data, std::size_t size) {
  out.append(static_cast<const char*>(data), size);
}

// Everything that a contact or a picture is computed from.
std::string bits(const Shape& s) {
  std::string out = s.name + ' ' + s.deviation_reason;
  for (const double x : {s.volume, s.mass, s.bounding_radius, s.rounding, s.stiffness_length,
                         s.stiffness, s.surface_deviation})
    put(out, &x, sizeof x);
  put(out, s.centroid.data(), sizeof s.centroid);
  put(out, s.shape_from_body.coeffs().data(), sizeof s.shape_from_body);
  put(out, s.inertia.data(), sizeof s.inertia);
  for (const Vec3& v : s.mesh.vertices) put(out, v.data(), sizeof v);
  for (const auto& t : s.mesh.triangles) put(out, t.data(), sizeof t);
  put(out, s.part_neighbors.data(), s.part_neighbors.size() * sizeof(s.part_neighbors[0]));
  for (const ConvexPart& part : s.parts)
    for (const std::vector<double>* x : {&part.x, &part.y, &part.z})
      put(out, x->data(), x->size() * sizeof(double));
  return out + std::to_string(s.material);
}

std::string shapes_of(const std::string& text, const std::string& folder) {
  std::string out;
  for (const Shape& s : read_case_text(text, "case", folder).model.shapes) out += bits(s);
  return out;
}

// Few values of each key, so that many cases share some shapes with an earlier one, and files whose
// content changes.
std::string random_case(std::mt19937& random, const std::string& folder) {
  const auto pick = [&](double a, double b) { return random() % 2 == 0 ? a : b; };
  const double height = pick(0.01, 0.02);
  std::ofstream(folder + "/wedge.obj")
      << fmt::format("v 0 0 0\nv 0.02 0 0\nv 0 0.03 0\nv 0 0 {}\n", height)
      << "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  return fmt::format(
      R"([case]
name = "shapes"
duration = "1 s"
[materials.ice]
density = "{} kg/m^3"
young_modulus = "{} GPa"
poisson_ratio = 0.33
[interactions.ice-ice]
static_friction = 0.2
restitution = 0.3
[shapes.crescent]
kind = "crescent"
material = "ice"
facets = 100
parts = {}
[shapes.other]
kind = "crescent"
material = "ice"
variant = "custom"
facets = 100
top_concavity_depth = "{} mm"
[shapes.box]
kind = "box"
material = "ice"
size = "{} 0.02 0.03 m"
[shapes.ball]
kind = "sphere"
material = "ice"
radius = "{} mm"
[shapes.wedge]
kind = "mesh"
material = "ice"
file = "wedge.obj"
length_unit = "{}"
[[particles]]
shape = "box"
position = "0 0 0.2 m"
)",
      pick(900, 917), pick(0.01, 0.02), pick(2, 4), pick(1, 0.5), pick(0.01, 0.02), pick(8, 9),
      random() % 2 == 0 ? "m" : "cm");
}

TEST(RepeatedShapes, AreThoseOfACaseThatIsReadOnce) {
  const test::ScratchFolder scratch("shapes");
  const std::string folder = scratch.path().string();
  std::mt19937 random(3);
  std::vector<std::string> seen;
  for (int k = 0; k < 40; ++k) {
    const std::string text = random_case(random, folder);
    std::string once;
    std::thread([&] { once = shapes_of(text, folder); }).join();  // has read no case before
    const std::string again = shapes_of(text, folder);
    EXPECT_EQ(once == again, true) << text;
    seen.push_back(again);
  }
  std::ranges::sort(seen);
  EXPECT_GT(std::ranges::unique(seen).begin() - seen.begin(), 20);
}

}  // namespace
}  // namespace firn
