// The rules of the results schema, applied to values.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "experiments/results/results_schema.h"

namespace firn::results {

// Bounds of indices, from lengths that are known.
struct Limits {
  double count = 0;       // one above the largest index
  double boundaries = 0;  // of the rules for bodies; infinite: not known
};

// `length` is that of the symbol which the rule names.
Limits limits_of(Rule rule, std::size_t length, std::size_t particles);

// What the rule expects, for messages: "0 or 1".
std::string range_text(Rule rule, const Limits& limits);

// The first value that breaks the rule, which may be one for several of them. `width`: values of a
// row of the last dimension.
std::optional<std::size_t> first_wrong(Rule rule, std::span<const double> values, std::size_t width,
                                       const Limits& limits);

// Throws hdf5::Error for values of a dataset that break the rule. `first_row`: number of the first
// row of `values` in the dataset.
void check_numbers(std::string_view path, Rule rule, std::span<const double> values,
                   const hdf5::Shape& shape, const Limits& limits, std::size_t first_row);

// Whether a text is one of `choices`, which are separated by '|', or one with ": " and more.
bool is_choice(std::string_view value, std::string_view choices);
std::string choices_text(std::string_view choices);  // "a, b, c"

}  // namespace firn::results
