#include "experiments/storage/hdf5_file.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "experiments/storage/hdf5_chunks.h"
#include "experiments/storage/hdf5_library.h"
#include "experiments/storage/hdf5_objects.h"
#include "experiments/storage/hdf5_values.h"

#ifndef H5_HAVE_THREADSAFE
#error "Firn writes results from a background thread and needs a thread-safe build of HDF5"
#endif

namespace firn::hdf5 {
namespace {

Handle link_with_groups() {
  Handle list = own(H5Pcreate(H5P_LINK_CREATE), "make a property list");
  check(H5Pset_create_intermediate_group(list.id(), 1), "make a property list");
  return list;
}

Handle file_access() {
  silence();
  Handle list = own(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
  // The superblock of this format carries no "open for writing" flag, so that the file of a killed
  // writer opens as it is. The recorder excludes a second writer by a separate lock, so that
  // readers can open the file of an active run. Its groups and object headers carry checksums: a
  // reader that meets half of a flush gets an error, where groups of the older format make HDF5
  // crash.
  check(H5Pset_libver_bounds(list.id(), H5F_LIBVER_V18, H5F_LIBVER_V18), "set the format");
  check(H5Pset_file_locking(list.id(), false, true), "set the locking");
  // Metadata reach the file in flush() and nowhere else: between flushes the old ones stay whole.
  H5AC_cache_config_t cache;
  cache.version = H5AC__CURR_CACHE_CONFIG_VERSION;
  check(H5Pget_mdc_config(list.id(), &cache), "read the cache's settings");
  cache.evictions_enabled = false;
  cache.incr_mode = H5C_incr__off;
  cache.flash_incr_mode = H5C_flash_incr__off;
  cache.decr_mode = H5C_decr__off;
  check(H5Pset_mdc_config(list.id(), &cache), "set the cache");
  // Together in the file, so that a flush is a few large writes.
  check(H5Pset_meta_block_size(list.id(), hsize_t{64} * 1024), "set the block size");
  return list;
}

constexpr std::size_t kCompressedRow = 4096;  // bytes
constexpr std::size_t kPlainChunk = 8192;     // bytes

Handle table_layout(const Shape& row) {
  const std::size_t bytes = product(row) * sizeof(double);
  std::vector<hsize_t> chunk{1};
  chunk.insert(chunk.end(), row.begin(), row.end());
  Handle list = own(H5Pcreate(H5P_DATASET_CREATE), "make a property list");
  if (bytes < kCompressedRow)
    chunk[0] = std::max<std::size_t>(1, kPlainChunk / std::max<std::size_t>(bytes, 1));
  check(H5Pset_chunk(list.id(), static_cast<int>(chunk.size()), chunk.data()), "set the chunks");
  if (bytes >= kCompressedRow) {
    check(H5Pset_shuffle(list.id()), "set the compression");
    check(H5Pset_deflate(list.id(), 1), "set the compression");
  }
  const double missing = std::numeric_limits<double>::quiet_NaN();
  check(H5Pset_fill_value(list.id(), H5T_NATIVE_DOUBLE, &missing), "set the fill value");
  return list;
}

herr_t collect_dataset(hid_t, const char* name, const H5O_info_t* info, void* names) {
  if (info->type == H5O_TYPE_DATASET)
    static_cast<std::vector<std::string>*>(names)->push_back(std::string("/") + name);
  return 0;
}

// Whether the file has the bytes of this type, with nothing to convert.
template <class T>
bool is_kept_as(hid_t dataset) {
  const Handle type = own(H5Dget_type(dataset), "read a type");
  return std::endian::native == std::endian::little && H5Tequal(type.id(), native_type<T>()) > 0;
}

hsize_t size_of_file(hid_t file) {
  hsize_t bytes = 0;
  check(H5Fget_filesize(file, &bytes), "read the file's size");
  return bytes;
}

// A dataset writes what it has in memory when its handle is closed. What failed there is lost
// without a trace in the file, so that the next flush must report it. errno; -1: not known.
std::atomic<int> failed_close = 0;

}  // namespace

void Handle::close() {
  if (id_ >= 0 && H5Idec_ref(id_) < 0) {
    const int error = system_error_in(last_message());
    failed_close = error == 0 ? -1 : error;
  }
  id_ = -1;
}

template <>
Id native_type<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
Id native_type<int>() {
  return H5T_NATIVE_INT;
}
template <>
Id native_type<std::uint64_t>() {
  return H5T_NATIVE_UINT64;
}
template <>
Id native_type<std::byte>() {
  return H5T_NATIVE_UINT8;
}

Table::Table(Handle dataset, std::size_t rows, std::size_t row_size)
    : dataset_(std::move(dataset)), rows_(rows), row_size_(row_size) {}

void Table::append(std::span<const double> values) {
  silence();
  const std::size_t count = row_size_ ? values.size() / row_size_ : 0;
  if (count == 0) return;
  truncate(rows_ + count);
  const Handle selected = select_rows(dataset_.id(), rows_ - count, count);
  const Handle memory = dataspace({values.size()});
  check(H5Dwrite(dataset_.id(), H5T_NATIVE_DOUBLE, memory.id(), selected.id(), H5P_DEFAULT,
                 values.data()),
        "write rows");
}

void Table::truncate(std::size_t rows) {
  silence();
  const Shape shape = shape_of(dataset_.id());
  std::vector<hsize_t> extent(shape.begin(), shape.end());
  extent[0] = rows;
  check(H5Dset_extent(dataset_.id(), extent.data()), "resize a table");
  rows_ = rows;
}

File File::create(const std::string& path) {
  const Handle access = file_access();
  failed_close = 0;  // of a file that was given up
  return File(own(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), "create it"),
              Access::write);
}

File File::open(const std::string& path, Access access) {
  const Handle list = file_access();
  if (access == Access::write) failed_close = 0;  // of a file that was given up
  const unsigned flags = access == Access::write ? H5F_ACC_RDWR : H5F_ACC_RDONLY;
  return File(own(H5Fopen(path.c_str(), flags, list.id()), "open it"), access);
}

void File::flush() {
  silence();
  check(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL), "flush");
  if (const int error = failed_close.exchange(0); error != 0)
    throw Error("cannot write a dataset", std::max(error, 0));
}

void File::close() {
  open_rows_.clear();
  flush();
  const Id id = std::exchange(file_, Handle()).release();
  check(H5Idec_ref(id), "close");
}

std::string File::stored(const std::string& path) const {
  return names_.stored ? names_.stored(path) : path;
}

std::string File::stored(const std::string& path, const std::string& attribute) const {
  return names_.stored_attribute ? names_.stored_attribute(path, attribute) : attribute;
}

// The name in use of an object of the file; false: it has none.
bool File::is_in_use(const std::string& stored_path, std::string& path) const {
  path = names_.current ? names_.current(stored_path) : stored_path;
  return stored(path) == stored_path;
}

bool File::contains(const std::string& path) const {
  silence();
  const std::string name = stored(path);
  // H5Lexists requires that every group of the path exists.
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    if (H5Lexists(file_.id(), name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

void File::remove(const std::string& path) {
  silence();
  check(H5Ldelete(file_.id(), stored(path).c_str(), H5P_DEFAULT), "remove " + path);
}

std::vector<std::string> File::datasets() const {
  silence();
  std::vector<std::string> names;
  check(H5Ovisit2(file_.id(), H5_INDEX_NAME, H5_ITER_INC, collect_dataset, &names, H5O_INFO_BASIC),
        "list the datasets");
  for (const std::string& name : names) check_printable(name, "a dataset");
  std::vector<std::string> in_use;
  std::string path;
  for (const std::string& name : names)
    if (is_in_use(name, path)) in_use.push_back(path);
  std::sort(in_use.begin(), in_use.end());
  return in_use;
}

std::vector<Object> File::objects() const {
  silence();
  std::vector<Object> all = list_objects(file_.id());
  std::string path;
  std::erase_if(all, [&](Object& object) {
    if (!is_in_use(object.path, path)) return true;
    object.path = path;
    return false;
  });
  std::sort(all.begin(), all.end(),
            [](const Object& a, const Object& b) { return a.path < b.path; });
  return all;
}

Stored File::check_storage(const std::string& path) const {
  const Handle dataset = open_dataset(file_.id(), stored(path));
  const Storage s = storage_of(dataset.id(), path);
  const Shape shape = shape_of(dataset.id());
  const hsize_t file_size = size_of_file(file_.id());
  const std::size_t rows = shape.empty() ? 1 : shape[0];
  if (s.layout == H5D_CHUNKED) {
    double sum = 0;
    std::size_t written = rows;
    for (std::size_t row = 0; row < rows; row += s.chunk[0]) {
      const Chunk c = chunk_at(dataset.id(), row, shape.size(), path);
      if (c.address == HADDR_UNDEF) {
        written = row;  // the rest of the index is unused
        break;
      }
      check_chunk(c, s, row, file_size, path);
      sum += static_cast<double>(c.size);
    }
    if (sum > static_cast<double>(file_size)) throw Error(path + ": has chunks that overlap");
    return {written, true};
  }
  check_believable(file_.id(), dataset, path);
  const haddr_t address = H5Dget_offset(dataset.id());
  const hsize_t bytes = H5Dget_storage_size(dataset.id());
  if (s.layout == H5D_CONTIGUOUS && address != HADDR_UNDEF &&
      (address > file_size || bytes > file_size - address || bytes < product(shape) * s.element))
    throw Error(path + ": has less space in the file than its values need");
  return {rows, false};
}

Shape File::shape(const std::string& path) const {
  return shape_of(open_dataset(file_.id(), stored(path)).id());
}

template <class T>
std::vector<T> File::read(const std::string& path) const {
  const Handle dataset = open_dataset(file_.id(), stored(path));
  check_believable(file_.id(), dataset, path);
  const Shape shape = shape_of(dataset.id());
  std::vector<T> values(product(shape));
  if (!values.empty() && is_kept_as<T>(dataset.id())) {
    if (const Storage s = storage_of(dataset.id(), path); s.layout == H5D_CHUNKED) {
      read_chunks(dataset.id(), s, 0, shape[0], size_of_file(file_.id()), path,
                  reinterpret_cast<unsigned char*>(values.data()));
      return values;
    }
  }
  if (!values.empty())
    check(H5Dread(dataset.id(), native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "read " + path);
  return values;
}

std::vector<std::string> File::read_strings(const std::string& path) const {
  const Handle dataset = open_dataset(file_.id(), stored(path));
  const Handle stored = own(H5Dget_type(dataset.id()), "read the type of " + path);
  check_string_class(stored.id(), path);
  const Handle space = own(H5Dget_space(dataset.id()), "read a shape");
  check_believable(file_.id(), dataset, path);
  std::vector<char*> text(product(shape_of_space(space.id())));
  std::vector<std::string> values;
  if (text.empty()) return values;
  check(H5Dread(dataset.id(), stored.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()),
        "read " + path);
  read_text(stored.id(), space.id(), text, values);
  for (std::string& value : values) {
    check_printable(value, path);
    if (names_.current_text) value = names_.current_text(path, value);
  }
  return values;
}

struct File::OpenRows {
  Handle dataset;
  Shape shape;
  bool kept_as_doubles = false;
  Storage storage;  // of a dataset kept as doubles
};

std::shared_ptr<const File::OpenRows> File::open_rows(const std::string& path) const {
  if (const auto found = open_rows_.find(path); found != open_rows_.end()) return found->second;
  const auto rows = std::make_shared<OpenRows>();
  rows->dataset = open_dataset(file_.id(), stored(path));
  const Id id = rows->dataset.id();
  rows->shape = shape_of(id);
  check_believable(file_.id(), rows->dataset, path);
  rows->kept_as_doubles = is_kept_as<double>(id);
  if (rows->kept_as_doubles) rows->storage = storage_of(id, path);
  if (access_ == Access::read) open_rows_[path] = rows;
  return rows;
}

std::vector<double> File::read_rows(const std::string& path, std::size_t first,
                                    std::size_t count) const {
  const auto rows = open_rows(path);
  Shape shape = rows->shape;
  if (shape.empty() || first + count > shape[0])
    throw Error(fmt::format("{} has no rows {} to {}", path, first, first + count));
  shape[0] = count;
  std::vector<double> values(product(shape));
  if (values.empty()) return values;
  const Id id = rows->dataset.id();
  if (rows->kept_as_doubles && rows->storage.layout == H5D_CHUNKED) {
    read_chunks(id, rows->storage, first, count, size_of_file(file_.id()), path,
                reinterpret_cast<unsigned char*>(values.data()));
    return values;
  }
  const Handle selected = select_rows(id, first, count);
  const Handle memory = dataspace({values.size()});
  check(H5Dread(id, H5T_NATIVE_DOUBLE, memory.id(), selected.id(), H5P_DEFAULT, values.data()),
        "read " + path);
  return values;
}

template <class T>
void File::write(const std::string& path, const Shape& shape, std::span<const T> values) {
  silence();
  const Id type = native_type<T>();
  Handle dataset;
  if (contains(path)) {
    dataset = open_dataset(file_.id(), stored(path));
    if (shape_of(dataset.id()) != shape) throw Error(path + " has another shape");
  } else {
    const Handle space = dataspace(shape), groups = link_with_groups();
    dataset = own(H5Dcreate2(file_.id(), stored(path).c_str(), type, space.id(), groups.id(),
                             H5P_DEFAULT, H5P_DEFAULT),
                  "create " + path);
  }
  if (values.empty()) return;
  check(H5Dwrite(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
        "write " + path);
}

void File::write_strings(const std::string& path, const std::vector<std::string>& values) {
  silence();
  const Handle type = string_type();
  Handle dataset;
  if (contains(path)) {
    dataset = open_dataset(file_.id(), stored(path));
    if (shape_of(dataset.id()) != Shape{values.size()}) throw Error(path + " has another shape");
  } else {
    const Handle space = dataspace({values.size()}), groups = link_with_groups();
    dataset = own(H5Dcreate2(file_.id(), stored(path).c_str(), type.id(), space.id(), groups.id(),
                             H5P_DEFAULT, H5P_DEFAULT),
                  "create " + path);
  }
  std::vector<const char*> text;
  text.reserve(values.size());
  for (const std::string& s : values) text.push_back(s.c_str());
  if (text.empty()) return;
  check(H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()),
        "write " + path);
}

void File::write_bytes(const std::string& path, std::span<const std::byte> bytes) {
  silence();
  Handle dataset;
  if (contains(path)) {
    dataset = open_dataset(file_.id(), stored(path));
    const hsize_t extent = std::max(shape_of(dataset.id()).at(0), bytes.size());
    check(H5Dset_extent(dataset.id(), &extent), "resize " + path);
  } else {
    const hsize_t extent = bytes.size(), unlimited = H5S_UNLIMITED, chunk = hsize_t{256} * 1024;
    const Handle space = own(H5Screate_simple(1, &extent, &unlimited), "make a dataspace");
    const Handle layout = own(H5Pcreate(H5P_DATASET_CREATE), "make a property list");
    check(H5Pset_chunk(layout.id(), 1, &chunk), "set the chunks");
    const Handle groups = link_with_groups();
    dataset = own(H5Dcreate2(file_.id(), stored(path).c_str(), H5T_NATIVE_UINT8, space.id(),
                             groups.id(), layout.id(), H5P_DEFAULT),
                  "create " + path);
  }
  const Handle selected = select_rows(dataset.id(), 0, bytes.size());
  const Handle memory = dataspace({bytes.size()});
  check(H5Dwrite(dataset.id(), H5T_NATIVE_UINT8, memory.id(), selected.id(), H5P_DEFAULT,
                 bytes.data()),
        "write " + path);
}

Table File::create_table(const std::string& path, const Shape& row, const std::string& unit) {
  silence();
  std::vector<hsize_t> extent{0}, limit{H5S_UNLIMITED};
  extent.insert(extent.end(), row.begin(), row.end());
  limit.insert(limit.end(), row.begin(), row.end());
  const Handle space =
      own(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), limit.data()),
          "make a dataspace");
  const Handle groups = link_with_groups(), layout = table_layout(row);
  Handle dataset = own(H5Dcreate2(file_.id(), stored(path).c_str(), H5T_NATIVE_DOUBLE, space.id(),
                                  groups.id(), layout.id(), H5P_DEFAULT),
                       "create " + path);
  set_attribute(path, "unit", unit);
  return Table(std::move(dataset), 0, product(row));
}

Table File::open_table(const std::string& path) {
  Handle dataset = open_dataset(file_.id(), stored(path));
  Shape shape = shape_of(dataset.id());
  if (shape.empty()) throw Error(path + " is not a table");
  const std::size_t rows = shape[0];
  shape.erase(shape.begin());
  return Table(std::move(dataset), rows, product(shape));
}

template std::vector<double> File::read(const std::string&) const;
template std::vector<int> File::read(const std::string&) const;
template std::vector<std::uint64_t> File::read(const std::string&) const;
template std::vector<std::byte> File::read(const std::string&) const;
template void File::write(const std::string&, const Shape&, std::span<const double>);
template void File::write(const std::string&, const Shape&, std::span<const int>);
template void File::write(const std::string&, const Shape&, std::span<const std::uint64_t>);
template void File::write(const std::string&, const Shape&, std::span<const std::byte>);

}  // namespace firn::hdf5
