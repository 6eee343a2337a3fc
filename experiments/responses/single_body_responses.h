// Responses of single bodies: onset of sliding, sliding time, rebound. Computed from frames;
// methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// Motion of a body relative to a boundary, over the frames in which the body exists.
struct BoundaryTrack {
  std::vector<double> time;      // s
  std::vector<double> distance;  // m, from the first position, in the x, y plane of the boundary
  // rad, angle between the z axis of the boundary in body axes and its first value. Rotation about
  // that axis does not count.
  std::vector<double> turn;
  std::vector<double> inclination;  // rad, of the z axis of the boundary from the vertical
};

// Velocity of a body over the frames in which it exists.
struct FallTrack {
  std::vector<double> time;    // s
  std::vector<Vec3> velocity;  // m/s, world
};

struct SlipResult {
  enum class End { at_rest, slid, tipped };
  End end = End::at_rest;
  double angle = 0;       // rad, inclination at the displacement Measure::slip; 0: at rest
  double resolution = 0;  // rad, change of the inclination between two frames at that time
};
SlipResult measure_slip(const BoundaryTrack& track, const Measure& measure);

struct SlideResult {
  bool passed = false;      // reached both marks
  double time = 0;          // s from mark to mark
  double resolution = 0;    // s between two frames
  double acceleration = 0;  // m/s^2, of a parabola fitted to the distance between the marks
  double distance = 0;      // m, in the last frame
};
SlideResult measure_slide(const BoundaryTrack& track, const Measure& measure);

struct ReboundResult {
  bool landed = false;        // a free fall ended with a contact
  double impact_speed = 0;    // m/s, downwards, at the first contact
  double take_off_speed = 0;  // m/s, upwards, largest after a contact; 0: none
  double resolution = 0;      // m/s, change by gravity between two frames
};
ReboundResult measure_rebound(const FallTrack& track, const Vec3& gravity);

// Responses of all [[measure]] tables of the kinds "slip", "slide" and "rebound".
std::vector<Response> body_responses(const Recording& recording, const Case& c);

}  // namespace firn
