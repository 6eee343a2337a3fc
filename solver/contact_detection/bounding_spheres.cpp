#include "solver/contact_detection/bounding_spheres.h"

#include <algorithm>
#include <limits>

#include "solver/core/prefetch.h"

namespace firn {

namespace {

constexpr std::size_t kSpheresPerTask = 256;  // bodies a task
constexpr std::size_t kSpheresAhead = 8;      // bodies to prefetch: they are scattered in memory

// The bits of x, 21 of them, with room for two more behind each.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// The present particles along a Morton curve through cells of about their size. Neighbors on the
// curve are mostly neighbors in space. The neighbor list keeps this order, so that successive pairs
// use bodies that are still in the cache.
std::vector<int> morton_order(const Model& model, const Workspace& w, const State& s) {
  constexpr double kMost = (1 << 21) - 1;
  std::vector<KeyIndex> order;
  order.reserve(model.particles.size());
  Vec3 lowest = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    if (s.presence[i] != Presence::present) continue;
    order.push_back({0, static_cast<std::int32_t>(i)});
    lowest = lowest.cwiseMin(s.motion[i].position);
  }
  const double cell = *std::max_element(w.reach.begin(), w.reach.begin() + w.shapes);
  parallel_for_blocks(
      w.threads, order.size(), kSpheresPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
          const Vec3 from = s.motion[order[n].number].position - lowest;
          for (int k = 0; k < 3; ++k) {
            const double at = from[k] / cell;
            order[n].key |= spread_bits(static_cast<std::uint64_t>(at < kMost ? at : kMost)) << k;
          }
        }
      });
  sort_by_key(w.threads, order);
  std::vector<int> particles;
  particles.reserve(order.size());
  for (const KeyIndex& one : order) particles.push_back(one.number);
  return particles;
}

[[gnu::always_inline]] inline void prefetch_body(const State& s, int i) {  // see prefetch.h
  prefetch(&s.motion[i].position);
  prefetch(&s.orientation[i]);
  prefetch(&s.skin[i]);
}

double& lane(Vec4& q, std::size_t k) { return (&q.x)[k]; }

// The squared distances of a point from four centers.
[[gnu::always_inline]] inline void square_distances(const SphereGroup& g, const Vec& p,
                                                    Simd4d& out) {
  Simd4d x, y, z;
  get(&g.x, x);
  get(&g.y, y);
  get(&g.z, z);
  x -= p.x;
  y -= p.y;
  z -= p.z;
  out = x * x + y * y + z * z;
}

}  // namespace

BoundingSpheres update_bounding_spheres(const Model& model, const Workspace& w, const State& s) {
  constexpr std::size_t kSize = SphereGroup::size;
  const Vec3 kNowhere = Vec3::Constant(std::numeric_limits<double>::infinity());
  BoundingSpheres out;
  out.particle = morton_order(model, w, s);
  out.first.reserve(out.particle.size() + 1);
  out.first.push_back(0);
  for (const int i : out.particle) {
    const std::size_t parts = model.shapes[model.particles[i].shape].parts.size();
    out.first.push_back(out.first.back() + (parts + kSize - 1) / kSize);
  }
  out.groups.resize(out.first.back());
  out.places.resize(out.particle.size());
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
    const auto put = [&](std::size_t p, const Vec3& at, double radius) {
      SphereGroup& group = out.groups[out.first[k] + p / kSize];
      lane(group.x, p % kSize) = at.x();
      lane(group.y, p % kSize) = at.y();
      lane(group.z, p % kSize) = at.z();
      lane(group.radius, p % kSize) = radius;
    };
    const Vec3& center = s.motion[i].position;
    out.places[k] = {center.x(), center.y(), center.z(), s.skin[i]};
    Aabb& box = out.boxes[k];
    const std::size_t parts = shape.parts.size();
    for (std::size_t p = 0; p < parts; ++p) {
      const double radius = shape.parts[p].bounding_radius;
      const Vec3 c = center + rotation * shape.parts[p].center;
      const Vec3 r = Vec3::Constant(radius + s.skin[i]);
      box.lower = p == 0 ? Vec3(c - r) : Vec3(box.lower.cwiseMin(c - r));
      box.upper = p == 0 ? Vec3(c + r) : Vec3(box.upper.cwiseMax(c + r));
      put(p, c, radius);
    }
    for (std::size_t p = parts; p % kSize != 0; ++p) put(p, kNowhere, 0);
  };
  parallel_for_blocks(w.threads, out.particle.size(), kSpheresPerTask,
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t k = begin; k < end; ++k) {
                          if (k + kSpheresAhead < end)
                            prefetch_body(s, out.particle[k + kSpheresAhead]);
                          place(k);
                        }
                      });
  return out;
}

int find_close_parts(std::span<const SphereGroup> a, std::span<const SphereGroup> b,
                     const Vec3& center, double reach, double margins, PartNumbers* found) {
  // Branch-free: the outcome is unpredictable.
  constexpr std::uint32_t kSize = SphereGroup::size;
  const double all_of_b = reach + margins + kRounding;
  const Vec center_b = to_vec(center);
  int count = 0;
  Simd4d distance, radius;
  for (std::uint32_t g = 0; g < a.size(); ++g) {
    square_distances(a[g], center_b, distance);
    get(&a[g].radius, radius);
    radius += all_of_b;
    const unsigned near = movemask(distance <= radius * radius);
    std::uint32_t of_a[kSize + 1];
    std::uint32_t many = 0;
    for (std::uint32_t k = 0; k < kSize; ++k) {
      of_a[many] = k;
      many += near >> k & 1;
    }
    for (std::uint32_t n = 0; n < many; ++n) {
      const std::uint32_t k = of_a[n];
      const Vec center_a{(&a[g].x.x)[k], (&a[g].y.x)[k], (&a[g].z.x)[k]};
      const double radius_a = (&a[g].radius.x)[k];
      for (std::uint32_t h = 0; h < b.size(); ++h) {
        square_distances(b[h], center_a, distance);
        get(&b[h].radius, radius);
        radius = (radius_a + radius) + margins;
        const unsigned meet = movemask(distance < radius * radius);
        for (std::uint32_t l = 0; l < kSize; ++l) {
          found[count] = {kSize * g + k, kSize * h + l};
          count += meet >> l & 1;
        }
      }
    }
  }
  return count;
}

}  // namespace firn
