// Bounds that a user puts on responses with --require.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/response.h"

namespace firn {

struct Requirement {
  enum class Relation { at_most, at_least, below, above };
  std::string text;      // as the user wrote it
  std::string response;  // its name
  Relation relation = Relation::at_most;
  double bound = 0;  // in the response's own unit
};

inline constexpr const char* requirement_help =
    "Leave with status 3 when the response misses this bound:\n"
    "<=, >=, < or > and a number in its own unit (may be repeated)";

// Parses "NAME<=VALUE" (or >=, <, >). Throws InputError.
Requirement parse_requirement(const std::string& text);

struct RequirementResult {
  Requirement requirement;
  bool met = false;  // every value of the response keeps the bound; an undefined one does not
};

// Throws InputError naming the responses there are when one is not among them.
std::vector<RequirementResult> check_requirements(const std::vector<Requirement>& requirements,
                                                  const std::vector<Response>& responses);
bool all_met(const std::vector<RequirementResult>& verdicts);

}  // namespace firn
