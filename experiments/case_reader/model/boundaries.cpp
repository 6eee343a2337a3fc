#include "experiments/case_reader/model/boundaries.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/case_reader/model/machine_parts.h"
#include "experiments/case_reader/model/materials.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/meshes/mesh_repair.h"
#include "experiments/meshes/wall_solids.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// The shortest rotation that takes z to the unit vector n; half a turn about x where none is.
Quat shortest_rotation_from_z(const Vec3& n) {
  constexpr double kOpposite = 1e-12;
  if (1 + n.z() < kOpposite) return Quat(0, 1, 0, 0);
  return Quat(1 + n.z(), -n.y(), n.x(), 0).normalized();
}

// Keys of every solid, whatever its kind.
constexpr std::string_view kSolidKeys[] = {
    "name",         "material", "kind",     "rigid",       "stiffness",
    "motion_frame", "motions",  "position", "orientation", "allow_overlap_with"};

std::vector<std::string_view> all_kinds() {
  std::vector<std::string_view> kinds = {"plane", "box", "mesh"};
  kinds.insert(kinds.end(), machine_kinds().begin(), machine_kinds().end());
  return kinds;
}

Boundary read_geometry(const TomlTable& t, const std::string& directory) {
  const std::string kind = t.choice("kind", all_kinds());
  if (kind == "plane") {
    t.allow({"name", "material", "kind", "rigid", "stiffness", "motion_frame", "motions", "point",
             "normal", "allow_overlap_with"});
    const Vec3 point = t.vector("point", dimension::length, "0 0 0 m");
    return plane_boundary("", 0, point, t.direction("normal"));
  }
  Boundary b;
  if (kind == "box") {
    t.allow({"name", "material", "kind", "rigid", "stiffness", "motion_frame", "motions",
             "position", "orientation", "size", "allow_overlap_with"});
    b = box_boundary("", 0, t.sizes("size"), Vec3::Zero());
  } else if (kind != "mesh") {
    Solid part = read_machine_part(t, kind, kSolidKeys);
    b.kind = Boundary::Kind::solid;
    b.mesh = std::move(part.mesh);
    b.parts = std::move(part.parts);
  } else {
    t.allow({"name", "material", "kind", "rigid", "stiffness", "motion_frame", "motions",
             "position", "orientation", "file", "length_unit", "sha256", "any_size", "thickness",
             "allow_overlap_with"});
    const double thickness = t.quantity("thickness", dimension::length, Sign::positive, "2 mm");
    b.kind = Boundary::Kind::solid;
    b.mesh = read_mesh(t, directory, kBoundaryMesh);
    b.parts = t.at("file", [&] {
      return with_repair_advice(b.mesh, MeshUse::boundary, t.string("file"),
                                t.string("length_unit"),
                                [&] { return wall_solids(b.mesh, thickness); });
    });
  }
  b.origin = t.vector("position", dimension::length, "0 0 0 m");
  b.orientation = t.orientation("orientation");
  return b;
}

}  // namespace

std::vector<Boundary> read_boundaries(const TomlTable& root, const std::vector<Material>& materials,
                                      const std::vector<MotionFrame>& frames,
                                      const std::string& directory) {
  std::vector<Boundary> boundaries;
  for (const TomlTable& t : root.tables("boundaries")) {
    Boundary b = read_geometry(t, directory);
    b.name = valid_name(t);
    b.material = material_index(t, "material", materials);
    b.rigid = t.boolean("rigid", false);
    b.stiffness =
        t.optional_quantity("stiffness", dimension::stiffness, Sign::positive).value_or(0);
    if (b.rigid && b.stiffness > 0) {
      t.fail("stiffness", "is given for a rigid boundary; expected one of the two");
    }
    if (!b.rigid && b.stiffness == 0 && materials[b.material].young_modulus == 0) {
      t.fail("material", fmt::format("\"{}\" has no young_modulus; expected one, or a stiffness of "
                                     "the boundary, or rigid = true",
                                     materials[b.material].name));
    }
    b.frame = optional_frame(t, "motion_frame", frames);
    for (const TomlTable& motion : t.tables("motions")) {
      b.motions.push_back(read_motion(motion));
    }
    boundaries.push_back(std::move(b));
  }
  return boundaries;
}

std::vector<std::pair<int, int>> read_allowed_overlaps(const TomlTable& root,
                                                       const std::vector<Boundary>& boundaries) {
  std::vector<std::pair<int, int>> pairs;
  int b = 0;
  for (const TomlTable& t : root.tables("boundaries")) {
    for (const std::string& other : t.strings("allow_overlap_with"))
      pairs.emplace_back(b, boundary_index(t, "allow_overlap_with", other, boundaries));
    ++b;
  }
  return pairs;
}

Boundary plane_boundary(const std::string& name, int material, const Vec3& point,
                        const Vec3& normal) {
  Boundary b;
  b.name = name;
  b.material = material;
  b.kind = Boundary::Kind::plane;
  b.origin = point;
  b.orientation = shortest_rotation_from_z(normal);
  return b;
}

Boundary box_boundary(const std::string& name, int material, const Vec3& size, const Vec3& center) {
  Boundary b;
  b.name = name;
  b.material = material;
  b.kind = Boundary::Kind::solid;
  b.origin = center;
  b.parts = {convex_part(box_half_spaces(size), 0)};
  b.mesh = box_mesh(size);
  return b;
}

int boundary_index(const TomlTable& table, std::string_view key, const std::string& name,
                   const std::vector<Boundary>& boundaries) {
  return index_of(table, key, name, boundaries, "boundary");
}

}  // namespace firn
