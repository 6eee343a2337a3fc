// What the program prints of contacts: for people and as JSON.
#pragma once

#include <string>
#include <vector>

#include "app/output/response_output.h"
#include "experiments/inspection/contact_inspection.h"

namespace firn {

// Contacts of one body or pair, point by point, with the balance of forces.
std::string audit_text(const Case& c, const ContactSelection& choice, const ContactSnapshot& now);
// A whole instant.
std::string summary_text(const Case& c, const ContactSnapshot& now);
// Over time.
std::string history_text(const std::vector<HistoryRow>& rows);
std::string events_text(const Case& c, const std::vector<PatchEvent>& events);

Json audit_json(const Case& c, const ContactSelection& choice, const ContactSnapshot& now);
Json summary_json(const Case& c, const ContactSnapshot& now);
Json history_json(const Case& c, const std::vector<HistoryRow>& rows,
                  const std::vector<PatchEvent>& events);

}  // namespace firn
