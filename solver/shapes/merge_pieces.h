// Merge of convex pieces of a solid whose union is convex, and detection of internal faces. The
// contact of a body must not depend on how its solid is divided into pieces.
#pragma once

#include <vector>

#include "firn/convex_part.h"

namespace firn {

// The faces of a convex piece without rounding.
using Piece = std::vector<HalfSpace>;

// Replaces pieces with a convex union by the union: all connected pieces if possible, else pairs
// until no pair is left. Pieces must not overlap. Planes that differ by less than a millionth of
// the size are equal. A surface face is not merged with an internal one. The union is exact; the
// choice among several possible pairs depends on the order of the pieces.
std::vector<Piece> merge_convex_pieces(std::vector<Piece> pieces);

// Marks faces as internal that other pieces cover completely, at most kMaxInternalFaces of each
// piece. `size` (m): diagonal of the whole solid. Pieces must not overlap.
void mark_internal_faces(std::vector<Piece>& pieces, double size);

}  // namespace firn
