// Parts of the page of a study that are plots: predicted responses, the estimate by number of runs,
// sensitivity. Lists of another length, and values that are not finite, throw BadValue.
#pragma once

#include "calibrate/output/study_document.h"
#include "reports/html/page.h"

namespace firn {

// One plot per target: response predicted from the posterior samples, and its measured value.
// Nothing of a study that has none.
void predictions_section(const StudyDocument& results, page::Page& page);

// One plot per parameter: median with 68 % and 95 % interval after each round of runs. Nothing of a
// study that has none.
void estimate_history_section(const StudyDocument& results, page::Page& page);

// Sobol indices of every response by parameter, with their 95 % intervals where there are some:
// first order, and total where it is known. One sentence of a study with one parameter, and nothing
// of one that has no indices.
void add_sensitivity(const StudyDocument& results, page::Content& content);

}  // namespace firn
