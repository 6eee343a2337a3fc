// Options that commands share which carry out many runs: calibrate, validate, sweep,
// optimize.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "experiments/batch/batch_folder.h"

namespace firn {

struct BatchArguments {
  std::string directory, executor = "local", store, progress = "text";
  int jobs = 0;
  bool no_store = false, resume = false, json = false;

  // The file of outcomes. Default: store.db in the parent of the folder, which is runs/<name> by
  // default. Empty: none.
  std::string store_file() const;
};

// Sets the options of a batch, which Ctrl-C interrupts.
void apply(const BatchArguments& arguments, BatchOptions& options);
// Reports an interrupted batch on standard error. Returns the exit status.
int report_interruption(const std::string& directory);

// `what`: "study", "validation", "sweep".
void add_batch_options(CLI::App& command, BatchArguments& arguments, const std::string& what);

}  // namespace firn
