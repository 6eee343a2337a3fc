#include "solver/shapes/cut_trials.h"

#include <bit>
#include <utility>

namespace firn {

std::optional<CutTrial> measure_cut(const CutPiece& piece, const HalfSpace& cut,
                                    const CutSettings& s) {
  const auto sides = split_piece(piece, cut, s);
  if (!sides) return std::nullopt;
  CutTrial trial;
  for (std::size_t i = 0; i < 2; ++i) {
    const CutPiece& side = (*sides)[i];
    trial.sides[i] = {side.deviation, side.surplus, hull_thickness(side)};
  }
  for (const auto& f : (*sides)[0].boundary) {
    if (f.cap && f.normal == cut.normal) {
      trial.cap_area +=
          0.5 * (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).dot(cut.normal);
    }
  }
  return trial;
}

void CutTrials::begin_plan(std::size_t facets) {
  if (facets != facets_) entries_.clear();
  facets_ = facets;
}

std::optional<CutTrial> CutTrials::measure(const CutPiece& piece, const HalfSpace& cut,
                                           const CutSettings& s) {
  Entry& e = entry(piece, cut);
  const std::lock_guard lock(e.mutex);
  // A cut that leaves enough thickness does so for a lower limit, too, and one that is refused is
  // refused for a higher one.
  const double thickness = s.options.min_thickness;
  const bool holds = e.trial ? thickness <= e.min_thickness : thickness >= e.min_thickness;
  if (!e.known || !holds) {
    e.trial = measure_cut(piece, cut, s);
    e.min_thickness = thickness;
    e.known = true;
  }
  return e.trial;
}

CutTrials::PlaneBits CutTrials::bits(const HalfSpace& plane) {
  return std::bit_cast<PlaneBits>(
      std::array<double, 4>{plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset});
}

CutTrials::Entry& CutTrials::entry(const CutPiece& piece, const HalfSpace& cut) {
  std::vector<PlaneBits> path;
  for (const auto& h : piece.path) path.push_back(bits(h));
  const std::lock_guard lock(mutex_);
  return entries_[std::move(path)][bits(cut)];
}

}  // namespace firn
