#include "experiments/storage/netcdf_file.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <numeric>

#include "experiments/storage/hdf5_library.h"

namespace firn {
namespace {

using hdf5::check;
using hdf5::Handle;
using hdf5::own;

// NetCDF orders its objects by their creation.
void keep_order(hid_t properties) {
  check(H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
        "set the order of objects");
}

void write_attributes(hid_t object, const NetcdfAttributes& attributes) {
  for (const auto& [name, text] : attributes) {
    const Handle type = own(H5Tcopy(H5T_C_S1), "make a text type");
    check(H5Tset_size(type.id(), std::max<std::size_t>(text.size(), 1)), "set a text type");
    check(H5Tset_cset(type.id(), H5T_CSET_UTF8), "set a text type");
    const Handle space = own(H5Screate(H5S_SCALAR), "make an attribute");
    const Handle attribute =
        own(H5Acreate2(object, name.c_str(), type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT),
            "make the attribute " + name);
    check(H5Awrite(attribute.id(), type.id(), text.empty() ? "" : text.data()),
          "write the attribute " + name);
  }
}

std::string path_of(const std::string& group, const std::string& name) {
  return group.empty() ? "/" + name : "/" + group + "/" + name;
}

Handle make_dataset(hid_t file, const std::string& path, hid_t type,
                    const std::vector<hsize_t>& shape) {
  const Handle space =
      own(shape.empty() ? H5Screate(H5S_SCALAR)
                        : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
          "make the shape of " + path);
  const Handle properties = own(H5Pcreate(H5P_DATASET_CREATE), "make " + path);
  check(H5Pset_attr_creation_order(properties.id(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
        "set the order of attributes");
  return own(
      H5Dcreate2(file, path.c_str(), type, space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
      "make " + path);
}

}  // namespace

NetcdfFile::NetcdfFile(const std::string& path) : path_(path), temporary_(path + ".part") {
  hdf5::silence();
  const Handle properties = own(H5Pcreate(H5P_FILE_CREATE), "make a file");
  keep_order(properties.id());
  file_ = own(H5Fcreate(temporary_.c_str(), H5F_ACC_TRUNC, properties.id(), H5P_DEFAULT),
              "make " + temporary_);
}

NetcdfFile::~NetcdfFile() {
  if (path_.empty()) return;
  file_.close();
  unlink(temporary_.c_str());
}

void NetcdfFile::group(const std::string& name, const NetcdfAttributes& attributes) {
  if (name.empty()) {
    const Handle root = own(H5Gopen2(file_.id(), "/", H5P_DEFAULT), "open the root");
    return write_attributes(root.id(), attributes);
  }
  const Handle properties = own(H5Pcreate(H5P_GROUP_CREATE), "make a group");
  keep_order(properties.id());
  const Handle made = own(
      H5Gcreate2(file_.id(), path_of("", name).c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
      "make the group " + name);
  write_attributes(made.id(), attributes);
}

void NetcdfFile::dimension(const std::string& group, const std::string& name, std::size_t size) {
  const std::string path = path_of(group, name);
  const Handle scale = make_dataset(file_.id(), path, H5T_STD_I64LE, {size});
  std::vector<std::int64_t> coordinates(size);
  std::iota(coordinates.begin(), coordinates.end(), 0);
  check(H5Dwrite(scale.id(), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, coordinates.data()),
        "write " + path);
  check(H5DSset_scale(scale.id(), name.c_str()), "make the dimension " + path);
  dimensions_.push_back({group, name, size});
}

const NetcdfFile::Dimension& NetcdfFile::find(const std::string& group,
                                              const std::string& name) const {
  for (const Dimension& d : dimensions_)
    if (d.group == group && d.name == name) return d;
  throw hdf5::Error(fmt::format("the group {} has no dimension {}", group, name));
}

void NetcdfFile::variable(const std::string& group, const std::string& name,
                          const std::vector<std::string>& dimensions,
                          std::span<const double> values, const NetcdfAttributes& attributes) {
  const std::string path = path_of(group, name);
  std::vector<hsize_t> shape;
  std::size_t count = 1;
  for (const std::string& d : dimensions) {
    shape.push_back(find(group, d).size);
    count *= find(group, d).size;
  }
  if (count != values.size()) throw hdf5::Error("the values do not fill " + path);
  const Handle data = make_dataset(file_.id(), path, H5T_IEEE_F64LE, shape);
  check(H5Dwrite(data.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
        "write " + path);
  for (unsigned i = 0; i < dimensions.size(); ++i) {
    const Handle scale = own(
        H5Dopen2(file_.id(), path_of(group, dimensions[i]).c_str(), H5P_DEFAULT), "open " + path);
    check(H5DSattach_scale(data.id(), scale.id(), i), "give " + path + " its dimensions");
  }
  write_attributes(data.id(), attributes);
}

void NetcdfFile::commit() {
  check(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL), "write " + temporary_);
  file_.close();
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
    throw hdf5::Error("cannot rename " + temporary_, errno);
  path_.clear();
}

}  // namespace firn
