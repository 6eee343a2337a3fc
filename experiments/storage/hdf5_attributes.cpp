// Attributes of the objects of an HDF5 file.
#include <fmt/format.h>
#include <hdf5.h>

#include "experiments/storage/hdf5_file.h"
#include "experiments/storage/hdf5_library.h"
#include "experiments/storage/hdf5_values.h"

namespace firn::hdf5 {
namespace {

Handle open_attribute(hid_t file, const std::string& path, const std::string& name) {
  silence();
  return own(H5Aopen_by_name(file, path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
             fmt::format("open the attribute {} of {}", name, path));
}

void put_attribute(hid_t file, const std::string& path, const std::string& name, hid_t type,
                   const Shape& shape, const void* value) {
  silence();
  const std::string what = fmt::format("write the attribute {} of {}", name, path);
  const Handle object = own(H5Oopen(file, path.c_str(), H5P_DEFAULT), what);
  if (check(H5Aexists(object.id(), name.c_str()), what) > 0)
    check(H5Adelete(object.id(), name.c_str()), what);
  const Handle space = dataspace(shape);
  const Handle attribute =
      own(H5Acreate2(object.id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), what);
  const double nothing = 0;  // HDF5 refuses null, also where there is nothing to write
  check(H5Awrite(attribute.id(), type, value == nullptr ? &nothing : value), what);
}

}  // namespace

bool File::has_attribute(const std::string& path, const std::string& name) const {
  silence();
  return H5Aexists_by_name(file_.id(), stored(path).c_str(), stored(path, name).c_str(),
                           H5P_DEFAULT) > 0;
}

Attribute File::attribute(const std::string& path, const std::string& name) const {
  const Handle opened = open_attribute(file_.id(), stored(path), stored(path, name));
  const Handle type = own(H5Aget_type(opened.id()), "read the type of " + name);
  const Handle space = own(H5Aget_space(opened.id()), "read a shape");
  Attribute found;
  found.type = type_of(type.id());
  found.has_space = has_extent(space.id());
  if (found.has_space) found.shape = shape_of_space(space.id());
  return found;
}

void File::set_attribute(const std::string& path, const std::string& name,
                         const std::string& value) {
  silence();
  const Handle type = string_type();
  const char* text = value.c_str();
  put_attribute(file_.id(), stored(path), stored(path, name), type.id(), {}, &text);
}

void File::set_attribute(const std::string& path, const std::string& name, double value) {
  put_attribute(file_.id(), stored(path), stored(path, name), H5T_NATIVE_DOUBLE, {}, &value);
}

void File::set_attribute(const std::string& path, const std::string& name, std::uint64_t value) {
  put_attribute(file_.id(), stored(path), stored(path, name), H5T_NATIVE_UINT64, {}, &value);
}

void File::set_attribute(const std::string& path, const std::string& name,
                         const std::vector<double>& values) {
  put_attribute(file_.id(), stored(path), stored(path, name), H5T_NATIVE_DOUBLE, {values.size()},
                values.data());
}

std::string File::text_attribute(const std::string& path, const std::string& name) const {
  const Handle attribute = open_attribute(file_.id(), stored(path), stored(path, name));
  const Handle stored = own(H5Aget_type(attribute.id()), "read the type of " + name);
  check_string_class(stored.id(), "the attribute " + name);
  const Handle space = own(H5Aget_space(attribute.id()), "read a shape");
  if (!shape_of_space(space.id()).empty()) throw Error("the attribute " + name + " is a list");
  std::vector<char*> text(1);
  check(H5Aread(attribute.id(), stored.id(), text.data()), "read the attribute " + name);
  std::vector<std::string> values;
  read_text(stored.id(), space.id(), text, values);
  // A case is checked by its reader, which names the key.
  if (name != "case") check_printable(values.front(), "the attribute " + name);
  return values.front();
}

std::vector<double> File::number_attribute(const std::string& path, const std::string& name) const {
  const Handle attribute = open_attribute(file_.id(), stored(path), stored(path, name));
  const Handle space = own(H5Aget_space(attribute.id()), "read a shape");
  const Shape shape = shape_of_space(space.id());
  check_believable(file_.id(), shape, 1, false, name);
  std::vector<double> values(product(shape));
  if (!values.empty())
    check(H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, values.data()), "read the attribute " + name);
  return values;
}

std::uint64_t File::integer_attribute(const std::string& path, const std::string& name) const {
  const Handle attribute = open_attribute(file_.id(), stored(path), stored(path, name));
  const Handle space = own(H5Aget_space(attribute.id()), "read a shape");
  if (!shape_of_space(space.id()).empty()) throw Error("the attribute " + name + " is a list");
  std::uint64_t value = 0;
  check(H5Aread(attribute.id(), H5T_NATIVE_UINT64, &value), "read the attribute " + name);
  return value;
}

}  // namespace firn::hdf5
