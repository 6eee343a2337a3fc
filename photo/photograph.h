// Photographs of users: PNG and JPEG files as pixels.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// Eight bits a channel, rows from the top. Pixel (i, j) covers i to i + 1 and j to j + 1.
struct Photograph {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // [height][width][3]
  std::string file;               // it was read from
  std::string hash;               // SHA-256 of the file

  std::array<std::uint8_t, 3> at(int column, int row) const {
    const std::size_t k = 3 * (static_cast<std::size_t>(row) * width + column);
    return {rgb[k], rgb[k + 1], rgb[k + 2]};
  }
};

// The picture upright, as viewers show it: the orientation that a camera stores with a JPEG is
// applied. `source` begins messages. Sizes are checked before anything is decoded (input_limits.h).
// Throws InputError, one line, for what is neither PNG nor JPEG, too large or damaged.
Photograph decode_photograph(std::string_view bytes, const std::string& source);
Photograph read_photograph(const std::string& file);

}  // namespace firn
