#include "experiments/text/json_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/system/input_file.h"
#include "experiments/text/json_aliases.h"
#include "experiments/text/suggestions.h"

namespace firn {
namespace {

using FieldJson = nlohmann::ordered_json;

constexpr double kLargestField = 1e100;
constexpr std::int64_t kLargestInt = 1'000'000'000;

std::string path_of(const JsonPlace& place) {
  if (place.parent == nullptr) return std::string(place.key);
  const std::string above = path_of(*place.parent);
  return fmt::format("{}{}{}", above, above.empty() ? "" : ".",
                     place.key.empty() ? std::to_string(place.index) : std::string(place.key));
}

// "FILE:LINE" of a place.
std::string file_and_line(const JsonPlace& place) {
  std::vector<std::string> path;
  const JsonPlace* outer = &place;
  for (; outer->parent != nullptr; outer = outer->parent)
    path.push_back(outer->key.empty() ? std::to_string(outer->index) : std::string(outer->key));
  std::ranges::reverse(path);
  return json_place(place.file, outer->text, path);
}

bool is_whole_number(const FieldJson& json, std::int64_t least, std::int64_t most) {
  if (!json.is_number_integer()) return false;
  // Beyond 63 bits a number is unsigned and compares as too large.
  if (json.is_number_unsigned() && json.get<std::uint64_t>() > static_cast<std::uint64_t>(most))
    return false;
  return json.get<std::int64_t>() >= least && json.get<std::int64_t>() <= most;
}

std::string description(const FieldJson& json) {
  if (json.is_object()) return "an object";
  if (json.is_array()) return fmt::format("a list of {}", json.size());
  return shortened(json.dump(-1, ' ', false, FieldJson::error_handler_t::replace));
}

}  // namespace

void JsonPlace::refuse(const FieldJson& found, std::string_view expected) const {
  const std::string path = path_of(*this);
  throw InputError(fmt::format("{}: {}: is {}; expected {}", file_and_line(*this),
                               path.empty() ? "document" : path, description(found), expected));
}

void JsonPlace::refuse_missing(std::string_view missing) const {
  throw InputError(fmt::format("{}: {}: missing; expected this key", file_and_line(*this),
                               path_of(at(missing))));
}

void JsonPlace::refuse_unknown_keys(const FieldJson& object,
                                    const std::vector<std::string_view>& known) const {
  const std::string path = path_of(*this);
  for (const auto& [key, value] : object.items())
    if (std::ranges::find(known, key) == known.end())
      throw InputError(fmt::format("{}: {}: unknown key \"{}\"; {}", file_and_line(at(key)),
                                   path.empty() ? "document" : path, key, suggestion(key, known)));
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, double& value) {
  if (place.reading == JsonReading::strict) {
    if (!json.is_number()) place.refuse(json, "a number");
    value = json.get<double>();  // finite, as the parser refuses others
    return;
  }
  value = std::numeric_limits<double>::quiet_NaN();
  if (json.is_null()) return;
  if (json.is_number()) value = json.get<double>();
  if (!(std::abs(value) <= kLargestField)) place.refuse(json, "a number up to 1e100");
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, bool& value) {
  if (!json.is_boolean()) place.refuse(json, "true or false");
  value = json.get<bool>();
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, std::string& value) {
  if (!json.is_string()) place.refuse(json, "a text");
  value = json.get<std::string>();
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, int& value) {
  if (!is_whole_number(json, -kLargestInt, kLargestInt))
    place.refuse(json, "a whole number up to a billion");
  value = json.get<int>();
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, PositiveInt& number) {
  if (!is_whole_number(json, 1, number.most))
    place.refuse(json, fmt::format("a whole number from 1 to {}", number.most));
  number.value = json.get<int>();
}

void JsonFieldReader::read(const Json& json, const JsonPlace& place, std::uint64_t& value) {
  if (!json.is_number_unsigned()) place.refuse(json, "a whole number of at least 0");
  value = json.get<std::uint64_t>();
}

std::string ResultsJson::kind() const {
  if (!document.is_object()) return "";
  const FieldJson kind = document.value("kind", FieldJson());
  if (kind == "sweep" || kind == "validation" || kind == "optimization")
    return kind.get<std::string>();
  return document.contains("study") ? "study" : "";
}

void ResultsJson::require_kind(const std::string& wanted, const std::string& command) const {
  if (kind() != wanted)
    throw InputError(
        fmt::format("{}: is not a result of a {}; expected the results.json that {} writes", file,
                    wanted, command));
}

ResultsJson read_results_json(const std::string& file, const std::string& expected) {
  ResultsJson results{read_json_file(file, expected)};
  use_current_json_names(results.document);
  return results;
}

}  // namespace firn
