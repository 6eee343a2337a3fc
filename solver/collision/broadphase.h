// Broad phase: finds the bodies and parts that may touch before the neighbor list is rebuilt.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "firn/math.h"

namespace firn {

struct Aabb {
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  // m
  bool overlaps(const Aabb& o) const {
    return (lower.array() <= o.upper.array()).all() && (o.lower.array() <= upper.array()).all();
  }
};

// For each box, the overlapping boxes of higher index, ascending.
class AabbOverlaps {
 public:
  std::span<const std::int32_t> of(std::size_t box) const {
    const Place& p = places_[box];
    return {found_[p.task].data() + p.first, p.count};
  }

 private:
  friend AabbOverlaps find_aabb_overlaps(const std::vector<Aabb>& boxes, int threads);
  struct Place {
    std::uint32_t task, first, count;
  };
  std::vector<Place> places_;                     // [boxes]
  std::vector<std::vector<std::int32_t>> found_;  // [tasks]
};
// Uses a cell list. For boxes of similar size, the time is linear in their number except for the
// sort.
AabbOverlaps find_aabb_overlaps(const std::vector<Aabb>& boxes, int threads = 1);

// A tree over fixed boxes (the parts of a boundary), for queries with one box.
class AabbTree {
 public:
  explicit AabbTree(std::vector<Aabb> boxes);
  ~AabbTree();
  AabbTree(AabbTree&&) noexcept;
  AabbTree& operator=(AabbTree&&) noexcept;
  // Appends the indices of the boxes that overlap `query`, in ascending order.
  void find(const Aabb& query, std::vector<int>& found) const;
  const Aabb& bounds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
