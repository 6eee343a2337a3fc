// A formula in place of the simulation, behind the same interface.
#pragma once

#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>

#include "calibrate/calibrate.h"
#include "calibrate/study/study_file.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/batch/execution/executor.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {

class FakeExperiment : public Executor {
 public:
  using Values = std::map<std::string, double>;  // by case key
  // Makes the outcome of one run from its parameters and a separate stream of random numbers.
  using Formula = std::function<JobResult(const Values&, std::mt19937_64&)>;

  explicit FakeExperiment(Formula formula) : formula_(std::move(formula)) {}

  ResolvedCase resolve(const std::string&, const std::vector<Override>& overrides,
                       const MaterialRequest&) override {
    std::string text;
    for (const auto& [key, value] : overrides)
      text.append(key).append(" = ").append(value).append("\n");
    return {text, case_identity(text)};
  }

  void run(const std::vector<Job>& jobs, const JobEvents& events) override {
    for (const Job& job : jobs) {
      events.started(job);
      ++runs;
      if (on_run) on_run(job);
      Values values;
      for (const auto& [key, value] : job.overrides) values[key] = std::stod(value);
      // Every run has its own noise: of its seed and its parameters.
      std::uint64_t hash = 14695981039346656037u;
      for (const unsigned char c : job.text) hash = (hash ^ c) * 1099511628211u;
      std::mt19937_64 random(hash);
      events.ended(job, formula_(values, random));
      if (on_ended) on_ended(job);
      if (stop) return;
    }
  }

  int runs = 0;
  std::function<void(const Job&)> on_run, on_ended;
  bool stop = false;

 private:
  Formula formula_;
};

inline Response scalar(const std::string& name, double value, const std::string& unit) {
  return {name, {value}, {}, unit, "formula", 1};
}
inline JobResult finished(std::vector<Response> responses) {
  return {JobStatus::finished, "", std::move(responses), 1.0};
}

// A folder with an empty case.
class Folder : public test::ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("calibrate-" + name) {
    write("case.toml", "[case]\n");
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path() / name) << text;
    return *this / name;
  }
  // What read_study() says of this text in the file study.toml; "no complaint".
  std::string study_error(const std::string& text) const {
    try {
      read_study(write("study.toml", text));
    } catch (const InputError& e) {
      return e.what();
    }
    return "no complaint";
  }
};

using test::read_text;

// A study of two frictions, mu1 and mu2, of the fake experiment; `more` is added to it.
inline std::string friction_study(const std::string& more, const std::string& budget =
                                                               "center_replicates = 3\n"
                                                               "design_points = 8\n"
                                                               "replicates_per_point = 2\n"
                                                               "refine_rounds = 1\n"
                                                               "refine_points = 3\n"
                                                               "confirmation_replicates = 5\n") {
  return "[study]\nname = \"fake\"\ncase = \"case.toml\"\nseed = 1\n\n[budget]\n" + budget +
         "\n[[parameters]]\nname = \"mu1\"\nkeys = [\"a.mu1\"]\nmin = 0.01\nmax = 0.3\n"
         "scale = \"log\"\n\n"
         "[[parameters]]\nname = \"mu2\"\nkeys = [\"a.mu2\", \"b.mu2\"]\nmin = 0.03\nmax = 0.5\n"
         "scale = \"log\"\n\n" +
         more;
}

// A target of such a study.
inline const std::string angle_target =
    "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = \"0.5 deg\"\n";

// The angle of repose by Zhou's law for spheres as far as friction goes, deg. With the factor,
// 10 deg is inside the ranges of friction_study().
inline double zhou_angle(double mu1, double mu2) {
  return 35 * std::pow(mu1, 0.27) * std::pow(mu2, 0.22);
}
inline double zhou_angle(const FakeExperiment::Values& v) {
  return zhou_angle(v.at("a.mu1"), v.at("a.mu2"));
}

inline StudySummary run_study(const std::string& file, const std::string& directory,
                              Executor& executor) {
  StudyOptions options;
  options.study_file = file;
  options.directory = directory;
  options.show_progress = false;
  options.plot = false;
  options.replace_executor = &executor;
  return calibrate(options);
}

}  // namespace firn
