// Convex pieces of one solid: pieces that form a larger convex solid are merged, and faces that
// other pieces cover are marked. The contact of a body must not depend on how its solid was cut.
#pragma once

#include <vector>

#include "firn/convex_part.h"

namespace firn {

// The faces of a convex piece, not eroded by a rounding.
using Piece = std::vector<HalfSpace>;

// Replaces pieces whose union is convex by that union: all that are connected if possible, else
// pairs until no pair is left. Pieces must not overlap. Planes that differ by less than a millionth
// of the size count as one. A surface face is not merged with an internal one. The union is exact;
// which of several possible pairs are merged depends on the order of the pieces.
std::vector<Piece> merge_convex_pieces(std::vector<Piece> pieces);

// Marks as internal the faces that lie wholly inside or against other pieces, at most kMaxSeams of
// each piece. `size` (m): diagonal of the whole solid. Pieces must not overlap.
void mark_internal_faces(std::vector<Piece>& pieces, double size);

}  // namespace firn
