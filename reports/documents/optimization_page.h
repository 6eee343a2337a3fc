// The page of an optimization: the best design, what it gains, and the designs of the search.
#pragma once

#include "experiments/text/json_fields.h"
#include "reports/html/page.h"

namespace firn {

// Throws InputError for a file that is no results.json of an optimization.
page::Page optimization_page(const ResultsJson& results);

}  // namespace firn
