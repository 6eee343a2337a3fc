// The page of a study: what was fitted, how well each parameter is known, what would tell more.
#pragma once

#include <string>

#include "reports/html/page.h"

namespace firn {

// From a study's results.json, and the fitted response beside it where there is one. Throws
// InputError for a file that is none.
page::Page study_page(const std::string& results_file);

}  // namespace firn
