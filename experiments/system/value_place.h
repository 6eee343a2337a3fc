// Where a file states a value, for messages.
#pragma once

#include <map>
#include <string>

#include "firn/math.h"

namespace firn {

// "FILE:LINE: KEY" of a value and of its parts.
struct ValuePlace {
  std::string whole;  // empty: no file states the value
  // Of the parts of a table or list, by their path in it ("1.position"). A part without an entry
  // has the place of the nearest part around it.
  std::map<std::string, std::string> parts;

  const std::string& at(std::string path) const {
    while (!path.empty()) {
      if (const auto found = parts.find(path); found != parts.end()) return found->second;
      const std::size_t dot = path.rfind('.');
      path.resize(dot == std::string::npos ? 0 : dot);
    }
    return whole;
  }
};

// Where a fault is: `place`, or `file` if no place is known.
inline const std::string& place_or_file(const std::string& place, const std::string& file) {
  return place.empty() ? file : place;
}

// Returns make(). Puts `place` before the message of an InputError that it throws. Empty: no place
// is known.
template <class Make>
auto with_place(const std::string& place, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    if (place.empty()) throw;
    throw InputError(place + ": " + error.what());
  }
}

}  // namespace firn
