// Storage layout of datasets in an HDF5 file. For the sources of this folder.
#pragma once

#include <hdf5.h>

#include <string>
#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

constexpr double kLargestCompression = 1032;  // compression ratio of deflate for zeros

// Storage layout of a dataset.
struct Storage {
  H5D_layout_t layout = H5D_COMPACT;
  bool packed = false;         // compressed by shuffle and deflate
  std::vector<hsize_t> chunk;  // dimensions of a chunk, of a chunked dataset
  std::size_t element = 0;     // bytes of an element
  std::size_t chunk_bytes = 0;
};
// Throws Error for a layout or a filter that Firn does not write.
Storage storage_of(Id dataset, const std::string& path);

struct Chunk {
  haddr_t address = HADDR_UNDEF;  // HADDR_UNDEF: not in the file
  hsize_t size = 0;               // bytes in the file
  unsigned skipped = 0;           // bit mask of filters that were not applied
};
// The chunk that begins at `row`.
Chunk chunk_at(Id dataset, std::size_t row, std::size_t rank, const std::string& path);
// Throws Error unless the chunk is inside the file and its size is plausible for its rows.
void check_chunk(const Chunk& c, const Storage& s, std::size_t row, hsize_t file_size,
                 const std::string& path);
// Reads rows [first, first + count) of a chunked dataset to `to`. Throws Error.
void read_chunks(Id dataset, const Storage& s, std::size_t first, std::size_t count,
                 hsize_t file_size, const std::string& path, unsigned char* to);

}  // namespace firn::hdf5
