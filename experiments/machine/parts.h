// Parts of icemakers and of laboratory rigs from a few dimensions. Every maker is a pure function;
// dimensions that cannot be made end in a DimensionError. docs/machine-parts.md has the drawings.
// Lengths in m, angles in rad, own axes as said with each part.
#pragma once

#include <numbers>

#include "experiments/machine/swept_solid.h"
#include "firn/shape.h"

namespace firn {

inline constexpr double kDegree = std::numbers::pi / 180;

// A row of crescent cavities along x, open above. The origin is the middle of the axis of their
// arcs, about which an ejector turns; z up. The cavity is the crescent's arc, run on to the rim,
// its thickness and draft, everywhere `clearance` away from the crescent.
struct Mold {
  CrescentParameters cube = named_crescent("mass-matched", {}).parameters;
  int cavities = 8;
  double pitch = 25e-3;
  double clearance = 1e-3;
  double freeboard = 4e-3;    // rim above the water line
  double wall = 4e-3;         // around and below the cavities, end walls at the rim
  double notch_width = 4e-3;  // channel through the webs that the water runs along; 0: none
  double notch_depth = 4e-3;  // of the channel below the water line

  bool operator==(const Mold&) const = default;
};
Solid make_mold(const Mold& mold);
// Height (m) of the crescent's water line above the axis; below zero.
double water_line(const CrescentParameters& cube);

// A shaft along x with a row of blades, all towards +y. The origin is the middle of its axis.
struct Ejector {
  int blades = 8;
  double pitch = 25e-3;
  double tip_radius = 36.8e-3;
  double blade_width = 6e-3;      // along x
  double blade_thickness = 3e-3;  // along z
  double shaft_diameter = 10e-3;
  double shaft_length = 220e-3;

  bool operator==(const Ejector&) const = default;
};
Solid make_ejector(const Ejector& ejector);

// Fingers between blades, falling towards +y, joined by an apron at their lower end. The origin is
// that of the ejector.
struct Stripper {
  int blades = 8;  // between blades + 1 fingers
  double pitch = 25e-3;
  double finger_width = 15e-3;
  double near = 9e-3;    // y of the upper end
  double far = 54e-3;    // y of the lower end
  double height = 5e-3;  // z of the upper end
  double slope = 25 * kDegree;
  double thickness = 3e-3;
  double apron = 10e-3;  // along y

  bool operator==(const Stripper&) const = default;
};
Solid make_stripper(const Stripper& stripper);

// A round wire bent along a line of points.
struct Wire {
  double diameter = 3e-3;
  std::vector<Vec3> points;

  bool operator==(const Wire&) const = default;
};
Solid make_wire(const Wire& wire);

// A box open above, its walls leaning out by the draft. The origin is the middle of the inner
// floor, z up, the front towards +y, the outlet towards +x. Inner length (x) and width (y) are
// those at the floor, z = 0, of the walls produced. The tops of the end walls run straight from the
// rim of the back wall to that of the front.
struct Bucket {
  enum class Outlet { none, end, floor };
  double length = 300e-3, width = 130e-3;
  double back_height = 100e-3, front_height = 140e-3;
  double wall = 3e-3;
  double draft = 3 * kDegree;
  // A round floor along x, tangent to shoulders that slope up to the walls; 0: a flat floor.
  double trough_radius = 0;
  double shoulder = 45 * kDegree;
  // An opening in the end wall at +x, or in the floor before it, in the middle of the width.
  Outlet outlet = Outlet::none;
  double outlet_width = 95e-3;
  double outlet_height = 95e-3;  // end: above z = 0
  double outlet_length = 90e-3;  // floor: along x

  bool operator==(const Bucket&) const = default;
};
Solid make_bucket(const Bucket& bucket);

// A helical blade about a shaft along x. The blade begins at the origin, towards +y, and advances
// to +x; its flats are sheets of `blade_thickness` along x.
struct Auger {
  double outer_diameter = 95e-3;
  double shaft_diameter = 30e-3;
  double pitch = 55e-3;
  double turns = 5;  // in steps of 1/48
  double blade_thickness = 3e-3;
  double overhang = 10e-3;  // of the shaft beyond both ends of the blade
  bool left_handed = false;

  bool operator==(const Auger&) const = default;
};
Solid make_auger(const Auger& auger);

// A wire wound about the x axis, from the origin to +x, beginning towards +y.
struct WireAuger {
  double outer_diameter = 95e-3;  // over the wire
  double wire_diameter = 7e-3;
  double pitch = 55e-3;
  double turns = 5;
  bool left_handed = false;

  bool operator==(const WireAuger&) const = default;
};
Solid make_wire_auger(const WireAuger& auger);

// A round channel open above, along x about the origin, its lowest line below it.
struct Trough {
  double radius = 50e-3;  // inner
  double length = 300e-3;
  double wall = 3e-3;
  double angle = 180 * kDegree;  // of the arc

  bool operator==(const Trough&) const = default;
};
Solid make_trough(const Trough& trough);

// A channel closed all around and open at both ends: a first leg from the origin (the middle of its
// inlet), which falls from +x by the inclination, and if it bends a second one, which falls by the
// bend more. Lengths are those of the middle line.
struct Chute {
  bool round = false;
  double width = 90e-3, height = 90e-3;  // inner, along y and across
  double diameter = 90e-3;               // inner, if round
  double wall = 3e-3;
  double inclination = 50 * kDegree;
  double length = 150e-3;
  double bend = 0;
  double bend_length = 150e-3;

  bool operator==(const Chute&) const = default;
};
Solid make_chute(const Chute& chute);

// A cup open above; the origin is the middle of its inner floor.
struct Container {
  bool round = true;
  double diameter = 85e-3;               // inner, if round
  double length = 85e-3, width = 85e-3;  // inner, along x and y
  double height = 120e-3;                // inner
  double wall = 3e-3, floor = 3e-3;

  bool operator==(const Container&) const = default;
};
Solid make_container(const Container& container);

// A closed cylinder along x about the origin, with straight lifters inside, the first towards +y.
struct Drum {
  double diameter = 300e-3, length = 200e-3;  // inner
  double wall = 5e-3;
  int lifters = 0;
  double lifter_height = 20e-3;     // inwards
  double lifter_thickness = 10e-3;  // along the circumference

  bool operator==(const Drum&) const = default;
};
Solid make_drum(const Drum& drum);

// A disc or block about its middle, its faces up and down.
struct Platen {
  bool round = true;
  double diameter = 100e-3;
  double length = 100e-3, width = 100e-3;
  double thickness = 20e-3;

  bool operator==(const Platen&) const = default;
};
Solid make_platen(const Platen& platen);

// A box open above with an opening in the middle of its floor, over the whole width. The origin is
// the middle of the opening at the inner floor. The door is a separate boundary.
struct TrapDoorBox {
  double length = 596.9e-3, width = 139.7e-3, height = 314.96e-3;  // inner
  double wall = 10e-3, floor = 10e-3;
  double door_length = 146.05e-3;

  bool operator==(const TrapDoorBox&) const = default;
};
Solid make_trap_door_box(const TrapDoorBox& box);

}  // namespace firn
