#include "experiments/meshes/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>

#include "firn/shape.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class StlFile : public testing::Test {
 protected:
  std::string file = test::scratch_path("mesh.stl");
  TriangleMesh mesh = crescent_mesh({.facets = 68});

  void TearDown() override { std::filesystem::remove(file); }

  void put(const std::string& bytes) const { std::ofstream(file, std::ios::binary) << bytes; }
  std::string get() const { return test::read_text(file); }
  // Changes the bytes of a good binary file.
  template <typename Change>
  void spoil(Change change) {
    write_stl(file, mesh, 1e-3);
    std::string bytes = get();
    change(bytes);
    put(bytes);
  }
  // The one line of the refusal.
  std::string refusal() const {
    const std::string message = test::error_of([&] { read_stl(file, 1e-3); });
    EXPECT_THAT(message, StartsWith(file + ":"));
    EXPECT_THAT(message, testing::Not(HasSubstr("\n")));
    return message;
  }
};

void put_float(std::string& bytes, std::size_t at, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(bits >> (8 * i) & 0xff);
}

// The text form of a mesh, each number with the nine digits that single precision needs.
std::string text_of(const TriangleMesh& mesh, double unit, const std::string& end_of_line) {
  std::string text = "solid a facet of ice" + end_of_line;
  const auto number = [](double value) {
    char word[32];
    std::snprintf(word, sizeof word, " %.9g", static_cast<double>(static_cast<float>(value)));
    return std::string(word);
  };
  for (const auto& t : mesh.triangles) {
    text += "  facet normal nan 0 0" + end_of_line + "    outer loop" + end_of_line;
    for (const int i : t) {
      const Vec3 v = mesh.vertices[i] / unit;
      text += "      vertex" + number(v.x()) + number(v.y()) + number(v.z()) + end_of_line;
    }
    text += "    endloop" + end_of_line + "  endfacet" + end_of_line;
  }
  return text + "endsolid a facet of ice" + end_of_line;
}

void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_TRUE(a.vertices == b.vertices);
}

TEST_F(StlFile, BinaryComesBackInSinglePrecision) {
  write_stl(file, mesh, 1e-3);
  const TriangleMesh read = read_stl(file, 1e-3);
  ASSERT_EQ(read.triangles.size(), mesh.triangles.size());
  ASSERT_EQ(read.vertices.size(), mesh.vertices.size());
  EXPECT_TRUE(inspect(read).is_valid());
  const double volume = mass_properties(mesh).volume;
  EXPECT_NEAR(mass_properties(read).volume, volume, 1e-6 * volume);
  EXPECT_EQ(get().size(), 84 + 50 * mesh.triangles.size());
}

TEST_F(StlFile, LengthUnitScales) {
  write_stl(file, mesh, 1);
  const TriangleMesh meters = read_stl(file, 1), inches = read_stl(file, 0.0254);
  EXPECT_NEAR(bounding_box(inches)[1].x() / bounding_box(meters)[1].x(), 0.0254, 1e-12);
}

TEST_F(StlFile, TextAndBinaryTwinsAreIdentical) {
  write_stl(file, mesh, 1e-3);
  const TriangleMesh binary = read_stl(file, 1e-3);
  for (const char* end_of_line : {"\n", "\r\n"}) {
    put(text_of(mesh, 1e-3, end_of_line));
    expect_same(read_stl(file, 1e-3), binary);
  }
  std::string upper = text_of(mesh, 1e-3, "\n");
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  put("\n  " + upper);
  expect_same(read_stl(file, 1e-3), binary);
}

TEST_F(StlFile, BinaryTitleMayBeginWithSolid) {
  write_stl(file, mesh, 1e-3);
  const TriangleMesh read = read_stl(file, 1e-3);
  spoil([](std::string& bytes) { bytes.replace(0, 12, "solid facet "); });
  expect_same(read_stl(file, 1e-3), read);
}

TEST_F(StlFile, LengthIsThatOfTheCount) {
  spoil([](std::string& bytes) { bytes += "made by a tool"; });
  EXPECT_THAT(refusal(),
              HasSubstr("header states 68 triangles and the file holds 68 in 3498 bytes"));
  spoil([](std::string& bytes) { bytes[80] = 34; });  // half of the triangles
  EXPECT_THAT(refusal(),
              HasSubstr("header states 34 triangles and the file holds 68 in 3484 bytes"));
}

TEST_F(StlFile, ByteOrderMarkIsSkipped) {
  write_stl(file, mesh, 1e-3);
  const TriangleMesh read = read_stl(file, 1e-3);
  put("\xEF\xBB\xBF" + text_of(mesh, 1e-3, "\n"));
  expect_same(read_stl(file, 1e-3), read);
}

TEST_F(StlFile, LimitsAreCheckedBeforeTheTrianglesAreRead) {
  // Two million triangles that are not on the disk: a file with a hole.
  std::string header(84, ' ');
  constexpr std::uint32_t kMany = 2000000;
  for (std::size_t i = 0; i < 4; ++i) header[80 + i] = static_cast<char>(kMany >> (8 * i) & 0xff);
  put(header);
  std::filesystem::resize_file(file, 84 + 50ull * kMany);
  EXPECT_THAT(refusal(), HasSubstr("has 2000000 triangles; expected at most 200000"));
  put("solid long\n");
  std::filesystem::resize_file(file, 500'000'000);
  EXPECT_THAT(refusal(), HasSubstr("is longer than"));
  EXPECT_EQ(refusal().find("has 2000000"), std::string::npos);
  // One above the limit, and one at it, in both formats.
  const auto read_at = [&](std::size_t limit) {
    return read_stl(file, 1e-3, {.triangles = limit});
  };
  write_stl(file, mesh, 1e-3);
  EXPECT_EQ(read_at(68).triangles.size(), 68U);
  EXPECT_THROW(read_at(67), InputError);
  put(text_of(mesh, 1e-3, "\n"));
  EXPECT_EQ(read_at(68).triangles.size(), 68U);
  EXPECT_THROW(read_at(67), InputError);
}

TEST_F(StlFile, SizesThatSuggestAnotherUnitAreRefused) {
  const double size = (bounding_box(mesh)[1] - bounding_box(mesh)[0]).maxCoeff();
  write_stl(file, mesh, 1e-3);
  struct Member {
    double longest;
    bool particle, boundary;
  };
  for (const Member& m : {Member{0.9e-6, false, true},
                          {1.1e-6, true, true},
                          {99, true, true},
                          {101, false, true},
                          {9.9e3, false, true},
                          {10.1e3, false, false}}) {
    const double unit = 1e-3 * m.longest / size;
    const auto reads = [&](const MeshLimits& limits) {
      try {
        read_stl(file, unit, limits);
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("any_size = true"));
        return false;
      }
      return true;
    };
    EXPECT_EQ(reads(kParticleMesh), m.particle) << m.longest;
    EXPECT_EQ(reads(kBoundaryMesh), m.boundary) << m.longest;
    EXPECT_TRUE(reads(without_size_limits(kParticleMesh))) << m.longest;
  }
  EXPECT_THROW(read_stl(file, 1e-33 / size, without_size_limits(kParticleMesh)), InputError);
}

TEST_F(StlFile, TruncatedBinaryIsRefused) {
  spoil([](std::string& bytes) { bytes.resize(bytes.size() - 1); });
  EXPECT_THAT(refusal(), HasSubstr("header states 68 triangles and the file holds 67"));
}

TEST_F(StlFile, ImpossibleCountIsRefused) {
  spoil([](std::string& bytes) { bytes.replace(80, 4, "\xff\xff\xff\xff"); });
  EXPECT_THAT(refusal(), HasSubstr("header states 4294967295 triangles and the file holds 68"));
}

TEST_F(StlFile, NoTrianglesAreRefused) {
  put(std::string(84, '\0'));
  EXPECT_THAT(refusal(), HasSubstr("holds no triangles"));
  put("solid empty\nendsolid empty\n");
  EXPECT_THAT(refusal(), HasSubstr("holds no triangles"));
}

TEST_F(StlFile, CoordinatesThatAreNoLengthsAreRefused) {
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity(), 1e30f}) {
    spoil([value](std::string& bytes) { put_float(bytes, 84 + 50 + 12, value); });
    EXPECT_THAT(refusal(), HasSubstr("triangle 2 has the corner"));
  }
  put("solid s\nfacet normal 0 0 1\nouter loop\nvertex 1e99 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid s\n");
  EXPECT_THAT(refusal(), HasSubstr("triangle 1 has the corner (inf, 0, 0)"));
}

TEST_F(StlFile, TextErrorsNameTheirLine) {
  const std::string start = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
  put(start + "vertex 1 0 zero\n");
  EXPECT_THAT(refusal(), HasSubstr(":5: \"zero\" is out of place; expected a number"));
  put(start + "vertex 1 0 0\n");
  EXPECT_THAT(refusal(), HasSubstr(":6: the file ends early; expected \"vertex\""));
  put(start + "vertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid\n");
  EXPECT_THAT(refusal(), HasSubstr(":7: \"vertex\" is out of place; expected \"endloop\""));
  put(start + "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n");
  EXPECT_THAT(refusal(), HasSubstr("expected \"facet\" or \"endsolid\""));
}

TEST_F(StlFile, OtherFilesAreRefused) {
  EXPECT_THAT(refusal(), HasSubstr("cannot be opened"));
  put("");
  EXPECT_THAT(refusal(), HasSubstr("empty"));
  put("v 0 0 0\n");
  EXPECT_THAT(refusal(), HasSubstr("neither"));
  put(std::string(500, 'v'));
  EXPECT_THAT(refusal(), HasSubstr("expected a whole binary STL file"));
  EXPECT_THROW(write_stl("no/such/folder/x.stl", mesh, 1), InputError);
  EXPECT_THROW(read_stl(test::scratch_path(""), 1), InputError);
}

TEST_F(StlFile, HashIsThatOfTheBytes) {
  write_stl(file, mesh, 1e-3);
  const MeshFile a = read_mesh_file(file, 1e-3);
  expect_same(a.mesh, read_stl(file, 1e-3));
  EXPECT_EQ(a.sha256.size(), 64u);
  spoil([](std::string& bytes) { bytes[0] = 'B'; });
  EXPECT_NE(read_mesh_file(file, 1e-3).sha256, a.sha256);
}

}  // namespace
}  // namespace firn
