#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/export/export.h"
#include "experiments/export/scene_extent.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

using nlohmann::json;

// Codes of glTF 2.0, section 3.6.2 (accessors) and 3.6.1.2 (targets of buffer views).
constexpr int kFloat32 = 5126, kUint32 = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;

// The binary chunk and what refers to it. All values are 4 bytes wide, so that offsets stay
// aligned.
class GltfBuffer {
 public:
  // Rows of `width` floats; `bounds`: the accessor states its least and largest values.
  int add(const std::vector<float>& values, std::size_t width, bool bounds, int target = 0) {
    static const std::map<std::size_t, const char*> types{{1, "SCALAR"}, {3, "VEC3"}, {4, "VEC4"}};
    json accessor{{"bufferView", append(values.data(), values.size(), target)},
                  {"componentType", kFloat32},
                  {"count", values.size() / width},
                  {"type", types.at(width)}};
    if (bounds) {
      std::vector<float> least(width, std::numeric_limits<float>::max());
      std::vector<float> largest(width, std::numeric_limits<float>::lowest());
      for (std::size_t i = 0; i < values.size(); ++i) {
        least[i % width] = std::min(least[i % width], values[i]);
        largest[i % width] = std::max(largest[i % width], values[i]);
      }
      accessor["min"] = least;
      accessor["max"] = largest;
    }
    return keep(accessor);
  }
  int add_indices(const std::vector<std::uint32_t>& indices) {
    return keep({{"bufferView", append(indices.data(), indices.size(), kElementBuffer)},
                 {"componentType", kUint32},
                 {"count", indices.size()},
                 {"type", "SCALAR"}});
  }

  std::string bytes;
  json accessors = json::array(), views = json::array();

 private:
  template <class Value>
  int append(const Value* values, std::size_t count, int target) {
    static_assert(sizeof(Value) == 4);
    json view{{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", 4 * count}};
    if (target != 0) view["target"] = target;
    views.push_back(std::move(view));
    bytes.append(reinterpret_cast<const char*>(values), 4 * count);
    return static_cast<int>(views.size()) - 1;
  }
  int keep(json accessor) {
    accessors.push_back(std::move(accessor));
    return static_cast<int>(accessors.size()) - 1;
  }
};

// Where a body is at each frame; NaN where it does not exist.
struct Path {
  std::vector<Vec3> position;
  std::vector<Quat> orientation;
};

void append_vector(std::vector<float>& values, const Vec3& v) {
  for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(v[k]));
}

class GltfScene {
 public:
  explicit GltfScene(const std::vector<double>& times) : times_(times) {
    // glTF's vertical axis is y, Firn's is z.
    const double half = std::numbers::sqrt2 / 2;
    nodes_.push_back(
        {{"name", "firn"}, {"rotation", {-half, 0, 0, half}}, {"children", json::array()}});
  }

  int add_material(const std::string& name, std::array<double, 3> color, double opacity) {
    json material{{"name", name},
                  {"doubleSided", true},
                  {"pbrMetallicRoughness",
                   {{"baseColorFactor", {color[0], color[1], color[2], opacity}},
                    {"metallicFactor", 0},
                    {"roughnessFactor", 0.6}}}};
    if (opacity < 1) material["alphaMode"] = "BLEND";
    materials_.push_back(std::move(material));
    return static_cast<int>(materials_.size()) - 1;
  }

  // The accessors of a surface: positions without normals, which makes viewers shade each triangle
  // flat.
  struct Surface {
    int positions = 0, indices = 0;
  };
  Surface add_surface(const TriangleMesh& mesh, const Vec3& origin) {
    std::vector<float> positions;
    for (const Vec3& v : mesh.vertices) append_vector(positions, v - origin);
    std::vector<std::uint32_t> indices;
    for (const auto& t : mesh.triangles)
      for (const int corner : t) indices.push_back(static_cast<std::uint32_t>(corner));
    Surface surface;
    surface.positions = buffer_.add(positions, 3, true, kArrayBuffer);
    surface.indices = buffer_.add_indices(indices);
    return surface;
  }
  int add_mesh(const std::string& name, const Surface& surface, int material) {
    meshes_.push_back({{"name", name},
                       {"primitives",
                        {{{"attributes", {{"POSITION", surface.positions}}},
                          {"indices", surface.indices},
                          {"material", material}}}}});
    return static_cast<int>(meshes_.size()) - 1;
  }

  // A body that exists at no frame is left out.
  void add_body(const std::string& name, int mesh, const Path& path) {
    const std::size_t frames = path.position.size();
    std::vector<bool> exists(frames);
    for (std::size_t i = 0; i < frames; ++i) exists[i] = path.position[i].allFinite();
    const auto first =
        static_cast<std::size_t>(std::find(exists.begin(), exists.end(), true) - exists.begin());
    if (first == frames) return;
    // Where the body does not exist it has scale 0 and stays at the nearest earlier place, or at
    // its first one.
    std::vector<Vec3> position(frames);
    std::vector<Quat> orientation(frames);
    std::size_t known = first;
    for (std::size_t i = 0; i < frames; ++i) {
      if (exists[i]) known = i;
      position[i] = path.position[known];
      orientation[i] = path.orientation[known];
      // Interpolation takes the shorter of the two ways.
      if (i > 0 && orientation[i].dot(orientation[i - 1]) < 0) orientation[i].coeffs() *= -1;
    }
    const auto differs = [&](std::size_t i) {
      return position[i] != position[0] || orientation[i].coeffs() != orientation[0].coeffs();
    };
    bool moves = false;
    for (std::size_t i = 0; i < frames; ++i) moves = moves || differs(i);
    const bool always = std::find(exists.begin(), exists.end(), false) == exists.end();
    const Quat& q = orientation[0];
    json node{{"name", name},
              {"mesh", mesh},
              {"translation", {position[0].x(), position[0].y(), position[0].z()}},
              {"rotation", {q.x(), q.y(), q.z(), q.w()}}};
    if (!exists[0]) node["scale"] = {0, 0, 0};
    const auto index = static_cast<int>(nodes_.size());
    nodes_.push_back(std::move(node));
    nodes_[0]["children"].push_back(index);
    if (moves) {
      std::vector<float> translations, rotations;
      for (const Vec3& p : position) append_vector(translations, p);
      for (const Quat& o : orientation)
        for (const double value : {o.x(), o.y(), o.z(), o.w()})
          rotations.push_back(static_cast<float>(value));
      animate(index, "translation", "LINEAR", buffer_.add(translations, 3, false));
      animate(index, "rotation", "LINEAR", buffer_.add(rotations, 4, false));
    }
    if (!always) {
      std::vector<float> scales;
      for (const bool here : exists) scales.insert(scales.end(), 3, here ? 1.0F : 0.0F);
      animate(index, "scale", "STEP", buffer_.add(scales, 3, false));
    }
  }

  // A .glb file: header, the chunk of JSON, the binary chunk (glTF 2.0, section 4).
  std::string to_glb() {
    json document{{"asset", {{"version", "2.0"}, {"generator", "Firn"}}},
                  {"scene", 0},
                  {"scenes", {{{"nodes", {0}}}}},
                  {"nodes", nodes_},
                  {"meshes", meshes_},
                  {"materials", materials_},
                  {"accessors", buffer_.accessors},
                  {"bufferViews", buffer_.views},
                  {"buffers", {{{"byteLength", buffer_.bytes.size()}}}}};
    if (!channels_.empty()) {
      document["animations"] = {
          {{"name", "run"}, {"channels", channels_}, {"samplers", samplers_}}};
    }
    std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t length = 12 + 8 + text.size() + 8 + buffer_.bytes.size();
    if (length > std::numeric_limits<std::uint32_t>::max()) {
      throw InputError(
          fmt::format("the scene takes {:.1f} GB as glTF, whose limit is 4.3 GB; expected fewer "
                      "frames (--every)",
                      static_cast<double>(length) / 1e9));
    }
    std::string file;
    file.reserve(length);
    const auto add_word = [&](std::size_t word) {
      const auto value = static_cast<std::uint32_t>(word);
      char bytes[4];
      std::memcpy(bytes, &value, 4);
      file.append(bytes, 4);
    };
    constexpr std::uint32_t magic = 0x46546C67, json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
    for (const std::size_t word :
         {std::size_t{magic}, std::size_t{2}, length, text.size(), std::size_t{json_chunk}})
      add_word(word);
    file += text;
    add_word(buffer_.bytes.size());
    add_word(binary_chunk);
    return file + buffer_.bytes;
  }

 private:
  void animate(int node, const char* path, const char* interpolation, int output) {
    if (input_ < 0) {
      std::vector<float> seconds;
      for (const double t : times_) seconds.push_back(static_cast<float>(t));
      input_ = buffer_.add(seconds, 1, true);
    }
    channels_.push_back(
        {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers_.push_back({{"input", input_}, {"output", output}, {"interpolation", interpolation}});
  }

  std::vector<double> times_;
  GltfBuffer buffer_;
  json nodes_ = json::array(), meshes_ = json::array(), materials_ = json::array();
  json channels_ = json::array(), samplers_ = json::array();
  int input_ = -1;
};

// Colors of Okabe and Ito, which color-blind readers distinguish; the first is that of ice.
std::array<double, 3> tag_color(std::size_t tag) {
  static constexpr std::array<std::array<double, 3>, 7> colors{{{0.34, 0.71, 0.91},
                                                                {0.90, 0.62, 0.00},
                                                                {0.00, 0.62, 0.45},
                                                                {0.80, 0.47, 0.65},
                                                                {0.84, 0.37, 0.00},
                                                                {0.94, 0.89, 0.26},
                                                                {0.00, 0.45, 0.70}}};
  return colors[tag % colors.size()];
}

TriangleMesh square_mesh(double reach) {
  TriangleMesh mesh;
  mesh.vertices = {{-reach, -reach, 0}, {reach, -reach, 0}, {reach, reach, 0}, {-reach, reach, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// The frames that are exported, and where all bodies are at each.
struct Movement {
  std::vector<double> times;                // s
  std::vector<Path> particles, boundaries;  // [bodies]
};
Movement movement_of(const Recording& recording, const Model& model, std::size_t every) {
  const std::vector<double> times = recording.frame_times();
  if (times.empty())
    throw InputError(recording.file() + ": holds no frame; expected a run that has begun");
  Movement all;
  all.particles.resize(model.particles.size());
  all.boundaries.resize(model.boundaries.size());
  for (std::size_t i = 0; i < times.size(); i += every) {
    all.times.push_back(times[i]);
    const Frame frame = recording.frame(i);
    for (std::size_t p = 0; p < all.particles.size(); ++p) {
      const auto& q = frame.orientation[p];
      all.particles[p].position.emplace_back(frame.position[p].data());
      all.particles[p].orientation.emplace_back(q[0], q[1], q[2], q[3]);
    }
    for (std::size_t b = 0; b < all.boundaries.size(); ++b) {
      const BoundaryFrame state = recording.boundary(model.boundaries[b].name, i);
      all.boundaries[b].position.push_back(state.position);
      all.boundaries[b].orientation.push_back(state.orientation);
    }
  }
  return all;
}

// `plane`: half the edge of the square that stands for a plane, m.
void add_boundary_bodies(GltfScene& scene, const Model& model, const std::vector<Path>& paths,
                         double plane) {
  const int wall = scene.add_material("boundary", {0.55, 0.55, 0.58}, 0.35);
  for (std::size_t b = 0; b < paths.size(); ++b) {
    const Boundary& boundary = model.boundaries[b];
    const TriangleMesh mesh = boundary.mesh.triangles.empty() ? square_mesh(plane) : boundary.mesh;
    const int id = scene.add_mesh(boundary.name, scene.add_surface(mesh, Vec3::Zero()), wall);
    scene.add_body(boundary.name, id, paths[b]);
  }
}

void add_particle_bodies(GltfScene& scene, const Model& model, const std::vector<Path>& paths) {
  std::vector<GltfScene::Surface> surfaces;
  for (const Shape& shape : model.shapes)
    surfaces.push_back(scene.add_surface(shape.mesh, shape.centroid));
  // One mesh for each shape and tag; tags take colors in their order.
  std::map<int, int> tag_material;
  for (const Particle& particle : model.particles) tag_material[particle.tag] = 0;
  std::size_t tags = 0;
  for (auto& [tag, material] : tag_material)
    material = scene.add_material(fmt::format("tag {}", tag), tag_color(tags++), 1);
  std::map<std::pair<int, int>, int> meshes;
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const Particle& particle = model.particles[p];
    const auto shape = static_cast<std::size_t>(particle.shape);
    const auto [mesh, added] = meshes.try_emplace({particle.shape, particle.tag}, 0);
    if (added) {
      mesh->second =
          scene.add_mesh(fmt::format("{}, tag {}", model.shapes[shape].name, particle.tag),
                         surfaces[shape], tag_material.at(particle.tag));
    }
    scene.add_body(fmt::format("particle {}", p), mesh->second, paths[p]);
  }
}

}  // namespace

void export_gltf(const Recording& recording, const std::string& file, int every) {
  if (every < 1) throw InputError("every: is below 1; expected each how many frames");
  const auto step = static_cast<std::size_t>(every);
  const Case c = read_case(recording);
  const Movement movement = movement_of(recording, c.model, step);
  GltfScene scene(movement.times);
  add_boundary_bodies(scene, c.model, movement.boundaries,
                      drawn_plane_extent(recording, c.model, step));
  add_particle_bodies(scene, c.model, movement.particles);
  write_file(file, scene.to_glb());
}

}  // namespace firn
