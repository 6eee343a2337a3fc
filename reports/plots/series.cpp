#include "reports/plots/series.h"

#include <array>
#include <limits>
#include <vector>

#include "reports/plots/axes.h"

namespace firn::plots {

void require_fitting_lists(const Series& s) {
  const auto fits = [&](const std::vector<double>& v) {
    return v.empty() || v.size() == s.x.size();
  };
  require_consistent(s.y.size() == s.x.size() && fits(s.x_error) && fits(s.y_error) &&
                         fits(s.low) && fits(s.high) && s.low.size() == s.high.size() &&
                         fits(s.wide_low) && s.wide_low.size() == s.wide_high.size(),
                     "lists of a series have different lengths");
}

std::string write_series(const Drawing& drawing, const std::string& name, const Series& s,
                         const Axis& x, const Axis& y, bool& any) {
  std::vector<std::array<double, 8>> rows;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const bool there = shown(x, s.x[i]) && shown(y, s.y[i]);
    any = any || there;
    rows.push_back({drawn(x, s.x[i]),
                    there ? drawn(y, s.y[i]) : std::numeric_limits<double>::quiet_NaN(),
                    value_at(s.x_error, i), value_at(s.y_error, i), drawn(y, value_at(s.low, i)),
                    drawn(y, value_at(s.high, i)), drawn(y, value_at(s.wide_low, i)),
                    drawn(y, value_at(s.wide_high, i))});
  }
  return drawing.data(name, rows);
}

}  // namespace firn::plots
