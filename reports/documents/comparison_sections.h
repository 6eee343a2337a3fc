// Sections of a validation page for each kind of comparison.
#pragma once

#include <string>
#include <vector>

#include "reports/html/json_values.h"
#include "reports/html/page.h"

namespace firn {

// All parameter sets of one comparison in results.json, in the suite's order.
using Sets = std::vector<const Json*>;

page::Badge badge_of(const std::string& verdict);

// Plots and tables of the comparison's kind. Throws Json::exception for data that differ from the
// format of `firn validate`.
void add_comparison(const Sets& sets, page::Content& content);

}  // namespace firn
