// Values of results.json files, as pages need them.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace firn {

using Json = nlohmann::ordered_json;

// NaN: null, which stands for a number that is not defined.
inline double number(const Json& j) {
  return j.is_number() ? j.get<double>() : std::numeric_limits<double>::quiet_NaN();
}
inline double number(const Json& j, const char* key) { return number(j.at(key)); }
inline std::string text(const Json& j, const char* key) { return j.at(key).get<std::string>(); }
inline std::vector<double> numbers(const Json& j) {
  std::vector<double> all;
  for (const Json& one : j) all.push_back(number(one));
  return all;
}

}  // namespace firn
