// Values of results.json files, as pages need them. What is missing or of another type, length or
// size throws BadValue, or an exception of the JSON library.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "reports/html/page.h"

namespace firn {

using Json = nlohmann::ordered_json;

struct BadValue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// NaN for null, which stands for a number that is not defined. At most 1e100 either way.
double number(const Json& j);
double number(const Json& j, const char* key);
int whole_number(const Json& j, const char* key);  // from 0 to a billion
std::string text(const Json& j, const char* key);
int contact_model_of(const Json& results);  // 1: the document does not state one
std::vector<double> numbers(const Json& j);
std::vector<double> numbers(const Json& j, std::size_t count);
std::pair<double, double> interval(const Json& j);  // two numbers
// As number() and numbers(), but null is refused; ascending: none is below the one before.
double finite_number(const Json& j);
std::vector<double> finite_numbers(const Json& j, std::size_t count);
std::vector<double> ascending_numbers(const Json& j, std::size_t count);
const Json& list(const Json& j, const char* key);

// A results.json file of at most the limit of input_limits.h, in current names.
Json read_results_json(const std::string& file);
// Result of `build` for the document. A value that the document lacks throws an InputError that
// names the file.
page::Page page_from(const std::string& file, const std::function<page::Page()>& build);

}  // namespace firn
