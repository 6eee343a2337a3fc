// Broken mesh files and what is said of each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>

#include "experiments/meshes/mesh_file.h"
#include "firn/shape.h"
#include "tests/support/error_of.h"
#include "tests/support/replaced.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// What reading a file as a particle of millimeters comes to; "accepted" when nothing is wrong.
std::string outcome(const std::string& name, const std::string& text) {
  const std::string file = test::scratch_path(name);
  std::ofstream(file, std::ios::binary) << text;
  ShapeOptions options;
  options.density = 900;
  options.young_modulus = 1e6;
  const std::string said = test::error_if_any(
      [&] { make_mesh(read_mesh_file(file, 1e-3, kParticleMesh).mesh, options); });
  std::filesystem::remove(file);
  return said.empty() ? "accepted" : said;
}

// A tetrahedron, in OBJ and in STL, and changes of it.
const std::string kCorners = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\n";
const std::string kFaces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

using test::replaced;

std::string facet(const char* a, const char* b, const char* c) {
  std::string text = "facet normal 0 0 0\nouter loop\n";
  for (const char* corner : {a, b, c}) text += std::string("vertex ") + corner + "\n";
  return text + "endloop\nendfacet\n";
}
const std::string kStl = "solid t\n" + facet("0 0 0", "0 10 0", "10 0 0") +
                         facet("0 0 0", "10 0 0", "0 0 10") + facet("10 0 0", "0 10 0", "0 0 10") +
                         facet("0 10 0", "0 0 0", "0 0 10") + "endsolid t\n";

struct Member {
  std::string text, said;
};

TEST(MeshCorpus, ObjFiles) {
  const std::string whole = kCorners + kFaces;
  std::string crlf;
  for (const char c : whole) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  std::string polygon = "f";
  for (int i = 0; i < 1001; ++i) polygon += " 1";
  const std::vector<Member> members = {
      {whole, "accepted"},
      {crlf, "accepted"},
      {"\xEF\xBB\xBF" + whole, "accepted"},
      {kCorners + "f -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -2 -4 -1\n", "accepted"},
      {"", "is empty"},
      {"# nothing\n", "holds no triangles"},
      {kCorners, "holds no triangles"},
      {replaced(whole, "v 10 0 0", "v nan 0 0"), "\"nan\" is not a coordinate"},
      {replaced(whole, "v 10 0 0", "v inf 0 0"), "\"inf\" is not a coordinate"},
      {replaced(whole, "v 10 0 0", "v 1e999 0 0"), "\"1e999\" is not a coordinate"},
      {replaced(whole, "v 10 0 0", "v 10 0"), "is not a coordinate"},
      {replaced(whole, "v 10 0 0", "v 10,5 0 0"), "\"10,5\" is not a coordinate"},
      {replaced(whole, "v 10 0 0", "v 1e12 0 0"), "up to 1000 km"},
      {replaced(whole, "f 1 3 2", "f 1 3 5"), "vertex 5 is not there"},
      {replaced(whole, "f 1 3 2", "f 1 3 -5"), "vertex -5 is not there"},
      {replaced(whole, "f 1 3 2", "f 1 3 0"), "vertex 0 is not there"},
      {replaced(whole, "f 1 3 2", "f 1 3 x"), "\"x\" is not a vertex"},
      {replaced(whole, "f 1 3 2", "f 1 3 99999999999999999999"), "is not a vertex"},
      {replaced(whole, "f 1 3 2", "f 1 3"), "a face of 2 corners"},
      {whole + polygon + "\n", "a face of more than 1000 corners"},
      {kFaces + kCorners, "is not there"},
      {replaced(whole, "f 1 3 2\n", ""), "3 open edges"},
      {replaced(whole, "f 1 3 2", "f 1 2 3"), "3 edges between triangles that face opposite ways"},
      {whole + "f 1 3 2\n", "1 repeated triangle"},
      {kCorners + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n", "inside out"},
      {whole + "v 5 5 -9\nf 1 2 5\nf 2 1 5\n", "edge of more than two triangles"},
      {kCorners + "f 1 1 2\n", "triangles without area alone"},
  };
  for (std::size_t i = 0; i < members.size(); ++i)
    EXPECT_THAT(outcome("corpus.obj", members[i].text), HasSubstr(members[i].said)) << i;
}

TEST(MeshCorpus, StlFiles) {
  const std::vector<Member> members = {
      {kStl, "accepted"},
      {"\xEF\xBB\xBF" + kStl, "accepted"},
      {replaced(kStl, "vertex 10 0 0", "vertex nan 0 0"), "expected finite coordinates"},
      {replaced(kStl, "vertex 10 0 0", "vertex inf 0 0"), "expected finite coordinates"},
      {replaced(kStl, "vertex 10 0 0", "vertex 1e30 0 0"), "up to 1000 km"},
      {replaced(kStl, "vertex 10 0 0", "vertex 1e999 0 0"), "expected a number"},
      {replaced(kStl, "vertex 10 0 0", "vertex 10 0"), "expected a number"},
      {replaced(kStl, "vertex 10 0 0", "10 0 0"), "expected \"vertex\""},
      {replaced(kStl, "outer loop", "loop"), "expected \"outer\""},
      {replaced(kStl, "endloop\n", ""), "expected \"endloop\""},
      {replaced(kStl, "endfacet\n", ""), "expected \"endfacet\""},
      {replaced(kStl, "endsolid t\n", ""), "expected \"facet\" or \"endsolid\""},
      {kStl + "rest", "expected \"solid\""},
      {"solid empty\nendsolid empty\n", "holds no triangles"},
      {"solid", "expected \"facet\" or \"endsolid\""},
      {"STL", "neither a text nor a binary STL file"},
      {std::string(84, '\0'), "holds no triangles"},
      {std::string(84 + 25, '\0'), "expected a whole binary STL file"},
      {std::string(300, '\xff'), "expected a whole binary STL file"},
      {replaced(kStl, "10 0 0", "11 0 0"), "open edges"},
      {"solid t\n" + facet("0 0 0", "1 0 0", "0 1 0") + "endsolid\n", "3 open edges"},
      {"solid t\n" + facet("0 0 0", "0 0 0", "0 0 0") + "endsolid\n", "expected 1e-06 m to 100 m"},
  };
  for (std::size_t i = 0; i < members.size(); ++i)
    EXPECT_THAT(outcome("corpus.stl", members[i].text), HasSubstr(members[i].said)) << i;
}

void put(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

using Corners = std::vector<std::array<float, 9>>;
const float kNan = std::numeric_limits<float>::quiet_NaN();
const Corners kTetrahedron = {{0, 0, 0, 0, 10, 0, 10, 0, 0},
                              {0, 0, 0, 10, 0, 0, 0, 0, 10},
                              {10, 0, 0, 0, 10, 0, 0, 0, 10},
                              {0, 10, 0, 0, 0, 0, 0, 0, 10}};

// A binary file that promises `count` triangles.
std::string binary(const Corners& corners, std::size_t count, const std::string& title = "t") {
  std::string bytes = title;
  bytes.resize(80, ' ');
  put(bytes, static_cast<std::uint32_t>(count));
  for (const auto& triangle : corners) {
    bytes.append(12, '\0');
    for (const float v : triangle) put(bytes, std::bit_cast<std::uint32_t>(v));
    bytes.append(2, '\0');
  }
  return bytes;
}

// The tetrahedron moved and scaled.
Corners moved(float scale, float x, Corners corners = kTetrahedron) {
  for (auto& triangle : corners)
    for (std::size_t k = 0; k < 9; ++k) triangle[k] = triangle[k] * scale + (k % 3 == 0 ? x : 0);
  return corners;
}

Corners both(Corners a, const Corners& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Corners changed(std::size_t triangle, std::size_t coordinate, float value) {
  Corners corners = kTetrahedron;
  corners[triangle][coordinate] = value;
  return corners;
}

TEST(MeshCorpus, BinaryStlFiles) {
  const std::string whole = binary(kTetrahedron, 4);
  const Corners without(kTetrahedron.begin() + 1, kTetrahedron.end());
  const std::vector<Member> members = {
      {whole, "accepted"},
      {binary(kTetrahedron, 4, "solid t"), "accepted"},
      {binary(kTetrahedron, 2), "header states 2 triangles and the file holds 4"},
      {binary(kTetrahedron, 3), "header states 3 triangles and the file holds 4"},
      {binary(kTetrahedron, 5), "header states 5 triangles and the file holds 4"},
      {binary(kTetrahedron, 0), "header states 0 triangles and the file holds 4"},
      {binary(kTetrahedron, 0xffffffff), "header states 4294967295 triangles and the file holds 4"},
      {binary(kTetrahedron, 0x80000000), "header states 2147483648 triangles and the file holds 4"},
      {whole.substr(0, whole.size() - 1), "header states 4 triangles and the file holds 3"},
      {whole.substr(0, 85), "header states 4 triangles and the file holds 0"},
      {whole.substr(0, 83), "neither a text nor a binary STL file"},
      {whole + "\n", "header states 4 triangles and the file holds 4"},
      {binary({}, 0), "holds no triangles"},
      {binary(changed(1, 3, kNan), 4), "triangle 2 has the corner"},
      {binary(changed(2, 8, INFINITY), 4), "triangle 3 has the corner"},
      {binary(changed(0, 4, 3e38F), 4), "triangle 1 has the corner"},
      {binary(moved(1e-33F, 0), 4), "check the length unit"},
      {binary(moved(1e-5F, 0), 4), "check the length unit"},
      {binary(moved(1e5F, 0), 4), "check the length unit"},
      {binary(without, 3), "3 open edges"},
      {binary(changed(0, 3, 5), 4), "open edges"},
      {binary(both(kTetrahedron, {kTetrahedron[2]}), 5), "1 repeated triangle"},
      {binary(both(kTetrahedron, moved(1, 2)), 8), "overlap"},
      {binary(both(moved(4, -2), moved(1, 1)), 8), "overlap"},
      {binary(both(kTetrahedron, kTetrahedron), 8), "repeated triangle"},
  };
  for (std::size_t i = 0; i < members.size(); ++i)
    EXPECT_THAT(outcome("corpus.stl", members[i].text), HasSubstr(members[i].said)) << i;
}

// Every prefix of a file is refused, or has the same triangles.
TEST(MeshCorpus, PrefixesOfAnStlFile) {
  const std::string whole = kStl.substr(0, kStl.size() - 3);  // the last name and line end count
  for (std::size_t length = 0; length + 9 < whole.size(); ++length)
    EXPECT_NE(outcome("corpus.stl", whole.substr(0, length)), "accepted") << length;
}
TEST(MeshCorpus, PrefixesOfABinaryStlFile) {
  const std::string whole = binary(kTetrahedron, 4);
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(outcome("corpus.stl", whole.substr(0, length)), "accepted") << length;
}

}  // namespace
}  // namespace firn
