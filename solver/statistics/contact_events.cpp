// Contact by contact: what pairs of bodies do to each other, over every step.
//
// Ranges of pairs are read in parallel, each into separate notes. New and ended contacts are then
// processed in order, range by range, so that every number of threads gives the same bytes.
#include "solver/statistics/contact_events.h"

#include <algorithm>
#include <tuple>

#include "solver/state/workspace.h"

namespace firn {

namespace {

// What the patches of a pair do together.
struct PairLoad {
  double normal = 0;             // N
  Vec3 friction = Vec3::Zero();  // N, on a
  Vec3 push = Vec3::Zero();      // N, on a, friction included
  double work = 0;               // J taken from the bodies
};

class ContactReader {
 public:
  ContactReader(const Model& model, State& s)
      : model_(model),
        s_(s),
        particles_(static_cast<int>(model.particles.size())),
        dt_(model.timestep),
        step_(s.steps + 1) {}

  // Adds up the open contacts of a range of pairs, and notes those that begin and part.
  void read(const PairBlock& range, RangeStatistics& notes) const {
    StatisticsState& stats = s_.statistics;
    const PatchWork* work = notes.work.data();
    notes.begun.clear();
    notes.parted.clear();
    for (const ActivePair& pair : range.active) {
      const PairLoad load = load_of(pair, work);
      work += pair.patch_count;
      const std::int32_t open = stats.open_of_pair[pair.pair];
      if (load.normal > 0) {
        if (open < 0)
          notes.begun.push_back(begin(pair, load));
        else
          add(pair, load, stats.open[open], stats.sums[open]);
      } else if (open >= 0) {
        stats.sums[open].work += load.work;
        note_parting(open, notes);
      }
    }
    for (const ActivePair& pair : range.refreshed) {
      const std::int32_t open = stats.open_of_pair[pair.pair];
      if (open >= 0 && pair.patch_count == 0) note_parting(open, notes);
    }
  }

 private:
  PairLoad load_of(const ActivePair& pair, const PatchWork* work) const {
    PairLoad load;
    for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
      const ContactPatch& patch = s_.patches[pair.first_patch + k];
      load.work += work[k].normal + work[k].friction;
      if (!(patch.normal_force > 0)) continue;
      load.normal += patch.normal_force;
      load.friction += patch.tangential;
      load.push -= patch.normal_force * patch.normal;
    }
    load.push += load.friction;
    return load;
  }

  void note_parting(std::int32_t open, RangeStatistics& notes) const {
    if (s_.statistics.sums[open].last + 1 == step_) notes.parted.push_back(open);
  }

  void add(const ActivePair& pair, const PairLoad& load, OpenContact& contact,
           ContactSums& sums) const {
    sums.impulse += dt_ * load.push;
    sums.normal_impulse += dt_ * load.normal;
    sums.tangential_impulse += dt_ * load.friction.norm();
    sums.work += load.work;
    sums.last = step_;
    if (load.normal > sums.peak) {
      sums.peak = load.normal;
      note_peak(pair, load, contact.event);
    }
  }

  NewContact begin(const ActivePair& pair, const PairLoad& load) const {
    NewContact begun;
    OpenContact& contact = begun.contact;
    contact.event.a = pair.a;
    contact.event.b = pair.b;
    contact.start = step_;
    contact.pair = pair.pair;
    add(pair, load, contact, begun.sums);
    // The velocities here are those between the two half kicks, which the contact law used.
    const BodyMotion &a = s_.motion[pair.a], &b = s_.motion[pair.b];
    const Vec3 &place = contact.event.position, &normal = contact.event.normal;
    const Vec3 velocity = a.velocity + a.angular_velocity.cross(place - a.position) - b.velocity -
                          b.angular_velocity.cross(place - b.position);
    contact.event.impact_velocity_normal = velocity.dot(normal);
    contact.event.impact_velocity_tangential = (velocity - velocity.dot(normal) * normal).norm();
    return begun;
  }

  void note_peak(const ActivePair& pair, const PairLoad& load, ContactEvent& event) const {
    Vec3 arm = Vec3::Zero(), normal = Vec3::Zero();
    for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
      const ContactPatch& patch = s_.patches[pair.first_patch + k];
      if (!(patch.normal_force > 0)) continue;
      arm += patch.normal_force * patch.arm;
      normal += patch.normal_force * patch.normal;
    }
    event.peak_time = static_cast<double>(step_) * dt_;
    event.peak_friction = load.friction.norm();
    // Patches that press against each other across a part between them have no normal together.
    const double size = normal.norm();
    if (size > 0) event.normal = normal / size;
    event.position = s_.motion[pair.a].position + arm / load.normal;
    event.position_on_a = on_body(pair.a, event.position);
    event.position_on_b = on_body(pair.b, event.position);
  }

  // A place in the axes of a body's mesh.
  Vec3 on_body(int body, const Vec3& place) const {
    Vec3 local = s_.orientation[body].conjugate() * (place - s_.motion[body].position);
    if (body >= particles_) return local;
    const Shape& shape = model_.shapes[model_.particles[body].shape];
    return shape.centroid + shape.shape_from_body * local;
  }

  const Model& model_;
  State& s_;
  int particles_;
  double dt_;
  std::uint64_t step_;
};

// The open contacts of a new neighbor list, or of the same one without free places: in order of
// the list, then those whose pair is not listed.
void remap_open_contacts(State& s) {
  StatisticsState& stats = s.statistics;
  const std::size_t particles = s.angular_momentum.size();
  // Old places by their first body.
  std::vector<std::uint32_t> first(particles + 1, 0);
  for (const OpenContact& c : stats.open) {
    if (c.event.a >= 0) ++first[c.event.a + 1];
  }
  for (std::size_t i = 0; i < particles; ++i) first[i + 1] += first[i];
  std::vector<std::uint32_t> places(first.back());
  std::vector<std::uint32_t> end(first.begin(), first.end() - 1);
  for (std::size_t k = 0; k < stats.open.size(); ++k) {
    if (stats.open[k].event.a >= 0)
      places[end[stats.open[k].event.a]++] = static_cast<std::uint32_t>(k);
  }
  std::vector<OpenContact> open;
  std::vector<ContactSums> sums;
  std::vector<std::int32_t> moved(stats.open.size(), -1);
  const auto move = [&](std::uint32_t old, std::int64_t pair) {
    moved[old] = static_cast<std::int32_t>(open.size());
    open.push_back(stats.open[old]);
    open.back().pair = pair;
    sums.push_back(stats.sums[old]);
  };
  stats.open_of_pair.assign(s.pairs.size(), -1);
  for (std::size_t p = 0; p < s.pairs.size(); ++p) {
    const Pair& pair = s.pairs[p];
    for (std::uint32_t k = first[pair.a]; k < first[pair.a + 1]; ++k) {
      if (stats.open[places[k]].event.b != pair.b) continue;
      stats.open_of_pair[p] = static_cast<std::int32_t>(open.size());
      move(places[k], static_cast<std::int64_t>(p));
      break;
    }
  }
  for (const std::uint32_t old : places) {
    if (moved[old] >= 0) continue;
    move(old, -1);
    if (stats.sums[old].last == s.steps) stats.parted.push_back(static_cast<std::int32_t>(old));
  }
  for (std::int32_t& k : stats.parted) k = moved[k];
  stats.open = std::move(open);
  stats.sums = std::move(sums);
  stats.free_places = 0;
  stats.list = s.diagnostics.rebuilds;
}

// An open contact as an event up to now.
ContactEvent event_of(const OpenContact& contact, const ContactSums& sums, double dt) {
  ContactEvent e = contact.event;
  e.start = static_cast<double>(contact.start) * dt;
  e.duration = static_cast<double>(sums.last + 1 - contact.start) * dt;
  e.peak_normal_force = sums.peak;
  e.normal_impulse = sums.normal_impulse;
  e.tangential_impulse = sums.tangential_impulse;
  e.impulse = sums.impulse;
  e.dissipated = sums.work;
  return e;
}

// Counts an ended contact in all that asks for it.
void finish(const Model& model, const StatisticsWorkspace& w, const ContactEvent& event,
            StatisticsState& stats) {
  const StatisticsOptions& options = model.statistics;
  const auto particles = static_cast<std::int32_t>(model.particles.size());
  if (options.events && event.peak_normal_force >= options.threshold)
    stats.finished.push_back(event);
  if (options.energies.count() > 0) {
    const int kind = event.b < particles ? 0 : 1 + event.b - particles;
    EnergySums& sums =
        stats.energies[kind * options.energies.count() + options.energies.of(event.dissipated)];
    sums.dissipated += event.dissipated;
    ++sums.contacts;
  }
  if (options.surfaces.empty()) return;
  const auto add = [&](std::int32_t particle, const Vec3& place) {
    const int shape = model.particles[particle].shape;
    SurfaceSums& sums =
        stats.surfaces[w.first_of_shape[shape] + w.surface_index[shape].nearest(place)];
    sums.normal_impulse += event.normal_impulse;
    sums.peak_normal_force = std::max(sums.peak_normal_force, event.peak_normal_force);
    ++sums.contacts;
  };
  add(event.a, event.position_on_a);
  if (event.b < particles) add(event.b, event.position_on_b);
}

// Ends the contacts that have been parted for long enough, in order of their bodies.
void end_parted(const Model& model, const StatisticsWorkspace& w, State& s) {
  StatisticsState& stats = s.statistics;
  const std::uint64_t step = s.steps + 1;
  std::vector<ContactEvent> ended;
  std::erase_if(stats.parted, [&](std::int32_t k) {
    OpenContact& contact = stats.open[k];
    const std::uint64_t parted = step - stats.sums[k].last;
    if (parted == 0) return true;  // together again
    if (static_cast<double>(parted) * model.timestep < model.statistics.merge_gap) return false;
    ended.push_back(event_of(contact, stats.sums[k], model.timestep));
    if (contact.pair >= 0) stats.open_of_pair[contact.pair] = -1;
    contact.event.a = -1;
    ++stats.free_places;
    return true;
  });
  std::ranges::sort(ended, {}, [](const ContactEvent& e) { return std::pair(e.a, e.b); });
  for (const ContactEvent& e : ended) finish(model, w, e, stats);
}

}  // namespace

void update_contact_events(const Model& model, Workspace& w, State& s) {
  StatisticsState& stats = s.statistics;
  constexpr std::size_t kFew = 64;  // free places, not worth the while
  if (stats.list != s.diagnostics.rebuilds || stats.open_of_pair.size() != s.pairs.size() ||
      2 * stats.free_places > stats.open.size() + kFew)
    remap_open_contacts(s);
  const ContactReader reader(model, s);
  parallel_for_blocks(w.threads, s.pairs.size(), kPairsPerBlock,
                      [&](std::size_t begin, std::size_t) {
                        PairBlock& range = w.ranges[begin / kPairsPerBlock];
                        reader.read(range, range.notes);
                      });
  for (const PairBlock& range : w.ranges) {
    stats.parted.insert(stats.parted.end(), range.notes.parted.begin(), range.notes.parted.end());
    for (const NewContact& begun : range.notes.begun) {
      stats.open_of_pair[begun.contact.pair] = static_cast<std::int32_t>(stats.open.size());
      stats.open.push_back(begun.contact);
      stats.sums.push_back(begun.sums);
    }
  }
  end_parted(model, w.statistics, s);
}

std::vector<ContactEvent> open_events(const Model& model, const State& s) {
  std::vector<ContactEvent> events;
  for (std::size_t k = 0; k < s.statistics.open.size(); ++k) {
    const OpenContact& contact = s.statistics.open[k];
    const ContactSums& sums = s.statistics.sums[k];
    if (contact.event.a < 0) continue;
    events.push_back(event_of(contact, sums, model.timestep));
    events.back().open_at_end = 1;
  }
  std::ranges::sort(events, {},
                    [](const ContactEvent& e) { return std::tuple(e.start, e.a, e.b); });
  return events;
}

}  // namespace firn
