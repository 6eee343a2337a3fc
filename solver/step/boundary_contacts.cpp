// Phase: contacts of boundaries with each other. There are few, so that they go one after the other
// through the functions that the batches of particle contacts are made of: the same search, the
// same patches with their memory, the same force law.
#include "solver/step/boundary_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solver/contact/surface_contacts.h"
#include "solver/state/workspace.h"

namespace firn {

namespace {

using RotationMap = Eigen::Map<const Mat3>;

struct Bodies {
  std::size_t a, b;  // boundaries
  int body_a, body_b;
  Pose pose;  // of b in a
};

Bodies bodies_of(const Model& model, const State& s, const BoundaryContact& contact) {
  const int n = static_cast<int>(model.particles.size());
  return {static_cast<std::size_t>(contact.a), static_cast<std::size_t>(contact.b), n + contact.a,
          n + contact.b, relative_pose(s, n + contact.a, n + contact.b)};
}

// A bound on how far any two points of the bodies have moved against each other since the last
// search, and on how far directions and arms in world axes have aged by the turning of a, m.
double moved_since(const BoundaryContactTable& table, const BoundaryContactHistory& memory,
                   const Pose& pose, const Mat3& rotation_a) {
  const auto chord = [](const Mat3& change) { return change.norm() / std::sqrt(2.0); };
  const RotationMap before(memory.rotation);
  const Vec3 place = Eigen::Map<const Vec3>(memory.translation);
  Mat3 turn = pose.rotation - before;
  Vec3 shift = turn * table.center + pose.translation - place;
  if (table.smaller_is_a) {
    turn.transposeInPlace();
    shift = turn * table.center -
            (pose.rotation.transpose() * pose.translation - before.transpose() * place);
  }
  const double aged = chord(rotation_a - RotationMap(memory.rotation_a)) * table.reach_a;
  return std::max(shift.norm() + chord(turn) * table.radius, aged);
}

// Adds what touches to `contacts`, and returns the least gap; a lower bound, if nothing touches.
double collide_all(const BoundaryContactTable& table, const Pose& pose,
                   std::vector<PartContact>& contacts, std::size_t& used) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](int a, int b, const auto& collide_them) {
    if (contacts.size() == used) contacts.emplace_back();
    PartContact& c = contacts[used];
    c.a = a;
    c.b = b;
    c.other_a = c.other_b = 0;
    c.radius_a = table.parts_a[static_cast<std::size_t>(a)].radius;
    c.radius_b = table.parts_b.empty() ? 0 : table.parts_b[static_cast<std::size_t>(b)].radius;
    collide_them(c.manifold);
    used += c.manifold.points.empty() ? 0 : 1;
    least = std::min(least, c.manifold.gap);
  };
  const double contact_margin = table.law.contact_margin;
  for (std::size_t i = 0; i < table.parts_a.size(); ++i) {
    const ConvexPart& part = table.parts_a[i];
    if (table.parts_b.empty()) {
      const Vec3 normal = pose.rotation.col(2);
      const double offset = normal.dot(pose.translation);
      if (normal.dot(part.center) - part.bounding_radius - offset >=
          std::max(least, contact_margin))
        continue;
      take(static_cast<int>(i), 0,
           [&](Manifold& m) { collide_plane(part, normal, offset, contact_margin, m); });
      continue;
    }
    for (std::size_t k = 0; k < table.parts_b.size(); ++k) {
      const ConvexPart& other = table.parts_b[k];
      const double apart =
          (pose * other.center - part.center).norm() - part.bounding_radius - other.bounding_radius;
      if (apart >= std::max(least, contact_margin)) continue;
      take(static_cast<int>(i), static_cast<int>(k), [&](Manifold& m) {
        GjkCache cold;
        collide(part, other, pose, contact_margin, cold, m);
      });
    }
  }
  if (!table.surfaces_a.empty() || !table.surfaces_b.empty()) {
    used = join_surface_contacts({table.parts_a, table.parts_b, table.surfaces_a, table.surfaces_b,
                                  pose, pose.rotation.col(2).dot(pose.translation), contact_margin},
                                 contacts, used);
  }
  return least;
}

void fill_motion(const State& s, const Bodies& bodies, double dt, PatchInput& in) {
  const BodyMotion &a = s.motion[bodies.body_a], &b = s.motion[bodies.body_b];
  const Vec3 apart = a.position - b.position, closing = a.velocity - b.velocity;
  in.velocity = closing - b.angular_velocity.cross(apart);
  in.velocity_before = closing - b.angular_velocity.cross(apart - dt * closing);
  in.angular_velocity = a.angular_velocity - b.angular_velocity;
  in.dt = dt;
}

[[noreturn]] void refuse(const Model& model, const State& s, const BoundaryContact& contact,
                         const std::string& what, const Vec3& place) {
  const Vec3 p = 1e3 * place;
  throw RunError(fmt::format(
      "boundary \"{}\" {} boundary \"{}\" at {:.6g} s near ({:.1f} {:.1f} {:.1f}) mm",
      model.boundaries[static_cast<std::size_t>(contact.a)].name, what,
      model.boundaries[static_cast<std::size_t>(contact.b)].name, s.time, p.x(), p.y(), p.z()));
}

// A contact is certain only while the bodies move less in a step than they may overlap.
void check_speed(const Model& model, const State& s, const BoundaryContact& contact,
                 const BoundaryContactTable& table, const Bodies& bodies) {
  const BodyMotion &a = s.motion[bodies.body_a], &b = s.motion[bodies.body_b];
  const int smaller = table.smaller_is_a ? bodies.body_a : bodies.body_b;
  const Vec3 center = s.motion[smaller].position + rotation_of(s, smaller) * table.center;
  const Vec3 velocity = a.velocity + a.angular_velocity.cross(center - a.position) - b.velocity -
                        b.angular_velocity.cross(center - b.position);
  const double travel =
      (velocity.norm() + (a.angular_velocity - b.angular_velocity).norm() * table.radius) *
      model.timestep;
  if (travel > table.law.overlap_limit)
    refuse(model, s, contact,
           fmt::format("moves {:.4g} m in a step, more than the {:.4g} m that it may overlap,",
                       travel, table.law.overlap_limit),
           center);
}

// Updates the patches of a contact from those at `old_patches`, whose points are `old_points`.
void search(const Model& model, const State& s, const BoundaryContactTable& table,
            const Bodies& bodies, std::span<const ContactPatch> old_patches,
            const ContactPoint* old_points, Workspace& w, BoundaryContactHistory& memory) {
  TaskScratch& scratch = w.boundary_scratch;
  std::size_t used = 0;
  memory.gap = collide_all(table, bodies.pose, scratch.contacts, used);
  const Mat3 rotation_a = rotation_of(s, bodies.body_a);
  w.boundary_details.assign(old_patches.size(), {});
  PatchInput in{table.law, rotation_a,  {scratch.contacts.data(), used}, table.connected,
                {},        old_patches, w.boundary_details.data(),       old_points};
  fill_motion(s, bodies, model.timestep, in);
  build_patches(in, scratch.patches, scratch.search.found);
  memory.test_distance =
      used > 0 ? table.law.contact_update_distance
               : std::max(memory.gap - table.law.contact_margin, table.law.contact_update_distance);
  Eigen::Map<Mat3>(memory.rotation_a) = rotation_a;
  Eigen::Map<Mat3>(memory.rotation) = bodies.pose.rotation;
  Eigen::Map<Vec3>(memory.translation) = bodies.pose.translation;
}

// Advances the patches of a contact by the step and puts what they do on both boundaries.
void apply(const Model& model, State& s, const BoundaryContact& contact,
           const BoundaryContactTable& table, const Bodies& bodies, std::span<ContactPatch> patches,
           ContactPoint* points, BoundaryContactHistory& memory) {
  const double dt = model.timestep;
  const PairCoefficients& law = table.law;
  const FrictionLaw friction{law.tangential_stiffness, law.static_friction, law.dynamic_friction,
                             law.restick_velocity};
  const BodyMotion &a = s.motion[bodies.body_a], &b = s.motion[bodies.body_b];
  const Vec3 apart = a.position - b.position,
             angular_velocity = a.angular_velocity - b.angular_velocity;
  const Vec3 velocity = a.velocity - b.velocity - b.angular_velocity.cross(apart);
  Vec3 force = Vec3::Zero(), moment_a = Vec3::Zero(), moment_b = Vec3::Zero();
  double normal = 0;
  for (ContactPatch& patch : patches) {
    const PatchMotion motion =
        patch_motion(to_vec(patch.normal), to_vec(velocity + angular_velocity.cross(patch.arm)),
                     to_vec(angular_velocity), dt);
    const NormalLoad load = advance_points(law, patch, points + patch.first_point, motion);
    if (load.overlap > law.overlap_limit)
      refuse(model, s, contact,
             fmt::format("overlaps by {:.4g} m, beyond the limit of {:.4g} m,", load.overlap,
                         law.overlap_limit),
             a.position + patch.arm);
    const FrictionStep step =
        advance_friction(friction, {to_vec(patch.tangential), patch.torsion, double(patch.sliding)},
                         load.force, friction_region(patch), motion, dt);
    patch.gap_is_current = 0;
    patch.normal_force = load.force;
    patch.tangential = to_eigen(step.state.tangential);
    patch.torsion = step.state.torsion;
    patch.sliding = step.state.sliding > 0 ? 1 : 0;
    memory.work_normal += load.work;
    memory.work_friction += step.work;
    const Wrench on_a = wrench(to_vec(patch.normal), load.force, load.offset_force, step.state);
    const Vec3 push = to_eigen(on_a.force), turn = to_eigen(on_a.moment);
    force += push;
    moment_a += turn + patch.arm.cross(push);
    moment_b -= turn + (patch.arm + apart).cross(push);
    normal += load.force;
  }
  memory.force = force;
  memory.moment_a = moment_a;
  memory.moment_b = moment_b;
  memory.impulse += force * dt;
  memory.peak_normal_force = std::max(memory.peak_normal_force, normal);
  const auto add = [&](std::size_t boundary, const Vec3& f, const Vec3& moment) {
    s.boundary_load[boundary].force += f;
    s.boundary_load[boundary].torque += moment;
    s.boundary_impulse[boundary] += f * dt;
    s.boundary_angular_impulse[boundary] += moment * dt;
    s.boundary_peak[boundary] = std::max(s.boundary_peak[boundary], normal);
  };
  add(bodies.a, force, moment_a);
  add(bodies.b, -force, moment_b);
}

}  // namespace

void boundary_contacts(const Model& model, Workspace& w, State& s) {
  std::vector<ContactPatch>& patches = w.boundary_patches;
  std::vector<ContactPoint>& points = w.boundary_points;
  patches.clear();
  points.clear();
  std::size_t first_patch = 0, first_point = 0;  // in the state
  for (std::size_t k = 0; k < model.boundary_contacts.size(); ++k) {
    const BoundaryContact& contact = model.boundary_contacts[k];
    const BoundaryContactTable& table = w.boundary_contacts[k];
    BoundaryContactHistory& memory = s.boundary_contacts[k];
    const std::span<const ContactPatch> old_patches(s.boundary_patches.data() + first_patch,
                                                    memory.patch_count);
    const ContactPoint* old_points = s.boundary_points.data() + first_point;
    first_patch += memory.patch_count;
    first_point += memory.point_count;
    const auto present = [&](int b) {
      return s.boundary_present[static_cast<std::size_t>(b)] != 0;
    };
    const bool acts = present(contact.a) && present(contact.b);
    // The load of the last step acts on both boundaries in the first half of this one.
    if (!acts) memory.work_normal -= 0.5 * model.timestep * boundary_contact_power(model, s, k);
    memory.force.setZero();
    memory.moment_a.setZero();
    memory.moment_b.setZero();
    if (!acts) {
      memory.patch_count = memory.point_count = 0;
      memory.test_distance = -1;
      continue;
    }
    const Bodies bodies = bodies_of(model, s, contact);
    check_speed(model, s, contact, table, bodies);
    const std::size_t patches_before = patches.size(), points_before = points.size();
    const double moved = moved_since(table, memory, bodies.pose, rotation_of(s, bodies.body_a));
    if (memory.test_distance < 0 || moved >= memory.test_distance) {
      search(model, s, table, bodies, old_patches, old_points, w, memory);
      const PatchBuffer& found = w.boundary_scratch.search.found;
      patches.insert(patches.end(), found.patches.begin(), found.patches.end());
      points.insert(points.end(), found.points.begin(), found.points.end());
      memory.patch_count = found.patches.size();
      memory.point_count = found.points.size();
    } else {
      patches.insert(patches.end(), old_patches.begin(), old_patches.end());
      points.insert(points.end(), old_points, old_points + memory.point_count);
    }
    apply(model, s, contact, table, bodies,
          {patches.data() + patches_before, static_cast<std::size_t>(memory.patch_count)},
          points.data() + points_before, memory);
  }
  std::swap(s.boundary_patches, patches);
  std::swap(s.boundary_points, points);
}

double boundary_contact_power(const Model& model, const State& s, std::size_t number) {
  const BoundaryContact& contact = model.boundary_contacts[number];
  const BoundaryContactHistory& memory = s.boundary_contacts[number];
  const std::size_t n = model.particles.size();
  const BodyMotion &a = s.motion[n + index(contact.a)], &b = s.motion[n + index(contact.b)];
  return memory.force.dot(a.velocity - b.velocity) + memory.moment_a.dot(a.angular_velocity) +
         memory.moment_b.dot(b.angular_velocity);
}

BoundaryContactState boundary_contact_state(const Workspace& w, const State& s,
                                            std::size_t number) {
  const BoundaryContactHistory& memory = s.boundary_contacts[number];
  const PairCoefficients& law = w.boundary_contacts[number].law;
  std::size_t first_patch = 0, first_point = 0;
  for (std::size_t k = 0; k < number; ++k) {
    first_patch += s.boundary_contacts[k].patch_count;
    first_point += s.boundary_contacts[k].point_count;
  }
  BoundaryContactState out;
  out.gap = memory.patch_count > 0 ? std::numeric_limits<double>::infinity() : memory.gap;
  out.force = memory.force;
  out.impulse = memory.impulse;
  out.peak_normal_force = memory.peak_normal_force;
  StoredEnergy stored;
  for (std::size_t k = first_patch; k < first_patch + memory.patch_count; ++k) {
    const ContactPatch& patch = s.boundary_patches[k];
    const ContactPoint* points = s.boundary_points.data() + first_point + patch.first_point;
    for (std::uint32_t i = 0; i < patch.point_count; ++i)
      out.gap = std::min(out.gap, points[i].gap);
    const StoredEnergy one = stored_energy(law, patch, Vec3::Zero(), points);
    stored.normal += one.normal;
    stored.friction += one.friction;
    out.normal_force += patch.normal_force;
    out.patches += patch.normal_force > 0 ? 1 : 0;
    out.sliding += patch.normal_force > 0 && patch.sliding ? 1 : 0;
  }
  out.elastic = stored.normal + stored.friction;
  out.dissipated_normal = memory.work_normal - stored.normal;
  out.dissipated_friction = memory.work_friction - stored.friction;
  return out;
}

}  // namespace firn
