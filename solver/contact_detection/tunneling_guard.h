// Prevents tunneling. The minimum translation vector points back to the side of entry only while
// the overlap is less than half of the combined thickness, and a fast body can cross a thin part
// within one step. In both cases the contact normal of the previous step, or a sweep over the step,
// selects the side.
#pragma once

#include "solver/contact/patch_builder.h"
#include "solver/state/workspace.h"

namespace firn {

// Input for one test of a pair of bodies. A boundary must be a solid.
struct SideInput {
  const Model& model;
  const Workspace& workspace;
  const State& state;
  const Pair& pair;
};

class TunnelingGuard {
 public:
  explicit TunnelingGuard(const SideInput& input);

  // True when the motion within a step exceeds the overlap at which the side of entry is still
  // certain.
  bool needs_sweep() const { return needs_sweep_; }

  // Call for every part pair that overlaps or had points, and for all when needs_sweep().
  // Recomputes the contact when it is not on the side where the parts met. Returns false when the
  // parts have passed through each other.
  bool enforce_contact_side(const PartPair& parts, const Pose& b_in_a, double contact_margin,
                            Manifold& m) const;

  // A bound on how far any two points of the bodies move relative to each other in a step, m.
  double motion() const { return motion_; }

 private:
  const ConvexPart& part_b(std::uint32_t index) const;
  Pose pose_before(double seconds) const;
  bool covers_part(const ContactPatch& patch, const ConvexPart& b) const;
  template <class Visit>
  void for_each_patch(const PartPair& parts, bool neighbors, const Visit& visit) const;
  const ContactPatch* nearest(const PartPair& parts, bool neighbors, const Vec3& normal) const;
  bool sweep_pair(const ConvexPart& a, const ConvexPart& b, Vec3& normal, double& at) const;
  bool find_first_impact(const PartPair& parts, Vec3& side) const;
  bool penetrates_during_step(const ConvexPart& a, const ConvexPart& b, double from,
                              double deep) const;

  SideInput in_;
  double motion_ = 0;
  bool needs_sweep_ = false;
};

// The motion bound of TunnelingGuard for any pair, planes included, m.
double step_motion(const Model& model, const Workspace& workspace, const State& state, int a,
                   int b);

// Throws RunError when a particle moves so far within a step that the neighbor list may miss bodies
// along its path.
void check_step_lengths(const Model& model, const Workspace& workspace, const State& state);

}  // namespace firn
