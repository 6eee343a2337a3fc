// A solid is cut by planes until the hull of every piece is near its surface; then pieces whose
// common hull is near the surface, too, are joined. Pieces of a tree of cuts are separated by
// planes, so their hulls do not overlap. Cuts are chosen one by one (greedily), by several rules in
// turn; the rule that ends with the fewest pieces wins. A thorough search also gives thin pieces
// that are not convex enough a higher cost, and backtracks from cuts that lead to pieces that no
// cut helps.
#include "solver/shapes/convex_decomposition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "solver/core/parallel.h"
#include "solver/shapes/cut_search.h"
#include "solver/shapes/cut_trials.h"

namespace firn {
namespace {

// Of a thorough search.
constexpr double kThinWeight = 4;   // see CutRule
constexpr int kMaxBacktracks = 40;  // of one tree of cuts
constexpr double kNear = 1.15;      // deviation over the tolerance up to which parts are counted

constexpr std::array<CutRule, 5> kRules = {{{CutRule::Cost::surplus, false},
                                            {CutRule::Cost::surplus_root, false},
                                            {CutRule::Cost::surplus_deviation, false},
                                            {CutRule::Cost::deviation, false},
                                            {CutRule::Cost::surplus, true}}};

// A thorough search applies every rule as a quick one does, and once more with a higher cost of
// thin pieces and with backtracking.
std::vector<CutRule> all_rules(bool thorough) {
  std::vector<CutRule> rules(kRules.begin(), kRules.end());
  for (std::size_t i = 0; thorough && i < kRules.size(); ++i) {
    rules.push_back(kRules[i]);
    rules.back().thin_weight = kThinWeight;
    rules.back().max_backtracks = kMaxBacktracks;
  }
  return rules;
}

CutRule last_rule(bool thorough) {
  CutRule rule = kRules[0];
  if (thorough) rule.thin_weight = kThinWeight;
  return rule;
}

// Pieces at the leaves of a tree of cuts, before and after the merge.
struct Outcome {
  std::vector<CutPiece> tree, merged;
  double score = std::numeric_limits<double>::infinity();
};

Outcome search_once(const CutPiece& plan, const CutRule& rule,
                    const std::vector<ReflexEdge>& reflex_edges, const CutSettings& settings,
                    CutTrials& trials) {
  Outcome o;
  o.tree = cut_pieces({plan}, rule, reflex_edges, settings, &trials);
  o.merged = merge_pieces(o.tree, settings);
  double worst = 0;  // of the deviations, over the tolerance
  for (const auto& p : o.merged) worst = std::max(worst, p.deviation / settings.options.tolerance);
  // Near the tolerance the number of parts counts, beyond it the deviation.
  const double near = settings.options.thorough ? kNear : 1;
  o.score = static_cast<double>(o.merged.size()) + worst + (worst > near ? 100 * worst : 0);
  return o;
}

// Backtracks only where the tree ends with pieces that no cut helps.
Outcome search(const CutPiece& plan, const CutRule& rule,
               const std::vector<ReflexEdge>& reflex_edges, const CutSettings& settings,
               CutTrials& trials) {
  CutRule direct = rule;
  direct.max_backtracks = 0;
  Outcome first = search_once(plan, direct, reflex_edges, settings, trials);
  const bool stuck =
      std::any_of(first.tree.begin(), first.tree.end(), [](const CutPiece& p) { return p.final; });
  if (!stuck || rule.max_backtracks == 0) return first;
  Outcome second = search_once(plan, rule, reflex_edges, settings, trials);
  return second.score < first.score ? second : first;
}

// decompose() of a mesh whose bounding box begins at the origin and has a diagonal of about 1.
Decomposition decompose_unit(const TriangleMesh& mesh, const DecomposeOptions& options,
                             CutTrials& trials) {
  const auto [lower, upper] = bounding_box(mesh);
  const double size = (upper - lower).norm();
  CutPiece whole;
  whole.boundary = sorted_facets(mesh);
  const PointInMesh interior(mesh);
  const CutSettings settings{interior, options, size, 1e-9 * size, (lower + upper) / 2};
  if (!measure_piece(whole, settings)) throw InputError("the mesh is flat; expected a solid");
  std::vector<CutPiece> pieces;
  if (is_convex_enough(whole, settings) || options.max_parts == 1) {
    pieces.push_back(std::move(whole));
  } else {
    CutPiece plan = whole;
    if (plan.boundary.size() > options.plan_triangles) {
      plan.boundary = simplify_facets(whole.boundary, options.plan_triangles, size);
    }
    const bool exact = plan.boundary.size() == whole.boundary.size();
    measure_piece(plan, settings);
    trials.begin_plan(plan.boundary.size());
    const auto reflex_edges = find_reflex_edges(plan.boundary, size);
    const std::vector<CutRule> rules = all_rules(options.thorough);
    std::vector<Outcome> outcomes(rules.size());
    const int threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                                   static_cast<int>(rules.size()));
    parallel_for_blocks(threads, rules.size(), 1, [&](std::size_t i, std::size_t) {
      outcomes[i] = search(plan, rules[i], reflex_edges, settings, trials);
    });
    Outcome& best =
        *std::min_element(outcomes.begin(), outcomes.end(),
                          [](const Outcome& a, const Outcome& b) { return a.score < b.score; });
    if (exact) {
      pieces = std::move(best.merged);
    } else {
      std::vector<const CutPiece*> leaves;
      for (const auto& leaf : best.tree) leaves.push_back(&leaf);
      repeat_cuts(whole, leaves, 0, settings, pieces);
      pieces = merge_pieces(std::move(pieces), settings);
    }
    for (auto& p : pieces) p.final = false;
    const std::size_t before = pieces.size();
    pieces = cut_pieces(std::move(pieces), last_rule(options.thorough), reflex_edges, settings);
    if (pieces.size() > before) pieces = merge_pieces(std::move(pieces), settings);
  }
  Decomposition result;
  for (const auto& piece : pieces) {
    if (!is_convex_enough(piece, settings)) {
      const bool full = static_cast<int>(pieces.size()) >= options.max_parts;
      (full ? result.part_limit_reached : result.thickness_limit_reached) = true;
    }
    std::vector<HalfSpace> hull = convex_hull(reduced_corners(piece, settings));
    for (auto& h : hull) {
      // The pieces on both sides of a cut get exactly opposite planes.
      for (const auto& cut : piece.cuts) {
        if (same_plane(h, cut, settings)) h = cut;
      }
    }
    result.pieces.push_back(std::move(hull));
  }
  return result;
}

}  // namespace

// Cuts of equal cost are common, and rounding errors would choose among them. The corners are
// therefore taken relative to the box and rounded: unit and position of the mesh do not matter.
Decomposition decompose(const TriangleMesh& mesh, const DecomposeOptions& options,
                        CutTrials* trials) {
  constexpr double kSteps = 0x1p32;  // of the box diagonal
  const auto [lower, upper] = bounding_box(mesh);
  const double size = (upper - lower).norm();
  TriangleMesh unit = mesh;
  for (Vec3& v : unit.vertices) v = ((v - lower) / size * kSteps).array().round() / kSteps;
  DecomposeOptions relative = options;
  relative.tolerance /= size;
  relative.min_thickness /= size;
  CutTrials own_trials;
  Decomposition result = decompose_unit(unit, relative, trials ? *trials : own_trials);
  for (auto& piece : result.pieces) {
    for (HalfSpace& h : piece) h.offset = size * h.offset + h.normal.dot(lower);
  }
  return result;
}

}  // namespace firn
