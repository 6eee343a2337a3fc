// Executes the runs of a study: takes finished runs from the journal, executes the others and reads
// their responses.
#pragma once

#include <Eigen/Dense>
#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibrate/study/study_file.h"
#include "experiments/batch/batch.h"

namespace firn {

// One set of parameters and its runs, one per experiment and seed.
struct Point {
  std::string phase;
  int number = 0;              // within the phase
  std::vector<double> values;  // in order of Study::parameters
  Eigen::VectorXd u;           // the same in the unit cube
  std::vector<std::uint64_t> seeds;
  std::vector<Override> set;                    // case keys of this point, for all experiments
  std::optional<std::size_t> only;              // experiment; without it, all
  std::vector<std::vector<JobResult>> results;  // [experiment][seed]
  std::vector<std::vector<std::string>> keys;   // of the runs, [experiment][seed]
  // Outliers (outliers.h): by label of a response, indices of seeds that give no value of it.
  std::map<std::string, std::set<std::size_t>> outliers = {};
  std::vector<bool> low_fidelity = {};  // [experiment], whether simulated so; empty: none

  bool is_low_fidelity(std::size_t experiment) const {
    return experiment < low_fidelity.size() && low_fidelity[experiment];
  }

  // Of the run with this index of its seed; nothing when it is no number.
  std::optional<double> value(const ResponseId& response, std::size_t seed) const;
  // Values of a response over the finished runs; runs in which it is not a number are left out.
  // Nothing when a limit cut one of the runs short: the finished runs are the fast ones, which may
  // have different responses.
  std::vector<double> finished(const ResponseId& response) const;
  // Its unit; empty when no run has it.
  std::string unit(const ResponseId& response) const;
  // Runs that ended so, of one experiment or of all.
  int count(JobStatus status, std::size_t experiment) const;
  int count(JobStatus status) const;
  double wall() const;  // s, of all its runs
};

// Mean and spread over seeds.
struct Sample {
  int count = 0;
  double mean = 0;
  double sum_of_squares = 0;  // about the mean
  double sd() const;          // NaN below two
};
Sample sample(const std::vector<double>& values);

// What a run sets over the experiment's case file: its seed, the experiment's own keys, those of
// the point, and the parameters that the experiment takes. Later ones win.
std::vector<Override> overrides_of(const Study& study, const Experiment& experiment,
                                   const std::vector<double>& values, std::uint64_t seed,
                                   const std::vector<Override>& of_the_point = {});

// Values of the placeholders of a program in a run, with the same order of precedence.
std::map<std::string, std::string> placeholders_of(const Study& study, const Experiment& experiment,
                                                   const std::vector<double>& values,
                                                   std::uint64_t seed,
                                                   const std::vector<Override>& of_the_point);

class StudyRuns {
 public:
  // `store`: outcomes of other studies are found there, and these go there; null: none.
  StudyRuns(const Study& study, Executor& executor, Journal& journal, RunCache* store,
            BatchProgress& progress, std::string folder, const std::atomic<bool>* interrupt);

  Point point(const std::string& phase, int number, const std::vector<double>& values,
              const std::vector<std::uint64_t>& seeds) const;
  // The same point in the study's low fidelity. Its phase begins with low_fidelity_phase.
  Point in_low_fidelity(Point point) const;
  static constexpr const char* low_fidelity_phase = "low fidelity: ";
  // Points within the ranges that other studies of the same case have run, according to the store,
  // with the seeds whose runs have ended in all experiments; of at most so many runs together. They
  // are chosen when the folder of the study is new, and read from its journal afterwards. Their
  // phase is `reused_phase`.
  std::vector<Point> reusable(int most_runs);
  static constexpr const char* reused_phase = "reused";
  // Fills in the results. Throws BatchInterrupted, and InputError when the case does not take the
  // parameters or does not have the responses.
  void run(std::vector<Point>& points);
  // Of the program that simulates; where all experiments are programs of the user, their identity.
  const std::string& program() const { return program_; }
  // Whether the study asked for this run in this session. A journal may hold others: by another
  // program, or of points chosen when other runs were cut short.
  bool was_requested(const std::string& key) const { return requested_.contains(key); }

 private:
  BatchRun batch_run(const Point& point, std::size_t experiment, std::uint64_t seed) const;
  // Of an experiment with a case. Throws InputError with the place in the study where the case does
  // not take what the study sets.
  BatchRun case_run(const Experiment& experiment, const Point& point, std::uint64_t seed,
                    const std::vector<Override>& set, const RunLabel& label) const;
  std::string describe(const Point& point) const;
  void check_responses(std::size_t experiment, const JobResult& result) const;

  std::optional<std::vector<double>> values_of(const std::string& parameters) const;

  const Study& study_;
  Journal& journal_;
  RunCache* store_;
  Batch batch_;
  std::string program_;
  std::string folder_;
  std::set<std::string> requested_;  // keys
};

}  // namespace firn
