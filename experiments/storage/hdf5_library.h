// Calls of the HDF5 library: errors as hdf5::Error, shapes, opened objects. For the sources of this
// folder.
#pragma once

#include <string>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

// To be called before any other call of a thread: the library prints nothing then.
void silence();
// Innermost message of the calling thread's last failure.
std::string last_message();
// errno in such a message; 0: it has none.
int system_error_in(const std::string& message);
// Throws "cannot WHAT" with the library's reason.
[[noreturn]] void fail(const std::string& what);

template <class Result>
Result check(Result result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}
Handle own(Id id, const std::string& what);

std::size_t product(const Shape& shape);
Handle dataspace(const Shape& shape);
Shape shape_of_space(Id space);
Handle open_dataset(Id file, const std::string& path);
Shape shape_of(Id dataset);
Type type_of(Id type);
bool has_extent(Id space);  // a shape, be it a scalar's

// Names and texts of a file are shown to people and written to other files.
void check_printable(const std::string& text, const std::string& what);

}  // namespace firn::hdf5
