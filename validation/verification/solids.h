// Families of concave solids with random dimensions, for checks of convex decomposition.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "solver/mesh.h"

namespace firn::verification {

// Names of all families: ice of several machines, parts of machines and plain test bodies.
const std::vector<std::string>& solid_families();

// A closed mesh of a member, m. Member 0 of a family has fixed dimensions, all others have
// random ones that depend on family and member alone. Sizes are about 20 to 60 mm.
TriangleMesh solid(const std::string& family, std::uint64_t member);

}  // namespace firn::verification
