// Scenes of results files.
#include <gtest/gtest.h>

#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "reports/rendering/scene_picture.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

class SceneSources : public ResultsFolder {};

// A bridge is drawn between its bodies. A bond of the whole section lies within them.
TEST_F(SceneSources, ShowBondsThatTheirBodiesDoNotHide) {
  const std::string bodies = R"(
[case]
duration = "2 ms"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
poisson_ratio = 0.33
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 0 mm"
grid = [2, 1, 1]
spacing = "21 0 0 mm"
[[bonds]]
name = "b"
pairs = [[0, 1]]
length = "20 mm"
tensile_strength = "1 MPa"
shear_strength = "1 MPa"
)";
  const auto drawn = [&](const std::string& section) {
    run(read_case_text(bodies + section, "c.toml", "."), options("bonds.h5"));
    const Recording recording(path("bonds.h5"));
    RecordedScenes scenes(recording);
    const ScenePicture picture = scenes.scene(0);
    EXPECT_NE(picture.subtitle.find("2 of 2 bodies, 1 bond holds"), std::string::npos)
        << picture.subtitle;
    return picture.particles.size();
  };
  EXPECT_EQ(drawn("width = \"4 mm\"\nheight = \"4 mm\"\n"), 3u);
  EXPECT_EQ(drawn("width = \"19 mm\"\nheight = \"4 mm\"\n"), 3u);
  EXPECT_EQ(drawn("width = \"19 mm\"\nheight = \"17 mm\"\n"), 2u);
}

}  // namespace
}  // namespace firn
