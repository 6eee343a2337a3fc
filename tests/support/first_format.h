// Gives a results file the names that files of format 1 have.
#pragma once

#include <hdf5.h>

#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/results_schema.h"
#include "experiments/text/response_aliases.h"
#include "tests/support/results_mutations.h"

namespace firn::test {

// The path in format 1; empty: it has no other name there.
inline std::string first_path(std::string_view path) {
  const std::string_view responses = "/responses/";
  if (path.starts_with(responses)) {
    const std::string name(path.substr(responses.size())), first = first_response_name(name);
    return first == name ? "" : std::string(responses) + first;
  }
  for (const results::Dataset& d : results::datasets()) {
    if (d.first_name.empty()) continue;
    const std::size_t open = d.path.find('<');
    if (open == std::string_view::npos) {
      if (path == d.path) return std::string(d.first_name);
      continue;
    }
    const std::string_view before = d.path.substr(0, open),
                           after = d.path.substr(d.path.find('>') + 1);
    if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
        !path.ends_with(after))
      continue;
    const std::string name(path.substr(before.size(), path.size() - before.size() - after.size()));
    return std::string(d.first_name.substr(0, d.first_name.find('<'))) + name +
           std::string(d.first_name.substr(d.first_name.find('>') + 1));
  }
  return "";
}

inline void replace_texts(hdf5::File& file, const std::string& path, const std::string& from,
                          const std::string& to) {
  if (!file.contains(path)) return;
  std::vector<std::string> texts = file.read_strings(path);
  for (std::string& text : texts)
    if (text == from) text = to;
  file.write_strings(path, texts);
}

// Returns the number of datasets that have another name now.
inline int use_first_names(const std::string& file) {
  std::vector<std::string> paths;
  {
    hdf5::File open = hdf5::File::open(file, hdf5::File::Access::write);
    replace_texts(open, "/bonds/break_mode", "intact", "whole");
    replace_texts(open, "/bonds/break_mode", "removed", "parted");
    replace_texts(open, "/stages/end_reason", "settled", "at rest");
    paths = open.datasets();
    open.close();
  }
  int moved = 0;
  ResultsMutator open(file, [](std::size_t) { return std::size_t{0}; });
  const Hid groups(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(groups, 1);
  for (const std::string& path : paths) {
    const std::string first = first_path(path);
    if (first.empty()) continue;
    moved +=
        H5Lmove(open.file(), path.c_str(), open.file(), first.c_str(), groups, H5P_DEFAULT) >= 0;
  }
  for (const char* group :
       {"/sensors", "/limit_switches", "/diagnostics", "/statistics/energy_spectrum"})
    open.remove(group);
  H5Arename_by_name(open.file(), "/", "responses_complete", "measured", H5P_DEFAULT);
  H5Adelete_by_name(open.file(), "/", "format_version", H5P_DEFAULT);
  return moved;
}

}  // namespace firn::test
