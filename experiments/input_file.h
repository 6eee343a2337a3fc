// How files of users are opened: regular files alone, whose size is checked before they are read.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace firn {

// Throws InputError `FILE: what is wrong; expected WANTED` unless the file can be read and is a
// regular one: no folder, device, pipe or socket. Does not block.
void require_regular_file(const std::string& file, std::string_view wanted);

// All bytes of a regular file of at most `most` bytes. Throws InputError as above, before it reads
// a file that is longer.
std::string read_input_file(const std::string& file, std::string_view wanted, std::uintmax_t most);

// The first characters of a text, for messages.
std::string shortened(std::string_view text);

}  // namespace firn
