// Machine parts: closed meshes of the drawn volume, contact parts that fill them, and refusals.
#include "experiments/machine/parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace firn {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

double volume(const Solid& solid) { return mass_properties(solid.mesh).volume; }

double volume(const std::vector<ConvexPart>& parts) {
  double sum = 0;
  for (const ConvexPart& part : parts) sum += mass_properties(surface_mesh(part)).volume;
  return sum;
}

// Area of the polygon that stands for a circle.
double disc(double radius, int corners) {
  return 0.5 * corners * std::sin(2 * pi / corners) * radius * radius;
}

// How often the mesh winds around a point: 1 inside, 0 outside (sum of solid angles).
double winding(const TriangleMesh& mesh, const Vec3& at) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - at, b = mesh.vertices[t[1]] - at,
               c = mesh.vertices[t[2]] - at;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * pi);
}

// Height of a point over the surface of the nearest part; below zero inside.
double height(const std::vector<ConvexPart>& parts, const Vec3& at) {
  double least = std::numeric_limits<double>::infinity();
  for (const ConvexPart& part : parts) {
    double most = -std::numeric_limits<double>::infinity();
    for (const auto& face : part.faces) most = std::max(most, face.normal.dot(at) - face.offset);
    least = std::min(least, most);
  }
  return least;
}

struct Maker {
  const char* name;
  std::function<Solid()> make;
};

std::vector<Maker> makers() {
  Mold plain;
  plain.notch_width = 0;
  plain.cavities = 2;
  plain.cube = named_crescent("table1", {}).parameters;
  Bucket round;
  round.trough_radius = 50e-3;
  Bucket end = round;
  end.outlet = Bucket::Outlet::end;
  Bucket floor = round;
  floor.outlet = Bucket::Outlet::floor;
  Bucket flat_floor;
  flat_floor.outlet = Bucket::Outlet::floor;
  Bucket flat_end;
  flat_end.outlet = Bucket::Outlet::end;
  flat_end.draft = 0;
  Chute bent;
  bent.bend = 0.5;
  Chute tube;
  tube.round = true;
  tube.inclination = pi / 2;
  Container square;
  square.round = false;
  Drum lifted;
  lifted.lifters = 6;
  Platen block;
  block.round = false;
  Auger left;
  left.left_handed = true;
  left.turns = 1.25;
  const Wire bail{3e-3, {{0, 0, 0}, {0, 0.1, -0.05}, {0.2, 0.1, -0.05}, {0.2, 0, 0.01}}};
  return {{"mold", [] { return make_mold({}); }},
          {"mold without notch", [=] { return make_mold(plain); }},
          {"ejector", [] { return make_ejector({}); }},
          {"stripper", [] { return make_stripper({}); }},
          {"wire", [=] { return make_wire(bail); }},
          {"bucket", [] { return make_bucket({}); }},
          {"bucket with trough", [=] { return make_bucket(round); }},
          {"bucket with trough and outlet in its end", [=] { return make_bucket(end); }},
          {"bucket with trough and outlet in its floor", [=] { return make_bucket(floor); }},
          {"flat bucket with outlet in its floor", [=] { return make_bucket(flat_floor); }},
          {"flat bucket with outlet in its end", [=] { return make_bucket(flat_end); }},
          {"auger", [] { return make_auger({.turns = 2}); }},
          {"left-handed auger", [=] { return make_auger(left); }},
          {"wire auger", [] { return make_wire_auger({.turns = 2}); }},
          {"trough", [] { return make_trough({}); }},
          {"chute", [] { return make_chute({}); }},
          {"bent chute", [=] { return make_chute(bent); }},
          {"tube", [=] { return make_chute(tube); }},
          {"container", [] { return make_container({}); }},
          {"square container", [=] { return make_container(square); }},
          {"drum", [] { return make_drum({}); }},
          {"drum with lifters", [=] { return make_drum(lifted); }},
          {"platen", [] { return make_platen({}); }},
          {"block", [=] { return make_platen(block); }},
          {"trap door box", [] { return make_trap_door_box({}); }}};
}

TEST(MachineParts, MeshesAreClosedAndFaceOutwards) {
  for (const Maker& maker : makers()) {
    const Solid solid = maker.make();
    EXPECT_TRUE(inspect(solid.mesh).is_valid())
        << maker.name << ": " << inspect(solid.mesh).to_message();
    EXPECT_GT(volume(solid), 0) << maker.name;
  }
}

TEST(MachineParts, ContactPartsHoldTheVolumeOfTheMesh) {
  for (const Maker& maker : makers()) {
    const Solid solid = maker.make();
    EXPECT_NEAR(volume(solid.parts), volume(solid), 1e-8 * volume(solid)) << maker.name;
  }
}

// Points about the part: inside the mesh are those inside a contact part, and no others.
TEST(MachineParts, ContactPartsAreWhereTheMeshIs) {
  std::mt19937 random(1);
  for (const Maker& maker : makers()) {
    const Solid solid = maker.make();
    const auto [low, high] = bounding_box(solid.mesh);
    int inside = 0, outside = 0;
    for (int i = 0; i < 300; ++i) {
      Vec3 at;
      if (i % 2 == 0) {  // anywhere
        for (int k = 0; k < 3; ++k) {
          at[k] = std::uniform_real_distribution(low[k], high[k])(random);
        }
      } else {  // half a millimeter off the surface, to either side
        const auto& t = solid.mesh.triangles[random() % solid.mesh.triangles.size()];
        const Vec3 &a = solid.mesh.vertices[t[0]], &b = solid.mesh.vertices[t[1]],
                   &c = solid.mesh.vertices[t[2]];
        at = (a + b + c) / 3 + (i % 4 == 1 ? 5e-4 : -5e-4) * (b - a).cross(c - a).normalized();
      }
      const double over = height(solid.parts, at);
      if (std::abs(over) < 1e-6) continue;
      EXPECT_NEAR(winding(solid.mesh, at), over < 0 ? 1 : 0, 1e-6)
          << maker.name << " at " << at.transpose();
      ++(over < 0 ? inside : outside);
    }
    EXPECT_GT(inside, 20) << maker.name;
    EXPECT_GT(outside, 20) << maker.name;
  }
}

// Every seam is shared: just beyond an internal face is another part. Just beyond all others is
// none, or a body that has sunk in would meet a step there; but for the shaft of an auger, which
// the blade stands on.
TEST(MachineParts, FacesAreSeamsWhollyOrNotAtAll) {
  for (const Maker& maker : makers()) {
    const Solid solid = maker.make();
    int seams = 0;
    for (const ConvexPart& part : solid.parts) {
      for (const auto& face : part.faces) {
        seams += face.internal;
        Vec3 middle = Vec3::Zero();
        for (int k = 0; k < face.count; ++k) {
          middle += part.vertex(part.face_vertices[face.first + k]) / face.count;
        }
        if (std::string(maker.name).ends_with("auger") && part.faces.size() > 48) continue;
        for (int k = 0; k < face.count; ++k) {
          const Vec3 corner = part.vertex(part.face_vertices[face.first + k]);
          for (const double inwards : {0.01, 0.5, 1.0}) {
            const Vec3 beyond = corner + inwards * (middle - corner) + 1e-6 * face.normal;
            EXPECT_EQ(height(solid.parts, beyond) < 0, face.internal) << maker.name;
          }
        }
      }
    }
    EXPECT_EQ(seams == 0, solid.parts.size() == 1) << maker.name;
  }
}

TEST(MachineParts, CupHoldsItsClosedForm) {
  const Container c;
  const double outer = c.diameter / 2 + c.wall / std::cos(pi / kCircle);
  const double exact =
      disc(outer, kCircle) * (c.height + c.floor) - disc(c.diameter / 2, kCircle) * c.height;
  EXPECT_NEAR(volume(make_container(c)), exact, 1e-9 * exact);
  // A round cup of the same wall: 48 corners hold 0.3 % less.
  const double r = c.diameter / 2, R = r + c.wall;
  const double round = pi * (R * R * (c.height + c.floor) - r * r * c.height);
  EXPECT_NEAR(volume(make_container(c)), round, 0.004 * round);
}

TEST(MachineParts, DrumHoldsItsClosedForm) {
  Drum d;
  const double R = d.diameter / 2 + d.wall, r = d.diameter / 2;
  const double exact = disc(R, kCircle) * (d.length + 2 * d.wall) - disc(r, kCircle) * d.length;
  EXPECT_NEAR(volume(make_drum(d)), exact, 1e-9 * exact);
  // Lifters are boxes on separate flats, less the gaps at their ends.
  d.lifters = 4;
  const double lifters = 4 * d.lifter_height * d.lifter_thickness * d.length * (1 - 2e-3);
  const double inside = pi * r * r * d.length - lifters;
  const double round = pi * R * R * (d.length + 2 * d.wall) - inside;
  EXPECT_NEAR(volume(make_drum(d)), round, 0.01 * round);
}

TEST(MachineParts, HelixHoldsItsClosedForm) {
  Auger a;
  a.turns = 3.5;
  const double shaft = a.pitch * a.turns + a.blade_thickness + 2 * a.overhang;
  const double r = a.shaft_diameter / 2, R = a.outer_diameter / 2;
  const double exact = disc(r, kCircle) * shaft +
                       (disc(R, kCircle) - disc(r, kCircle)) * a.blade_thickness * a.turns;
  EXPECT_NEAR(volume(make_auger(a)), exact, 1e-9 * exact);
  const double round = pi * r * r * shaft + pi * (R * R - r * r) * a.blade_thickness * a.turns;
  EXPECT_NEAR(volume(make_auger(a)), round, 0.003 * round);  // 2 pi^2 / (3 * 48^2)
  a.left_handed = true;
  EXPECT_NEAR(volume(make_auger(a)), exact, 1e-9 * exact);
}

// The blade's corners lie on the true helix; the middles of its triangles off it by no more than
// the flats of the circle.
TEST(MachineParts, BladeFollowsTheHelix) {
  const Auger a;
  for (const bool left : {false, true}) {
    Auger hand = a;
    hand.left_handed = left;
    const Solid solid = make_auger(hand);
    double worst = 0;
    for (const auto& t : solid.mesh.triangles) {
      const Vec3 &p = solid.mesh.vertices[t[0]], &q = solid.mesh.vertices[t[1]],
                 &r = solid.mesh.vertices[t[2]];
      const Vec3 middle = (p + q + r) / 3, n = (q - p).cross(r - p).normalized();
      const double radius = std::hypot(middle.y(), middle.z());
      if (radius < 0.6 * a.shaft_diameter || n.x() > -0.3) continue;  // the flank that faces back
      const double angle = std::atan2(left ? -middle.z() : middle.z(), middle.y());
      const double along = middle.x() - a.pitch * angle / (2 * pi);
      worst = std::max(worst, std::abs(along - a.pitch * std::round(along / a.pitch)));
    }
    EXPECT_GT(worst, 0);
    EXPECT_LT(worst, 0.2e-3);  // as docs/machine-parts.md states
  }
}

TEST(MachineParts, WireHoldsItsClosedForm) {
  const Wire w{4e-3, {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.05, 0}, {0.1, 0.05, 0.07}}};
  // Halved angles at the bends: the volume is that of the straight wire.
  const double exact = disc(2e-3, kWireCircle) * 0.22;
  EXPECT_NEAR(volume(make_wire(w)), exact, 1e-9 * exact);
  EXPECT_NEAR(volume(make_wire(w)), pi * 4e-6 * 0.22, 0.046 * pi * 4e-6 * 0.22);
}

TEST(MachineParts, BucketHoldsItsClosedForm) {
  Bucket b;
  b.draft = 0;
  b.back_height = b.front_height = 120e-3;
  const double outer = (b.length + 2 * b.wall) * (b.width + 2 * b.wall) * (120e-3 + b.wall);
  const double exact = outer - b.length * b.width * 120e-3;
  EXPECT_NEAR(volume(make_bucket(b)), exact, 1e-9 * exact);
  b.outlet = Bucket::Outlet::end;
  EXPECT_NEAR(volume(make_bucket(b)), exact - b.wall * b.outlet_width * b.outlet_height,
              1e-9 * exact);
  b.outlet = Bucket::Outlet::floor;
  EXPECT_NEAR(volume(make_bucket(b)), exact - b.wall * b.outlet_width * b.outlet_length,
              1e-9 * exact);
}

// A crescent at the water line, where it froze, is clear of the mold by the clearance, everywhere.
TEST(MachineParts, CavityIsTheCrescentWithItsClearance) {
  for (const char* name : {"mass-matched", "table1"}) {
    Mold m;
    m.cube = named_crescent(name, {}).parameters;
    const Solid solid = make_mold(m);
    const Vec3 place((m.cavities - 1) / 2.0 * m.pitch, 0, water_line(m.cube));
    double nearest = 1;
    for (const Vec3& v : crescent_mesh(m.cube).vertices) {
      // The chord lies across the row.
      nearest = std::min(nearest, height(solid.parts, Vec3(-v.y(), v.x(), v.z()) + place));
    }
    EXPECT_LT(nearest, m.clearance) << name;
    EXPECT_GT(nearest, 0.94 * m.clearance) << name;  // flats of the arc lie 0.05 mm inside
  }
}

// The ejector turns freely in the mold and between the fingers.
TEST(MachineParts, EjectorClearsMoldAndStripper) {
  const Solid mold = make_mold({}), stripper = make_stripper({}), ejector = make_ejector({});
  for (int degrees = 0; degrees < 360; degrees += 5) {
    const Mat3 turn = Eigen::AngleAxisd(degrees * kDegToRad, Vec3::UnitX()).toRotationMatrix();
    for (const Vec3& v : ejector.mesh.vertices) {
      EXPECT_GT(height(mold.parts, turn * v), 1e-3);
      EXPECT_GT(height(stripper.parts, turn * v), 1e-3);
    }
  }
}

template <class Make>
std::string refusal(Make make) {
  try {
    make();
  } catch (const DimensionError& error) {
    EXPECT_THAT(error.message, HasSubstr("expected"));
    return error.key;
  }
  return "accepted";
}

TEST(MachineParts, ImpossibleDimensionsAreRefusedByTheirKey) {
  EXPECT_EQ(refusal([] { make_auger({.outer_diameter = 0.01, .shaft_diameter = 0.02}); }),
            "shaft_diameter");
  EXPECT_EQ(refusal([] { make_auger({.turns = 1.01}); }), "turns");
  EXPECT_EQ(refusal([] { make_auger({.pitch = 2e-3}); }), "blade_thickness");
  EXPECT_EQ(refusal([] { make_stripper({.finger_width = 0.03}); }), "finger_width");
  EXPECT_EQ(refusal([] { make_ejector({.tip_radius = 4e-3}); }), "tip_radius");
  EXPECT_EQ(refusal([] { make_ejector({.shaft_length = 0.1}); }), "shaft_length");
  Mold steep;
  steep.cube.draft = 40 * kDegToRad;
  EXPECT_EQ(refusal([&] { make_mold(steep); }), "draft");
  EXPECT_EQ(refusal([] { make_mold({.pitch = 22e-3}); }), "pitch");
  EXPECT_EQ(refusal([] { make_mold({.freeboard = 25e-3}); }), "freeboard");
  EXPECT_EQ(refusal([] { make_wire({3e-3, {Vec3::Zero()}}); }), "points");
  EXPECT_EQ(refusal([] { make_wire({3e-3, {{0, 0, 0}, {0.01, 0, 0}, {0, 1e-4, 0}}}); }), "points");
  EXPECT_EQ(refusal([] { make_wire_auger({.pitch = 5e-3}); }), "pitch");
  EXPECT_EQ(refusal([] { make_bucket({.trough_radius = 0.2}); }), "trough_radius");
  EXPECT_EQ(refusal([] { make_bucket({.back_height = 0.03, .trough_radius = 0.05}); }),
            "back_height");
  Bucket open;
  open.outlet = Bucket::Outlet::end;
  open.outlet_height = 0.13;
  EXPECT_EQ(refusal([&] { make_bucket(open); }), "outlet_height");
  open.outlet_width = 0.2;
  EXPECT_EQ(refusal([&] { make_bucket(open); }), "outlet_width");
  EXPECT_EQ(refusal([] { make_trough({.angle = 200 * kDegToRad}); }), "angle");
  EXPECT_EQ(refusal([] { make_chute({.length = 0.04, .bend = 1.5}); }), "bend");
  EXPECT_EQ(refusal([] { make_drum({.lifters = 8, .lifter_height = 0.2}); }), "lifter_height");
  EXPECT_EQ(refusal([] { make_drum({.lifters = 100, .lifter_thickness = 0.02}); }),
            "lifter_thickness");
  EXPECT_EQ(refusal([] { make_container({.wall = 0}); }), "wall");
  EXPECT_EQ(refusal([] { make_trap_door_box({.door_length = 1}); }), "door_length");
}

}  // namespace
}  // namespace firn
