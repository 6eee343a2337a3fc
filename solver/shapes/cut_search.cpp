#include "solver/shapes/cut_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "solver/shapes/cut_planes.h"

namespace firn {
namespace {

constexpr std::size_t kMaxRejected = 3;  // cuts of one piece, by backtracking
constexpr double kHighestCost = std::numeric_limits<double>::infinity();

// Undoes the cut that made `stuck`: replaces all descendants of its parent by the parent.
void backtrack(std::vector<CutPiece>& pieces, const CutPiece& stuck) {
  const std::shared_ptr<const CutPiece> parent = stuck.parent;
  CutPiece restored = *parent;
  restored.rejected.push_back(stuck.path[parent->path.size()]);
  std::erase_if(pieces, [&parent](const CutPiece& p) {
    const CutPiece* ancestor = p.parent.get();
    while (ancestor && ancestor != parent.get()) ancestor = ancestor->parent.get();
    return ancestor != nullptr;
  });
  pieces.push_back(std::move(restored));
}

// Cost of a cut: sum over both sides. A side that is convex enough has no cost.
double cost_of_cut(const CutTrial& cut, const CutRule& rule, const CutSettings& s) {
  const double unit = s.size * s.size * s.size;
  double sum = 0, least = kHighestCost;
  for (const auto& side : cut.sides) {
    const double excess = side.deviation / s.options.tolerance, surplus = side.surplus / unit;
    double c = 0;
    if (excess > 1) {
      switch (rule.cost) {
        case CutRule::Cost::surplus:
          c = surplus;
          break;
        case CutRule::Cost::surplus_root:
          c = std::cbrt(std::max(surplus, 0.0));
          break;
        case CutRule::Cost::surplus_deviation:
          c = excess * surplus;
          break;
        case CutRule::Cost::deviation:
          c = excess;
          break;
      }
    }
    if (c > 0 && rule.thin_weight > 0) {
      c *= 1 + rule.thin_weight * s.options.min_thickness / side.thickness;
    }
    sum += c;
    least = std::min(least, c);
  }
  if (rule.cost == CutRule::Cost::deviation) sum -= 0.5 * least;
  // Among equal cuts, one with less surplus and a smaller area is preferred.
  return sum + 0.01 * (cut.sides[0].surplus + cut.sides[1].surplus) / unit +
         0.001 * cut.cap_area / (s.size * s.size);
}

bool was_rejected(const CutPiece& piece, const HalfSpace& cut) {
  return std::any_of(piece.rejected.begin(), piece.rejected.end(), [&cut](const HalfSpace& h) {
    return (h.normal == cut.normal && h.offset == cut.offset) ||
           (h.normal == -cut.normal && h.offset == -cut.offset);
  });
}

// The cut of least cost, and its sides. Nothing if no plane gives two sides that are thick enough.
std::optional<std::array<CutPiece, 2>> best_split(const CutPiece& piece, const CutRule& rule,
                                                  const std::vector<ReflexEdge>& reflex_edges,
                                                  const CutSettings& s, CutTrials* trials) {
  std::optional<HalfSpace> best;
  double best_cost = kHighestCost;
  for (const auto& cut : candidate_planes(piece, reflex_edges, rule.middle_only, s)) {
    if (was_rejected(piece, cut)) continue;
    const auto trial = trials ? trials->measure(piece, cut, s) : measure_cut(piece, cut, s);
    if (!trial) continue;
    const double c = cost_of_cut(*trial, rule, s);
    if (c >= best_cost * (1 - 1e-9)) continue;
    if (trial->sides[0].thickness < s.options.min_thickness ||
        trial->sides[1].thickness < s.options.min_thickness)
      continue;
    best_cost = c;
    best = cut;
  }
  if (!best) return std::nullopt;
  return split_piece(piece, *best, s);
}

}  // namespace

std::vector<CutPiece> cut_pieces(std::vector<CutPiece> pieces, const CutRule& rule,
                                 const std::vector<ReflexEdge>& reflex_edges, const CutSettings& s,
                                 CutTrials* trials) {
  int backtracks = 0;
  while (static_cast<int>(pieces.size()) < s.options.max_parts) {
    CutPiece* worst = nullptr;
    for (auto& p : pieces) {
      if (!p.final && !is_convex_enough(p, s) && (!worst || p.deviation > worst->deviation))
        worst = &p;
    }
    if (!worst) break;
    std::optional<std::array<CutPiece, 2>> sides;
    if (worst->rejected.size() < kMaxRejected) {
      sides = best_split(*worst, rule, reflex_edges, s, trials);
    }
    if (!sides) {
      if (backtracks < rule.max_backtracks && worst->parent) {
        ++backtracks;
        backtrack(pieces, *worst);
      } else {
        worst->final = true;
      }
      continue;
    }
    if (rule.max_backtracks > 0) {
      const auto parent = std::make_shared<const CutPiece>(std::move(*worst));
      for (auto& side : *sides) side.parent = parent;
    }
    *worst = std::move((*sides)[0]);
    pieces.push_back(std::move((*sides)[1]));
  }
  return pieces;
}

void repeat_cuts(CutPiece piece, const std::vector<const CutPiece*>& leaves, std::size_t depth,
                 const CutSettings& s, std::vector<CutPiece>& result) {
  if (leaves.size() == 1) {
    result.push_back(std::move(piece));
    return;
  }
  const HalfSpace cut = leaves[0]->path[depth];
  std::array<std::vector<const CutPiece*>, 2> parts;
  std::array<double, 2> volumes{};
  for (const CutPiece* leaf : leaves) {
    const int side = leaf->path[depth].normal == cut.normal ? 0 : 1;
    parts[side].push_back(leaf);
    volumes[side] += leaf->volume;
  }
  if (auto sides = split_piece(piece, cut, s)) {
    for (int i = 0; i < 2; ++i) repeat_cuts(std::move((*sides)[i]), parts[i], depth + 1, s, result);
  } else {
    repeat_cuts(std::move(piece), parts[volumes[1] > volumes[0]], depth + 1, s, result);
  }
}

std::vector<CutPiece> merge_pieces(std::vector<CutPiece> pieces, const CutSettings& s) {
  struct Pair {
    std::size_t a, b;
    CutPiece whole;
  };
  std::vector<Pair> pairs;
  std::vector<char> alive(pieces.size(), 1);
  const auto consider = [&](std::size_t a, std::size_t b) {
    if (!boxes_touch(pieces[a], pieces[b], s)) return;
    auto whole = join_pieces(pieces[a], pieces[b], s);
    if (whole && is_convex_enough(*whole, s)) pairs.push_back({a, b, std::move(*whole)});
  };
  for (std::size_t b = 1; b < pieces.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) consider(a, b);
  }
  while (!pairs.empty()) {
    std::size_t best = pairs.size();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (best < pairs.size() && pairs[i].whole.surplus >= pairs[best].whole.surplus) continue;
      const Pair& p = pairs[i];
      bool clear = true;
      for (std::size_t k = 0; k < pieces.size() && clear; ++k) {
        if (alive[k] && k != p.a && k != p.b) clear = hulls_are_separate(p.whole, pieces[k], s);
      }
      if (clear) best = i;
    }
    if (best == pairs.size()) break;
    Pair chosen = std::move(pairs[best]);
    alive[chosen.a] = alive[chosen.b] = 0;
    std::erase_if(pairs, [&alive](const Pair& p) { return !alive[p.a] || !alive[p.b]; });
    pieces.push_back(std::move(chosen.whole));
    alive.push_back(1);
    const std::size_t added = pieces.size() - 1;
    for (std::size_t k = 0; k < added; ++k) {
      if (alive[k]) consider(k, added);
    }
  }
  std::vector<CutPiece> result;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (alive[i]) result.push_back(std::move(pieces[i]));
  }
  return result;
}

}  // namespace firn
