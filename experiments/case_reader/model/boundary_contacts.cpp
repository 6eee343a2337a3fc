#include "experiments/case_reader/model/boundary_contacts.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/materials.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_names.h"

namespace firn {

std::vector<BoundaryContact> read_boundary_contacts(const TomlTable& root, const Model& model) {
  root.require_at_most("boundary_contacts", input_limits::boundary_contacts);
  std::vector<BoundaryContact> contacts;
  for (const TomlTable& t : root.tables("boundary_contacts")) {
    BoundaryContact c;
    const std::vector<std::string> names = t.strings("between");
    if (names.size() != 2 || names[0] == names[1])
      t.fail("between", "does not name two boundaries; expected such as [\"arm\", \"bucket\"]");
    c.a = boundary_index(t, "between", names[0], model.boundaries);
    c.b = boundary_index(t, "between", names[1], model.boundaries);
    const auto is_plane = [&](int b) {
      return model.boundaries[static_cast<std::size_t>(b)].kind == Boundary::Kind::plane;
    };
    if (is_plane(c.a)) std::swap(c.a, c.b);
    if (is_plane(c.a)) t.fail("between", "names two planes; expected a solid");
    const auto free = [&](int b) {
      return free_frame(model.frames, model.boundaries[static_cast<std::size_t>(b)].frame);
    };
    if (free(c.a) == free(c.b))
      t.fail("between",
             free(c.a) < 0
                 ? "names boundaries that no force can move; expected one on a free motion frame"
                 : "names two boundaries of one motion frame; expected of different ones");
    const auto same = [&](const BoundaryContact& other) {
      return std::minmax(other.a, other.b) == std::minmax(c.a, c.b);
    };
    if (std::ranges::any_of(contacts, same))
      t.fail("between", "names a pair that has a contact already; expected one table a pair");
    if (!t.has("name")) t.set("name", names[0] + "-" + names[1]);
    c.name = unique_table_name(t, contacts);
    c.law = read_dry_interaction(t, {"name", "between", "stiffness", "rounding"});
    c.stiffness = t.quantity("stiffness", dimension::stiffness, Sign::positive);
    c.rounding = t.quantity("rounding", dimension::length, Sign::positive, "0.5 mm");
    contacts.push_back(std::move(c));
  }
  return contacts;
}

}  // namespace firn
