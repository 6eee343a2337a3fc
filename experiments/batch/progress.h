// How far a batch of runs has come, on standard error: for people a bar on a terminal and a plain
// line now and then otherwise; for programs one JSON object a line for every event.
#pragma once

#include <chrono>
#include <string>

#include "experiments/batch/journal/journal.h"

namespace firn {

enum class ProgressStyle { none, text, json };

class BatchProgress {
 public:
  // `name`: what plain lines begin with; `total`: runs planned at most; `jobs`: runs side by side,
  // 0: unknown.
  // `journal`: it keeps the total and the knowledge for readers of the folder; null: none.
  BatchProgress(ProgressStyle style, std::string name, int total, int jobs,
                Journal* journal = nullptr);
  ~BatchProgress();

  void phase(const std::string& name);
  void started(const PlannedRun& run);
  void stopped(const PlannedRun& run, const JobResult& why);  // without an outcome
  void ended(const PlannedRun& run, const JobResult& result);
  void found(const PlannedRun& run, const JobResult& result);  // in the journal or the store
  void note(const PlannedRun& run, const std::string& line);   // about its files
  // What the runs so far say: the best region and the valley. One or a few lines for people, a JSON
  // object for programs. Call it after each fit.
  void knowledge(const std::string& text, const std::string& json);
  void tick();  // draws when it is time to
  void done();  // takes the bar away

 private:
  using Clock = std::chrono::steady_clock;
  void count(const JobResult& result);
  double time_left() const;  // s; NaN: not known
  std::string line() const;
  void draw(bool now);
  void erase();
  void write_event(const char* event, const PlannedRun* run, const JobResult* result,
                   const std::string& note = {}) const;

  void record(const std::string& knowledge);

  ProgressStyle style_;
  Journal* journal_;
  bool terminal_;
  std::string name_;
  int total_, jobs_;
  int done_ = 0, running_ = 0, failed_ = 0, cut_short_ = 0, timed_ = 0;
  double wall_ = 0;  // s, of all timed runs
  std::string phase_, knowledge_;
  int lines_drawn_ = 0;  // on the terminal
  bool drawn_ = false;
  Clock::time_point last_draw_{};
};

}  // namespace firn
