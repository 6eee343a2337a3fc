// A simulator of the user as an experiment of a study: `program` of [[experiments]].
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/batch/execution/program_run.h"
#include "experiments/case/case.h"

namespace firn {

class TomlTable;

struct ProgramInput {
  std::string name;  // in the folder of each run
  std::string file;  // path
  std::string hash;  // SHA-256 of its content when the study was read
};

struct UserProgram {
  std::vector<std::string> arguments;  // with placeholders
  std::string template_name, template_text;
  std::vector<ProgramInput> inputs;
  std::string responses;  // file that each run writes
};

// Whether a study may start programs. The user allows it on the command line; a study file cannot.
enum class Programs { refused, allowed };

// From an [[experiments]] table with a key `program`. Paths are relative to the study's folder.
// Throws InputError, for every study with such a table where programs are refused.
UserProgram read_user_program(const TomlTable& table, const std::string& study_file,
                              Programs programs);

// Throws InputError unless the placeholders of the program are these names and `seed`, and each
// name has a placeholder.
void require_placeholders(const TomlTable& table, const UserProgram& program,
                          const std::vector<std::string>& names);

// `values`: placeholder -> text.
ProgramRun program_run(const UserProgram& program,
                       const std::map<std::string, std::string>& values);

// A TOML value as a placeholder's text: strings without their quotes.
std::string placeholder_text(const std::string& toml_value);

// Copies the inputs into the folder of the runs, by content. Throws InputError for one that has
// changed since the study was read.
void keep_inputs(const UserProgram& program, const std::string& runs_folder);

}  // namespace firn
