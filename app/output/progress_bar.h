// Shows how a run gets on: a bar on a terminal, a plain line now and then elsewhere.
#pragma once

#include "experiments/run/run.h"
#include "experiments/system/terminal.h"

namespace firn {

class ProgressMeter {
 public:
  // timestep: s, for the number of steps per second.
  explicit ProgressMeter(double timestep);
  void show(const Progress& progress);
  void finish() { bar_.erase(); }  // leaves the terminal's line clean

 private:
  // Simulated seconds per wall second, smoothed over the last while.
  void update_rate(const Progress& progress);
  void draw_bar(const Progress& progress);
  void log_line(const Progress& progress) const;

  double timestep_;
  bool terminal_;
  TerminalLines bar_;
  bool first_ = true;
  double last_time_ = 0;  // s, simulated
  double last_wall_ = 0;  // s
  double last_line_ = 0;  // s, wall time of the last plain line
  double rate_ = 0;
};

}  // namespace firn
