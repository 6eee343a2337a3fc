#include "solver/state/snapshot.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "firn/word_hash.h"
#include "solver/state/contact_statistics_state.h"

namespace firn {

namespace {

constexpr std::uint64_t kMagic = 0x4e5249460000000c;  // "FIRN" and the layout's version

// The same walk over the state writes and reads it.
class Writer {
 public:
  void group(const char*) {}
  template <class T>
  void value(const T& v) {
    const auto* p = reinterpret_cast<const std::byte*>(&v);
    bytes.insert(bytes.end(), p, p + sizeof(T));
  }
  template <class T, class Memory>
  void array(const std::vector<T, Memory>& v) {
    value<std::uint64_t>(v.size());
    const auto* p = reinterpret_cast<const std::byte*>(v.data());
    bytes.insert(bytes.end(), p, p + v.size() * sizeof(T));
  }
  std::vector<std::byte> bytes;
};

class Reader {
 public:
  explicit Reader(const std::vector<std::byte>& b) : bytes_(b) {}
  void group(const char*) {}
  template <class T>
  void value(T& v) {
    take(&v, sizeof(T));
  }
  template <class T, class Memory>
  void array(std::vector<T, Memory>& v) {
    std::uint64_t n = 0;
    value(n);
    if (n > (bytes_.size() - at_) / sizeof(T)) throw RunError("checkpoint is cut short");
    v.resize(n);
    take(v.data(), n * sizeof(T));
  }
  bool done() const { return at_ == bytes_.size(); }

 private:
  void take(void* to, std::size_t n) {
    if (n > bytes_.size() - at_) throw RunError("checkpoint is cut short");
    if (n > 0) std::memcpy(to, bytes_.data() + at_, n);
    at_ += n;
  }
  const std::vector<std::byte>& bytes_;
  std::size_t at_ = 0;
};

// Neither writes nor reads: hashes what belongs to each group.
class Hasher {
 public:
  void group(const char* name) { groups.push_back({name, kWordHashStart}); }
  template <class T>
  void value(const T& v) {
    mix(&v, sizeof(T));
  }
  template <class T, class Memory>
  void array(const std::vector<T, Memory>& v) {
    value<std::uint64_t>(v.size());
    mix(v.data(), v.size() * sizeof(T));
  }
  std::vector<GroupHash> groups;

 private:
  void mix(const void* from, std::size_t n) {
    groups.back().hash = hash_words(groups.back().hash, from, n);
  }
};

template <class Archive, class S>
void walk(Archive& ar, S& s) {
  ar.group("time");
  ar.value(s.time);
  ar.value(s.steps);
  ar.group("positions and velocities");
  ar.array(s.motion);
  ar.group("orientations");
  ar.array(s.orientation);
  ar.group("angular momenta");
  ar.array(s.angular_momentum);
  ar.group("contact loads");
  ar.array(s.load);
  ar.group("motion bounds");
  ar.array(s.translation_bound);
  ar.array(s.rotation_bound);
  ar.array(s.skin);
  ar.array(s.rebuild_distance);
  ar.group("presence and peaks");
  ar.array(s.presence);
  ar.array(s.peak_normal_force);
  ar.group("boundary loads");
  ar.array(s.boundary_present);
  ar.array(s.boundary_impulse);
  ar.array(s.boundary_angular_impulse);
  ar.array(s.boundary_peak);
  ar.array(s.boundary_load);
  ar.group("motion frames");
  ar.array(s.frames);
  ar.array(s.frame_position);
  ar.array(s.frame_orientation);
  ar.array(s.boundary_position);
  ar.array(s.boundary_orientation);
  ar.array(s.joint_reactions);
  ar.array(s.couplings);
  ar.group("boundary contacts");
  ar.array(s.boundary_contacts);
  ar.array(s.boundary_patches);
  ar.array(s.boundary_points);
  ar.group("neighbor list");
  ar.value(s.neighbor_list_invalid);
  ar.array(s.pairs);
  ar.group("pair motion bounds");
  ar.array(s.next_test_distance);
  ar.array(s.motion_bound);
  ar.group("pairs of parts");
  ar.array(s.part_pairs);
  ar.group("patches");
  ar.array(s.patches);
  ar.array(s.patch_details);
  ar.group("contact points");
  ar.array(s.points);
  ar.group("bonds");
  ar.array(s.bonds);
  ar.array(s.bond_loads);
  ar.group("energy accounts");
  ar.value(s.work_normal);
  ar.value(s.work_friction);
  ar.value(s.work_boundaries);
  ar.value(s.boundary_work);
  ar.value(s.removed_energy);
  ar.value(s.lost_in_bonds);
  ar.value(s.free_bodies);
  ar.value(s.lowest_energy);
  ar.value(s.largest_kinetic);
  ar.value(s.energy_known);
  ar.group("diagnostics");
  ar.value(s.diagnostics.largest_overlap);
  ar.value(s.diagnostics.largest_overlap_particle);
  ar.value(s.diagnostics.late_contacts);
  ar.value(s.diagnostics.unconverged_steps);
  ar.value(s.diagnostics.energy_error);
  ar.value(s.diagnostics.rebuilds);
  ar.value(s.diagnostics.queries);
  ar.value(s.diagnostics.contact_searches);
  ar.group("statistics");
  ar.value(s.statistics.recording);
  ar.value(s.statistics.list);
  ar.array(s.statistics.open_of_pair);
  ar.array(s.statistics.open);
  ar.array(s.statistics.sums);
  ar.array(s.statistics.parted);
  ar.value(s.statistics.free_places);
  ar.array(s.statistics.surfaces);
  ar.array(s.statistics.energies);
  ar.array(s.statistics.opposed);
  ar.array(s.statistics.triangles);
  ar.value(s.statistics.interval_start);
  ar.array(s.statistics.triangle_of_point);
  ar.value(s.statistics.points_list);
  ar.group("stage motions");
  ar.array(s.stage_motion_mover);
  ar.array(s.stage_motion_group);
  ar.array(s.stage_motor_joint);
  ar.array(s.stage_motor_group);
}

// Finished events and intervals that the caller has not taken yet. They are not part of the hash:
// they depend on when the caller takes them and do not affect the next steps.
template <class Archive, class S>
void walk_finished(Archive& ar, S& s) {
  ar.array(s.statistics.finished);
  ar.array(s.statistics.finished_intervals);
  ar.array(s.statistics.finished_triangles);
}

// Motions and motors have padding, so their fields go one by one.
template <class Archive, class S>
void walk_schedule(Archive& ar, S& s) {
  ar.value(s.start);
  ar.value(s.stop);
  ar.value(s.period);
  ar.value(s.end);
}
template <class Archive, class M>
void walk_motion(Archive& ar, M& m) {
  walk_schedule(ar, m);
  ar.value(m.kind);
  ar.value(m.profile);
  ar.value(m.velocity);
  ar.value(m.axis);
  ar.value(m.center);
  ar.value(m.angular_speed);
  for (auto* v : {&m.rate, &m.end_rate, &m.ramp_time, &m.amplitude, &m.frequency, &m.phase})
    ar.value(*v);
  ar.array(m.times);
  ar.array(m.positions);
}
template <class Archive, class D>
void walk_drive(Archive& ar, D& d) {
  walk_schedule(ar, d);
  ar.value(d.speed);
  ar.value(d.max_load);
  ar.value(d.no_load_speed);
  double target = d.target.value_or(std::numeric_limits<double>::quiet_NaN());
  ar.value(target);
  if constexpr (!std::is_const_v<D>) {
    d.target.reset();
    if (!std::isnan(target)) d.target = target;
  }
}
template <class Archive, class S>
void walk_started(Archive& ar, S& s) {
  for (auto& m : s.stage_motions) walk_motion(ar, m);
  for (auto& d : s.stage_motors) walk_drive(ar, d);
}

// What must agree between the model that made a state and the one that takes it up.
std::vector<double> fingerprint(const Model& model) {
  std::vector<double> f = {model.timestep,
                           model.gravity.x(),
                           model.gravity.y(),
                           model.gravity.z(),
                           double(model.particles.size()),
                           double(model.boundaries.size()),
                           double(model.frames.size()),
                           double(model.couplings.size()),
                           model.numerics.contact_margin,
                           model.numerics.contact_margin_limit,
                           model.numerics.contact_update_fraction,
                           model.numerics.skin};
  for (const Interaction& i : model.interactions) {
    f.insert(f.end(),
             {i.static_friction, i.dynamic_friction, i.restitution, i.tangential_stiffness_ratio,
              i.minimum_unloading_ratio, i.rolling_resistance, i.restick_velocity, i.adhesion_force,
              i.adhesion_stiffness_fraction});
  }
  for (const BoundaryContact& c : model.boundary_contacts) {
    f.insert(f.end(), {double(c.a), double(c.b), c.stiffness, c.rounding, c.law.static_friction,
                       c.law.dynamic_friction, c.law.restitution, c.law.tangential_stiffness_ratio,
                       c.law.minimum_unloading_ratio, c.law.restick_velocity});
  }
  for (const BeamLaw& b : model.beams) {
    f.insert(f.end(), {b.section.area, b.length, b.young_modulus, b.shear_modulus,
                       b.tensile_strength, b.shear_strength, b.damping_ratio, b.lifetime});
  }
  for (const Bond& b : model.bonds) f.insert(f.end(), {double(b.a), double(b.b), double(b.law)});
  for (const Shape& s : model.shapes) {
    f.insert(f.end(), {s.mass, s.volume, s.stiffness, s.rounding, double(s.parts.size())});
  }
  return f;
}

// A saved state without statistics, or with some that are not requested any more, can be resumed:
// statistics start then.
void start_missing(const Model& model, State& state) {
  StatisticsState& stats = state.statistics;
  const bool has_none = stats.list == 0 && stats.surfaces.empty() && stats.energies.empty() &&
                        stats.opposed.empty() && stats.triangles.empty();
  if (!has_none && model.statistics.any()) return;
  const std::uint64_t recording = stats.recording;
  stats = empty_statistics(model);
  stats.recording = recording;
  if (model.statistics.any()) stats.interval_start = state.steps;
}

bool fits(const StatisticsState& stats, const Model& model) {
  const StatisticsState expected = empty_statistics(model);
  return stats.surfaces.size() == expected.surfaces.size() &&
         stats.energies.size() == expected.energies.size() &&
         stats.opposed.size() == expected.opposed.size() &&
         stats.triangles.size() == expected.triangles.size() &&
         stats.finished_triangles.size() ==
             stats.finished_intervals.size() / 2 * expected.triangles.size();
}

bool boundary_contacts_fit(const State& s, const Model& model) {
  if (s.boundary_contacts.size() != model.boundary_contacts.size()) return false;
  std::size_t patch = 0, points = 0;
  for (const BoundaryContactHistory& contact : s.boundary_contacts) {
    if (contact.patch_count > s.boundary_patches.size() - patch ||
        contact.point_count > s.boundary_points.size() - points)
      return false;
    for (const std::size_t end = patch + contact.patch_count; patch < end; ++patch) {
      const ContactPatch& p = s.boundary_patches[patch];
      if (std::uint64_t{p.first_point} + p.point_count > contact.point_count) return false;
    }
    points += contact.point_count;
  }
  return patch == s.boundary_patches.size() && points == s.boundary_points.size();
}

}  // namespace

std::vector<std::byte> pack(const Model& model, const State& state) {
  Writer w;
  w.value(kMagic);
  w.array(fingerprint(model));
  walk(w, state);
  walk_finished(w, state);
  walk_started(w, state);
  return std::move(w.bytes);
}

std::vector<GroupHash> hash_groups(const State& state) {
  Hasher hasher;
  walk(hasher, state);
  walk_started(hasher, state);
  return std::move(hasher.groups);
}

std::uint64_t combined(const std::vector<GroupHash>& groups) {
  std::uint64_t all = kWordHashStart;
  for (const GroupHash& g : groups) all = hash_word(all, g.hash);
  return all;
}

void unpack(const std::vector<std::byte>& bytes, const Model& model, State& state) {
  Reader r(bytes);
  std::uint64_t magic = 0;
  r.value(magic);
  if (magic != kMagic) throw RunError("checkpoint was written by another version of the program");
  std::vector<double> theirs;
  r.array(theirs);
  if (theirs != fingerprint(model)) throw RunError("checkpoint belongs to another case");
  State fresh;
  walk(r, fresh);
  walk_finished(r, fresh);
  fresh.stage_motions.resize(fresh.stage_motion_mover.size());
  fresh.stage_motors.resize(fresh.stage_motor_joint.size());
  walk_started(r, fresh);
  start_missing(model, fresh);
  if (!r.done() || !fits(fresh.statistics, model) ||
      fresh.presence.size() != model.particles.size() ||
      fresh.boundary_present.size() != model.boundaries.size() ||
      fresh.frames.size() != model.frames.size() ||
      fresh.joint_reactions.size() != model.frames.size() ||
      fresh.couplings.size() != model.couplings.size() || !boundary_contacts_fit(fresh, model) ||
      fresh.bonds.size() != model.bonds.size() || fresh.bond_loads.size() != model.bonds.size()) {
    throw RunError("checkpoint does not fit the case");
  }
  state = std::move(fresh);
}

}  // namespace firn
