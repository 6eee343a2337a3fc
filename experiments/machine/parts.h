// Parametric solids of icemaker parts and laboratory rigs. The make_*() functions are pure. They
// throw DimensionError for dimensions without a valid solid. Drawings: docs/machine-parts.md.
// Lengths in m, angles in rad; the part axes are stated with each part.
#pragma once

#include "experiments/machine/swept_solid.h"
#include "firn/shape.h"

namespace firn {

// A row of crescent cavities along x, open above, z up. The origin is the middle of the axis of
// their arcs, about which an ejector rotates. A cavity is the crescent with its arc extended to the
// rim, with its thickness and draft, enlarged by `clearance` on all sides.
struct Mold {
  CrescentParameters cube = named_crescent("mass-matched", {}).parameters;
  int cavities = 8;
  double pitch = 25e-3;
  double clearance = 1e-3;
  double freeboard = 4e-3;  // height of the rim above the water line
  double wall = 4e-3;  // thickness around and below the cavities, and of the end walls at the rim
  double notch_width = 4e-3;  // of the water channel through the webs between cavities; 0: none
  double notch_depth = 4e-3;  // depth of the channel below the water line

  bool operator==(const Mold&) const = default;
};
Solid make_mold(const Mold& mold);
// Height (m) of the water line of the crescent above the axis of its arc; negative.
double water_line(const CrescentParameters& cube);

// A shaft along x with a row of blades that point to +y. The origin is the middle of the shaft
// axis.
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

// Fingers between the blades of the ejector that fall towards +y, joined by an apron at their lower
// end. The origin is that of the ejector.
struct Stripper {
  int blades = 8;  // of the ejector; there are blades + 1 fingers
  double pitch = 25e-3;
  double finger_width = 15e-3;
  double near = 9e-3;    // y of the upper end
  double far = 54e-3;    // y of the lower end
  double height = 5e-3;  // z of the upper end
  double slope = 25 * kDegToRad;
  double thickness = 3e-3;
  double apron = 10e-3;  // along y

  bool operator==(const Stripper&) const = default;
};
Solid make_stripper(const Stripper& stripper);

// A round wire bent along a polyline.
struct Wire {
  double diameter = 3e-3;
  std::vector<Vec3> points;

  bool operator==(const Wire&) const = default;
};
Solid make_wire(const Wire& wire);

// A box open above, with walls inclined outwards by the draft. The origin is the middle of the
// inner floor, z up, the front at +y, the outlet at +x. Inner length (x) and width (y) are those of
// the extended walls at the floor level z = 0. The top edges of the end walls are straight lines
// from the rim of the back wall to that of the front wall.
struct Bucket {
  enum class Outlet { none, end, floor };
  double length = 300e-3, width = 130e-3;
  double back_height = 100e-3, front_height = 140e-3;
  double wall = 3e-3;
  double draft = 3 * kDegToRad;
  // Radius of a cylindrical floor along x, tangent to inclined shoulders; 0: a flat floor.
  double trough_radius = 0;
  double shoulder = 45 * kDegToRad;
  // Opening in the end wall at +x or in the floor next to it, in the middle of the width.
  Outlet outlet = Outlet::none;
  double outlet_width = 95e-3;
  double outlet_height = 95e-3;  // of an outlet in the end wall, above z = 0
  double outlet_length = 90e-3;  // of an outlet in the floor, along x

  bool operator==(const Bucket&) const = default;
};
Solid make_bucket(const Bucket& bucket);

// A helical blade on a shaft along x. The blade begins at the origin at +y and advances to +x. It
// has the thickness `blade_thickness` along x.
struct Auger {
  double outer_diameter = 95e-3;
  double shaft_diameter = 30e-3;
  double pitch = 55e-3;
  double turns = 5;  // in steps of 1/48
  double blade_thickness = 3e-3;
  double overhang = 10e-3;  // of the shaft beyond each end of the blade
  bool left_handed = false;

  bool operator==(const Auger&) const = default;
};
Solid make_auger(const Auger& auger);

// A helical wire about the x axis, from the origin to +x, that begins at +y.
struct WireAuger {
  double outer_diameter = 95e-3;  // over the wire
  double wire_diameter = 7e-3;
  double pitch = 55e-3;
  double turns = 5;
  bool left_handed = false;

  bool operator==(const WireAuger&) const = default;
};
Solid make_wire_auger(const WireAuger& auger);

// A cylindrical channel open above, along x. The origin is on the axis, in the middle of the
// length.
struct Trough {
  double radius = 50e-3;  // inner
  double length = 300e-3;
  double wall = 3e-3;
  double angle = 180 * kDegToRad;  // of the arc

  bool operator==(const Trough&) const = default;
};
Solid make_trough(const Trough& trough);

// A tube open at both ends. The first leg starts at the origin, the middle of its inlet, in the
// direction +x inclined downwards by `inclination`. A second leg exists if `bend` > 0; it is
// inclined by `bend` more. Lengths are those of the center line.
struct Chute {
  bool round = false;
  double width = 90e-3, height = 90e-3;  // inner, along y and normal to it
  double diameter = 90e-3;               // inner, if round
  double wall = 3e-3;
  double inclination = 50 * kDegToRad;
  double length = 150e-3;
  double bend = 0;
  double bend_length = 150e-3;

  bool operator==(const Chute&) const = default;
};
Solid make_chute(const Chute& chute);

// A cup open above. The origin is the middle of the inner floor.
struct Container {
  bool round = true;
  double diameter = 85e-3;               // inner, if round
  double length = 85e-3, width = 85e-3;  // inner, along x and y
  double height = 120e-3;                // inner
  double wall = 3e-3, floor = 3e-3;

  bool operator==(const Container&) const = default;
};
Solid make_container(const Container& container);

// A closed cylinder along x, centered at the origin, with straight lifters inside, the first at +y.
struct Drum {
  double diameter = 300e-3, length = 200e-3;  // inner
  double wall = 5e-3;
  int lifters = 0;
  double lifter_height = 20e-3;     // inwards
  double lifter_thickness = 10e-3;  // along the circumference

  bool operator==(const Drum&) const = default;
};
Solid make_drum(const Drum& drum);

// A disc or block, centered at the origin, with faces normal to z.
struct Platen {
  bool round = true;
  double diameter = 100e-3;
  double length = 100e-3, width = 100e-3;
  double thickness = 20e-3;

  bool operator==(const Platen&) const = default;
};
Solid make_platen(const Platen& platen);

// A box open above with an opening in the middle of its floor over the full width. The origin is
// the middle of the opening at the level of the inner floor. The door is a separate boundary.
struct TrapDoorBox {
  double length = 596.9e-3, width = 139.7e-3, height = 314.96e-3;  // inner
  double wall = 10e-3, floor = 10e-3;
  double door_length = 146.05e-3;

  bool operator==(const TrapDoorBox&) const = default;
};
Solid make_trap_door_box(const TrapDoorBox& box);

}  // namespace firn
