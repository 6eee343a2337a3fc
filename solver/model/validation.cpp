#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "firn/model.h"
#include "solver/dynamics/free_body.h"
#include "solver/dynamics/mechanism.h"
#include "solver/model/bond_checks.h"
#include "solver/model/used_shapes.h"

namespace firn {

namespace {

double in_series(double k1, double k2) { return k1 * k2 / (k1 + k2); }

void check_interaction(const Interaction& law, const std::string& where) {
  const auto fail = [&](const std::string& what) { throw InputError(where + ": " + what); };
  if (!(law.restitution > 0 && law.restitution <= 1)) {
    fail(fmt::format("restitution is {}; expected a number above 0 and up to 1", law.restitution));
  }
  if (!(law.dynamic_friction >= 0)) fail("dynamic friction is negative; expected 0 or more");
  if (law.static_friction < law.dynamic_friction) {
    fail(fmt::format("static friction {} is below dynamic friction {}; expected at least as much",
                     law.static_friction, law.dynamic_friction));
  }
  if (!(law.tangential_stiffness_ratio > 0)) fail("tangential stiffness ratio must be above 0");
  if (!(law.minimum_unloading_ratio >= 0 && law.minimum_unloading_ratio < 1)) {
    fail("unloading floor must be at least 0 and below 1");
  }
  if (!(law.rolling_resistance >= 0)) fail("rolling resistance is negative; expected 0 or more");
  if (!(law.restick_velocity >= 0)) fail("sliding speed is negative; expected 0 or more");
  if (!(law.adhesion_force >= 0)) fail("adhesion force is negative; expected 0 or more");
  if (!(law.adhesion_stiffness_fraction >= 0 && law.adhesion_stiffness_fraction < 1))
    fail("adhesion stiffness fraction must be at least 0 and below 1");
  if ((law.adhesion_force > 0 || law.adhesion_stiffness_fraction > 0) &&
      law.minimum_unloading_ratio == 0)
    fail("adhesion acts only with a contact force; expected an unloading floor above 0 with it");
}

void check_interaction(const Model& model, int a, int b) {
  check_interaction(model.interaction(a, b),
                    "interactions." + model.materials[a].name + "-" + model.materials[b].name);
}

void check_free_body(const MotionFrame& frame) {
  const auto fail = [&](const std::string& what) {
    throw InputError("motion_frames." + frame.name + ": " + what);
  };
  const FreeBody& body = *frame.free;
  const auto rotations = std::ranges::count(body.joints, Joint::Kind::rotation, &Joint::kind);
  if (body.joints.empty() && !body.free_rotation) fail("is free, but has no joint to move along");
  if (rotations + (body.free_rotation ? 1 : 0) > 1)
    fail("turns about more than one axis; expected one rotation, or free turning about all");
  if (body.joints.size() + (body.free_rotation ? 3 : 0) > kMaxJoints)
    fail(fmt::format("has {} axes; expected at most {}", body.joints.size(),
                     kMaxJoints - (body.free_rotation ? 3 : 0)));
  if (!(body.mass > 0) || !body.inertia.allFinite()) fail("is free, but has no mass or inertia");
  if (!(min_effective_mass(body, frame.origin, body.center - frame.origin) > 0))
    fail(
        "cannot be moved along its axes by finite forces: two of them are the same, or mass or "
        "inertia is zero there");
  if (!frame.motions.empty())
    fail("is free and has motions; expected one of the two, or motors of its joints");
}

void check_frames(const Model& model) {
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const MotionFrame& frame = model.frames[f];
    if (frame.parent >= static_cast<int>(f))
      throw InputError("motion_frames." + frame.name +
                       ": has a parent that is listed later; expected an earlier one");
    if (frame.free) check_free_body(frame);
    const int above = free_frame(model.frames, frame.parent);
    if (above >= 0 && !frame.motions.empty())
      throw InputError(
          fmt::format("motion_frames.{}: has motions on the free frame \"{}\"; expected "
                      "it to be fixed there, or to be free with motors of its joints",
                      frame.name, model.frames[static_cast<std::size_t>(above)].name));
  }
}

void check_coupling_friction(const Coupling& c) {
  const auto fail = [&](const std::string& what) {
    throw InputError("couplings." + c.name + ": " + what);
  };
  using Kind = Coupling::Kind;
  if (!(c.friction >= 0) || !(c.friction_coefficient >= 0))
    fail("has a negative friction; expected at least 0");
  if (c.has_friction() && (c.ties_joints() || c.kind == Kind::weld))
    fail("has friction without a pin or slot; expected a ball, hinge or slot");
  if (c.friction_coefficient > 0 && c.kind != Kind::slot && !(c.bearing_radius > 0))
    fail("has a friction coefficient without a bearing radius; expected both");
}

void check_couplings(const Model& model) {
  const int frames = static_cast<int>(model.frames.size());
  for (const Coupling& c : model.couplings) {
    const auto fail = [&](const std::string& what) {
      throw InputError("couplings." + c.name + ": " + what);
    };
    if (c.a < -1 || c.b < -1 || c.a >= frames || c.b >= frames)
      fail("ties frames that do not exist");
    check_coupling_friction(c);
    if (!c.ties_joints()) continue;
    const auto has_joint = [&](int frame, int joint) {
      if (frame < 0 || !model.frames[static_cast<std::size_t>(frame)].free) return false;
      const auto& joints = model.frames[static_cast<std::size_t>(frame)].free->joints;
      return joint >= 0 && joint < static_cast<int>(joints.size());
    };
    if (!has_joint(c.a, c.joint_a) || !has_joint(c.b, c.joint_b))
      fail("ties a joint that does not exist; expected joints of free motion frames");
    if (c.kind == Coupling::Kind::cam && (c.angles.size() < 4 || c.angles.size() != c.lifts.size()))
      fail("has fewer than four angles, or not as many lifts");
  }
  // Their constructors check the rest.
  for (MechanismMembers& members : find_mechanisms(model.frames, model.couplings))
    Mechanism(model.frames, model.couplings, std::move(members));
}

}  // namespace

double particle_pair_stiffness(const Shape& a, const Shape& b) {
  return in_series(a.stiffness, b.stiffness);
}

double boundary_pair_stiffness(const Model& model, const Shape& a, const Boundary& b) {
  if (b.rigid) return a.stiffness;
  const double wall = b.stiffness > 0
                          ? b.stiffness
                          : model.materials[b.material].young_modulus * a.stiffness_length;
  return in_series(a.stiffness, wall);
}

namespace {

void check_boundary_contacts(const Model& model) {
  const int boundaries = static_cast<int>(model.boundaries.size());
  for (const BoundaryContact& c : model.boundary_contacts) {
    const std::string where = "boundary_contacts." + c.name;
    const auto fail = [&](const std::string& what) { throw InputError(where + ": " + what); };
    if (c.a < 0 || c.b < 0 || c.a >= boundaries || c.b >= boundaries || c.a == c.b)
      fail("joins boundaries that do not exist, or one with itself");
    const Boundary& a = model.boundaries[static_cast<std::size_t>(c.a)];
    const Boundary& b = model.boundaries[static_cast<std::size_t>(c.b)];
    if (a.kind != Boundary::Kind::solid) fail("joins two planes; expected a solid first");
    const int free_a = free_frame(model.frames, a.frame),
              free_b = free_frame(model.frames, b.frame);
    if (free_a == free_b)
      fail(fmt::format(
          "\"{}\" and \"{}\" {}; expected a free motion frame that carries one of "
          "them",
          a.name, b.name, free_a < 0 ? "both move as prescribed" : "are fixed to the same frame"));
    if (!(c.stiffness > 0)) fail("stiffness is not positive");
    if (!(c.rounding > 0)) fail("rounding is not positive");
    check_interaction(c.law, where);
  }
}

// What read them has seen to the rest.
void check_statistics(const Model& model) {
  const StatisticsOptions& options = model.statistics;
  for (const MonitoredBoundary& monitored : options.monitored) {
    if (monitored.boundary < 0 || monitored.boundary >= static_cast<int>(model.boundaries.size()) ||
        monitored.mesh.triangles.empty())
      throw InputError("statistics: a monitored boundary has no triangles, or does not exist");
  }
  if (!options.surfaces.empty() && options.surfaces.size() != model.shapes.size())
    throw InputError("statistics: expected a surface for every shape, or none");
  for (const TriangleMesh& surface : options.surfaces)
    if (surface.triangles.empty()) throw InputError("statistics: a surface has no triangles");
  if (options.energies.count() > 0 && !(options.energies.lowest > 0))
    throw InputError("statistics: the lowest energy is not positive");
}

}  // namespace

void validate(const Model& model) {
  const std::size_t m = model.materials.size();
  if (model.interactions.size() != m * m) {
    throw InputError(fmt::format("interactions: {} given for {} materials; expected {}",
                                 model.interactions.size(), m, m * m));
  }
  if (!(model.timestep > 0) || !std::isfinite(model.timestep)) {
    throw InputError(fmt::format("timestep is {} s; expected a positive time", model.timestep));
  }
  if (!model.gravity.allFinite()) throw InputError("gravity is not finite");
  for (const Shape& s : model.shapes) {
    if (!(s.mass > 0) || !(s.inertia.minCoeff() > 0)) {
      throw InputError("shapes." + s.name + ": mass or inertia is not positive");
    }
    if (!(s.stiffness > 0)) throw InputError("shapes." + s.name + ": stiffness is not positive");
    if (s.parts.empty()) throw InputError("shapes." + s.name + ": has no parts to touch with");
  }
  check_frames(model);
  check_couplings(model);
  check_boundary_contacts(model);
  check_bonds(model);
  check_statistics(model);
  const std::vector<char> used = used_shapes(model);
  for (std::size_t i = 0; i < model.shapes.size(); ++i) {
    if (!used[i]) continue;
    for (std::size_t j = 0; j < model.shapes.size(); ++j) {
      if (used[j]) check_interaction(model, model.shapes[i].material, model.shapes[j].material);
    }
    for (const Boundary& b : model.boundaries) {
      check_interaction(model, model.shapes[i].material, b.material);
      if (!(boundary_pair_stiffness(model, model.shapes[i], b) > 0)) {
        throw InputError(
            "boundaries." + b.name +
            ": has no stiffness; expected a Young's modulus, a stiffness or rigid = true");
      }
    }
  }
}

}  // namespace firn
