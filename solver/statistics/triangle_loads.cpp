// Loads on the triangles of boundaries, over every step (see TriangleSums).
#include "solver/statistics/triangle_loads.h"

#include "solver/state/workspace.h"

namespace firn {

namespace {

class BoundaryReader {
 public:
  BoundaryReader(const Model& model, const Workspace& w, State& s)
      : w_(w.statistics),
        s_(s),
        triangles_(s.statistics.triangle_of_point),
        particles_(static_cast<int>(model.particles.size())) {}

  // Finds the triangles under the points of a range: of pairs with a new contact search, or of all.
  // The search costs more than all else here.
  void look_up(const PairBlock& range, bool all) const {
    if (all) {
      for (const ActivePair& pair : range.active) look_up(pair.pair);
    } else {
      for (const ActivePair& pair : range.refreshed) look_up(pair.pair);
    }
  }

  void read(const PairBlock& range, RangeStatistics& notes) const {
    notes.triangle_loads.clear();
    const PatchWork* work = notes.work.data();
    for (const ActivePair& pair : range.active) {
      if (monitored(pair.b) >= 0) {
        for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
          const ContactPatch& patch = s_.patches[pair.first_patch + k];
          if (patch.normal_force > 0) add(pair, patch, work[k].friction, notes.triangle_loads);
        }
      }
      work += pair.patch_count;
    }
  }

 private:
  int monitored(int body) const { return body < particles_ ? -1 : w_.monitored[body - particles_]; }

  void look_up(std::uint32_t p) const {
    const Pair& pair = s_.pairs[p];
    const int number = monitored(pair.b);
    if (number < 0) return;
    const NearestTriangle& index = w_.monitored_index[number];
    const std::uint32_t first = w_.first_of_monitored[number];
    const BodyMotion &a = s_.motion[pair.a], &b = s_.motion[pair.b];
    const Mat3 to_boundary = rotation_of(s_, pair.b).transpose();
    for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
      const ContactPatch& patch = s_.patches[pair.first_patch + k];
      const Vec3 place = a.position + patch.arm - b.position, out = to_boundary * -patch.normal;
      for (std::uint32_t i = patch.first_point; i < patch.first_point + patch.point_count; ++i) {
        // What the point's place in memory had last is near, mostly.
        const int last = static_cast<int>(triangles_[i]) - static_cast<int>(first);
        const int nearest = index.nearest(to_boundary * (place + s_.points[i].offset), out, last);
        triangles_[i] = first + static_cast<std::uint32_t>(nearest);
      }
    }
  }

  void add(const ActivePair& pair, const ContactPatch& patch, double friction_work,
           std::vector<TriangleLoad>& loads) const {
    const BodyMotion &a = s_.motion[pair.a], &b = s_.motion[pair.b];
    const Mat3 to_boundary = rotation_of(s_, pair.b).transpose();
    const Vec3 out = to_boundary * -patch.normal;
    const Vec3 friction = to_boundary * -patch.tangential;  // on the boundary
    double speed = 0;
    if (patch.sliding) {
      const Vec3 velocity = a.velocity + a.angular_velocity.cross(patch.arm) - b.velocity -
                            b.angular_velocity.cross(a.position + patch.arm - b.position);
      speed = (velocity - velocity.dot(patch.normal) * patch.normal).norm();
    }
    const double size = friction.norm();
    for (std::uint32_t i = patch.first_point; i < patch.first_point + patch.point_count; ++i) {
      const double force = s_.points[i].force;
      if (!(force > 0)) continue;
      const double part = force / patch.normal_force;
      TriangleLoad& load = loads.emplace_back();
      load.triangle = triangles_[i];
      load.normal_force = force;
      load.friction = part * size;
      load.force = part * friction - force * out;
      load.sliding_speed = part * speed;
      load.sliding_power = force * speed;
      load.friction_work = part * friction_work;
    }
  }

  const StatisticsWorkspace& w_;
  State& s_;
  std::vector<std::uint32_t>& triangles_;
  int particles_;
};

void add_up(const std::vector<TriangleLoad>& loads, double dt, StatisticsWorkspace& w,
            std::vector<TriangleSums>& sums) {
  for (const TriangleLoad& load : loads) {
    TriangleSums& sum = sums[load.triangle];
    sum.normal_impulse += dt * load.normal_force;
    sum.tangential_impulse += dt * load.friction;
    sum.impulse += dt * load.force;
    sum.sliding_distance += dt * load.sliding_speed;
    sum.sliding_work += dt * load.sliding_power;
    sum.friction_work += load.friction_work;
    if (w.force[load.triangle] == 0) w.touched.push_back(load.triangle);
    w.force[load.triangle] += load.normal_force;
  }
}

}  // namespace

void sum_triangle_loads(const Model& model, Workspace& w, State& s) {
  StatisticsState& stats = s.statistics;
  const bool all = w.points_moved || stats.points_list != s.diagnostics.rebuilds;
  stats.points_list = s.diagnostics.rebuilds;
  stats.triangle_of_point.resize(s.points.size());
  const BoundaryReader reader(model, w, s);
  parallel_for_blocks(w.threads, s.pairs.size(), kPairsPerBlock,
                      [&](std::size_t begin, std::size_t) {
                        PairBlock& range = w.ranges[begin / kPairsPerBlock];
                        reader.look_up(range, all);
                        reader.read(range, range.notes);
                      });
  StatisticsWorkspace& scratch = w.statistics;
  scratch.touched.clear();
  for (const PairBlock& range : w.ranges)
    add_up(range.notes.triangle_loads, model.timestep, scratch, stats.triangles);
  for (const std::uint32_t t : scratch.touched) {
    stats.triangles[t].peak = std::max(stats.triangles[t].peak, scratch.force[t]);
    scratch.force[t] = 0;
  }
  if (model.statistics.interval <= 0) return;
  const auto steps =
      std::max(1LL, std::llround(std::min(model.statistics.interval / model.timestep, 1e15)));
  if (s.steps + 1 >= stats.interval_start + static_cast<std::uint64_t>(steps))
    end_load_interval(model, s.steps + 1, stats);
}

void end_load_interval(const Model& model, std::uint64_t step, StatisticsState& stats) {
  for (const std::uint64_t at : {stats.interval_start, step})
    stats.finished_intervals.push_back(static_cast<double>(at) * model.timestep);
  stats.finished_triangles.insert(stats.finished_triangles.end(), stats.triangles.begin(),
                                  stats.triangles.end());
  stats.triangles.assign(stats.triangles.size(), {});
  stats.interval_start = step;
}

}  // namespace firn
