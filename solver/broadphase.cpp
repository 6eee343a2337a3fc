#include "solver/broadphase.h"

#include <algorithm>
#include <unsupported/Eigen/BVH>

namespace firn {

namespace {

// Cell coordinates packed so that neighbours along z are neighbours in order.
constexpr std::int64_t kOffset = 1 << 20;  // cells may be this far from the origin, either way

std::int64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return ((x + kOffset) << 42) | ((y + kOffset) << 21) | (z + kOffset);
}

struct CellEntry {
  std::int64_t key;
  std::int32_t box;
  bool operator<(const CellEntry& o) const { return key != o.key ? key < o.key : box < o.box; }
};

}  // namespace

void box_pairs(const std::vector<Box3>& boxes, std::vector<std::array<std::int32_t, 2>>& pairs) {
  pairs.clear();
  if (boxes.empty()) return;
  double cell = 0;
  for (const Box3& b : boxes) cell = std::max(cell, (b.upper - b.lower).maxCoeff());
  if (!(cell > 0)) cell = 1;
  std::vector<std::array<std::int64_t, 3>> at(boxes.size());
  std::vector<CellEntry> order(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Vec3 c = 0.5 * (boxes[i].lower + boxes[i].upper) / cell;
    for (int k = 0; k < 3; ++k) {
      at[i][k] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(c[k])), -kOffset + 2,
                                          kOffset - 2);
    }
    order[i] = {cell_key(at[i][0], at[i][1], at[i][2]), static_cast<std::int32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto [x, y, z] = at[i];
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const std::int64_t first = cell_key(x + dx, y + dy, z - 1);
        const std::int64_t last = cell_key(x + dx, y + dy, z + 1);
        auto it = std::lower_bound(order.begin(), order.end(), CellEntry{first, -1});
        for (; it != order.end() && it->key <= last; ++it) {
          if (it->box > static_cast<std::int32_t>(i) && boxes[i].meets(boxes[it->box])) {
            pairs.push_back({static_cast<std::int32_t>(i), it->box});
          }
        }
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
}

namespace {
using AlignedBox = Eigen::AlignedBox3d;

struct IndexedBox {
  int index;
  AlignedBox box;
};
// Found by argument-dependent lookup from Eigen's tree.
AlignedBox bounding_box(const IndexedBox& b) { return b.box; }

struct Query {
  const AlignedBox& box;
  std::vector<int>& found;
  bool intersectVolume(const AlignedBox& b) const { return b.intersects(box); }
  bool intersectObject(const IndexedBox& o) {
    if (o.box.intersects(box)) found.push_back(o.index);
    return false;  // go on
  }
};
}  // namespace

struct BoxTree::Impl {
  Eigen::KdBVH<double, 3, IndexedBox> tree;
  Box3 bounds;
};

BoxTree::BoxTree(std::vector<Box3> boxes) : impl_(std::make_unique<Impl>()) {
  std::vector<IndexedBox> objects;
  objects.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    objects.push_back({static_cast<int>(i), AlignedBox(boxes[i].lower, boxes[i].upper)});
    if (i == 0) impl_->bounds = boxes[0];
    impl_->bounds.lower = impl_->bounds.lower.cwiseMin(boxes[i].lower);
    impl_->bounds.upper = impl_->bounds.upper.cwiseMax(boxes[i].upper);
  }
  impl_->tree.init(objects.begin(), objects.end());
}
BoxTree::~BoxTree() = default;
BoxTree::BoxTree(BoxTree&&) noexcept = default;
BoxTree& BoxTree::operator=(BoxTree&&) noexcept = default;

void BoxTree::find(const Box3& query, std::vector<int>& found) const {
  const std::size_t first = found.size();
  const AlignedBox box(query.lower, query.upper);
  Query q{box, found};
  Eigen::BVIntersect(impl_->tree, q);
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(first), found.end());
}

const Box3& BoxTree::bounds() const { return impl_->bounds; }

}  // namespace firn
