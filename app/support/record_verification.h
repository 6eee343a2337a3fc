// Verification of records: hashes, raw data, and repeated simulations.
#pragma once

#include <string>
#include <vector>

#include "experiments/material_records/material_database.h"

namespace firn {

// not_checked: a file is missing, or the scatter is unknown.
enum class CheckOutcome { passed, failed, not_checked };

struct RecordCheck {
  std::string record, what;
  CheckOutcome outcome = CheckOutcome::passed;
  std::string detail;
};

// Of every version of a name: content against hash, hash against the next version's. Of the record
// that is asked for (the newest unless a version is given): raw data against their hashes.
std::vector<RecordCheck> verify_records(const MaterialDatabase& database,
                                        const MaterialChoice& choice);

struct RecordReplayOptions {
  int threads = 1;
  int runs = 0;  // at most, of each reference set in each experiment; 0: all
};

// Simulates the reference sets of a record again with the recorded seeds. With the same program
// (equal program_identity()), responses are the same bits; with another one, the mean of each is
// that of the recorded runs within their scatter (two-sided, 99 %). Throws RunError when a
// simulation fails.
std::vector<RecordCheck> replay_record(const StoredRecord& stored,
                                       const RecordReplayOptions& options);

}  // namespace firn
