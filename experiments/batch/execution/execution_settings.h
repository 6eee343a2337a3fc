// Table [execution] of a study file: how runs are executed. No effect on results. Keys:
// docs/calibration.md.
#pragma once

#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"

namespace firn {

class TomlTable;

struct SlurmSettings {
  std::string partition, account;    // empty: default of the cluster
  std::vector<std::string> options;  // additional options of sbatch
  double poll = 10;                  // s between two queries of the queue
};

struct Execution {
  RunLimits limits;
  SlurmSettings slurm;
};

// Throws InputError with file, line and key.
Execution read_execution(const TomlTable& study);

// `count` (not below 0) seeds from `first` on.
std::vector<std::uint64_t> seed_list(std::uint64_t first, int count);

// "2 GiB" in bytes; kB, MB, GB, TB and KiB, MiB, GiB, TiB. Throws InputError (one sentence).
double parse_memory(const std::string& text);

std::string memory_text(double bytes);  // "2 GiB"
std::string time_text(double seconds);  // "10 min"

// The part of the text of a study that determines its runs: TOML without [execution], comments and
// layout. Throws InputError for text that is not TOML.
std::string study_identity(const std::string& text, const std::string& source);

}  // namespace firn
