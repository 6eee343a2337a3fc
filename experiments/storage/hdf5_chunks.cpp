#include "experiments/storage/hdf5_chunks.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "experiments/storage/hdf5_library.h"

namespace firn::hdf5 {
namespace {

// Deflate is left out of a chunk that it would not make smaller.
constexpr unsigned kDeflateSkipped = 1u << 1;

// The bytes of one chunk, as many as its rows have. The library checks neither that a chunk holds
// them all nor that its filters were applied; so they are unpacked here.
class ChunkReader {
 public:
  ChunkReader(hid_t dataset, const Storage& storage, const std::string& path)
      : dataset_(dataset), storage_(storage), path_(path), values_(storage.chunk_bytes) {}

  const std::vector<unsigned char>& read(std::size_t row, const Chunk& c) {
    stored_.resize(c.size);
    std::vector<hsize_t> offset(storage_.chunk.size(), 0);
    offset[0] = row;
    std::uint32_t skipped = 0;
    check(H5Dread_chunk(dataset_, H5P_DEFAULT, offset.data(), &skipped, stored_.data()),
          "read " + path_);
    if (!storage_.packed) return stored_;
    uLongf size = storage_.chunk_bytes;
    shuffled_.resize(size);
    if (c.skipped == kDeflateSkipped) {
      shuffled_ = stored_;
    } else if (uncompress(shuffled_.data(), &size, stored_.data(), stored_.size()) != Z_OK ||
               size != shuffled_.size()) {
      throw Error(fmt::format("{}: the compressed values of row {} are damaged", path_, row));
    }
    const std::size_t count = storage_.chunk_bytes / storage_.element;
    for (std::size_t byte = 0; byte < storage_.element; ++byte)
      for (std::size_t i = 0; i < count; ++i)
        values_[i * storage_.element + byte] = shuffled_[byte * count + i];
    return values_;
  }

 private:
  hid_t dataset_;
  const Storage& storage_;
  const std::string& path_;
  std::vector<unsigned char> stored_, shuffled_, values_;
};

}  // namespace

Storage storage_of(Id dataset, const std::string& path) {
  const std::string what = "read the layout of " + path;
  const Handle list = own(H5Dget_create_plist(dataset), what);
  const Handle type = own(H5Dget_type(dataset), "read the type of " + path);
  Storage s;
  s.element = H5Tget_size(type.id());
  s.layout = H5Pget_layout(list.id());
  if (s.layout != H5D_COMPACT && s.layout != H5D_CONTIGUOUS && s.layout != H5D_CHUNKED)
    throw Error(path + ": keeps its values elsewhere; expected them in the file");
  if (check(H5Pget_external_count(list.id()), what) > 0)
    throw Error(path + ": keeps its values in another file; expected them in this one");
  std::vector<H5Z_filter_t> filters;
  const int count = check(H5Pget_nfilters(list.id()), what);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0;
    std::size_t parameters = 0;
    filters.push_back(check(H5Pget_filter2(list.id(), static_cast<unsigned>(i), &flags, &parameters,
                                           nullptr, 0, nullptr, nullptr),
                            what));
  }
  s.packed = filters == std::vector<H5Z_filter_t>{H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE};
  if (!filters.empty() && !s.packed)
    throw Error(path + ": is packed in an unknown way; expected none, or shuffle and deflate");
  if (s.layout != H5D_CHUNKED) return s;
  const Shape shape = shape_of(dataset);
  s.chunk.resize(shape.size());
  check(H5Pget_chunk(list.id(), static_cast<int>(s.chunk.size()), s.chunk.data()), what);
  double bytes = static_cast<double>(s.element);
  for (std::size_t k = 0; k < shape.size(); ++k) {
    if (s.chunk[k] == 0 || (k > 0 && s.chunk[k] != shape[k]))
      throw Error(path + ": is cut into chunks that are not whole rows");
    bytes *= static_cast<double>(s.chunk[k]);
  }
  if (bytes >= 4294967296.0) throw Error(path + ": has chunks of more than 4 GiB");
  s.chunk_bytes = static_cast<std::size_t>(bytes);
  return s;
}

Chunk chunk_at(Id dataset, std::size_t row, std::size_t rank, const std::string& path) {
  std::vector<hsize_t> offset(rank, 0);
  offset[0] = row;
  Chunk c;
  check(H5Dget_chunk_info_by_coord(dataset, offset.data(), &c.skipped, &c.address, &c.size),
        "look for the rows of " + path);
  return c;
}

void check_chunk(const Chunk& c, const Storage& s, std::size_t row, hsize_t file_size,
                 const std::string& path) {
  const bool inside = c.address < file_size && c.size <= file_size - c.address;
  const bool deflated = s.packed && c.skipped == 0;
  const bool plain = c.skipped == (s.packed ? kDeflateSkipped : 0u);
  const bool fits = deflated ? static_cast<double>(s.chunk_bytes) <=
                                   kLargestCompression * static_cast<double>(c.size) + 64
                             : plain && c.size == s.chunk_bytes;
  if (!inside || !fits)
    throw Error(fmt::format("{}: the chunk of row {} does not fit its rows", path, row));
}

void read_chunks(Id dataset, const Storage& s, std::size_t first, std::size_t count,
                 hsize_t file_size, const std::string& path, unsigned char* to) {
  const std::size_t rows = s.chunk[0], row_bytes = s.chunk_bytes / rows;
  ChunkReader reader(dataset, s, path);
  for (std::size_t row = first; row < first + count;) {
    const std::size_t start = row / rows * rows, take = std::min(start + rows, first + count) - row;
    const Chunk c = chunk_at(dataset, start, s.chunk.size(), path);
    if (c.address == HADDR_UNDEF)
      throw Error(fmt::format("{}: row {} was never written", path, row));
    check_chunk(c, s, start, file_size, path);
    std::memcpy(to, reader.read(start, c).data() + (row - start) * row_bytes, take * row_bytes);
    to += take * row_bytes;
    row += take;
  }
}

}  // namespace firn::hdf5
