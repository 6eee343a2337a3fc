#include "reports/rendering/scene_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "experiments/machine/parts.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

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
  const std::string text = test::read_text(file);
  std::filesystem::remove(file);
  for (const char* word : {"a cup", "empty", "the cup", "from above", "section along x",
                           "section across x", "x / mm", "y / mm", "z / mm"}) {
    EXPECT_THAT(text, HasSubstr(word));
  }
}

// However many names there are, each stands inside the picture; the ice has its own entries.
TEST(ScenePicture, TheLegendIsComplete) {
  const Solid cup = make_container({});
  ScenePicture picture;
  picture.title = "many";
  for (int i = 0; i < 60; ++i)
    picture.walls.push_back({"boundary number " + std::to_string(i), {&cup.mesh, {}}});
  for (int tag = 0; tag < 12; ++tag) {
    picture.particles.push_back({&cup.mesh, {}});
    picture.tags.push_back(tag);
  }
  picture.width = 400;
  const std::string file = test::scratch_path("legend.svg");
  draw_scene(picture, file);
  const std::string text = test::read_text(file);
  std::filesystem::remove(file);
  for (int i = 0; i < 60; ++i)
    EXPECT_THAT(text, HasSubstr("boundary number " + std::to_string(i) + "<"));
  EXPECT_THAT(text, HasSubstr("tag 0<"));
  EXPECT_THAT(text, HasSubstr("tag 11<"));
  EXPECT_THAT(text, testing::Not(HasSubstr("tag 5<")));
  // The last name is above the lower end of the picture.
  std::smatch size, place;
  ASSERT_TRUE(std::regex_search(text, size, std::regex("viewBox=\"0 0 400 ([0-9]+)\"")));
  const std::string before = text.substr(0, text.find("boundary number 59<"));
  const std::size_t at = before.rfind("translate(");
  const std::string where = before.substr(at, 60);
  ASSERT_TRUE(std::regex_search(where, place, std::regex(",([0-9.]+)\\)")));
  EXPECT_LT(std::stod(place[1]), std::stod(size[1]));
}

// The only kind of bodies, and a boundary that the title names, need no legend.
TEST(ScenePicture, ALegendOfOneEntryIsLeftOut) {
  const Solid cup = make_container({});
  const auto drawn = [&](const ScenePicture& picture) {
    const std::string file = test::scratch_path("one entry.svg");
    draw_scene(picture, file);
    const std::string text = test::read_text(file);
    std::filesystem::remove(file);
    return text;
  };
  ScenePicture picture;
  picture.title = "grains";
  picture.width = 300;
  picture.particles = {{&cup.mesh, {}}, {&cup.mesh, {}}};
  picture.tags = {3, 3};
  EXPECT_THAT(drawn(picture), testing::Not(HasSubstr("■")));
  picture.tags = {3, 4};
  EXPECT_THAT(drawn(picture), HasSubstr("tag 4<"));
  picture.tags = {3, 3};
  picture.walls = {{"the cup", {&cup.mesh, {}}}};
  EXPECT_THAT(drawn(picture), HasSubstr("bodies<"));
  picture.particles.clear();
  picture.tags.clear();
  EXPECT_THAT(drawn(picture), HasSubstr("the cup<"));
  picture.title = "the cup";
  EXPECT_THAT(drawn(picture), testing::Not(HasSubstr("■")));
}

TEST(ScenePicture, AnEmptySceneAndUnknownFormatsAreRefused) {
  ScenePicture picture;
  picture.title = "nothing";
  EXPECT_THROW(draw_scene(picture, test::scratch_path("scene.png")), InputError);
  EXPECT_THROW(draw_scene(picture, test::scratch_path("scene.bmp")), InputError);
}

}  // namespace
}  // namespace firn
