// The page of a validation: verdicts at a glance, then each comparison with what it rests on.
#pragma once

#include <string>

#include "reports/page.h"

namespace firn {

// From a validation's results.json. Throws InputError for a file that is none.
page::Page validation_page(const std::string& results_file);

}  // namespace firn
