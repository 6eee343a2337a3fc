// Sub-commands, options and values of options that exist, and messages about words that do not.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// The end of a message about an unknown word: `did you mean "sweep"?`, or without a similar word
// `expected one of run, sweep`. Hyphens separate parts of a word.
std::string expected_word(std::string_view word, const std::vector<std::string>& known);

// Validator of an option that takes one of these values. Its help is "{local,slurm}".
CLI::Validator one_of(std::vector<std::string> values);

// Message about the first argument that is no sub-command or long option of a command that has
// failed to parse its arguments, nor of the sub-command that was chosen; empty: there is none.
std::string unknown_argument(const CLI::App& command);

}  // namespace firn
