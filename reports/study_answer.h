// What a study found, in five lines.
#pragma once

#include <string>

namespace firn {

// From the JSON of a study (StudySummary::json) and the file of its page (empty: there is none):
// recommended values, what is determined, what the compare sets give, what to measure next, where
// the report is. Five lines, each ends in a new line; fewer when the study has no answer.
std::string study_conclusion(const std::string& json, const std::string& page);

}  // namespace firn
