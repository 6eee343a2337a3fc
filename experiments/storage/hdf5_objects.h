// The groups and datasets of a file. For the sources of this folder.
#pragma once

#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

// Of all levels, those near the root first. Throws Error for a file with links to elsewhere, with
// two names of one object, or with too many objects or levels.
std::vector<Object> list_objects(Id file);

}  // namespace firn::hdf5
