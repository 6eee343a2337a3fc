// The object of a [[measure]]: a boundary contact, a coupling, a boundary or a motion frame.
#pragma once

#include <string>

#include "experiments/case/case.h"

namespace firn {

// Name of the object.
inline std::string measured_part(const Case& c, const Measure& m) {
  if (m.contact >= 0) return c.model.boundary_contacts[static_cast<std::size_t>(m.contact)].name;
  if (m.coupling >= 0) return c.model.couplings[static_cast<std::size_t>(m.coupling)].name;
  return m.boundary.empty() ? c.model.frames[static_cast<std::size_t>(m.frame)].name : m.boundary;
}

// Path of its group in the results file, with a slash at the end.
inline std::string part_group(const Case& c, const Measure& m) {
  const char* group = m.contact >= 0       ? "/boundary_contacts/"
                      : m.coupling >= 0    ? "/couplings/"
                      : m.boundary.empty() ? "/motion_frames/"
                                           : "/boundaries/";
  return group + measured_part(c, m) + "/";
}

}  // namespace firn
