// Which side of each other two parts are on. The shortest way out of an overlap is the way in only
// while the overlap is less than half as deep as both parts are thick together; and a fast body can
// be past a thin one at the end of a step. What is known of the time before decides then.
#pragma once

#include "solver/contact/patch_builder.h"
#include "solver/state/workspace.h"

namespace firn {

// One look at one pair of bodies; a boundary must be a solid.
struct SideInput {
  const Model& model;
  const Workspace& workspace;
  const State& state;
  const Pair& pair;
};

class TunnellingGuard {
 public:
  explicit TunnellingGuard(const SideInput& input);

  // True when the bodies move farther within a step than parts may overlap unwatched.
  bool fast() const { return fast_; }

  // Call for every part pair that overlaps or had points, and for all when fast(). Recomputes the
  // contact when it is on another side than the one where the parts met. False when the parts have
  // passed through each other.
  bool keep(const PartPair& parts, const Pose& b_in_a, double shell, Manifold& m) const;

  // A bound on how far any two points of the bodies move relative to each other in a step, m.
  double motion() const { return motion_; }

 private:
  const ConvexPart& part_b(std::uint32_t index) const;
  Pose pose_before(double seconds) const;
  bool lies_on(const Patch& patch, const ConvexPart& b) const;
  template <class Visit>
  void for_patches(const PartPair& parts, bool neighbours, const Visit& visit) const;
  const Patch* nearest(const PartPair& parts, bool neighbours, const Vec3& normal) const;
  bool entry(const ConvexPart& a, const ConvexPart& b, Vec3& normal, double& at) const;
  bool first_entry(const PartPair& parts, Vec3& side) const;
  bool deep_on_the_way(const ConvexPart& a, const ConvexPart& b, double from, double deep) const;

  SideInput in_;
  double motion_ = 0;
  bool fast_ = false;
};

// The motion bound of TunnellingGuard for any pair, planes included, m.
double step_motion(const Model& model, const Workspace& workspace, const State& state, int a,
                   int b);

// Throws RunError when a particle moves so far within a step that the neighbour list may miss what
// it passes.
void check_step_lengths(const Model& model, const Workspace& workspace, const State& state);

}  // namespace firn
