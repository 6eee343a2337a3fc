// Outcomes of runs in a database: two tables, equal in the journal of a study and in the run cache.
#pragma once

#include <optional>
#include <string>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/tables_file.h"

namespace firn {

// Columns of a table `runs` with a unique column `key`, and the table of its responses.
inline constexpr const char* outcome_columns =
    "status TEXT NOT NULL CHECK (status IN ('planned', 'running', 'finished', 'arched', "
    "'failed', 'crashed', 'timed out', 'out of memory')), "
    "reason TEXT NOT NULL DEFAULT '', "
    "wall REAL NOT NULL DEFAULT 0, simulated REAL NOT NULL DEFAULT 0, "  // s
    "cut_at REAL NOT NULL DEFAULT 0, "   // the limit that stopped it: s or bytes
    "results TEXT NOT NULL DEFAULT ''";  // its results file
inline constexpr const char* responses_table =
    "CREATE TABLE responses (run TEXT NOT NULL REFERENCES runs (key), "
    "name TEXT NOT NULL, part INTEGER NOT NULL, "  // index into one with several values
    "value REAL, uncertainty REAL, "               // NULL: not a number; not known
    "unit TEXT NOT NULL, method TEXT NOT NULL, method_version INTEGER NOT NULL, "
    "PRIMARY KEY (run, name, part)) WITHOUT ROWID;";

// The outcome of a run. Nothing for a run that is unknown or has not ended.
std::optional<JobResult> read_outcome(Database& db, const std::string& key);
// The result that read_outcome() returns after write_outcome() of `result`.
JobResult stored_form(JobResult result);
// Replaces the outcome of a run in the table. The caller must have begun a transaction.
void write_outcome(Database& db, const std::string& key, const JobResult& result);

}  // namespace firn
