#include "app/output/progress_bar.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cmath>

#include "experiments/text/number_text.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

constexpr double line_interval = 10;   // s between plain lines
constexpr double smoothing_time = 20;  // s, memory of the rate
constexpr int bar_width = 24, narrow_bar_width = 10;
constexpr std::size_t narrow = 90;  // columns; below, the text needs the room

}  // namespace

ProgressMeter::ProgressMeter(double timestep)
    : timestep_(timestep), terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressMeter::show(const Progress& progress) {
  update_rate(progress);
  if (terminal_) {
    draw_bar(progress);
  } else if (progress.wall - last_line_ >= line_interval) {
    last_line_ = progress.wall;
    log_line(progress);
  }
}

void ProgressMeter::update_rate(const Progress& p) {
  const double wall = p.wall - last_wall_;
  if (!first_ && wall > 0) {
    const double now = (p.time - last_time_) / wall;
    const double weight = rate_ > 0 ? 1 - std::exp(-wall / smoothing_time) : 1;
    rate_ += weight * (now - rate_);
  }
  first_ = false;
  last_time_ = p.time;
  last_wall_ = p.wall;
}

void ProgressMeter::draw_bar(const Progress& p) {
  const int width = terminal_columns() < narrow ? narrow_bar_width : bar_width;
  const double share = p.end_time_limit > 0 ? p.time / p.end_time_limit : 0;
  // Stages may end early, so the time to the latest end is an upper bound.
  const std::string left =
      rate_ > 0
          ? "at most " + estimated_duration_text((p.end_time_limit - p.time) / rate_) + " left, "
          : "";
  bar_.draw(fmt::format("{} {:.3f} of {} s, {}{}", progress_bar(share, width), p.time,
                        number_text(p.end_time_limit), left, stage_text(p)));
}

void ProgressMeter::log_line(const Progress& p) const {
  spdlog::info("{:.3f} of {} s, {}, {:.0f} steps/s, at most {} left", p.time,
               number_text(p.end_time_limit), stage_text(p), rate_ / timestep_,
               rate_ > 0 ? estimated_duration_text((p.end_time_limit - p.time) / rate_) : "?");
}

}  // namespace firn
