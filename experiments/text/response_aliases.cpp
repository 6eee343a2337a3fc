#include "experiments/text/response_aliases.h"

#include <algorithm>

namespace firn {
namespace {

constexpr RenamedResponse kRenamedResponses[] = {
    {"covered_fraction_left", "window_coverage_left"},
    {"covered_fraction_right", "window_coverage_right"},
    {"wall_rise", "wall_height_excess"},
    {"wall_rise_left", "wall_height_excess_left"},
    {"wall_rise_right", "wall_height_excess_right"},
    {"largest_opposed_load", "largest_compressive_load"},
    {"opposed_load_median", "compressive_load_median"},
    {"opposed_loads", "compressive_loads"},
    {"_fifo_index", "_order_index"},
    {"_first_half_evenness", "_first_half_similarity"},
    {"_first_half_evenness_at_random", "_first_half_similarity_at_random"},
    {"_first_half_mixing", "_mixing_index"},
    {"_waiting_times", "_censored_times"},
    {"_largest_drive", "_largest_motor_load"},
};

// Responses that end with the name of a stage or boundary, which is the user's.
constexpr std::string_view kBeforeUserNames[] = {
    "duration_",       "contacts_on_",    "largest_contact_on_",
    "peak_stress_on_", "wear_volume_on_", "wear_depth_on_",
};

// `text` with the name of its response replaced: `from` and `to` are members of RenamedResponse.
std::string with_response_renamed(std::string_view text, std::string_view RenamedResponse::*from,
                                  std::string_view RenamedResponse::*to) {
  const std::size_t begin = text.rfind(' ') + 1;  // npos + 1 is 0
  const std::size_t end = std::min(text.find('[', begin), text.size());
  const std::string_view name = text.substr(begin, end - begin);
  const bool ends_with_user_name = std::ranges::any_of(
      kBeforeUserNames, [&](std::string_view beginning) { return name.starts_with(beginning); });
  for (const RenamedResponse& r : kRenamedResponses) {
    const std::string_view known = r.*from;
    const bool matches = known.starts_with('_') ? name.size() > known.size() &&
                                                      name.ends_with(known) && !ends_with_user_name
                                                : name == known;
    if (!matches) continue;
    std::string renamed(text.substr(0, end - known.size()));
    return renamed.append(r.*to).append(text.substr(end));
  }
  return std::string(text);
}

}  // namespace

std::span<const RenamedResponse> renamed_responses() { return kRenamedResponses; }

std::string current_response_name(std::string_view text) {
  return with_response_renamed(text, &RenamedResponse::old_name, &RenamedResponse::name);
}

std::string first_response_name(std::string_view text) {
  return with_response_renamed(text, &RenamedResponse::name, &RenamedResponse::old_name);
}

}  // namespace firn
