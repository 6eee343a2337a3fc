#include "experiments/export/export.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "experiments/case_reader/read_case.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

// A cube of 0.1 m whose center falls from 1 m for 0.1 s. A panel moves next to it; below is a
// plane.
constexpr const char* kFall = R"(
[case]
name = "fall"
duration = "0.1 s"
timestep = "1e-4 s"
[materials.ice]
density = "1000 kg/m^3"
young_modulus = "0.01 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "0.1 0.1 0.1 m"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 1 m"
orientation = [1, 0, 0, 0]
tag = 4
[[boundaries]]
name = "floor"
material = "ice"
kind = "plane"
normal = [0, 0, 1]
[[boundaries]]
name = "panel"
material = "ice"
kind = "box"
position = "2 0 0 m"
orientation = [1, 0, 0, 0]
size = "0.2 0.2 0.2 m"
allow_overlap_with = ["floor"]
motions = [{ kind = "translation", velocity = "1 0 0 m/s" }]
[[sensors]]
name = "half way"
point = "0 0 0.5 m"
normal = [0, 0, -1]
[output]
frame_interval = "20 ms"
)";

class ExportTest : public ResultsFolder {
 protected:
  void SetUp() override {
    RunOptions options;
    options.results_file = (directory_ / "run.h5").string();
    const Case c = read_case_text(kFall, "fall.toml", ".");
    ASSERT_EQ(run(c, options).status, RunStatus::finished);
    recording_ = std::make_unique<Recording>(options.results_file);
  }

  std::vector<std::string> lines(const std::string& file) const {
    std::ifstream in(directory_ / file);
    std::vector<std::string> result;
    for (std::string line; std::getline(in, line);) result.push_back(line);
    return result;
  }

  std::unique_ptr<Recording> recording_;
};

TEST_F(ExportTest, CsvReadsBackExactly) {
  export_csv(*recording_, directory_.string());
  const std::vector<std::string> frames = lines("frames.csv");
  ASSERT_EQ(frames.size(), 1u + 6u);
  EXPECT_THAT(frames[0], StartsWith("time [s],particle,x [m],y [m],z [m],qw"));
  EXPECT_EQ(frames[1], "0,0,0,0,1,1,0,0,0,0,0,0,0,0,0");
  double time = 0, z = 0;
  ASSERT_EQ(std::sscanf(frames[6].c_str(), "%lf,0,%*f,%*f,%lf", &time, &z), 2);
  EXPECT_EQ(time, recording_->frame_times().back());
  EXPECT_EQ(z, recording_->frame(5).position[0][2]);

  const std::vector<std::string> series = lines("series.csv");
  ASSERT_EQ(series.size(), 7u);
  EXPECT_THAT(series[0], HasSubstr(",energy/kinetic [J],"));
  EXPECT_THAT(series[0], HasSubstr(",boundaries/panel/position.x [m],"));
  EXPECT_EQ(std::count(series[0].begin(), series[0].end(), ','),
            std::count(series[6].begin(), series[6].end(), ','));
  EXPECT_THAT(lines("particles.csv")[0],
              testing::EndsWith(",batch,insert_time [s],outlet,half way_time [s]"));
  EXPECT_THAT(lines("particles.csv")[1], StartsWith("0,0,4,1"));
  EXPECT_THAT(lines("particles.csv")[1], testing::EndsWith(",-1,0,,"));  // not through the gate
  EXPECT_EQ(lines("responses.csv")[0], "name,index,value,uncertainty,unit,method,method_version");
}

TEST_F(ExportTest, VtkIndexNamesEveryFrame) {
  export_vtk(*recording_, directory_.string(), {.every = 2});
  std::string index;
  for (const std::string& line : lines("particles.pvd")) index += line;
  for (int i : {0, 2, 4}) {
    const std::string file = fmt::format("particles/particles_{:06}.vtp", i);
    EXPECT_THAT(index, HasSubstr(fmt::format("timestep=\"{}\" part=\"0\" file=\"{}\"",
                                             recording_->frame_times()[static_cast<std::size_t>(i)],
                                             file)));
    EXPECT_TRUE(fs::exists(directory_ / file));
  }
  EXPECT_FALSE(fs::exists(directory_ / "particles/particles_000001.vtp"));
  EXPECT_THROW(export_vtk(*recording_, directory_.string(), {.every = 0}), InputError);
}

// ParaView's own reader sees the times, 12 triangles a box and where they are: after 0.1 s the cube
// is at 1 m - g t^2 / 2 = 0.951 m, give or take half its edge; the panel is at 2.1 m.
TEST_F(ExportTest, ParaViewReadsIt) {
  if (std::system("command -v pvpython > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ParaView (pvpython) is not installed";
  export_vtk(*recording_, directory_.string());
  const fs::path script = directory_ / "look.py", answer = directory_ / "answer.txt";
  std::ofstream(script) << fmt::format(R"(
from paraview.simple import *
out = open("{0}/answer.txt", "w")
for name in ("particles", "boundaries"):
    reader = PVDReader(FileName="{0}/" + name + ".pvd")
    times = list(reader.TimestepValues)
    reader.UpdatePipeline(times[-1])
    info = reader.GetDataInformation()
    out.write("%d %d" % (len(times), info.GetNumberOfCells()))
    out.write(" %.3f %.3f %.3f %.3f %.3f %.3f" % info.GetBounds())
    point = reader.PointData
    out.write(" " + " ".join(sorted(point[i].Name for i in range(len(point)))) + "\n")
    if name == "particles":
        out.write("%.4f %.1f\n" % (point["speed"].GetRange()[0], point["tag"].GetRange()[0]))
)",
                                       directory_.string());
  ASSERT_EQ(std::system(fmt::format("pvpython {} > /dev/null 2>&1", script.string()).c_str()), 0);
  const std::vector<std::string> seen = lines("answer.txt");
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0],
            "6 12 -0.050 0.050 -0.050 0.050 0.901 1.001 "
            "id peak_normal_force speed tag velocity");
  EXPECT_EQ(seen[1], "0.9810 4.0");
  int times = 0, cells = 0;
  double low = 0, high = 0;
  ASSERT_EQ(std::sscanf(seen[2].c_str(), "%d %d %lf %lf", &times, &cells, &low, &high), 4);
  EXPECT_EQ(times, 6);
  EXPECT_EQ(cells, 12 + 1);  // the panel, and a square for the plane
  EXPECT_NEAR(high, 2.2, 1e-3);
}

TEST_F(ExportTest, ContactPartsAreASmallerMesh) {
  export_vtk(*recording_, directory_.string(), {.contact_parts = true});
  EXPECT_THAT(test::read_text(directory_ / "particles/particles_000000.vtp"),
              HasSubstr("NumberOfPolys=\"6\""));  // the faces of a box
}

}  // namespace
}  // namespace firn
