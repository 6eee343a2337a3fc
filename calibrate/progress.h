// How far a study has come, on standard error: a bar on a terminal, a plain line now and then
// otherwise.
#pragma once

#include <chrono>
#include <string>

namespace firn {

class StudyProgress {
 public:
  // `total`: runs planned at most; `jobs`: runs side by side.
  StudyProgress(bool show, int total, int jobs);
  ~StudyProgress();

  void phase(const std::string& name);
  void started() { ++running_; }
  void stopped() { --running_; }  // without an outcome
  // A run ended, or was found in the journal (then `wall` is what it took in its time, s).
  void ended(double wall, bool in_journal, bool failed);
  void tick();  // draws when it is time to
  void done();  // takes the bar away

 private:
  using Clock = std::chrono::steady_clock;
  std::string line() const;

  bool show_, terminal_;
  int total_, jobs_;
  int done_ = 0, running_ = 0, failed_ = 0, timed_ = 0;
  double wall_ = 0;  // s, of all timed runs
  std::string phase_;
  bool drawn_ = false;
  Clock::time_point last_draw_{};
};

}  // namespace firn
