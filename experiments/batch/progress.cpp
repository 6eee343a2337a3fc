#include "experiments/batch/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "experiments/batch/batch_state.h"
#include "experiments/batch/execution/execution_settings.h"
#include "experiments/text/units.h"
#include "experiments/text/vector_json.h"

namespace firn {
namespace {

constexpr int bar_width = 24;
constexpr auto terminal_interval = std::chrono::milliseconds(200);
constexpr auto plain_interval = std::chrono::seconds(30);

}  // namespace

BatchProgress::BatchProgress(ProgressStyle style, std::string name, int total, int jobs,
                             Journal* journal)
    : style_(style),
      journal_(journal),
      terminal_(isatty(STDERR_FILENO) != 0),
      name_(std::move(name)),
      total_(total),
      jobs_(jobs) {
  record({});
}

BatchProgress::~BatchProgress() { done(); }

void BatchProgress::done() {
  lines_.erase();
  drawn_ = false;
}

void BatchProgress::phase(const std::string& name) {
  phase_ = name;
  write_event("phase", nullptr, nullptr);
  draw(true);
}

void BatchProgress::started(const PlannedRun& run) {
  ++running_;
  write_event("started", &run, nullptr);
}

void BatchProgress::stopped(const PlannedRun& run, const JobResult& why) {
  --running_;
  write_event("stopped", &run, &why);
}

void BatchProgress::ended(const PlannedRun& run, const JobResult& result) {
  --running_;
  count(result);
  write_event("ended", &run, &result);
  draw(false);
}

void BatchProgress::found(const PlannedRun& run, const JobResult& result) {
  count(result);
  write_event("found", &run, &result);
  draw(false);
}

void BatchProgress::note(const PlannedRun& run, const std::string& line) {
  lines_.erase();
  if (style_ != ProgressStyle::json) print_lines(stderr, "firn: {}\n", line);
  write_event("note", &run, nullptr, line);
}

void BatchProgress::count(const JobResult& result) {
  ++done_;
  failed_ += result.status == JobStatus::failed || result.status == JobStatus::crashed;
  cut_short_ += cut_short(result.status);
  if (result.wall <= 0) return;
  ++timed_;
  wall_ += result.wall;
}

void BatchProgress::record(const std::optional<BatchKnowledge>& knowledge) {
  if (journal_ != nullptr)
    journal_->record_progress(json_text(BatchProgressRecord{name_, total_, jobs_, knowledge}, -1));
}

void BatchProgress::knowledge(const std::string& text, const BatchKnowledge& knowledge) {
  knowledge_ = text;
  record(knowledge);
  if (style_ == ProgressStyle::text && !terminal_) print_lines(stderr, "{}\n", text);
  if (style_ == ProgressStyle::json)
    print_lines(stderr, "{{\"event\":\"knowledge\",\"knowledge\":{}}}\n", json_text(knowledge, -1));
  if (terminal_) draw(true);
}

double BatchProgress::time_left() const {
  if (timed_ == 0) return std::numeric_limits<double>::quiet_NaN();
  return firn::time_left(wall_ / timed_, total_ - done_, std::max(jobs_, running_));
}

std::string BatchProgress::line() const {
  const double share = total_ > 0 ? static_cast<double>(done_) / total_ : 1;
  std::string s = terminal_ ? progress_bar(share, bar_width) + " " : name_ + ": ";
  s += fmt::format("{} of at most {} runs", done_, total_);
  if (running_ > 0) s += fmt::format(", {} under way", running_);
  if (failed_ > 0) s += fmt::format(", {} failed", failed_);
  if (cut_short_ > 0) s += fmt::format(", {} cut short", cut_short_);
  if (const double left = time_left(); std::isfinite(left))
    s += fmt::format(", about {} left", estimated_duration_text(left));
  return s + fmt::format(", {}", phase_);
}

void BatchProgress::tick() { draw(false); }

void BatchProgress::draw(bool now) {
  if (style_ != ProgressStyle::text) return;
  const auto time = Clock::now();
  const auto interval = terminal_ ? Clock::duration(terminal_interval) : plain_interval;
  if (!now && drawn_ && time - last_draw_ < interval) return;
  last_draw_ = time;
  drawn_ = true;
  if (terminal_)
    lines_.draw(line() + '\n' + knowledge_);
  else
    print_lines(stderr, "{}\n", line());
}

void BatchProgress::write_event(const char* event, const PlannedRun* run, const JobResult* result,
                                const std::string& note) const {
  if (style_ != ProgressStyle::json) return;
  nlohmann::ordered_json j = {{"event", event}, {"phase", phase_}};
  if (run != nullptr)
    j["run"] = {{"key", run->key},
                {"purpose", run->label.phase},
                {"point", run->label.point},
                {"parameters", run->label.parameters},
                {"seed", run->label.seed}};
  if (result != nullptr) {
    j["status"] = to_string(result->status);
    if (!result->reason.empty()) j["reason"] = result->reason;
    j["wall"] = result->wall;
    for (const Response& r : result->responses)
      if (r.value.size() == 1) j["responses"][r.name] = {{"value", r.value[0]}, {"unit", r.unit}};
  }
  if (!note.empty()) j["note"] = note;
  j["done"] = done_;
  j["left_at_most"] = std::max(0, total_ - done_);
  j["under_way"] = running_;
  j["seconds_left"] = number_json(time_left());
  print_lines(stderr, "{}\n",
              j.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace firn
