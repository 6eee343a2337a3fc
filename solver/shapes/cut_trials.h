// Measures of cuts, stored for all rules and searches that try the same cut of the same piece.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "solver/shapes/cut_piece.h"

namespace firn {

// What the choice of a cut depends on.
struct CutTrial {
  struct Side {
    double deviation = 0;  // m, as in CutPiece
    double surplus = 0;    // m^3
    double thickness = 0;  // m, see hull_thickness()
  };
  std::array<Side, 2> sides;  // below and above the cut
  double cap_area = 0;        // m^2, signed area of the cap of the lower side
};

// The measures of the sides that split_piece() gives. Nothing where that gives nothing.
std::optional<CutTrial> measure_cut(const CutPiece& piece, const HalfSpace& cut,
                                    const CutSettings& settings);

// The cuts of one plan: of one mesh, simplified to one number of facets. A piece is found by its
// path. Merged pieces have no path and must not be measured here.
class CutTrials {
 public:
  // Forgets the trials of a plan of another number of facets.
  void begin_plan(std::size_t facets);

  // Equal to measure_cut(), bit by bit, in any order of calls. Thread-safe: of two threads that
  // measure the same cut, one waits for the other. The thickness of the settings may differ from
  // call to call.
  std::optional<CutTrial> measure(const CutPiece& piece, const HalfSpace& cut,
                                  const CutSettings& settings);

 private:
  using PlaneBits = std::array<std::uint64_t, 4>;  // of normal and offset
  struct Entry {
    std::mutex mutex;
    bool known = false;
    double min_thickness = 0;  // m, that the trial was made with
    std::optional<CutTrial> trial;
  };
  static PlaneBits bits(const HalfSpace& plane);
  Entry& entry(const CutPiece& piece, const HalfSpace& cut);

  std::mutex mutex_;
  std::map<std::vector<PlaneBits>, std::map<PlaneBits, Entry>> entries_;  // by path, by cut
  std::size_t facets_ = 0;
};

}  // namespace firn
