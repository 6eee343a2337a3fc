// Where a file states a value, for messages.
#pragma once

#include <map>
#include <string>

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

}  // namespace firn
