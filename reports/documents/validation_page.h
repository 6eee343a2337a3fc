// The page of a validation: a table of verdicts, then each comparison with its data.
#pragma once

#include <cstddef>

#include "experiments/text/json_fields.h"
#include "reports/html/page.h"

namespace firn {

struct ValidationPageOptions {
  bool replays = true;                     // of the first run of each experiment
  std::size_t replay_budget = 12'000'000;  // characters of data over all of them
};

// From a validation's results.json, and the results files that it names as far as they are there.
// Throws InputError for another kind of file.
page::Page validation_page(const ResultsJson& results, const ValidationPageOptions& options = {});

}  // namespace firn
