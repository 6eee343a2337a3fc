// What the program prints of a run: tables for people, JSON for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/support/requirement.h"
#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "firn/solver.h"

namespace firn {

using Json = nlohmann::ordered_json;

// Name, value +- one standard deviation, unit and method, one response a line.
std::string responses_table(const std::vector<Response>& responses);
// The table of a run's responses in display order. Below a table longer than a screen, a line "Main
// results:" and the rows of main_responses() again.
std::string run_responses_table(const std::vector<Response>& responses, const Case& c);
// name -> { value, uncertainty, unit, method, method_version }; a scalar's value is a number, any
// other response's an array; an unknown uncertainty and an undefined value are null.
Json responses_json(const std::vector<Response>& responses);

// One line a verdict.
std::string verdicts_table(const std::vector<RequirementResult>& verdicts);
Json verdicts_json(const std::vector<RequirementResult>& verdicts);

// Wall time by phase of the step, in order of appearance.
std::string profile_table(const std::vector<PhaseTime>& profile);
Json profile_json(const std::vector<PhaseTime>& profile);

Json energy_json(const Energy& energy);

// Lengths and a volume for people, in units that inputs accept as well.
std::string mm_text(const Vec3& size);   // "61.0 x 20.6 x 13.7 mm"
std::string volume_text(double volume);  // m^3; "14.9451 cm^3"

// Prints to standard output; the only JSON document there.
void print_json(const Json& document);

}  // namespace firn
