// Responses of single bodies: when they lose their hold, how they slide, how they bounce. Measured
// from the frames of a recording; methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// One body over the frames in which it exists, seen from a boundary.
struct BoundaryTrack {
  std::vector<double> time;         // s
  std::vector<double> distance;     // m from where it was first, along the boundary's x, y plane
  std::vector<double> turn;         // rad between the boundary's z axis in axes of the body now and
                                    // as it saw it first: tipping, not turning on the spot
  std::vector<double> inclination;  // rad, of the boundary's z axis against the vertical
};

// One body over the frames in which it exists, along the vertical.
struct FallTrack {
  std::vector<double> time;    // s
  std::vector<Vec3> velocity;  // m/s, world
};

struct SlipResult {
  enum class End { held, slid, tipped };
  End end = End::held;
  double angle = 0;       // rad, inclination when it had moved by `slip`; not when it held
  double resolution = 0;  // rad, by which the inclination changed between two frames then
};
SlipResult slip_of(const BoundaryTrack& track, const Measure& measure);

struct SlideResult {
  bool passed = false;      // both marks
  double time = 0;          // s from mark to mark
  double resolution = 0;    // s between two frames
  double acceleration = 0;  // m/s^2, of a parabola through the way between the marks
  double distance = 0;      // m, in the last frame
};
SlideResult slide_of(const BoundaryTrack& track, const Measure& measure);

struct ReboundResult {
  bool landed = false;        // fell freely, and touched something
  double impact_speed = 0;    // m/s downwards, when it first touched
  double take_off_speed = 0;  // m/s upwards, the largest with which it flew off again; 0: never did
  double resolution = 0;      // m/s that gravity gives between two frames
};
ReboundResult rebound_of(const FallTrack& track, const Vec3& gravity);

// Of all [[measure]] tables of these kinds.
std::vector<Response> body_responses(const Recording& recording, const Case& c);

}  // namespace firn
