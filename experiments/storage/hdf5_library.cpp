#include "experiments/storage/hdf5_library.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <charconv>
#include <numeric>
#include <type_traits>
#include <vector>

#include "experiments/system/text_encoding.h"

namespace firn::hdf5 {
namespace {

static_assert(std::is_same_v<Id, hid_t> || sizeof(Id) == sizeof(hid_t));

// The innermost message of the library's error stack, e.g. "file write failed: ... No space left".
herr_t keep_innermost(unsigned, const H5E_error2_t* error, void* text) {
  if (static_cast<std::string*>(text)->empty() && error->desc)
    *static_cast<std::string*>(text) = error->desc;
  return 0;
}

}  // namespace

// HDF5 keeps one error printer for each thread. It also cleans up when the program ends, and
// crashes there over objects that it could not close on a full disk. The first call must disable
// that.
void silence() {
  static const bool no_tidying = H5dont_atexit() >= 0;
  static_cast<void>(no_tidying);
  thread_local const bool silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  static_cast<void>(silent);
}

// The library has no other place for the error of a failed system call than its message:
// "file write failed: time = ..., errno = 28, error message = ...".
int system_error_in(const std::string& message) {
  constexpr std::string_view key = "errno = ";
  const std::size_t at = message.find(key);
  int error = 0;
  if (at != message.npos)
    std::from_chars(message.data() + at + key.size(), message.data() + message.size(), error);
  return error;
}

std::string last_message() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason);
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason;
}

void fail(const std::string& what) {
  const std::string reason = last_message();
  throw Error(reason.empty() ? "cannot " + what : fmt::format("cannot {} ({})", what, reason),
              system_error_in(reason));
}

Handle own(Id id, const std::string& what) { return Handle(check(id, what)); }

std::size_t product(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

Handle dataspace(const Shape& shape) {
  if (shape.empty()) return own(H5Screate(H5S_SCALAR), "make a dataspace");
  const std::vector<hsize_t> extent(shape.begin(), shape.end());
  return own(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
             "make a dataspace");
}

Shape shape_of_space(Id space) {
  const int rank = check(H5Sget_simple_extent_ndims(space), "read a shape");
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr), "read a shape");
  return Shape(extent.begin(), extent.end());
}

Handle open_dataset(Id file, const std::string& path) {
  silence();
  return own(H5Dopen2(file, path.c_str(), H5P_DEFAULT), "open " + path);
}

Shape shape_of(Id dataset) {
  const Handle space = own(H5Dget_space(dataset), "read a shape");
  return shape_of_space(space.id());
}

Type type_of(Id type) {
  const auto is = [type](Id known) { return H5Tequal(type, known) > 0; };
  if (H5Tget_class(type) == H5T_STRING)
    return H5Tis_variable_str(type) > 0 ? Type::text : Type::other;
  if (is(H5T_IEEE_F64LE)) return Type::real;
  if (is(H5T_STD_I32LE)) return Type::integer;
  if (is(H5T_STD_U64LE)) return Type::natural;
  if (is(H5T_STD_U8LE)) return Type::byte;
  return Type::other;
}

bool has_extent(Id space) {
  const H5S_class_t kind = H5Sget_simple_extent_type(space);
  return kind == H5S_SIMPLE || kind == H5S_SCALAR;
}

void check_printable(const std::string& text, const std::string& what) {
  if (const std::string found = encode::first_unprintable(text); !found.empty())
    throw Error(
        fmt::format("{} has the character {} in its text; expected printable text", what, found));
}

}  // namespace firn::hdf5
