#include "experiments/case_reader/model/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "experiments/case_reader/model/materials.h"
#include "experiments/meshes/length_unit.h"
#include "experiments/meshes/mesh_repair.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// All that make_...() computes from.
std::string options_text(const ShapeOptions& o) {
  return fmt::format("{} {} {} {} {} {} {} {} {}", o.material, o.density, o.young_modulus, o.mass,
                     o.rounding, o.stiffness_length, o.stiffness, o.max_parts, o.name);
}

// A batch reads its case for every run: the shapes that were made last are mostly wanted
// again. `description` holds all that `make` computes from, every number with all its digits.
template <class Make>
Shape latest_or_made(const std::string& description, Make make) {
  constexpr std::size_t kMost = 16;
  thread_local std::map<std::string, Shape> latest;
  if (const auto found = latest.find(description); found != latest.end()) return found->second;
  if (latest.size() == kMost) latest.clear();
  return latest.emplace(description, make()).first->second;
}

// Runs `make`; its errors name the rounding where the table gives one and it is too large, else
// `key`.
template <class Make>
Shape made_at(const TomlTable& t, std::string_view key, Make make) {
  try {
    return make();
  } catch (const RoundingError& e) {
    return t.at(t.has("rounding") ? "rounding" : key,
                [&]() -> Shape { throw InputError(e.what()); });
  } catch (const InputError& e) {
    return t.at(key, [&]() -> Shape { throw InputError(e.what()); });
  }
}

// Reads the tables of all shapes; compounds pull in what they are made of first.
class ShapeReader {
 public:
  ShapeReader(const TomlTable& root, const std::vector<Material>& materials,
              const std::string& directory)
      : all_(root.table("shapes")), materials_(materials), directory_(directory) {
    for (const std::string& name : all_.keys()) names_.push_back(name);
  }

  std::vector<Shape> read() {
    std::vector<Shape> shapes;
    for (const std::string& name : names_) shapes.push_back(shape(name));
    return shapes;
  }

 private:
  const Shape& shape(const std::string& name) {
    if (const auto it = done_.find(name); it != done_.end()) return it->second;
    const TomlTable t = all_.required_table(name);
    under_way_.push_back(name);
    Shape made = make(t, name);
    under_way_.pop_back();
    return done_.emplace(name, std::move(made)).first->second;
  }

  Shape make(const TomlTable& t, const std::string& name) {
    const std::string kind =
        t.choice("kind", {"box", "sphere", "crescent", "convex", "mesh", "compound"});
    if (kind == "box") return box(t, name);
    if (kind == "sphere") return sphere(t, name);
    if (kind == "crescent") return crescent(t, name);
    if (kind == "convex") return convex(t, name);
    if (kind == "mesh") return mesh(t, name);
    return compound(t, name);
  }

  // Keys common to all kinds; those of one kind come on top.
  ShapeOptions options(const TomlTable& t, const std::string& name) {
    ShapeOptions o;
    o.name = name;
    o.material = material_index(t, "material", materials_);
    const Material& material = materials_[o.material];
    o.density = material.density;
    o.young_modulus = material.young_modulus;
    o.mass = t.optional_quantity("mass", dimension::mass, Sign::positive).value_or(0);
    o.rounding =
        t.optional_quantity("rounding", dimension::length, Sign::non_negative).value_or(o.rounding);
    o.stiffness =
        t.optional_quantity("stiffness", dimension::stiffness, Sign::positive).value_or(0);
    o.stiffness_length =
        t.optional_quantity("stiffness_length", dimension::length, Sign::positive).value_or(0);
    if (o.mass == 0 && o.density == 0) {
      t.fail("material", fmt::format("\"{}\" has no density; expected one, or a mass of the shape",
                                     material.name));
    }
    if (o.stiffness == 0 && o.young_modulus == 0) {
      t.fail("material", fmt::format("\"{}\" has no young_modulus; expected one, or a stiffness of "
                                     "the shape",
                                     material.name));
    }
    return o;
  }

  Shape box(const TomlTable& t, const std::string& name) {
    t.allow({"kind", "material", "mass", "rounding", "stiffness", "stiffness_length", "size"});
    const ShapeOptions o = options(t, name);
    const Vec3 size = t.sizes("size");
    const std::string description =
        fmt::format("box {} {} {} {}", size.x(), size.y(), size.z(), options_text(o));
    return made_at(t, "size",
                   [&] { return latest_or_made(description, [&] { return make_box(size, o); }); });
  }

  Shape sphere(const TomlTable& t, const std::string& name) {
    t.allow({"kind", "material", "mass", "stiffness", "stiffness_length", "radius"});
    const ShapeOptions o = options(t, name);
    const double radius = t.quantity("radius", dimension::length, Sign::positive);
    const std::string description = fmt::format("sphere {} {}", radius, options_text(o));
    return t.at("radius", [&] {
      return latest_or_made(description, [&] { return make_sphere(radius, o); });
    });
  }

  Shape crescent(const TomlTable& t, const std::string& name) {
    t.allow({"kind", "material", "mass", "rounding", "stiffness", "stiffness_length", "variant",
             "chord", "thickness", "depth", "tip_height", "top_concavity_depth", "draft", "facets",
             "parts", "arc_segments", "half"});
    ShapeOptions o = options(t, name);
    auto [p, mass] = read_crescent(t);
    if (t.has("half")) {
      p.half = t.choice("half", {"left", "right"}, "left") == "left"
                   ? CrescentParameters::Half::left
                   : CrescentParameters::Half::right;
      mass /= 2;
    }
    p.parts = t.integer("parts", 1, p.parts);
    p.arc_segments = t.integer("arc_segments", 1, p.arc_segments);
    if (o.mass == 0) o.mass = mass;
    const std::string description =
        fmt::format("crescent {} {} {} {} {} {} {} {} {} {} {}", p.chord, p.width, p.depth,
                    p.tip_height, p.top_concavity_depth, p.draft, p.facets, p.parts, p.arc_segments,
                    static_cast<int>(p.half), options_text(o));
    return made_at(t, "", [&, &parameters = p] {
      return latest_or_made(description, [&] { return make_crescent(parameters, o); });
    });
  }

  Shape convex(const TomlTable& t, const std::string& name) {
    t.allow({"kind", "material", "mass", "rounding", "stiffness", "stiffness_length", "vertices"});
    const ShapeOptions o = options(t, name);
    if (!t.has("vertices")) t.fail("vertices", "missing; expected strings [\"x y z mm\", ...]");
    return made_at(t, "vertices", [&] {
      std::vector<Vec3> points;
      for (const std::string& text : t.strings("vertices")) {
        points.push_back(parse_vector(text, dimension::length));
      }
      return make_convex(points, o);
    });
  }

  Shape mesh(const TomlTable& t, const std::string& name) {
    t.allow({"kind", "material", "mass", "rounding", "stiffness", "stiffness_length", "file",
             "length_unit", "sha256", "any_size", "max_parts"});
    ShapeOptions o = options(t, name);
    constexpr int kMostParts = 64;  // of any shape
    o.max_parts = t.integer("max_parts", 1, o.max_parts);
    if (o.max_parts > kMostParts) {
      t.fail("max_parts", fmt::format("is {}; expected 1 to {}", o.max_parts, kMostParts));
    }
    const TriangleMesh triangles = read_mesh(t, directory_, kParticleMesh);
    const std::string description =
        fmt::format("mesh {} {} {} {}", t.string("file"), t.string("sha256"),
                    t.string("length_unit"), options_text(o));
    return made_at(t, "file", [&] {
      return latest_or_made(description, [&] {
        return with_repair_advice(triangles, MeshUse::particle, t.string("file"),
                                  t.string("length_unit"), [&] { return make_mesh(triangles, o); });
      });
    });
  }

  Shape compound(const TomlTable& t, const std::string& name) {
    t.allow(
        {"kind", "material", "mass", "rounding", "stiffness", "stiffness_length", "components"});
    const ShapeOptions o = options(t, name);
    std::vector<Component> components;
    for (const TomlTable& c : t.tables("components")) {
      c.allow({"shape", "position", "orientation"});
      const std::string part = c.string("shape");
      index_of(c, "shape", part, {names_.begin(), names_.end()}, "shape");
      if (std::ranges::find(under_way_, part) != under_way_.end()) {
        c.fail("shape", fmt::format("\"{}\" contains itself; expected another shape", part));
      }
      Component component{shape(part), {}};
      if (component.shape.material != o.material) {
        c.fail("shape",
               fmt::format("\"{}\" is of another material; expected the compound's", part));
      }
      component.pose.translation = c.vector("position", dimension::length, "0 0 0 m");
      component.pose.rotation = c.orientation("orientation").toRotationMatrix();
      components.push_back(std::move(component));
    }
    if (components.empty()) {
      t.fail("components",
             "missing; expected tables such as { shape = \"cube\", position = "
             "\"0 0 1 cm\" }");
    }
    return t.at("components", [&] { return make_compound(components, o); });
  }

  TomlTable all_;
  const std::vector<Material>& materials_;
  std::string directory_;
  std::vector<std::string> names_;
  std::vector<std::string> under_way_;
  std::map<std::string, Shape> done_;
};

}  // namespace

std::vector<Shape> read_shapes(const TomlTable& root, const std::vector<Material>& materials,
                               const std::string& directory) {
  return ShapeReader(root, materials, directory).read();
}

NamedCrescent read_crescent(const TomlTable& t) {
  const std::string variant = t.choice(
      "variant", {"mass-matched", "table1", "table1-mass-override", "custom"}, "mass-matched");
  const bool custom = variant == "custom";
  CrescentParameters p;
  const auto length = [&](std::string_view key, double fallback, Sign sign) {
    return t.quantity(key, dimension::length, sign, si_text(fallback, dimension::length));
  };
  for (const auto& [key, value] : {std::pair<std::string_view, double*>{"chord", &p.chord},
                                   {"thickness", &p.width},
                                   {"depth", &p.depth}}) {
    if (custom) *value = length(key, *value, Sign::positive);
    if (!custom && t.has(key)) {
      t.fail(key,
             fmt::format("is fixed by variant = \"{}\"; expected it with variant = \"custom\" only",
                         variant));
    }
  }
  p.tip_height = length("tip_height", p.tip_height, Sign::positive);
  p.top_concavity_depth = length("top_concavity_depth", p.top_concavity_depth, Sign::non_negative);
  p.draft = t.quantity("draft", dimension::angle, Sign::non_negative, "3 deg");
  p.facets = t.integer("facets", 4, p.facets);
  if (custom) return {p, 0};
  return t.at("", [&] { return named_crescent(variant, p); });
}

TriangleMesh read_mesh(const TomlTable& table, const std::string& directory,
                       const MeshLimits& limits) {
  if (!table.has("length_unit"))
    table.fail("length_unit",
               "missing; expected the unit of the numbers in the file, such as \"mm\" or \"in\"");
  const double unit =
      table.at("length_unit", [&] { return parse_length_unit(table.string("length_unit")); });
  const std::filesystem::path file = table.string("file");
  const std::string absolute =
      std::filesystem::absolute(directory / file).lexically_normal().string();
  const MeshLimits allowed =
      table.boolean("any_size", false) ? without_size_limits(limits) : limits;
  MeshFile read = table.at("file", [&] { return read_mesh_file(absolute, unit, allowed); });
  if (table.has("sha256") && table.string("sha256") != read.sha256) {
    table.fail("file", fmt::format("\"{}\" has changed; expected the content with SHA-256 {}",
                                   absolute, table.string("sha256")));
  }
  table.set("file", absolute);
  table.set("sha256", read.sha256);
  return std::move(read.mesh);
}

int shape_index(const TomlTable& table, std::string_view key, const std::vector<Shape>& shapes) {
  return shape_index(table, key, table.string(key), shapes);
}

int shape_index(const TomlTable& table, std::string_view key, const std::string& name,
                const std::vector<Shape>& shapes) {
  return index_of(table, key, name, shapes, "shape");
}

}  // namespace firn
