// Series of numbers as files of a drawing.
#pragma once

#include <string>

#include "reports/plots/plot_svg.h"
#include "reports/plots/plots.h"

namespace firn::plots {

// Throws std::logic_error where the lists have different lengths.
void require_fitting_lists(const Series& series);

// Columns: x y x_error y_error low high wide_low wide_high. Returns the file, quoted. `any` becomes
// true where a point is shown.
std::string write_series(const Drawing& drawing, const std::string& name, const Series& series,
                         const Axis& x, const Axis& y, bool& any);

}  // namespace firn::plots
