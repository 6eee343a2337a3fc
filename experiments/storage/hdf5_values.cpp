#include "experiments/storage/hdf5_values.h"

#include <fmt/format.h>
#include <hdf5.h>

#include "experiments/storage/hdf5_chunks.h"
#include "experiments/storage/hdf5_library.h"

namespace firn::hdf5 {

void check_believable(Id file, const Shape& shape, std::size_t element, bool packed,
                      const std::string& path) {
  hsize_t bytes = 0;
  check(H5Fget_filesize(file, &bytes), "read the file's size");
  double claimed = static_cast<double>(element);
  for (std::size_t n : shape) claimed *= static_cast<double>(n);
  if (claimed > (packed ? kLargestCompression : 1) * static_cast<double>(bytes))
    throw Error(fmt::format("{} claims more values than the file can hold", path));
}

void check_believable(Id file, const Handle& dataset, const std::string& path) {
  const Handle type = own(H5Dget_type(dataset.id()), "read the type of " + path);
  const Handle layout = own(H5Dget_create_plist(dataset.id()), "read the layout of " + path);
  const bool packed = check(H5Pget_nfilters(layout.id()), "read the layout of " + path) > 0;
  check_believable(file, shape_of(dataset.id()), H5Tget_size(type.id()), packed, path);
}

Handle string_type() {
  Handle type = own(H5Tcopy(H5T_C_S1), "make a string type");
  check(H5Tset_size(type.id(), H5T_VARIABLE), "make a string type");
  check(H5Tset_cset(type.id(), H5T_CSET_UTF8), "make a string type");
  return type;
}

Handle select_rows(Id dataset, std::size_t first, std::size_t count) {
  Handle space = own(H5Dget_space(dataset), "read a shape");
  const Shape shape = shape_of_space(space.id());
  std::vector<hsize_t> start(shape.size(), 0), size(shape.begin(), shape.end());
  start[0] = first;
  size[0] = count;
  check(
      H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr),
      "select rows");
  return space;
}

void read_text(Id type, Id space, const std::vector<char*>& text,
               std::vector<std::string>& values) {
  for (const char* s : text) values.emplace_back(s ? s : "");
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, const_cast<char**>(text.data()));
}

void check_string_class(Id type, const std::string& what) {
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0)
    throw Error(what + " is not text");
}

}  // namespace firn::hdf5
