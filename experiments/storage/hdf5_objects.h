// The groups and datasets of a file. For the sources of this folder.
#pragma once

#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

// All groups and datasets, parents before children. Throws Error as File::objects().
std::vector<Object> list_objects(Id file);

}  // namespace firn::hdf5
