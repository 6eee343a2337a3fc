// Names of files of format 1.
#include "experiments/results/results_schema.h"
#include "experiments/results/schema_paths.h"

namespace firn::results {
namespace {

// From the columns `first_name` of the schema.
std::string converted_path(const std::string& path, std::string_view Dataset::*from,
                           std::string_view Dataset::*to) {
  for (const Dataset& d : datasets()) {
    if (d.first_name.empty()) continue;
    if (const std::optional<std::string> name = Pattern(d.*from).name_in(path))
      return Pattern(d.*to).with(*name);
  }
  return path;
}

hdf5::Names first_names() {
  hdf5::Names names;
  names.stored = [](const std::string& path) {
    return converted_path(path, &Dataset::path, &Dataset::first_name);
  };
  names.current = [](const std::string& path) { return current_path(path); };
  names.stored_attribute = [](const std::string& path, const std::string& name) {
    for (const Attribute& a : attributes())
      if (!a.first_name.empty() && a.object == path && a.name == name)
        return std::string(a.first_name);
    return name;
  };
  names.current_text = [](const std::string& path, const std::string& value) {
    for (const RenamedText& t : renamed_texts())
      if (t.path == path && t.first == value) return std::string(t.current);
    return value;
  };
  return names;
}

}  // namespace

std::string current_path(const std::string& path) {
  return converted_path(path, &Dataset::first_name, &Dataset::path);
}

hdf5::File open_file(const std::string& path, hdf5::File::Access access) {
  hdf5::File file = hdf5::File::open(path, access);
  if (!file.has_attribute("/", "format_version")) file.use_names(first_names());
  return file;
}

}  // namespace firn::results
