// The sub-commands of the program that run many simulations. Each adds itself to the command line,
// as those of app/commands/commands.h do.
#pragma once

#include <CLI/CLI.hpp>

namespace firn {

void add_calibrate_command(CLI::App& app, int& status);
void add_slurm_task_command(CLI::App& app, int& status);
void add_optimize_command(CLI::App& app, int& status);
void add_sweep_command(CLI::App& app, int& status);
void add_validate_command(CLI::App& app, int& status);

}  // namespace firn
