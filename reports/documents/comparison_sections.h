// Sections of a validation page for each kind of comparison.
#pragma once

#include <string>
#include <vector>

#include "reports/html/page.h"
#include "validation/validation_document.h"

namespace firn {

// All parameter sets of one comparison in results.json, in the suite's order.
using Sets = std::vector<const ValidationDocument::ComparisonRow*>;

page::Badge badge_of(const std::string& verdict);

// Plots and tables of the comparison's kind. Throws BadValue for lists of different lengths.
void add_comparison(const Sets& sets, page::Content& content);

}  // namespace firn
