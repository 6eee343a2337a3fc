// The page of one run: responses, diagnostics and an interactive replay.
#pragma once

#include <string>

#include "reports/html/page.h"
#include "reports/replay/replay_view.h"

namespace firn {

// From a results file alone. Throws InputError for a file that cannot be read, and without gnuplot.
page::Page run_page(const std::string& results_file, const ReplayViewOptions& options = {});

}  // namespace firn
