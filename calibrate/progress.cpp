#include "calibrate/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace firn {
namespace {

constexpr int bar_width = 24;
constexpr auto terminal_interval = std::chrono::milliseconds(200);
constexpr auto plain_interval = std::chrono::seconds(30);

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", std::ceil(seconds));
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

StudyProgress::StudyProgress(bool show, int total, int jobs)
    : show_(show), terminal_(isatty(STDERR_FILENO) != 0), total_(total), jobs_(std::max(1, jobs)) {}

StudyProgress::~StudyProgress() { done(); }

void StudyProgress::done() {
  if (drawn_ && terminal_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void StudyProgress::phase(const std::string& name) {
  phase_ = name;
  last_draw_ = {};
  tick();
}

void StudyProgress::ended(double wall, bool in_journal, bool failed) {
  ++done_;
  if (!in_journal) --running_;
  if (failed) ++failed_;
  if (wall > 0) {
    ++timed_;
    wall_ += wall;
  }
  tick();
}

std::string StudyProgress::line() const {
  const int filled = total_ > 0 ? bar_width * std::min(done_, total_) / total_ : bar_width;
  std::string s = terminal_ ? fmt::format("[{:#<{}}{:.<{}}] ", "", filled, "", bar_width - filled)
                            : std::string("calibrate: ");
  s += fmt::format("{} of at most {} runs", done_, total_);
  if (running_ > 0) s += fmt::format(", {} under way", running_);
  if (failed_ > 0) s += fmt::format(", {} failed", failed_);
  s += fmt::format(", {}", phase_);
  const int left = total_ - done_;
  if (timed_ > 0 && left > 0)
    s += fmt::format(", about {} left", duration(wall_ / timed_ * left / std::min(jobs_, left)));
  return s;
}

void StudyProgress::tick() {
  if (!show_) return;
  const auto now = Clock::now();
  if (drawn_ && last_draw_ != Clock::time_point{} &&
      now - last_draw_ < (terminal_ ? Clock::duration(terminal_interval) : plain_interval))
    return;
  last_draw_ = now;
  drawn_ = true;
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r" : "", line(), terminal_ ? "\033[K" : "\n");
  std::fflush(stderr);
}

}  // namespace firn
