// The page of a sweep: how each response depends on each key, then the table of all combinations.
#pragma once

#include "experiments/text/json_fields.h"
#include "reports/html/page.h"

namespace firn {

// From a sweep's results.json. Throws InputError for another kind of file.
page::Page sweep_page(const ResultsJson& results);

}  // namespace firn
