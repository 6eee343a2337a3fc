// Reads a case from TOML text: tables, defaults, material records and checks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_aliases.h"

namespace firn {

// Reads, checks and completes a case. Throws InputError with one line
// `FILE:LINE: KEY: what is wrong; what is expected`.
Case read_case(const std::string& file, const std::vector<Override>& overrides = {},
               const MaterialRequest& materials = {});
// The same from text. `source`: name in messages. `directory`: base of relative paths.
Case read_case_text(const std::string& text, const std::string& source,
                    const std::string& directory, const std::vector<Override>& overrides = {},
                    const MaterialRequest& materials = {}, OldNames old_names = OldNames::warn);

// Parses "KEY=VALUE" of --set. Throws InputError.
Override parse_override(const std::string& text);

// Number of time steps nearest to the time `seconds` (s). 0 for a negative time.
std::uint64_t to_steps(const Case& c, double seconds);

// The text from which the hash of a case and the keys of its runs are computed: a resolved case
// with the first name of each renamed key. A rename does not change it.
std::string case_identity(const std::string& resolved);

// SHA-256 of the identity as hexadecimal digits: equal for equal cases, seed and mesh files
// included.
std::string case_hash(const Case& c);

}  // namespace firn
