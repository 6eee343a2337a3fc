// Greedy search for the cuts that divide a solid into nearly convex pieces, and merge of pieces.
#pragma once

#include <vector>

#include "solver/shapes/cut_piece.h"
#include "solver/shapes/cut_trials.h"

namespace firn {

// How a search chooses among the planes that it tries.
struct CutRule {
  // Cost of a side that is not convex enough: its surplus, the cube root of that, the product of
  // surplus and deviation, or the deviation.
  enum class Cost { surplus, surplus_root, surplus_deviation, deviation } cost;
  bool middle_only;  // see candidate_planes()
  // The cost of a side grows by this times the least allowed thickness over that of the side.
  double thin_weight = 0;
  int max_backtracks = 0;  // cuts that may be undone
};

// Cuts the piece of largest deviation, until all are convex enough, no cut helps or
// `options.max_parts` is reached. A piece that no cut helps becomes final. If the rule allows it,
// the cut that made the piece is undone instead, and another one is chosen.
// `trials` saves measures that it holds; without it, each cut is measured.
std::vector<CutPiece> cut_pieces(std::vector<CutPiece> pieces, const CutRule& rule,
                                 const std::vector<ReflexEdge>& reflex_edges,
                                 const CutSettings& settings, CutTrials* trials = nullptr);

// Applies to `piece` the tree of cuts that led to `leaves`, from the cut number `depth` of their
// paths on, and appends the pieces to `result`. A cut that split_piece() refuses is left out; the
// cuts of the larger of its sides follow.
void repeat_cuts(CutPiece piece, const std::vector<const CutPiece*>& leaves, std::size_t depth,
                 const CutSettings& settings, std::vector<CutPiece>& result);

// Joins pairs of pieces, least surplus first, while the union is convex enough and its hull does
// not overlap any other piece.
std::vector<CutPiece> merge_pieces(std::vector<CutPiece> pieces, const CutSettings& settings);

}  // namespace firn
