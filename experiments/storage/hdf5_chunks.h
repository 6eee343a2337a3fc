// How the values of a dataset are kept in the file. For the sources of this folder.
#pragma once

#include <hdf5.h>

#include <string>
#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn::hdf5 {

constexpr double kLargestCompression = 1032;  // compression ratio of deflate for zeros

// How the values of a dataset are kept.
struct Storage {
  H5D_layout_t layout = H5D_COMPACT;
  bool packed = false;         // by shuffle and deflate
  std::vector<hsize_t> chunk;  // of a chunked one
  std::size_t element = 0;     // bytes of one
  std::size_t chunk_bytes = 0;
};
// Throws Error for a layout or a packing that Firn does not write.
Storage storage_of(Id dataset, const std::string& path);

struct Chunk {
  haddr_t address = HADDR_UNDEF;  // not in the file
  hsize_t size = 0;               // bytes in the file
  unsigned skipped = 0;           // filters
};
Chunk chunk_at(Id dataset, std::size_t row, std::size_t rank, const std::string& path);
// That a chunk which is in the file can hold its rows.
void check_chunk(const Chunk& c, const Storage& s, std::size_t row, hsize_t file_size,
                 const std::string& path);
// Rows [first, first + count) of a dataset in chunks, as they are in the file.
void read_chunks(Id dataset, const Storage& s, std::size_t first, std::size_t count,
                 hsize_t file_size, const std::string& path, unsigned char* to);

}  // namespace firn::hdf5
