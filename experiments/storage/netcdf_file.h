// Writes netCDF-4 files (HDF5 with dimension scales) for other programs.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiments/storage/hdf5_file.h"

namespace firn {

using NetcdfAttributes = std::vector<std::pair<std::string, std::string>>;

// A new file, which has a temporary name until commit(). All functions throw hdf5::Error.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::string& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  // Creates a group in the root, with attributes; "": attributes of the root.
  void group(const std::string& name, const NetcdfAttributes& attributes = {});
  // Creates a dimension in a group with the coordinates 0 ... size - 1.
  void dimension(const std::string& group, const std::string& name, std::size_t size);
  // Writes a variable over dimensions of its group, row-major.
  void variable(const std::string& group, const std::string& name,
                const std::vector<std::string>& dimensions, std::span<const double> values,
                const NetcdfAttributes& attributes = {});
  void commit();

 private:
  struct Dimension {
    std::string group, name;
    std::size_t size = 0;
  };
  const Dimension& find(const std::string& group, const std::string& name) const;

  std::string path_, temporary_;
  hdf5::Handle file_;
  std::vector<Dimension> dimensions_;
};

}  // namespace firn
