#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "experiments/run/run.h"
#include "experiments/system/process.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// A .glb file read by the text of the standard, independently of the writer.
struct Glb {
  json document;
  std::string binary;

  explicit Glb(const std::string& file) {
    const std::string bytes = test::read_text(file);
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    if (bytes.size() < 20) throw std::runtime_error("too short");
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), bytes.size());
    const std::size_t text = word(12);
    EXPECT_EQ(text % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    document = json::parse(bytes.substr(20, text));
    EXPECT_EQ(bytes.substr(24 + text, 4), std::string("BIN\0", 4));
    EXPECT_EQ(word(20 + text) + 28 + text, bytes.size());
    binary = bytes.substr(28 + text);
    EXPECT_EQ(document["buffers"][0]["byteLength"], binary.size());
  }

  std::vector<float> values(const json& index) const {
    const json& accessor = document["accessors"].at(index.get<std::size_t>());
    const json& view = document["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    const std::string type = accessor["type"];
    const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
    EXPECT_EQ(view["byteLength"], 4 * width * accessor["count"].get<std::size_t>());
    std::vector<float> result(width * accessor["count"].get<std::size_t>());
    const std::size_t at = view["byteOffset"];
    EXPECT_EQ(at % 4, 0u);
    EXPECT_LE(at + 4 * result.size(), binary.size());
    std::memcpy(result.data(), binary.data() + at, 4 * result.size());
    return result;
  }
  std::size_t node(const std::string& name) const {
    for (std::size_t i = 0; i < document["nodes"].size(); ++i)
      if (document["nodes"][i]["name"] == name) return i;
    throw std::runtime_error("no node " + name);
  }
  // What a node's property is at each frame: of its channel, or what it always is.
  std::vector<float> track(std::size_t node, const std::string& path, std::size_t frames,
                           std::vector<float> usual) const {
    for (const json& animation : document.value("animations", json::array()))
      for (const json& channel : animation["channels"])
        if (channel["target"]["node"] == node && channel["target"]["path"] == path)
          return values(animation["samplers"].at(channel["sampler"].get<std::size_t>())["output"]);
    const json& n = document["nodes"][node];
    if (n.contains(path)) usual = n[path].get<std::vector<float>>();
    std::vector<float> result;
    for (std::size_t i = 0; i < frames; ++i)
      result.insert(result.end(), usual.begin(), usual.end());
    return result;
  }
};

class ExportGltf : public ResultsFolder {
 protected:
  void SetUp() override {
    RunOptions options;
    options.results_file = path("run.h5");
    ASSERT_EQ(run(read_case_text(kTray, "tray.toml", "."), options).status, RunStatus::finished);
  }
};

TEST_F(ExportGltf, HasEveryBodyOfEveryFrameWhereItIs) {
  const Recording recording(path("run.h5"));
  for (const std::size_t every : {1, 3}) {
    export_gltf(recording, path("run.glb"), static_cast<int>(every));
    const Glb glb(path("run.glb"));
    std::vector<std::size_t> frames;
    for (std::size_t i = 0; i < recording.frame_times().size(); i += every) frames.push_back(i);
    const std::vector<float> times =
        glb.values(glb.document["animations"][0]["samplers"][0]["input"]);
    ASSERT_EQ(times.size(), frames.size());
    std::size_t absent = 0, present = 0;
    for (std::size_t p = 0; p < recording.particle_count(); ++p) {
      const std::size_t node = glb.node(fmt::format("particle {}", p));
      const std::vector<float> x = glb.track(node, "translation", frames.size(), {0, 0, 0});
      const std::vector<float> q = glb.track(node, "rotation", frames.size(), {0, 0, 0, 1});
      const std::vector<float> s = glb.track(node, "scale", frames.size(), {1, 1, 1});
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const Frame frame = recording.frame(frames[i]);
        EXPECT_EQ(times[i], static_cast<float>(frame.time));
        const bool exists = !std::isnan(frame.position[p][0]);
        exists ? ++present : ++absent;
        for (std::size_t k = 0; k < 3; ++k) {
          ASSERT_EQ(s[3 * i + k], exists ? 1.0F : 0.0F) << p << " " << i;
          ASSERT_TRUE(std::isfinite(x[3 * i + k]));
          if (exists) {
            ASSERT_EQ(x[3 * i + k], static_cast<float>(frame.position[p][k]));
          }
        }
        float dot = 0, norm = 0, before = 0;
        for (std::size_t k = 0; k < 4; ++k) {
          // glTF: x y z w; a frame: w x y z.
          if (exists) dot += q[4 * i + k] * static_cast<float>(frame.orientation[p][(k + 1) % 4]);
          norm += q[4 * i + k] * q[4 * i + k];
          if (i > 0) before += q[4 * i + k] * q[4 * (i - 1) + k];
        }
        EXPECT_NEAR(norm, 1, 1e-5);
        if (exists) {
          EXPECT_NEAR(std::abs(dot), 1, 1e-5) << p << " " << i;
        }
        EXPECT_GE(before, 0) << "the longer way between two frames";
      }
    }
    EXPECT_GT(absent, 0u);
    EXPECT_GT(present, 0u);
    // The lid is removed during the run, the floor at its end: both are there at the start.
    for (const char* const name : {"floor", "lid"}) {
      const std::vector<float> s = glb.track(glb.node(name), "scale", frames.size(), {1, 1, 1});
      EXPECT_EQ(s[0], 1.0F) << name;
    }
    // Shapes are about the center of mass: a cube of 20 mm.
    const json& mesh = glb.document["nodes"][glb.node("particle 0")]["mesh"];
    const json& primitive = glb.document["meshes"].at(mesh.get<std::size_t>())["primitives"][0];
    for (const float value : glb.values(primitive["attributes"]["POSITION"]))
      EXPECT_FLOAT_EQ(std::abs(value), 0.01F);
  }
}

// A second reader, of another project.
TEST_F(ExportGltf, AssimpReadsIt) {
  const Recording recording(path("run.h5"));
  export_gltf(recording, path("run.glb"));
  const CommandResult result = run_command({"assimp", "info", path("run.glb")});
  ASSERT_EQ(result.status, 0) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("Animations:         1"));
  EXPECT_THAT(result.out, HasSubstr("particle 12"));
}

TEST_F(ExportGltf, WrongRequestsAreOneLine) {
  const Recording recording(path("run.h5"));
  EXPECT_THROW(export_gltf(recording, path("run.glb"), 0), InputError);
  EXPECT_THROW(export_gltf(recording, path("none/run.glb")), InputError);
}

}  // namespace
}  // namespace firn
