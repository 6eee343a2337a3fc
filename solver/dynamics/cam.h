// The profile of a cam.
#pragma once

#include <memory>
#include <vector>

namespace firn {

// A smooth lift over the angle, periodic in one turn: monotone between the given angles where the
// lifts are (PCHIP: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300).
class Cam {
 public:
  // rad, at least two, ascending within one turn; m or rad.
  Cam(const std::vector<double>& angles, const std::vector<double>& lifts);
  ~Cam();
  Cam(Cam&&) noexcept;
  Cam& operator=(Cam&&) noexcept;

  double lift(double angle) const;
  double slope(double angle) const;  // of the lift, per rad

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
