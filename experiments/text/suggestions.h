// The known word that is nearest to an unknown one, for messages.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// Levenshtein distance in half steps. A change of case counts as half a step.
int edit_distance(std::string_view a, std::string_view b);

// The candidate that the user most likely meant: one that means the same as a word of other
// programs, else one that is one edit away, else one with a common part between underscores
// ("friction": "static_friction"), else one within a few edits. The first one of equal candidates.
std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates);

// `did you mean "size"?`, the end of a message about an unknown word.
std::string did_you_mean(std::string_view word);

// did_you_mean() with the nearest() candidate; without one `expected one of a, b, c`.
std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace firn
