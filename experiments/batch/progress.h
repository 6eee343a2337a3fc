// Progress of a batch of runs on standard error: a bar on a terminal, otherwise periodic lines of
// text; or one JSON object per event.
#pragma once

#include <chrono>
#include <string>

#include "experiments/batch/batch_progress_record.h"
#include "experiments/batch/journal/journal.h"
#include "experiments/system/terminal.h"

namespace firn {

enum class ProgressStyle { none, text, json };

class BatchProgress {
 public:
  // `name`: prefix of lines of text. `total`: largest number of runs. `jobs`: concurrent runs, 0:
  // unknown. `journal`: stores the total and the latest estimate for readers of the folder; null:
  // none.
  BatchProgress(ProgressStyle style, std::string name, int total, int jobs,
                Journal* journal = nullptr);
  ~BatchProgress();

  void phase(const std::string& name);
  void started(const PlannedRun& run);
  void stopped(const PlannedRun& run, const JobResult& why);  // without an outcome
  void ended(const PlannedRun& run, const JobResult& result);
  void found(const PlannedRun& run, const JobResult& result);  // in the journal or the store
  void note(const PlannedRun& run, const std::string& line);   // a message about its files
  // Reports what is known from the runs so far; `text`: the same in a few lines. To be called after
  // each fit.
  void knowledge(const std::string& text, const BatchKnowledge& knowledge);
  void tick();  // redraws at intervals
  void done();  // removes the bar

 private:
  using Clock = std::chrono::steady_clock;
  void count(const JobResult& result);
  double time_left() const;  // s; NaN: not known
  std::string line() const;
  void draw(bool now);
  void write_event(const char* event, const PlannedRun* run, const JobResult* result,
                   const std::string& note = {}) const;

  void record(const std::optional<BatchKnowledge>& knowledge);

  ProgressStyle style_;
  Journal* journal_;
  bool terminal_;
  std::string name_;
  int total_, jobs_;
  int done_ = 0, running_ = 0, failed_ = 0, cut_short_ = 0, timed_ = 0;
  double wall_ = 0;  // s, of all timed runs
  std::string phase_, knowledge_;
  TerminalLines lines_;
  bool drawn_ = false;
  Clock::time_point last_draw_{};
};

}  // namespace firn
