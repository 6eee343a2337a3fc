// Formulas of problem files: numbers, names, + - * / ^, < and >, brackets, and a few functions.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace firn::proof {

using Formula = std::function<double(const std::vector<double>&)>;

// The formula as a function of the values of `names`, in their order. Comparisons are 1 or 0.
// Throws InputError (one sentence) for text that is none.
Formula parse_formula(const std::string& text, const std::vector<std::string>& names);

}  // namespace firn::proof
