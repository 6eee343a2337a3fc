// Errors of a case in values that another file sets in it, with their place in that file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// "FILE:LINE: KEY" where a file states an override; empty: it does not state the override.
using OverridePlaces = std::function<std::string(const Override&)>;

// Throws InputError `PLACE: the case CASE_FILE has no key "KEY"; ADVICE`, or for a value that the
// case refuses `PLACE: the case CASE_FILE does not take "KEY" = VALUE: PROBLEM`. Throws `error` if
// it has no place.
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

}  // namespace firn
