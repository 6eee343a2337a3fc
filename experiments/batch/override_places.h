// Errors of a case in values and material records that another file sets in it, with their place in
// that file.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/system/value_place.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Where a file states the path and the value of an override. Empty: it does not state the override.
struct OverridePlace {
  OverridePlace() = default;
  // The same place of both: "FILE:LINE: KEY".
  OverridePlace(const std::string& both) : path{both, {}}, value{both, {}} {}
  OverridePlace(ValuePlace of_path, ValuePlace of_value)
      : path(std::move(of_path)), value(std::move(of_value)) {}

  ValuePlace path, value;
};
using OverridePlaces = std::function<OverridePlace(const Override&)>;

// Where `places` [set] state one of the overrides `set`; empty: it is not among them.
OverridePlace place_among(const std::vector<Override>& set, const std::vector<ValuePlace>& places,
                          const Override& o);

// Throws InputError `PLACE: the case CASE_FILE has no key "KEY"; ADVICE`, or for a value that the
// case refuses `PLACE: the case CASE_FILE does not take "KEY" = VALUE: PROBLEM`. PLACE is that of
// what is wrong: the path, the value or a part of the value. Throws `error` if it has no place.
[[noreturn]] void throw_with_place(const OverrideError& error, const std::string& case_file,
                                   const std::vector<Override>& overrides,
                                   const OverridePlaces& places);

// Returns make(), which reads the case with the overrides. Throws as throw_with_place() in place of
// an OverrideError.
template <class Make>
auto with_override_places(const std::string& case_file, const std::vector<Override>& overrides,
                          const OverridePlaces& places, Make&& make) {
  try {
    return make();
  } catch (const OverrideError& error) {
    throw_with_place(error, case_file, overrides, places);
  }
}

// Returns make(), which reads a case with material records. Puts place_of(record) before the
// message of an error in a requested record; empty: nothing.
template <class PlaceOf, class Make>
auto with_material_places(const PlaceOf& place_of, const Make& make) {
  try {
    return make();
  } catch (const MaterialRequestError& error) {
    const std::string place = place_of(error.record);
    if (place.empty()) throw;
    throw InputError(place + ": " + error.what());
  }
}

}  // namespace firn
