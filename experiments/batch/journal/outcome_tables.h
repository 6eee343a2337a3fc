// The outcomes of runs in a database: the same two tables in a study's journal and in the store
// that studies share.
#pragma once

#include <optional>
#include <string>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/sqlite.h"

namespace firn {

// Columns of a table `runs` that has `key TEXT PRIMARY KEY` or `UNIQUE`, and the table of
// responses that belongs to it.
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

// The outcome of a run; nothing for a run that is unknown or has not ended.
std::optional<JobResult> read_outcome(Database& db, const std::string& key);
// What read_outcome() gives of a result that write_outcome() has written.
JobResult stored_form(JobResult result);
// Replaces the outcome of a run that is in the table. Within a transaction of the caller's.
void write_outcome(Database& db, const std::string& key, const JobResult& result);

}  // namespace firn
