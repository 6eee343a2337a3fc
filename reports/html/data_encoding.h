// Encodings of binary data in pages.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace firn {

// zlib's format (RFC 1950), which browsers inflate by themselves. Throws RunError out of memory.
std::vector<std::uint8_t> zlib_compressed(const std::vector<std::uint8_t>& bytes);
std::string base64(const std::vector<std::uint8_t>& bytes);  // RFC 4648, padded

}  // namespace firn
