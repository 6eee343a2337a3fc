// Types, selections and texts of HDF5 values; checks of their size. For the sources of this folder.
#pragma once

#include <string>
#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

// Throws Error for a shape with more elements than the file could hold, as a damaged header may
// promise: nothing is allocated for it. `element`: bytes of one in the file; `packed`: what is
// stored may be compressed.
void check_believable(Id file, const Shape& shape, std::size_t element, bool packed,
                      const std::string& path);
void check_believable(Id file, const Handle& dataset, const std::string& path);

Handle string_type();  // UTF-8 of variable length
// Throws Error for a type that is not string_type().
void check_string_class(Id type, const std::string& what);
// Appends the texts that the library has read, and releases them.
void read_text(Id type, Id space, const std::vector<char*>& text, std::vector<std::string>& values);

// Selects rows [first, first + count) of a dataset.
Handle select_rows(Id dataset, std::size_t first, std::size_t count);

}  // namespace firn::hdf5
