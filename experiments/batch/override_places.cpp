#include "experiments/batch/override_places.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

OverridePlace place_among(const std::vector<Override>& set, const std::vector<ValuePlace>& places,
                          const Override& o) {
  const auto found = std::ranges::find(set, o);
  if (found == set.end()) return {};
  const ValuePlace& place = places.at(static_cast<std::size_t>(found - set.begin()));
  return {place, place};
}

void throw_with_place(const OverrideError& error, const std::string& case_file,
                      const std::vector<Override>& overrides, const OverridePlaces& places) {
  const auto o = std::ranges::find_if(overrides, [&](const Override& one) {
    return override_label(one.first, one.second) == error.label;
  });
  const OverridePlace stated = o == overrides.end() ? OverridePlace() : places(*o);
  const std::string& place = error.of_value ? stated.value.at(error.value_part) : stated.path.whole;
  if (place.empty()) throw error;
  // An unknown key in a table that is the value is a problem of the value.
  if (!error.advice.empty() && !error.of_value)
    throw InputError(fmt::format("{}: the case {} has no key \"{}\"; {}", place, case_file,
                                 o->first, error.advice));
  throw InputError(fmt::format("{}: the case {} does not take \"{}\" = {}: {}{}{}", place,
                               case_file, o->first, o->second, error.problem,
                               error.advice.empty() ? "" : "; ", error.advice));
}

}  // namespace firn
