#include "experiments/meshes/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "experiments/meshes/obj_file.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

// 80 bytes of title, the number of triangles, then 50 bytes each: normal, three corners, 2 bytes.
constexpr std::size_t kTitle = 80, kHeader = 84, kNormal = 12, kTriangle = 50;

std::uint32_t little_endian(const char* p) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(p[i]);
  return value;
}

float little_endian_float(const char* p) { return std::bit_cast<float>(little_endian(p)); }

[[noreturn]] void refuse_count(const std::string& place, std::size_t triangles, std::size_t limit) {
  throw InputError(
      fmt::format("{}: has {} triangles; expected at most {}", place, triangles, limit));
}

// The whole file, or a refusal once it is longer than any mesh within the limit.
std::string read_bytes(const std::string& file, const MeshLimits& limits) {
  require_regular_file(file, "an STL or OBJ file");
  std::ifstream in(file, std::ios::binary);
  constexpr std::size_t kBytesPerTriangle = 1000, kRest = 1 << 20, kBlock = 1 << 16;
  const std::size_t most = limits.triangles * kBytesPerTriangle + kRest;
  std::string bytes;
  while (in && bytes.size() <= most) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kBlock);
    in.read(&bytes[before], kBlock);
    bytes.resize(before + static_cast<std::size_t>(in.gcount()));
    // The header of a long binary file is enough.
    if (before > 0 || bytes.size() < kHeader) continue;
    std::error_code unknown;
    const std::uintmax_t length = std::filesystem::file_size(file, unknown);
    const std::size_t count = little_endian(&bytes[kTitle]);
    if (!unknown && length == kHeader + kTriangle * count && count > limits.triangles)
      refuse_count(file, count, limits.triangles);
  }
  if (in.bad() || bytes.empty()) {
    throw InputError(file + ": cannot be read or is empty; expected an STL or OBJ file");
  }
  if (bytes.size() > most) {
    throw InputError(
        fmt::format("{}: is longer than {} bytes; expected a mesh of at most {} "
                    "triangles",
                    file, most, limits.triangles));
  }
  return bytes;
}

// Three corners a triangle, in the file's unit and in its single precision.
using Corners = std::vector<Vec3>;

Corners read_binary(std::string_view bytes, std::size_t triangles) {
  Corners corners;
  corners.reserve(3 * triangles);
  for (std::size_t i = 0; i < triangles; ++i) {
    const char* corner = &bytes[kHeader + i * kTriangle + kNormal];
    for (int k = 0; k < 3; ++k, corner += 12) {
      corners.emplace_back(little_endian_float(corner), little_endian_float(corner + 4),
                           little_endian_float(corner + 8));
    }
  }
  return corners;
}

// Words of a text file, in lower case, with the line they stand on.
class Words {
 public:
  Words(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  // Empty at the end of the file.
  std::string next() {
    while (at_ < text_.size() && is_space(text_[at_])) line_ += text_[at_++] == '\n';
    std::string word;
    while (at_ < text_.size() && !is_space(text_[at_])) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(text_[at_++])));
    }
    return word;
  }

  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void expect(const char* wanted) {
    const std::string word = next();
    if (word != wanted) fail(fmt::format("{}; expected \"{}\"", found(word), wanted));
  }

  double number() {
    const std::string word = next();
    const char *first = word.data() + word.starts_with('+'), *last = word.data() + word.size();
    double value = 0;
    const auto [end, error] = std::from_chars(first, last, value);
    if (word.empty() || error != std::errc() || end != last) {
      fail(found(word) + "; expected a number");
    }
    // Single precision, as the same number has in a binary file.
    return static_cast<float>(value);
  }

  static std::string found(const std::string& word) {
    return word.empty() ? "the file ends early" : fmt::format("\"{}\" is out of place", word);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_, line_, what));
  }

 private:
  static bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

  std::string file_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

// solid NAME { facet normal X Y Z, outer loop, 3 * vertex X Y Z, endloop, endfacet } endsolid NAME
Corners read_text(const std::string& file, std::string_view text, const MeshLimits& limits) {
  Corners corners;
  Words words(file, text);
  for (std::string word = words.next(); !word.empty(); word = words.next()) {
    if (word != "solid") words.fail(Words::found(word) + "; expected \"solid\"");
    words.skip_line();  // a name of any words
    for (word = words.next(); word == "facet"; word = words.next()) {
      if (corners.size() >= 3 * limits.triangles) {
        words.fail(
            fmt::format("has more than {} triangles; expected at most so many", limits.triangles));
      }
      words.expect("normal");
      for (int k = 0; k < 3; ++k) words.next();  // some programs write nan here
      words.expect("outer");
      words.expect("loop");
      for (int k = 0; k < 3; ++k) {
        words.expect("vertex");
        const double x = words.number(), y = words.number();
        corners.emplace_back(x, y, words.number());
      }
      words.expect("endloop");
      words.expect("endfacet");
    }
    if (word != "endsolid") {
      words.fail(Words::found(word) + "; expected \"facet\" or \"endsolid\"");
    }
    words.skip_line();
  }
  return corners;
}

bool looks_like_text(std::string_view bytes) {
  const std::string_view start = bytes.substr(0, 512);
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  if (first == start.npos || start.find('\0') != start.npos) return false;
  constexpr std::string_view kSolid = "solid";
  const std::string_view word = start.substr(first, kSolid.size());
  return std::equal(word.begin(), word.end(), kSolid.begin(), kSolid.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

Corners read_corners(const std::string& file, std::string_view bytes, const MeshLimits& limits) {
  const std::size_t stated = bytes.size() >= kHeader ? little_endian(&bytes[kTitle]) : 0;
  const std::size_t held = bytes.size() >= kHeader ? (bytes.size() - kHeader) / kTriangle : 0;
  // The title of a binary file may also begin with "solid". The file size then decides.
  const bool exact = bytes.size() == kHeader + kTriangle * stated;
  if (!exact && looks_like_text(bytes)) return read_text(file, bytes, limits);
  if (bytes.size() < kHeader) {
    throw InputError(file + ": is neither a text nor a binary STL file; expected one of them");
  }
  if (!exact) {
    throw InputError(fmt::format(
        "{}: the header states {} triangles and the file holds {} in {} bytes; expected a "
        "whole binary STL file of 84 + 50 n bytes",
        file, stated, held, bytes.size()));
  }
  if (stated > limits.triangles) refuse_count(file, stated, limits.triangles);
  return read_binary(bytes, stated);
}

bool is_obj(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending == ".obj";
}

void check_size(const std::string& file, const TriangleMesh& mesh, const MeshLimits& limits) {
  const auto [low, high] = bounding_box(mesh);
  const double size = (high - low).maxCoeff();
  if (size >= limits.smallest && size <= limits.largest) return;
  throw InputError(fmt::format(
      "{}: is {:.3g} m long; expected {:g} m to {:g} m: check the length unit, or allow it by "
      "any_size = true (firn shape: --any-size)",
      file, size, limits.smallest, limits.largest));
}

// As the file has them, in meters.
TriangleMesh triangles_of(const std::string& file, std::string_view bytes, double length_unit,
                          const MeshLimits& limits) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  TriangleMesh mesh;
  if (is_obj(file)) {
    mesh = read_obj(file, std::string(bytes), limits.triangles);
  } else {
    mesh.vertices = read_corners(file, bytes, limits);
    for (int i = 0; i + 2 < static_cast<int>(mesh.vertices.size()); i += 3)
      mesh.triangles.push_back({i, i + 1, i + 2});
  }
  if (mesh.triangles.empty()) throw InputError(file + ": holds no triangles; expected a mesh");
  constexpr double kFarthest = 1e6;  // m
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 corner = mesh.vertices[i];
    mesh.vertices[i] *= length_unit;
    if (mesh.vertices[i].allFinite() && mesh.vertices[i].cwiseAbs().maxCoeff() <= kFarthest)
      continue;
    throw InputError(fmt::format(
        "{}: {} {} has the corner ({:g}, {:g}, {:g}); expected finite coordinates up to "
        "1000 km",
        file, is_obj(file) ? "vertex" : "triangle", is_obj(file) ? i + 1 : i / 3 + 1, corner.x(),
        corner.y(), corner.z()));
  }
  check_size(file, mesh, limits);
  return mesh;
}

TriangleMesh merged(const std::string& file, const TriangleMesh& mesh) {
  TriangleMesh result = merge_equal_corners(mesh);
  if (result.triangles.empty())
    throw InputError(file + ": has triangles without area alone; expected a mesh");
  return result;
}

void put_little_endian(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

void append(std::string& bytes, const Vec3& v) {
  for (int k = 0; k < 3; ++k) {
    put_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(v(k))));
  }
}

}  // namespace

TriangleMesh merge_equal_corners(const TriangleMesh& mesh) {
  double largest = 0;
  for (const Vec3& p : mesh.vertices) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  // A few units in the last place of single precision: the same corner as several programs round
  // it.
  constexpr double kSame = 5e-7;
  return weld(mesh, kSame * largest);
}

TriangleMesh read_stl(const std::string& file, double length_unit, const MeshLimits& limits) {
  return read_mesh_file(file, length_unit, limits).mesh;
}

MeshFile read_mesh_file(const std::string& file, double length_unit, const MeshLimits& limits) {
  const std::string bytes = read_bytes(file, limits);
  return {merged(file, triangles_of(file, bytes, length_unit, limits)), sha256(bytes)};
}

TriangleMesh read_triangles(const std::string& file, double length_unit, const MeshLimits& limits) {
  return triangles_of(file, read_bytes(file, limits), length_unit, limits);
}

void write_stl(const std::string& file, const TriangleMesh& mesh, double length_unit) {
  std::string bytes = "binary STL written by Firn";
  bytes.resize(kTitle, ' ');
  put_little_endian(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    append(bytes, (q - p).cross(r - p).normalized());
    for (const Vec3& corner : {p, q, r}) append(bytes, corner / length_unit);
    bytes.append(2, '\0');
  }
  write_file(file, bytes);
}

}  // namespace firn
