#include "app/support/record_verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/run.h"
#include "experiments/storage/sha256.h"
#include "experiments/storage/version.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/temporary_folder.h"
#include "experiments/system/terminal.h"
#include "experiments/text/response_aliases.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

RecordCheck check_file(const std::string& record, const RawData& data) {
  RecordCheck check{record, fmt::format("{} {}", data.what, data.file), CheckOutcome::passed, ""};
  std::error_code error;
  const std::string file =
      fs::is_regular_file(data.file, error) ? data.file : moved_file(data.file);
  if (file.empty()) {
    check.outcome = CheckOutcome::not_checked;
    check.detail = "is not here";
  } else if (sha256(read_input_file(file, "raw data", input_limits::raw_data_bytes)) !=
             data.sha256) {
    check.outcome = CheckOutcome::failed;
    check.detail = "is another file now: its hash differs";
  }
  return check;
}

std::vector<Override> overrides_of(const MaterialRecord& r, const ReferenceSet& reference,
                                   const SimulatedCase& simulated, std::uint64_t seed) {
  std::vector<Override> overrides = {{"case.seed", std::to_string(seed)}};
  for (std::size_t i = 0; i < reference.values.size(); ++i) {
    const MaterialParameter& p = r.parameters[r.index(r.ensemble->axes[i].parameter)];
    if (std::ranges::find(simulated.parameters, p.name) == simulated.parameters.end()) continue;
    for (const std::string& key : p.keys)
      overrides.emplace_back(key, toml_value(reference.values[i], p.unit));
  }
  return overrides;
}

// One response over the runs of a reference set.
struct Replayed {
  std::vector<double> recorded;  // of the runs that were repeated
  std::vector<double> all;       // of every recorded run
  std::vector<double> now;
};

void judge(const Replayed& r, bool same_program, RecordCheck& check) {
  if (r.now == r.recorded) {
    check.detail = fmt::format("the same bits in {} runs", r.now.size());
    return;
  }
  if (r.now.size() != r.recorded.size()) {
    check.outcome = CheckOutcome::failed;
    check.detail = fmt::format("{} of {} runs still give it", r.now.size(), r.recorded.size());
    return;
  }
  check.detail = fmt::format("recorded {:.6g}, now {:.6g} (mean of {} runs)", mean(r.recorded),
                             mean(r.now), r.now.size());
  if (same_program) {
    check.outcome = CheckOutcome::failed;
    check.detail += "; expected the same bits of the same program";
  } else if (r.all.size() < 2) {
    check.outcome = CheckOutcome::not_checked;
    check.detail += "; one recorded run has no scatter to judge by";
  } else {
    // Chaos makes of another program's run another member of the same population.
    const double bound =
        student_factor(static_cast<double>(r.all.size() - 1), 0.99) * standard_deviation(r.all) *
        std::sqrt(1 / static_cast<double>(r.now.size()) + 1 / static_cast<double>(r.all.size()));
    if (!(std::abs(mean(r.now) - mean(r.all)) <= bound)) check.outcome = CheckOutcome::failed;
    check.detail += fmt::format("; the recorded scatter allows {:.2g}", bound);
  }
}

std::vector<Response> simulate(const MaterialRecord& r, const ReferenceSet& reference,
                               const SimulatedCase& simulated, std::uint64_t seed, int threads) {
  const TemporaryFolder scratch("replay");
  const Case c = read_case_text(simulated.text, r.reference() + ": case", ".",
                                overrides_of(r, reference, simulated, seed), {}, OldNames::accept);
  RunOptions options;
  options.results_file = scratch.file("run.h5");
  options.threads = threads;
  print_lines(stderr, "simulating {} #{}{}{} with seed {}\n", r.reference(), reference.name,
              simulated.experiment.empty() ? "" : ", ", simulated.experiment, seed);
  const RunSummary summary = run(c, options);
  if (summary.status != RunStatus::finished)
    throw RunError(
        fmt::format("the replay of {} with seed {}: {}", r.reference(), seed, summary.reason));
  return summary.responses;
}

// By response, behind the name of its experiment where it has one.
std::map<std::string, Replayed> replay(const MaterialRecord& r, const ReferenceSet& reference,
                                       const SimulatedCase& simulated,
                                       const RecordReplayOptions& options) {
  std::map<std::string, Replayed> all;
  int repeated = 0;
  for (const ReferenceRun& recorded : reference.runs) {
    if (recorded.experiment != simulated.experiment) continue;
    const auto entry = [&](const std::string& name) -> Replayed& {
      return all[simulated.experiment.empty() ? name : simulated.experiment + ": " + name];
    };
    for (const MaterialResponse& response : recorded.responses)
      entry(response.name).all.push_back(response.value);
    if (options.runs > 0 && repeated == options.runs) continue;
    ++repeated;
    const auto now = simulate(r, reference, simulated, recorded.seed, options.threads);
    for (const MaterialResponse& response : recorded.responses) {
      entry(response.name).recorded.push_back(response.value);
      const auto again =
          std::ranges::find(now, current_response_name(response.name), &Response::name);
      if (again != now.end() && again->value.size() == 1)
        entry(response.name).now.push_back(again->value[0]);
    }
  }
  return all;
}

}  // namespace

std::vector<RecordCheck> verify_records(const MaterialDatabase& database,
                                        const MaterialChoice& choice) {
  const std::vector<std::string> names = database.names();
  if (std::ranges::find(names, choice.name) == names.end())
    database.find(choice.name);  // throws with the nearest name
  std::vector<RecordCheck> checks;
  const std::vector<std::string> faults = database.integrity_errors(choice.name);
  for (const std::string& fault : faults)
    checks.push_back({choice.name, "content", CheckOutcome::failed, fault});
  if (!faults.empty()) return checks;
  checks.push_back({choice.name, "content", CheckOutcome::passed, "every version has its hash"});
  const StoredRecord stored = database.find(choice.name, choice.version);
  for (const RawData& data : stored.record.provenance.raw_data)
    checks.push_back(check_file(stored.record.reference(), data));
  return checks;
}

std::vector<RecordCheck> replay_record(const StoredRecord& stored,
                                       const RecordReplayOptions& options) {
  const MaterialRecord& r = stored.record;
  if (!r.ensemble || r.provenance.cases.empty())
    return {{r.reference(), "replay", CheckOutcome::not_checked, "rests on no simulation"}};
  const bool same_program = r.provenance.program == program_identity();
  std::vector<RecordCheck> checks;
  for (const ReferenceSet& reference : r.ensemble->reference_sets) {
    for (const SimulatedCase& simulated : r.provenance.cases) {
      for (const auto& [response, replayed] : replay(r, reference, simulated, options)) {
        RecordCheck check{r.reference(), fmt::format("replay of #{}: {}", reference.name, response),
                          CheckOutcome::passed, ""};
        judge(replayed, same_program, check);
        checks.push_back(check);
      }
    }
  }
  return checks;
}

}  // namespace firn
