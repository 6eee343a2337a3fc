// The sub-commands of the program, except those of app/batch_commands/. Each adds itself to the
// command line; when the user calls it, its callback does the work and stores the exit status
// (exit_status.h). Errors leave as exceptions.
#pragma once

#include <CLI/CLI.hpp>

namespace firn {

void add_run_command(CLI::App& app, int& status);
void add_measure_command(CLI::App& app, int& status);
void add_shape_command(CLI::App& app, int& status);
void add_export_command(CLI::App& app, int& status);
void add_report_command(CLI::App& app, int& status);
void add_verify_command(CLI::App& app, int& status);
void add_contacts_command(CLI::App& app, int& status);
void add_compare_traces_command(CLI::App& app, int& status);
void add_materials_command(CLI::App& app, int& status);
void add_new_command(CLI::App& app, int& status);
void add_view_command(CLI::App& app, int& status);
void add_check_results_command(CLI::App& app, int& status);

}  // namespace firn
