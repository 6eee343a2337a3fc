#include "experiments/batch/override_places.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

void throw_with_place(const OverrideError& error, const std::string& case_file,
                      const std::vector<Override>& overrides, const OverridePlaces& places) {
  const auto o = std::ranges::find_if(overrides, [&](const Override& one) {
    return override_label(one.first, one.second) == error.label;
  });
  const std::string place = o == overrides.end() ? "" : places(*o);
  if (place.empty()) throw error;
  // An unknown key in a table that is the value is a problem of the value.
  const bool in_value = error.problem.starts_with(o->first + ".");
  if (!error.advice.empty() && !in_value)
    throw InputError(fmt::format("{}: the case {} has no key \"{}\"; {}", place, case_file,
                                 o->first, error.advice));
  throw InputError(fmt::format("{}: the case {} does not take \"{}\" = {}: {}{}{}", place,
                               case_file, o->first, o->second, error.problem,
                               error.advice.empty() ? "" : "; ", error.advice));
}

}  // namespace firn
