// The page of a study, validation, sweep or optimization that has not ended: progress, responses of
// the finished runs, and the best parameters of a study so far.
#pragma once

#include <string>

#include "experiments/batch/batch_state.h"
#include "reports/html/page.h"

namespace firn {

page::Page batch_page(const BatchState& state, const std::string& name);

}  // namespace firn
