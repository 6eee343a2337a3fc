#include "solver/broadphase.h"

#include <algorithm>
#include <unsupported/Eigen/BVH>

#include "solver/parallel.h"

namespace firn {

namespace {

// Cell coordinates packed so that neighbours along z are neighbours in order.
constexpr std::int64_t kOffset = 1 << 20;  // cells may be this far from the origin, either way

std::int64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return ((x + kOffset) << 42) | ((y + kOffset) << 21) | (z + kOffset);
}

// A box in its cell. The box itself comes along, so that neighbours in space are neighbours in
// memory.
struct CellEntry {
  std::int64_t key;
  std::int32_t box;
  Box3 bounds;
  bool operator<(const CellEntry& o) const { return key != o.key ? key < o.key : box < o.box; }
};

std::vector<CellEntry> sort_into_cells(const std::vector<Box3>& boxes) {
  double cell = 0;
  for (const Box3& b : boxes) cell = std::max(cell, (b.upper - b.lower).maxCoeff());
  if (!(cell > 0)) cell = 1;
  std::vector<std::pair<std::int64_t, std::int32_t>> order(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Vec3 c = 0.5 * (boxes[i].lower + boxes[i].upper) / cell;
    std::int64_t at[3];
    for (int k = 0; k < 3; ++k) {
      at[k] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(c[k])), -kOffset + 2,
                                       kOffset - 2);
    }
    order[i] = {cell_key(at[0], at[1], at[2]), static_cast<std::int32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  std::vector<CellEntry> entries;
  entries.reserve(boxes.size());
  for (const auto& [key, box] : order) entries.push_back({key, box, boxes[box]});
  return entries;
}

// Pairs of entries [begin, end) with later ones: in the same cell, in the next one along z, and in
// the half of the rows of cells around that lies behind. Each row is walked once.
void search_cells(const std::vector<CellEntry>& entries, std::size_t begin, std::size_t end,
                  std::vector<std::array<std::int32_t, 2>>& pairs) {
  constexpr std::int64_t kX = std::int64_t{1} << 42, kY = std::int64_t{1} << 21;
  constexpr std::int64_t kRows[] = {kY, kX - kY, kX, kX + kY};
  const auto meet = [&](const CellEntry& a, const CellEntry& b) {
    if (a.bounds.meets(b.bounds)) pairs.push_back({std::min(a.box, b.box), std::max(a.box, b.box)});
  };
  std::size_t from[4];
  for (int r = 0; r < 4; ++r) {
    const CellEntry first{entries[begin].key + kRows[r] - 1, -1, {}};
    from[r] = static_cast<std::size_t>(std::lower_bound(entries.begin(), entries.end(), first) -
                                       entries.begin());
  }
  const std::size_t n = entries.size();
  for (std::size_t i = begin; i < end; ++i) {
    const CellEntry& mine = entries[i];
    for (std::size_t k = i + 1; k < n && entries[k].key <= mine.key + 1; ++k)
      meet(mine, entries[k]);
    for (int r = 0; r < 4; ++r) {
      const std::int64_t row = mine.key + kRows[r];
      while (from[r] < n && entries[from[r]].key < row - 1) ++from[r];
      for (std::size_t k = from[r]; k < n && entries[k].key <= row + 1; ++k) meet(mine, entries[k]);
    }
  }
}

}  // namespace

BoxNeighbours box_neighbours(const std::vector<Box3>& boxes, int threads) {
  constexpr std::size_t kGrain = 256;  // boxes a task
  BoxNeighbours out;
  out.first.assign(boxes.size() + 1, 0);
  const std::vector<CellEntry> entries = sort_into_cells(boxes);
  std::vector<std::vector<std::array<std::int32_t, 2>>> found((boxes.size() + kGrain - 1) / kGrain);
  for_ranges(threads, boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    search_cells(entries, begin, end, found[begin / kGrain]);
  });
  for (const auto& pairs : found) {
    for (const auto& pair : pairs) ++out.first[pair[0] + 1];
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) out.first[i + 1] += out.first[i];
  out.others.resize(out.first.back());
  std::vector<std::uint32_t> at(out.first.begin(), out.first.end() - 1);
  for (const auto& pairs : found) {
    for (const auto& pair : pairs) out.others[at[pair[0]]++] = pair[1];
  }
  for_ranges(threads, boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::sort(out.others.begin() + out.first[i], out.others.begin() + out.first[i + 1]);
  });
  return out;
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
