// The page of a study: the fit, the uncertainty of each parameter, suggested measurements.
#pragma once

#include "experiments/text/json_fields.h"
#include "reports/html/page.h"

namespace firn {

// From a study's results.json, and the fitted response in the same folder if there is one. Throws
// InputError for another kind of file.
page::Page study_page(const ResultsJson& results);

}  // namespace firn
