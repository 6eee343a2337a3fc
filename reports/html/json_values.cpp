#include "reports/html/json_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/json_aliases.h"
#include "experiments/text/json_reader.h"
#include "firn/math.h"

namespace firn {
namespace {

// Beyond every quantity, and so that products of several stay finite.
constexpr double kLargest = 1e100;

// Without the library's own number of the error.
std::string message_of(const std::exception& e) {
  const std::string text = e.what();
  const std::size_t end = text.find("] ");
  return text.starts_with("[json.exception") && end != text.npos ? text.substr(end + 2) : text;
}

[[noreturn]] void refuse(const Json& j, const std::string& wanted) {
  const std::string found = j.is_array()
                                ? fmt::format("a list of {}", j.size())
                                : shortened(j.dump(-1, ' ', false, Json::error_handler_t::replace));
  throw BadValue(fmt::format("{} stands where {} belongs", found, wanted));
}

}  // namespace

double number(const Json& j) {
  if (j.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!j.is_number()) refuse(j, "a number");
  const double value = j.get<double>();
  if (!(std::abs(value) <= kLargest)) refuse(j, "a number up to 1e100");
  return value;
}

double number(const Json& j, const char* key) { return number(j.at(key)); }

int whole_number(const Json& j, const char* key) {
  constexpr std::uint64_t kMost = 1'000'000'000;
  const Json& value = j.at(key);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > kMost)
    refuse(value, fmt::format("a whole number from 0 to {} (\"{}\")", kMost, key));
  return value.get<int>();
}

std::string text(const Json& j, const char* key) {
  const Json& value = j.at(key);
  if (!value.is_string()) refuse(value, fmt::format("a text (\"{}\")", key));
  return value.get<std::string>();
}

int contact_model_of(const Json& results) {
  return results.contains("contact_model") ? whole_number(results, "contact_model") : 1;
}

std::vector<double> numbers(const Json& j) {
  if (!j.is_array()) refuse(j, "a list of numbers");
  std::vector<double> all;
  for (const Json& one : j) all.push_back(number(one));
  return all;
}

std::vector<double> numbers(const Json& j, std::size_t count) {
  if (!j.is_array() || j.size() != count) refuse(j, fmt::format("a list of {} numbers", count));
  return numbers(j);
}

std::pair<double, double> interval(const Json& j) {
  const std::vector<double> ends = numbers(j, 2);
  return {ends[0], ends[1]};
}

double finite_number(const Json& j) {
  if (j.is_null()) refuse(j, "a number");
  return number(j);
}

std::vector<double> finite_numbers(const Json& j, std::size_t count) {
  std::vector<double> all = numbers(j, count);
  for (const Json& one : j) finite_number(one);
  return all;
}

std::vector<double> ascending_numbers(const Json& j, std::size_t count) {
  std::vector<double> all = finite_numbers(j, count);
  if (!std::ranges::is_sorted(all)) refuse(j, "a list of numbers in ascending order");
  return all;
}

const Json& list(const Json& j, const char* key) {
  const Json& value = j.at(key);
  if (!value.is_array()) refuse(value, fmt::format("a list (\"{}\")", key));
  return value;
}

Json read_results_json(const std::string& file) {
  Json document =
      parse_ordered_json(read_input_file(file, "the results.json of a study or a validation",
                                         input_limits::json_bytes),
                         file);
  use_current_json_names(document);
  return document;
}

page::Page page_from(const std::string& file, const std::function<page::Page()>& build) {
  const auto refuse_file = [&](const std::exception& e) {
    throw InputError(
        fmt::format("{}: a page cannot be made of it: {}; expected results.json as Firn writes it",
                    file, message_of(e)));
  };
  try {
    return build();
  } catch (const Json::exception& e) {
    refuse_file(e);
  } catch (const BadValue& e) {
    refuse_file(e);
  } catch (const std::logic_error& e) {  // a plot of lists of different lengths
    refuse_file(e);
  }
  throw std::logic_error("unreachable");
}

}  // namespace firn
