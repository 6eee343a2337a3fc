#include "reports/scene_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "experiments/machine/parts.h"
#include "tests/scratch_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

TEST(ScenePicture, NamesWallsAndDrawsFourViews) {
  const Solid cup = make_container({});
  ScenePicture picture;
  picture.title = "a cup";
  picture.subtitle = "empty";
  picture.walls = {{"the cup", {&cup.mesh, {}}}};
  picture.width = 300;
  const std::string file = test::scratch_path("scene.svg");
  draw_scene(picture, file);
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  for (const char* word : {"a cup", "empty", "the cup", "from above", "section along x",
                           "section across x", "x / mm", "y / mm", "z / mm"}) {
    EXPECT_THAT(text.str(), HasSubstr(word));
  }
}

TEST(ScenePicture, AnEmptySceneAndUnknownFormatsAreRefused) {
  ScenePicture picture;
  picture.title = "nothing";
  EXPECT_THROW(draw_scene(picture, test::scratch_path("scene.png")), InputError);
  EXPECT_THROW(draw_scene(picture, test::scratch_path("scene.bmp")), InputError);
}

}  // namespace
}  // namespace firn
