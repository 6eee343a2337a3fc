// The neighbour list: made anew when somebody has moved its margin, keeping the memory of the pairs
// that stay. Fast bodies get wider margins, so that a few that fall do not wear out the list of
// all.
#include <algorithm>

#include "solver/huge_pages.h"
#include "solver/sides.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kGrain = 64;  // bodies a task
constexpr double kRounding = 1e-9;  // m: tests that save others let more through than those do

// Places of the bounding spheres of all parts of the present particles.
struct PartSpheres {
  std::vector<int> particle;       // [present] ids, in the order of in_space()
  std::vector<std::size_t> first;  // [present] into centers
  std::vector<Vec3> centers;       // m, world
  std::vector<Box3> boxes;         // [present] m, world, with the margin around
  std::vector<double> reach;       // [shapes] m, of all spheres from the centre of mass
};

// A quarter of the skin, and as much again for each time that a body is faster than the average;
// at constant speed nobody then asks for a new list before the average body has moved a quarter.
void set_margins(const Model& model, const Workspace& w, State& s) {
  constexpr double kWidest = 2;  // skins
  const std::size_t n = model.particles.size();
  const auto speed = [&](std::size_t i) {
    return s.motion[i].velocity.norm() +
           s.motion[i].spin.norm() * w.reach[model.particles[i].shape];
  };
  double mean = 0;
  std::size_t present = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (s.presence[i] != Presence::present) continue;
    mean += speed(i);
    ++present;
  }
  if (present > 0) mean /= static_cast<double>(present);
  const double base = 0.25 * w.skin;
  for (std::size_t i = 0; i < s.path.size(); ++i) {
    const bool moves = i < n && s.presence[i] == Presence::present && mean > 0;
    s.margin[i] = moves ? std::min(base * (1 + speed(i) / mean), kWidest * w.skin) : 2 * base;
    s.relist_path[i] = s.path[i] + s.margin[i];
  }
}

// The bits of x, 21 of them, with room for two more behind each.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// The present particles along a curve through space (Morton's, through cells of about their size):
// neighbours on it are mostly neighbours in space. The list keeps this order, so that a step works
// on bodies that it has just had in its hands, whatever their numbers.
std::vector<int> in_space(const Model& model, const Workspace& w, const State& s) {
  constexpr double kMost = (1 << 21) - 1;
  std::vector<int> particles;
  Vec3 lowest = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    if (s.presence[i] != Presence::present) continue;
    particles.push_back(static_cast<int>(i));
    lowest = lowest.cwiseMin(s.motion[i].position);
  }
  const double cell = *std::max_element(w.reach.begin(), w.reach.begin() + w.shapes);
  std::vector<std::pair<std::uint64_t, int>> keys;
  keys.reserve(particles.size());
  for (const int i : particles) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      const double at = (s.motion[i].position[k] - lowest[k]) / cell;
      key |= spread_bits(static_cast<std::uint64_t>(at < kMost ? at : kMost)) << k;
    }
    keys.emplace_back(key, i);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t k = 0; k < keys.size(); ++k) particles[k] = keys[k].second;
  return particles;
}

PartSpheres place_spheres(const Model& model, const Workspace& w, const State& s) {
  PartSpheres out;
  out.particle = in_space(model, w, s);
  std::size_t parts = 0;
  for (const int i : out.particle) {
    out.first.push_back(parts);
    parts += model.shapes[model.particles[i].shape].parts.size();
  }
  out.centers.resize(parts);
  out.boxes.resize(out.particle.size());
  for (const Shape& shape : model.shapes) {
    double reach = 0;
    for (const ConvexPart& part : shape.parts)
      reach = std::max(reach, part.center.norm() + part.bounding_radius);
    out.reach.push_back(reach);
  }
  const auto place = [&](std::size_t k) {
    const int i = out.particle[k];
    const Shape& shape = model.shapes[model.particles[i].shape];
    const Mat3 rotation = rotation_of(s, i);
    Box3& box = out.boxes[k];
    for (std::size_t p = 0; p < shape.parts.size(); ++p) {
      const ConvexPart& part = shape.parts[p];
      const Vec3 c = s.motion[i].position + rotation * part.center;
      const Vec3 r = Vec3::Constant(part.bounding_radius + s.margin[i]);
      out.centers[out.first[k] + p] = c;
      box.lower = p == 0 ? Vec3(c - r) : Vec3(box.lower.cwiseMin(c - r));
      box.upper = p == 0 ? Vec3(c + r) : Vec3(box.upper.cwiseMax(c + r));
    }
  };
  for_ranges(model.numerics.threads, out.particle.size(), kGrain,
             [&](std::size_t begin, std::size_t end) {
               for (std::size_t k = begin; k < end; ++k) place(k);
             });
  return out;
}

// A stretch of the new list: the pairs of some bodies with later ones. Indices count from its own
// beginning.
struct ListPiece {
  std::vector<Pair> pairs;
  std::vector<double> wake;
  std::vector<PairWatch> watch;
  std::vector<PartPair> part_pairs;
  std::vector<Patch> patches;
  std::vector<Vec3> rolling;
  std::vector<ContactPoint> points;
};

// Where the pairs of the present list are.
class OldPairs {
 public:
  OldPairs(const std::vector<Pair>& pairs, std::size_t bodies) : first_(bodies + 1, 0) {
    for (const Pair& p : pairs) ++first_[p.a + 1];
    for (std::size_t i = 0; i < bodies; ++i) first_[i + 1] += first_[i];
    partners_.resize(pairs.size());
    std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      partners_[end[pairs[k].a]++] = {pairs[k].b, static_cast<std::uint32_t>(k)};
  }
  std::optional<std::uint32_t> find(int a, int b) const {
    for (std::uint32_t k = first_[a]; k < first_[a + 1]; ++k) {
      if (partners_[k].b == b) return partners_[k].pair;
    }
    return std::nullopt;
  }

 private:
  struct Partner {
    std::int32_t b;
    std::uint32_t pair;
  };
  std::vector<std::uint32_t> first_;  // [bodies + 1]
  std::vector<Partner> partners_;
};

// Collects a piece, taking over what the old list knew.
class ListMaker {
 public:
  ListMaker(const Model& model, const Workspace& w, const State& s, const OldPairs& old_pairs,
            ListPiece& piece)
      : model_(model),
        w_(w),
        s_(s),
        n_(static_cast<int>(model.particles.size())),
        old_pairs_(old_pairs),
        pairs_(piece.pairs),
        wake_(piece.wake),
        watch_(piece.watch),
        part_pairs_(piece.part_pairs),
        patches_(piece.patches),
        rolling_(piece.rolling),
        points_(piece.points) {}

  void add_particles(const PartSpheres& spheres, int i, int j) {
    if (spheres.particle[i] > spheres.particle[j]) std::swap(i, j);
    const int a = spheres.particle[i], b = spheres.particle[j];
    const auto& pa = model_.shapes[model_.particles[a].shape].parts;
    const auto& pb = model_.shapes[model_.particles[b].shape].parts;
    begin(a, b, w_.law_index(model_.particles[a].shape, model_.particles[b].shape));
    const double margins = s_.margin[a] + s_.margin[b];
    const double all_of_b = spheres.reach[model_.particles[b].shape] + margins + kRounding;
    for (std::size_t k = 0; k < pa.size(); ++k) {
      const Vec3& ca = spheres.centers[spheres.first[i] + k];
      const double near = pa[k].bounding_radius + all_of_b;
      if ((ca - s_.motion[b].position).squaredNorm() > near * near) continue;
      for (std::size_t l = 0; l < pb.size(); ++l) {
        const double reach = pa[k].bounding_radius + pb[l].bounding_radius + margins;
        if ((ca - spheres.centers[spheres.first[j] + l]).squaredNorm() < reach * reach) {
          add_part(static_cast<int>(k), static_cast<int>(l));
        }
      }
    }
    end();
  }

  void add_boundary(const PartSpheres& spheres, int i, int boundary) {
    const int a = spheres.particle[i], b = n_ + boundary;
    const Pose pose{rotation_of(s_, b), s_.motion[b].position};
    const auto& parts = model_.shapes[model_.particles[a].shape].parts;
    const double all_of_a =
        spheres.reach[model_.particles[a].shape] + s_.margin[a] + s_.margin[b] + kRounding;
    const Vec3 center = pose.rotation.transpose() * (s_.motion[a].position - pose.translation);
    if (w_.trees[boundary]) {
      const Box3& bounds = w_.trees[boundary]->bounds();
      const Vec3 all = Vec3::Constant(all_of_a);
      if (!bounds.meets({center - all, center + all})) return;
    } else if (center.z() > all_of_a) {
      return;
    }
    begin(a, b, w_.law_index_boundary(model_.particles[a].shape, boundary));
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Vec3 c =
          pose.rotation.transpose() * (spheres.centers[spheres.first[i] + k] - pose.translation);
      const double reach = parts[k].bounding_radius + s_.margin[a] + s_.margin[b];
      if (model_.boundaries[boundary].kind == Boundary::Kind::plane) {
        if (c.z() < reach) add_part(static_cast<int>(k), 0);
        continue;
      }
      found_.clear();
      w_.trees[boundary]->find({c - Vec3::Constant(reach), c + Vec3::Constant(reach)}, found_);
      for (int l : found_) add_part(static_cast<int>(k), l);
    }
    end();
  }

 private:
  // Finds the pair in the old list.
  void begin(int a, int b, int law) {
    pair_ = Pair{};
    pair_.a = a;
    pair_.b = b;
    pair_.law = law;
    pair_.first_part = static_cast<std::uint32_t>(part_pairs_.size());
    const std::optional<std::uint32_t> old = old_pairs_.find(a, b);
    known_ = old.has_value();
    old_ = old.value_or(0);
    old_part_ = known_ ? s_.pairs[old_].first_part : 0;
    old_part_end_ = known_ ? old_part_ + s_.pairs[old_].part_count : 0;
    new_part_ = false;
  }

  void add_part(int a, int b) {
    const auto before = [&](const PartPair& p) {
      return p.a < a || (p.a == a && p.b < static_cast<std::uint32_t>(b));
    };
    while (old_part_ < old_part_end_ && before(s_.part_pairs[old_part_])) ++old_part_;
    if (old_part_ < old_part_end_ && s_.part_pairs[old_part_].a == a &&
        s_.part_pairs[old_part_].b == static_cast<std::uint32_t>(b)) {
      part_pairs_.push_back(s_.part_pairs[old_part_]);
      return;
    }
    PartPair p;
    p.a = static_cast<std::uint16_t>(a);
    p.b = static_cast<std::uint32_t>(b);
    p.wake = known_ ? s_.watch[old_].moved : 0;
    part_pairs_.push_back(p);
    new_part_ = true;
  }

  void end() {
    pair_.part_count = static_cast<std::uint32_t>(part_pairs_.size()) - pair_.first_part;
    if (pair_.part_count == 0) return;
    const double path = s_.path[pair_.a] + s_.path[pair_.b];
    PairWatch watch;
    double wake = path;  // look at once
    if (known_) {
      watch = s_.watch[old_];
      wake = s_.wake[old_];
      if (new_part_) {
        watch.need = watch.moved;
        wake = path;
      }
      copy_contacts(s_.pairs[old_]);
    } else {
      watch.reference_path = path;
      watch.reference_turn = s_.turn[pair_.a];
      const Pose pose = relative_pose(s_, pair_.a, pair_.b);
      std::copy_n(pose.rotation.data(), 9, watch.reference_rotation);
      std::copy_n(pose.translation.data(), 3, watch.reference_translation);
    }
    pairs_.push_back(pair_);
    wake_.push_back(wake);
    watch_.push_back(watch);
  }

  void copy_contacts(const Pair& old) {
    if (old.patch_count == 0) return;
    pair_.first_patch = static_cast<std::uint32_t>(patches_.size());
    pair_.first_point = static_cast<std::uint32_t>(points_.size());
    pair_.patch_count = old.patch_count;
    for (std::uint32_t k = 0; k < old.patch_count; ++k) {
      Patch patch = s_.patches[old.first_patch + k];
      const auto from = s_.points.begin() + patch.first_point;
      patch.first_point = static_cast<std::uint32_t>(points_.size());
      points_.insert(points_.end(), from, from + patch.point_count);
      patches_.push_back(patch);
      rolling_.push_back(s_.rolling[old.first_patch + k]);
    }
    pair_.patch_capacity = old.patch_count;
    pair_.point_capacity = static_cast<std::uint32_t>(points_.size()) - pair_.first_point;
  }

  const Model& model_;
  const Workspace& w_;
  const State& s_;
  int n_;
  const OldPairs& old_pairs_;
  std::uint32_t old_ = 0;
  bool known_ = false, new_part_ = false;
  std::uint32_t old_part_ = 0, old_part_end_ = 0;
  Pair pair_;
  std::vector<int> found_;
  std::vector<Pair>& pairs_;
  std::vector<double>& wake_;
  std::vector<PairWatch>& watch_;
  std::vector<PartPair>& part_pairs_;
  std::vector<Patch>& patches_;
  std::vector<Vec3>& rolling_;
  std::vector<ContactPoint>& points_;
};

// Puts the pieces one behind the other: the list that one piece would have been.
void join(std::vector<ListPiece>& pieces, int threads, State& s) {
  struct Sizes {
    std::size_t pairs = 0, parts = 0, patches = 0, points = 0;
  };
  std::vector<Sizes> before(pieces.size() + 1);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const ListPiece& p = pieces[k];
    before[k + 1] = {before[k].pairs + p.pairs.size(), before[k].parts + p.part_pairs.size(),
                     before[k].patches + p.patches.size(), before[k].points + p.points.size()};
  }
  resize_large(s.pairs, before.back().pairs);
  resize_large(s.wake, before.back().pairs);
  resize_large(s.watch, before.back().pairs);
  resize_large(s.part_pairs, before.back().parts);
  resize_large(s.patches, before.back().patches);
  resize_large(s.rolling, before.back().patches);
  resize_large(s.points, before.back().points);
  for_ranges(threads, pieces.size(), 1, [&](std::size_t k, std::size_t) {
    ListPiece& p = pieces[k];
    const Sizes& at = before[k];
    for (Pair& pair : p.pairs) {
      pair.first_part += static_cast<std::uint32_t>(at.parts);
      if (pair.patch_count == 0) continue;
      pair.first_patch += static_cast<std::uint32_t>(at.patches);
      pair.first_point += static_cast<std::uint32_t>(at.points);
    }
    for (Patch& patch : p.patches) patch.first_point += static_cast<std::uint32_t>(at.points);
    std::copy(p.pairs.begin(), p.pairs.end(), s.pairs.begin() + at.pairs);
    std::copy(p.wake.begin(), p.wake.end(), s.wake.begin() + at.pairs);
    std::copy(p.watch.begin(), p.watch.end(), s.watch.begin() + at.pairs);
    std::copy(p.part_pairs.begin(), p.part_pairs.end(), s.part_pairs.begin() + at.parts);
    std::copy(p.patches.begin(), p.patches.end(), s.patches.begin() + at.patches);
    std::copy(p.rolling.begin(), p.rolling.end(), s.rolling.begin() + at.patches);
    std::copy(p.points.begin(), p.points.end(), s.points.begin() + at.points);
    p = {};
  });
}

bool must_rebuild(const Model& model, const Workspace& w, const State& s) {
  if (s.list_is_stale) return true;
  for (const char leaves : w.must_relist) {
    if (leaves) return true;
  }
  for (std::size_t i = model.particles.size(); i < s.path.size(); ++i) {
    if (s.path[i] > s.relist_path[i]) return true;
  }
  return false;
}

}  // namespace

void refresh_neighbours(const Model& model, Workspace& w, State& s) {
  if (!must_rebuild(model, w, s)) return;
  check_step_lengths(model, w, s);
  set_margins(model, w, s);
  const PartSpheres spheres = place_spheres(model, w, s);
  const int threads = model.numerics.threads;
  const BoxNeighbours near = box_neighbours(spheres.boxes, threads);
  const std::size_t present = spheres.particle.size();
  const OldPairs old_pairs(s.pairs, s.motion.size());
  std::vector<ListPiece> pieces((present + kGrain - 1) / kGrain);
  for_ranges(threads, present, kGrain, [&](std::size_t begin, std::size_t end) {
    ListMaker list(model, w, s, old_pairs, pieces[begin / kGrain]);
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::int32_t j : near.of(i)) list.add_particles(spheres, static_cast<int>(i), j);
      for (int b = 0; b < static_cast<int>(model.boundaries.size()); ++b) {
        if (s.boundary_present[b]) list.add_boundary(spheres, static_cast<int>(i), b);
      }
    }
  });
  join(pieces, threads, s);
  s.list_is_stale = false;
  w.list_is_new = true;
  ++s.health.rebuilds;
  s.health.pairs = s.pairs.size();
}

}  // namespace firn
