// firn shape: facts of a mesh file, or of every shape and boundary of a case.
#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/output/boundary_output.h"
#include "app/output/shape_output.h"
#include "app/support/case_file.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/meshes/length_unit.h"
#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/mesh_repair.h"
#include "experiments/meshes/mesh_union.h"
#include "experiments/meshes/wall_solids.h"
#include "experiments/system/terminal.h"
#include "experiments/text/suggestions.h"
#include "experiments/text/units.h"
#include "reports/rendering/scene_picture.h"

namespace firn {
namespace {

struct ShapeArguments {
  std::string file;
  std::string length_unit = "mm";
  std::string density = "916.7 kg/m^3";
  std::string young_modulus = "0.01 GPa";
  std::string rounding;
  int max_parts = ShapeOptions{}.max_parts;
  std::vector<std::string> settings;
  std::string picture;
  std::string repaired;
  std::string united;
  bool as_boundary = false;
  std::string boundary;  // of a case: its name; of a mesh file: empty
  std::string thickness;
  bool any_size = false;
  bool json = false;
};

double option_quantity(const char* option, const std::string& text, const Dimension& dimension) {
  try {
    return parse_quantity(text, dimension);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}", option, e.what()));
  }
}

double length_unit_option(const ShapeArguments& a) {
  try {
    return parse_length_unit(a.length_unit);
  } catch (const InputError& e) {
    throw InputError(fmt::format("--length-unit: {}", e.what()));
  }
}

// A line of a table; nothing where the size is a usual one.
std::string unit_row(double longest_edge, double unit, MeshUse use) {
  const std::string advice = length_unit_warning(longest_edge, unit, use);
  return advice.empty() ? "" : fmt::format("  {:<22}{}\n", "unit", advice);
}

Json repair_json(const MeshRepair& r) {
  return {{"needed", r.needed()},       {"repairable", r.is_repairable()},
          {"degenerate", r.degenerate}, {"disconnected_edges", r.disconnected_edges},
          {"joined", r.joined},         {"removed", r.removed},
          {"added", r.added},           {"reversed", r.reversed},
          {"parts", r.parts},           {"left", defects_json(r.left, find_conflicts(r.mesh))}};
}

std::string repair_rows(const MeshRepair& r) {
  return fmt::format("  {:<22}{}\n  {:<22}{}\n  {:<22}{}\n", "disconnected edges",
                     r.disconnected_edges, "pieces", r.parts, "repair", r.sentence());
}

// The union of the shells of a sound mesh in the file --united, and its facts.
int write_union(const ShapeArguments& a, const TriangleMesh& mesh, const MeshDefects& defects,
                const MeshConflicts& conflicts) {
  TriangleMesh united;
  try {
    united = unite(mesh);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("{}: {}; and cannot be united: {}; expected closed shells that do "
                    "not cross themselves",
                    a.file, conflicts.to_message(), e.what()));
  }
  write_stl(a.united, united, length_unit_option(a));
  const double volume = mass_properties(united).volume;
  if (a.json)
    print_json(
        {{"file", a.file},
         {"watertight", false},
         {"defects", defects_json(defects, conflicts)},
         {"union",
          {{"file", a.united}, {"triangles", united.triangles.size()}, {"volume", volume}}}});
  else
    print_lines(stdout, "{}\n  {:<22}{}\n  {:<22}{} triangles, {}\n", a.file, "defects",
                conflicts.to_message(), "union", united.triangles.size(), volume_text(volume));
  print_lines(stderr, "united in {}\n", a.united);
  return ExitStatus::done;
}

// An unsound mesh: its defects, the repair of them, and its place. Writes the mesh repaired or
// united where that is requested and possible.
int print_unsound(const ShapeArguments& a, const TriangleMesh& mesh, const MeshDefects& defects,
                  const MeshConflicts& conflicts, const MeshRepair& repair) {
  if (!a.united.empty()) {
    if (defects.is_valid()) return write_union(a, mesh, defects, conflicts);
    throw InputError(
        fmt::format("{}: {}; expected a mesh without them for --united, see --repair-to", a.file,
                    defects.to_message()));
  }
  const auto [low, high] = bounding_box(mesh);
  if (a.json) {
    print_json({{"file", a.file},
                {"triangles", mesh.triangles.size()},
                {"vertices", mesh.vertices.size()},
                {"watertight", false},
                {"defects", defects_json(defects, conflicts)},
                {"repair", repair_json(repair)}});
  } else {
    print_lines(stdout, "{}\n  {:<22}{}\n  {:<22}{}\n{}", a.file, "triangles",
                mesh.triangles.size(), "bounding box", mm_text(high - low), repair_rows(repair));
  }
  if (!find_conflicts(repair.mesh).none()) {
    const bool unitable = defects.is_valid() && conflicts.intersections == 0;
    print_lines(stderr,
                "firn: {}: {}{}; expected surfaces that do not cross and no solid inside another "
                "one\n",
                a.file, defects_text(defects, conflicts),
                unitable ? "; --united FILE.stl writes their union" : "");
    return ExitStatus::bad_input;
  }
  if (!repair.is_repairable() || a.repaired.empty()) {
    print_lines(stderr, "firn: {}: {}; {}; expected a closed mesh that faces outwards\n", a.file,
                defects_text(defects, conflicts),
                !repair.is_repairable() ? "and cannot be repaired: " + repair.failure_reason()
                                        : std::string("--repair-to FILE.stl writes it repaired"));
    return ExitStatus::bad_input;
  }
  write_stl(a.repaired, repair.mesh, length_unit_option(a));
  print_lines(stderr, "repaired in {}\n", a.repaired);
  return ExitStatus::done;
}

// A mesh file as a boundary: it may be open.
int print_boundary_mesh(const ShapeArguments& a) {
  if (!a.boundary.empty())
    throw InputError(fmt::format(
        "--boundary {}: {} is a mesh file; expected --boundary alone, or a case file (*.toml)",
        a.boundary, a.file));
  if (!a.repaired.empty())
    throw InputError("--repair-to: closes a mesh; expected it without --boundary");
  if (!a.united.empty())
    throw InputError("--united: unites the shells of a body; expected it without --boundary");
  const double unit = length_unit_option(a);
  const double thickness =
      option_quantity("--thickness", a.thickness.empty() ? "2 mm" : a.thickness, dimension::length);
  if (!(thickness > 0))
    throw InputError(
        fmt::format("--thickness: is \"{}\"; expected a length above zero", a.thickness));
  const MeshLimits limits = a.any_size ? without_size_limits(kBoundaryMesh) : kBoundaryMesh;
  Boundary b;
  b.name = std::filesystem::path(a.file).stem().string();
  b.kind = Boundary::Kind::solid;
  b.mesh = read_mesh_file(a.file, unit, limits).mesh;
  try {
    b.parts = with_repair_advice(b.mesh, MeshUse::boundary, a.file, a.length_unit,
                                 [&] { return wall_solids(b.mesh, thickness); });
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}", a.file, e.what()));
  }
  const BoundaryProperties facts = boundary_properties(b, "mesh", 0);
  if (a.json) {
    Json json = boundary_json(facts);
    json["file"] = a.file;
    print_json(json);
  } else {
    print_lines(stdout, "{} (lengths in {})\n{}{}", a.file, a.length_unit,
                unit_row((facts.upper - facts.lower).maxCoeff(), unit, MeshUse::boundary),
                boundary_table(facts));
  }
  if (!a.picture.empty()) {
    ScenePicture picture;
    picture.title = b.name;
    picture.walls.push_back({b.name, {&b.mesh, {Mat3::Identity(), Vec3::Zero()}}});
    draw_scene(picture, a.picture);
    print_lines(stderr, "drawn in {}\n", a.picture);
  }
  return ExitStatus::done;
}

int print_mesh(const ShapeArguments& a) {
  if (!a.thickness.empty())
    throw InputError("--thickness: is that of a boundary; expected --boundary as well");
  if (!a.picture.empty()) {
    throw InputError(
        "--picture: draws the scene of a case, or a boundary; expected a case file (*.toml), or "
        "--boundary");
  }
  const double unit = length_unit_option(a);
  ShapeOptions options;
  options.name = std::filesystem::path(a.file).stem().string();
  options.density = option_quantity("--density", a.density, dimension::density);
  options.young_modulus = option_quantity("--young-modulus", a.young_modulus, dimension::pressure);
  if (!a.rounding.empty()) {
    options.rounding = option_quantity("--rounding", a.rounding, dimension::length);
  }
  options.max_parts = a.max_parts;
  const MeshLimits limits = a.any_size ? without_size_limits(kParticleMesh) : kParticleMesh;
  const TriangleMesh mesh = read_mesh_file(a.file, unit, limits).mesh;
  const MeshDefects defects = inspect(mesh);
  const MeshRepair repair = firn::repair(read_triangles(a.file, unit, limits));
  const MeshConflicts conflicts = find_conflicts(mesh);
  if (!defects.is_valid() || !conflicts.none())
    return print_unsound(a, mesh, defects, conflicts, repair);
  if (!a.repaired.empty())
    throw InputError(fmt::format("--repair-to: {} has nothing to repair", a.file));
  if (!a.united.empty())
    throw InputError(
        fmt::format("--united: {} has no shells that overlap, nest or face inwards", a.file));
  const Shape shape = make_mesh(mesh, options);
  if (a.json) {
    Json document = shape_json(shape);
    document["file"] = a.file;
    document["density"] = options.density;
    document["repair"] = repair_json(repair);
    print_json(document);
  } else {
    print_lines(stdout, "{} (lengths in {}, {}, {})\n{}{}{}", a.file, a.length_unit, a.density,
                a.young_modulus, unit_row(shape.box.maxCoeff(), unit, MeshUse::particle),
                shape_table(shape), repair_rows(repair));
  }
  return ExitStatus::done;
}

// One boundary of a case.
int print_boundary(const ShapeArguments& a, const Case& c,
                   const std::vector<BoundaryProperties>& walls) {
  const auto wall = std::ranges::find(walls, a.boundary, &BoundaryProperties::name);
  if (wall == walls.end()) {
    std::vector<std::string_view> names;
    names.reserve(walls.size());
    for (const BoundaryProperties& w : walls) names.push_back(w.name);
    throw InputError(names.empty()
                         ? fmt::format("--boundary {}: {} has no boundaries", a.boundary, a.file)
                     : a.boundary.empty()
                         ? fmt::format("--boundary: names no boundary of {}; expected one of {}",
                                       a.file, comma_list(names))
                         : fmt::format("--boundary {}: unknown boundary of {}; {}", a.boundary,
                                       a.file, suggestion(a.boundary, names)));
  }
  if (a.json)
    print_json(boundary_json(*wall));
  else
    print_lines(stdout, "{}\n{}", wall->name, boundary_table(*wall));
  if (!a.picture.empty()) {
    if (wall->triangles == 0)
      throw InputError(fmt::format(
          "--picture: boundary \"{}\" is a half-space without a mesh; expected another one",
          wall->name));
    draw_boundary(c, wall->name, a.picture);
    print_lines(stderr, "drawn in {}\n", a.picture);
  }
  return ExitStatus::done;
}

int print_case(const ShapeArguments& a) {
  std::vector<Override> overrides;
  for (const std::string& text : a.settings) overrides.push_back(parse_override(text));
  const Case c = read_case(a.file, overrides);
  std::vector<BoundaryProperties> walls = boundary_properties(c);
  if (!a.thickness.empty())
    throw InputError("--thickness: is given with a case file; expected a mesh file");
  if (!a.united.empty())
    throw InputError("--united: is given with a case file; expected a mesh file");
  if (a.as_boundary) return print_boundary(a, c, walls);
  if (a.json) {
    Json shapes = Json::array(), boundaries = Json::array();
    for (const Shape& shape : c.model.shapes) shapes.push_back(shape_json(shape));
    for (const BoundaryProperties& wall : walls) boundaries.push_back(boundary_json(wall));
    print_json(
        {{"file", a.file}, {"case", c.name}, {"shapes", shapes}, {"boundaries", boundaries}});
  } else {
    for (const Shape& shape : c.model.shapes)
      print_lines(stdout, "{}\n{}", shape.name, shape_table(shape));
    for (const BoundaryProperties& wall : walls)
      print_lines(stdout, "{}\n{}", wall.name, boundary_table(wall));
  }
  if (!a.picture.empty()) {
    draw_scene(c, a.picture);
    print_lines(stderr, "drawn in {}\n", a.picture);
  }
  return ExitStatus::done;
}

// Of a mesh file as the body of a particle.
void add_mesh_options(CLI::App& command, ShapeArguments& a) {
  command
      .add_option("--length-unit", a.length_unit,
                  "Unit of the coordinates of a mesh file, which names none:\nmm, cm, m, in")
      ->type_name("UNIT")
      ->capture_default_str();
  command.add_option("--density", a.density, "Density of a mesh file's body, for its mass")
      ->type_name("QUANTITY")
      ->capture_default_str();
  command
      .add_option("--young-modulus", a.young_modulus,
                  "Young's modulus of a mesh file's body, for its stiffness")
      ->type_name("QUANTITY")
      ->capture_default_str();
  command
      .add_option("--rounding", a.rounding,
                  "Radius of edges and corners of a mesh file's body, e.g.\n\"0.5 mm\"; by default "
                  "up to 2 % of its smallest box edge")
      ->type_name("LENGTH");
  command.add_option("--max-parts", a.max_parts, "Convex parts of a mesh file's body, at most")
      ->check(CLI::Range(1, 64))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--repair-to", a.repaired,
                  "Write a mesh that has defects, and can be repaired, without them")
      ->type_name("FILE.stl");
  command
      .add_option("--united", a.united,
                  "Write the union of a mesh's shells that overlap, lie inside others or face "
                  "inwards")
      ->type_name("FILE.stl");
  command.add_flag("--any-size", a.any_size, "Accept a mesh file's body below 1 um or above 100 m");
}

// Of a case, or of a mesh file as a boundary. Returns --boundary.
CLI::Option* add_scene_options(CLI::App& command, ShapeArguments& a) {
  add_settings_option(command, a.settings);
  command
      .add_option("--picture", a.picture,
                  "Draw the case's boundaries and placed bodies, or the --boundary:\nan overview, "
                  "from above, and two sections. FILE.png or FILE.svg")
      ->type_name("FILE");
  CLI::Option* boundary = command.add_option(
      "--boundary", a.boundary,
      "Of a case: this boundary alone, facts and picture. Of a mesh\nfile, without a name: as a "
      "boundary, which may be open");
  boundary->expected(0, 1)->type_name("NAME");
  command
      .add_option("--thickness", a.thickness,
                  "Thickness of the walls of a mesh file as a boundary;\n\"2 mm\" by default")
      ->type_name("LENGTH");
  return boundary;
}

}  // namespace

void add_shape_command(CLI::App& app, int& status) {
  auto a = std::make_shared<ShapeArguments>();
  CLI::App* command = app.add_subcommand(
      "shape", "Print the facts of a mesh, or of a case's shapes and boundaries");
  command->add_option("FILE", a->file, "A mesh, STL or OBJ (*.obj), or a case file (*.toml)")
      ->required()
      ->type_name("");
  add_mesh_options(*command, *a);
  CLI::Option* boundary = add_scene_options(*command, *a);
  command->add_flag("--json", a->json, json_help);
  command->footer(
      "Status 2 for a mesh with defects. L is the length of the contact law's stiffness K = E L.");
  command->callback([a, boundary, &status] {
    a->as_boundary = boundary->count() > 0;
    status = is_case_file(a->file) ? print_case(*a)
             : a->as_boundary      ? print_boundary_mesh(*a)
                                   : print_mesh(*a);
  });
}

}  // namespace firn
