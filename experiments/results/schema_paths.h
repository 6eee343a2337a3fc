// Parsing of the paths and lists of the results schema.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/results_schema.h"

namespace firn::results {

// A path of the schema: the parts before and after the placeholder <name>.
struct Pattern {
  std::string_view before, after;
  bool open = false;  // has a placeholder

  explicit Pattern(std::string_view path) : before(path) {
    const std::size_t from = path.find('<');
    if (from == std::string_view::npos) return;
    open = true;
    before = path.substr(0, from);
    after = path.substr(path.find('>') + 1);
  }

  // The name in a path that matches; empty without a placeholder. Nothing for other paths.
  std::optional<std::string> name_in(std::string_view path) const {
    if (!open) return path == before ? std::optional<std::string>("") : std::nullopt;
    if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
        !path.ends_with(after))
      return std::nullopt;
    return std::string(path.substr(before.size(), path.size() - before.size() - after.size()));
  }
  // The path with this name.
  std::string with(std::string_view name) const {
    return open ? fmt::format("{}{}{}", before, name, after) : std::string(before);
  }
};

// A text value of a dataset that differs in files of format 1.
struct RenamedText {
  std::string_view path, first, current;
};
std::span<const RenamedText> renamed_texts();

std::vector<std::string_view> split_list(std::string_view list, char separator);
const Symbol* symbol_of(std::string_view name);  // null: unknown

}  // namespace firn::results
