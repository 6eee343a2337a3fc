// Wrappers of HDF5 calls: errors as hdf5::Error, shapes, opened objects. For the sources of this
// folder.
#pragma once

#include <string>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

// Disables error output of the library in this thread. To be called before any other HDF5 call.
void silence();
// Innermost message of the calling thread's last failure.
std::string last_message();
// errno that such a message states; 0: none.
int system_error_in(const std::string& message);
// Throws Error "cannot WHAT" with last_message().
[[noreturn]] void fail(const std::string& what);

// Throws as fail() for a negative result.
template <class Result>
Result check(Result result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}
// A handle of `id`. Throws as fail() for a negative one.
Handle own(Id id, const std::string& what);

std::size_t product(const Shape& shape);  // number of elements
Handle dataspace(const Shape& shape);
Shape shape_of_space(Id space);
Handle open_dataset(Id file, const std::string& path);
Shape shape_of(Id dataset);
Type type_of(Id type);
bool has_extent(Id space);  // true for a scalar or an array, false for a null dataspace

// Throws Error for names and texts with control characters: they are printed and written to other
// files.
void check_printable(const std::string& text, const std::string& what);

}  // namespace firn::hdf5
