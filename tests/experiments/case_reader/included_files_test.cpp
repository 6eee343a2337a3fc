// Cases that include other files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "tests/experiments/run/harvest_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using harvest_scene::kMaterials;
using testing::HasSubstr;

// A mesh that does not exist, a floor and a lid.
constexpr const char* kParts = R"(
[shapes.other]
kind = "mesh"
file = "cube.stl"
length_unit = "mm"
material = "ice"
[[boundaries]]
name = "floor"
kind = "plane"
material = "plastic"
normal = [0, 0, 1]
[[boundaries]]
name = "lid"
kind = "plane"
material = "plastic"
normal = [0, 0, -1]
point = "0 0 1 m"
)";

// Moves the lid, and adds a wall.
constexpr const char* kIncluding = R"(
include = ["lib/machine.toml"]
[case]
duration = "1 ms"
[materials.ice]
young_modulus = "3 MPa"
[[boundaries]]
name = "lid"
point = "0 0 2 m"
[[boundaries]]
name = "wall"
kind = "plane"
material = "plastic"
normal = [1, 0, 0]
point = "-1 0 0 m"
[[particles]]
shape = "cube"
position = "0 0 0.5 m"
)";

// In place of the mesh.
const Override kSphere = {"shapes.other",
                          "{ kind = \"sphere\", radius = \"1 cm\", material = \"ice\" }"};

class IncludedFiles : public testing::Test {
 protected:
  IncludedFiles() {
    write("lib/parts.toml", kParts);
    write("lib/machine.toml", std::string("include = \"parts.toml\"\n") + kMaterials);
    write("case.toml", kIncluding);
  }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  std::string error_of(const std::string& name) const {
    return test::error_of([&] { read_case(folder_ / name); });
  }
  std::string error_of_text(const std::string& text) const {
    write("bad.toml", text);
    return error_of("bad.toml");
  }

  const test::ScratchFolder folder_{"included"};
};

// The path of the mesh is relative to the file that names it.
TEST_F(IncludedFiles, PathsAreRelativeToTheFileThatHasThem) {
  EXPECT_THAT(error_of("case.toml"), HasSubstr("lib/parts.toml:"));
  EXPECT_THAT(error_of("case.toml"), HasSubstr("lib/cube.stl"));
}

TEST_F(IncludedFiles, TablesAreMerged) {
  const Case c = read_case(folder_ / "case.toml", {kSphere});
  ASSERT_EQ(c.model.boundaries.size(), 3u);
  EXPECT_EQ(c.model.boundaries[0].name, "floor");
  EXPECT_EQ(c.model.boundaries[1].name, "lid");  // changed, not added
  EXPECT_DOUBLE_EQ(c.model.boundaries[1].origin.z(), 2);
  EXPECT_EQ(c.model.boundaries[2].name, "wall");
  EXPECT_DOUBLE_EQ(c.model.materials[0].young_modulus, 3e6);
  EXPECT_DOUBLE_EQ(c.model.materials[0].density, 916.7);
  // What was read needs the files no more.
  EXPECT_EQ(c.resolved.find("include"), std::string::npos);
  EXPECT_EQ(read_case_text(c.resolved, "again.toml", "/").resolved, c.resolved);
}

// An element changes the one of that name in an included file, not another one in the same file.
TEST_F(IncludedFiles, ElementsOfOneFileAreNotMerged) {
  write("case.toml", std::string(kIncluding) +
                         "[[boundaries]]\nname = \"wall\"\nkind = \"plane\"\nmaterial = "
                         "\"plastic\"\nnormal = [-1, 0, 0]\npoint = \"1 0 0 m\"\n");
  const std::string error = test::error_of([&] { read_case(folder_ / "case.toml", {kSphere}); });
  EXPECT_THAT(error, HasSubstr("case.toml:"));
  EXPECT_THAT(error, HasSubstr("wall"));
}

TEST_F(IncludedFiles, MistakesAreNamed) {
  EXPECT_THAT(error_of_text("\ninclude = \"nowhere.toml\""), HasSubstr("bad.toml:2: include: "));
  EXPECT_THAT(error_of_text("include = 3"),
              HasSubstr("is the bare number 3; expected the name of a file"));
  EXPECT_THAT(error_of_text("include = \"bad.toml\""), HasSubstr("expected no circle"));
  write("lib/broken.toml", "\n\n[[boundaries]]\nname = \"x\"\nkind = \"plank\"");
  EXPECT_THAT(error_of_text("include = \"lib/broken.toml\"\n[case]\nduration = \"1 s\"\n" +
                            std::string(kMaterials)),
              HasSubstr("lib/broken.toml:5: boundaries.x.kind"));
}

}  // namespace
}  // namespace firn
