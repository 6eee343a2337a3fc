// A run of a user program: arguments, input files and the file of its responses. Plain data and its
// JSON text, from which the key of the run is computed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/results/response.h"

namespace firn {

struct ProgramRun {
  std::vector<std::string> arguments;  // program first; no shell is used
  std::string input_name, input_text;  // name and text of the filled template; empty: none
  std::map<std::string, std::string>
      inputs;             // name in the folder of the run -> SHA-256 of the content
  std::string responses;  // file that the program writes: .json or .csv
  std::map<std::string, std::string> values;  // placeholder -> text, with the seed
};

// Identity of the program in the keys of such runs: the version of Firn does not affect their
// results.
inline constexpr const char* user_program_identity = "user program";

std::string program_run_text(ProgramRun run);
// Inverse of program_run_text(). Throws InputError for any other text.
ProgramRun parse_program_run(const std::string& text);

// Responses of a finished program. JSON: {"NAME": NUMBER, ...}, or in place of the number
// {"value": NUMBER, "unit": "deg", "uncertainty": NUMBER}; null stands for an undefined value.
// CSV: columns `response`, `value` and perhaps `unit`. Throws InputError.
std::vector<Response> read_program_responses(const std::string& file);

}  // namespace firn
