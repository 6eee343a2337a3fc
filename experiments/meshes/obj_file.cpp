#include "experiments/meshes/obj_file.h"

#include <fmt/format.h>
#define TINYOBJLOADER_USE_DOUBLE  // as the library is built
#include <tiny_obj_loader.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

namespace firn {
namespace {

// The library takes what it cannot read for 0, and exponents beyond its own for anything, so
// vertices are read here and faces are looked at first.
class LineCheck {
 public:
  LineCheck(const std::string& file, std::size_t most) : file_(file), most_(most) {}

  void check(const std::string& line) {
    ++line_;
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Vec3& v = coordinates_.emplace_back();
      for (int k = 0; k < 3; ++k) v[k] = number(words);
      ++vertices_;
    } else if (word == "f") {
      std::size_t corners = 0;
      for (; words >> word; ++corners) {
        if (corners == kMostCorners)
          fail(fmt::format("a face of more than {} corners; expected fewer", kMostCorners));
        vertex(word);
      }
      if (corners < 3) fail(fmt::format("a face of {} corners; expected at least three", corners));
      triangles_ += corners - 2;
      if (triangles_ > most_)
        fail(fmt::format("has more than {} triangles; expected at most so many", most_));
    }
  }

  std::vector<Vec3> coordinates() && { return std::move(coordinates_); }

 private:
  double number(std::istringstream& words) {
    std::string word;
    words >> word;
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc() || end != word.data() + word.size() ||
        !std::isfinite(value))
      fail(fmt::format("\"{}\" is not a coordinate; expected \"v X Y Z\"", word));
    return value;
  }
  // "7", "7/1/2", "-1": the last one so far.
  void vertex(const std::string& word) {
    long index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    const bool whole = end == word.data() + word.size() || *end == '/';
    if (error != std::errc() || !whole)
      fail(fmt::format("\"{}\" is not a vertex; expected its number", word));
    if (index == 0 || index > vertices_ || index < -vertices_)
      fail(fmt::format("vertex {} is not there; {} came before", index, vertices_));
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_, line_, what));
  }

  static constexpr std::size_t kMostCorners = 1000;

  std::string file_;
  std::size_t most_, triangles_ = 0;
  long line_ = 0, vertices_ = 0;
  std::vector<Vec3> coordinates_;
};

}  // namespace

TriangleMesh read_obj(const std::string& file, const std::string& bytes, std::size_t limit) {
  LineCheck lines(file, limit);
  std::istringstream text(bytes);
  for (std::string line; std::getline(text, line);) lines.check(line);
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = true;
  config.vertex_color = false;
  if (!reader.ParseFromString(bytes, "", config))
    throw InputError(fmt::format("{}: is no OBJ file: {}", file, reader.Error()));
  TriangleMesh mesh;
  mesh.vertices = std::move(lines).coordinates();
  // The library may take blanks and ends of lines otherwise than the check of the lines does.
  if (const std::size_t taken = reader.GetAttrib().vertices.size() / 3;
      taken != mesh.vertices.size())
    throw InputError(
        fmt::format("{}: has {} or {} vertices, by how blanks are taken; expected spaces "
                    "and line feeds",
                    file, mesh.vertices.size(), taken));
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    const std::vector<tinyobj::index_t>& corners = shape.mesh.indices;
    for (const tinyobj::index_t& c : corners) {
      if (c.vertex_index < 0 || static_cast<std::size_t>(c.vertex_index) >= mesh.vertices.size())
        throw InputError(fmt::format("{}: a face has vertex {} of {}; expected one that is there",
                                     file, c.vertex_index + 1, mesh.vertices.size()));
    }
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      mesh.triangles.push_back(
          {corners[i].vertex_index, corners[i + 1].vertex_index, corners[i + 2].vertex_index});
  }
  return mesh;
}

}  // namespace firn
