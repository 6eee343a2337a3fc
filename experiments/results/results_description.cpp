// The schema in Markdown.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "experiments/results/results_schema.h"
#include "experiments/results/schema_paths.h"

namespace firn::results {
namespace {

using hdf5::Type;
using enum Presence;
using R = Rule;

std::string presence_text(const Dataset& d) {
  switch (d.presence) {
    case always:
      return "always";
    case newer:
      return "always, but for files of older builds";
    case together:
      return fmt::format("with `{}`", d.with);
    case optional:
      break;
  }
  return d.with.empty() ? "if the case has any" : fmt::format("may be, with `{}`", d.with);
}

std::string_view type_word(Type type) {
  switch (type) {
    case Type::real:
      return "float64";
    case Type::integer:
      return "int32";
    case Type::natural:
      return "uint64";
    case Type::byte:
      return "uint8";
    default:
      return "text";
  }
}

std::string rule_text(Rule rule, std::string_view limit) {
  switch (rule) {
    case R::any:
      return "";
    case R::finite:
      return "finite";
    case R::positive:
      return "> 0";
    case R::non_negative:
      return ">= 0";
    case R::finite_or_nan:
    case R::vector_or_nan:
      return "finite or NaN";
    case R::non_negative_or_nan:
      return ">= 0 or NaN";
    case R::rotation:
      return "unit length";
    case R::rotation_or_nan:
      return "unit length or NaN";
    case R::ascending:
      return ">= 0, not falling";
    case R::counting:
      return "0, 1, 2, ...";
    case R::flag:
      return "0 or 1";
    case R::batch:
      return ">= -1";
    case R::index:
      return fmt::format("0 ... {} - 1", limit);
    case R::index_or_none:
      return fmt::format("-1 ... {} - 1", limit);
    case R::body:
      return fmt::format("-{} ... N - 1", limit);
    case R::body_or_nan:
      return fmt::format("-{} ... N - 1 or NaN", limit);
    case R::choice:
      break;
  }
  std::string texts;
  for (const std::string_view one : split_list(limit, '|'))
    texts += fmt::format("{}`{}`", texts.empty() ? "" : ", ", one);
  return texts;
}

std::string shape_word(std::string_view shape) {
  if (shape.empty()) return "";
  if (shape == "k") return "scalar or [k]";
  return fmt::format("[{}]", fmt::join(split_list(shape, ','), ", "));
}

}  // namespace

std::string description() {
  std::string out = "Lengths: ";
  for (const Symbol& s : symbols())
    out += fmt::format("{}**{}** {}", &s == symbols().data() ? "" : "; ", s.name, s.meaning);
  out +=
      "; of a mesh **V** its vertices and **P** its triangles.\n\n"
      "| attribute | type | values | meaning |\n|---|---|---|---|\n";
  for (const Attribute& a : attributes())
    out += fmt::format("| `{}` of `{}` | {} | {} | {} |\n", a.name, a.object,
                       shape_word(a.shape).empty()
                           ? std::string(type_word(a.type))
                           : fmt::format("{} {}", type_word(a.type), shape_word(a.shape)),
                       rule_text(a.rule, a.limit), a.meaning);
  out += "\n| dataset | shape, type, unit | values | present | meaning |\n|---|---|---|---|---|\n";
  for (const Dataset& d : datasets())
    out += fmt::format("| `{}` | {} {}{} | {} | {} | {} |\n", d.path, shape_word(d.shape),
                       type_word(d.type),
                       d.unit.empty() || d.unit == "1" ? "" : fmt::format(" {}", d.unit),
                       rule_text(d.rule, d.limit), presence_text(d), d.meaning);
  out += "\n| name | in files of format 1 |\n|---|---|\n";
  for (const Dataset& d : datasets())
    if (!d.first_name.empty()) out += fmt::format("| `{}` | `{}` |\n", d.path, d.first_name);
  for (const Attribute& a : attributes())
    if (!a.first_name.empty())
      out += fmt::format("| `{}` of `{}` | `{}` |\n", a.name, a.object, a.first_name);
  for (const RenamedText& t : renamed_texts())
    out += fmt::format("| `{}` in `{}` | `{}` |\n", t.current, t.path, t.first);
  return out;
}

}  // namespace firn::results
