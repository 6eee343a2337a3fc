// Pictures of contacts: a body with its neighbors and the forces on it; forces over time.
#pragma once

#include <string>
#include <vector>

#include "experiments/inspection/contact_inspection.h"

namespace firn {

// Two views, from the front and from behind, of the chosen body, seen through its neighbors: an
// arrow at each contact point that bears, pushing on the body (normal force, length and thickness
// by force), one at each patch for friction, one for the weight. FILE.png or FILE.svg, each view
// `panel` pixels wide. Throws
// InputError for another extension or without gnuplot.
void draw_contacts(const Case& c, const ContactSelection& choice, const ContactSnapshot& now,
                   const std::string& file, int panel = 800);

// Normal force and friction over time with their work, and normal force over overlap: the area of a
// loop is what the contact has lost. As above.
void draw_history(const Case& c, const ContactSelection& choice,
                  const std::vector<HistoryRow>& rows, const std::string& file);

}  // namespace firn
