#include "solver/collision/broadphase.h"

#include <algorithm>
#include <unsupported/Eigen/BVH>

#include "solver/core/parallel.h"
#include "solver/core/simd.h"

namespace firn {

namespace {

constexpr std::size_t kBoxesPerTask = 256;  // boxes a task

// Cell coordinates packed so that neighbors along z are neighbors in order.
constexpr std::int64_t kOffset = 1 << 20;  // cells may be this far from the origin, either way

std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(((x + kOffset) << 42) | ((y + kOffset) << 21) | (z + kOffset));
}

// Boxes in the order of their cells. The list stores copies of the boxes, so that neighbors in
// space are neighbors in memory. The fourth component holds the number of the box.
struct CellList {
  struct Entry {
    Vec4 lower, upper;  // upper.w: the box's number
  };
  std::vector<std::uint64_t> keys;
  std::vector<Entry> boxes;
};

// Cells are as large as the largest box, and a quarter of that along z. With smaller cells along z,
// a row contains fewer boxes that are too far away.
constexpr std::int64_t kFine = 4;

CellList sort_into_cells(const std::vector<Aabb>& boxes, int threads) {
  double cell = 0;
  for (const Aabb& b : boxes) cell = std::max(cell, (b.upper - b.lower).maxCoeff());
  if (!(cell > 0)) cell = 1;
  const Vec3 sizes(cell, cell, cell / kFine);
  std::vector<KeyIndex> order(boxes.size());
  parallel_for_blocks(
      threads, boxes.size(), kBoxesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3 c = (0.5 * (boxes[i].lower + boxes[i].upper)).cwiseQuotient(sizes);
          std::int64_t at[3];
          for (int k = 0; k < 3; ++k) {
            at[k] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(c[k])),
                                             -kOffset + 2 * kFine, kOffset - 2 * kFine);
          }
          order[i] = {cell_key(at[0], at[1], at[2]), static_cast<std::int32_t>(i)};
        }
      });
  sort_by_key(threads, order);
  CellList list;
  list.keys.resize(boxes.size());
  list.boxes.resize(boxes.size());
  parallel_for_blocks(
      threads, boxes.size(), kBoxesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const Aabb& box = boxes[order[k].number];
          const Vec3 &l = box.lower, &u = box.upper;
          list.keys[k] = order[k].key;
          list.boxes[k] = {{l.x(), l.y(), l.z(), 0},
                           {u.x(), u.y(), u.z(), static_cast<double>(order[k].number)}};
        }
      });
  return list;
}

// The entries [begin, end) of a row of cells that are not too far away along z.
struct Row {
  std::size_t begin, end;
};

// Calls take(k, rows) for the entries [begin, end), with the nine rows around each.
template <class Take>
void walk_cells(const std::vector<std::uint64_t>& keys, std::size_t begin, std::size_t end,
                const Take& take) {
  constexpr std::int64_t kX = std::int64_t{1} << 42, kY = std::int64_t{1} << 21;
  const std::size_t n = keys.size();
  std::array<Row, 9> rows;
  std::array<std::uint64_t, 9> steps;
  for (int r = 0; r < 9; ++r) {
    steps[r] = static_cast<std::uint64_t>((r / 3 - 1) * kX + (r % 3 - 1) * kY);
    const auto from = std::lower_bound(keys.begin(), keys.end(), keys[begin] + steps[r] - kFine);
    rows[r].begin = rows[r].end = static_cast<std::size_t>(from - keys.begin());
  }
  for (std::size_t i = begin; i < end; ++i) {
    for (int r = 0; r < 9; ++r) {
      const std::uint64_t middle = keys[i] + steps[r];
      while (rows[r].begin < n && keys[rows[r].begin] < middle - kFine) ++rows[r].begin;
      while (rows[r].end < n && keys[rows[r].end] <= middle + kFine) ++rows[r].end;
    }
    take(i, rows);
  }
}

// Finds the boxes of higher number that overlap one box. Branch-free: the outcome is unpredictable.
class OverlapQuery {
 public:
  explicit OverlapQuery(const CellList::Entry& one) {
    get(&one.lower, lower_);
    get(&one.upper, upper_);
    lower_[3] = upper_[3] + 0.5;
    upper_[3] = 0;
  }
  // Writes their numbers and returns the count. The element after the last number is overwritten,
  // too.
  std::size_t find(const CellList::Entry* begin, const CellList::Entry* end,
                   std::int32_t* found) const {
    std::size_t many = 0;
    for (const CellList::Entry* other = begin; other != end; ++other) {
      Simd4d lower, upper;
      get(&other->lower, lower);
      get(&other->upper, upper);
      found[many] = static_cast<std::int32_t>(other->upper.w);
      many += movemask((lower_ <= upper) & (lower <= upper_)) == 0xf;
    }
    return many;
  }

 private:
  Simd4d lower_, upper_;
};

}  // namespace

AabbOverlaps find_aabb_overlaps(const std::vector<Aabb>& boxes, int threads) {
  AabbOverlaps out;
  out.places_.resize(boxes.size());
  const CellList list = sort_into_cells(boxes, threads);
  out.found_.resize((boxes.size() + kBoxesPerTask - 1) / kBoxesPerTask);
  parallel_for_blocks(
      threads, boxes.size(), kBoxesPerTask, [&](std::size_t begin, std::size_t end) {
        const auto task = static_cast<std::uint32_t>(begin / kBoxesPerTask);
        std::vector<std::int32_t>& found = out.found_[task];
        std::vector<std::int32_t> some;  // of one box
        walk_cells(list.keys, begin, end, [&](std::size_t k, std::span<const Row> rows) {
          const OverlapQuery query(list.boxes[k]);
          std::size_t many = 0, most = 1;
          for (const Row& row : rows) most += row.end - row.begin;
          if (some.size() < most) some.resize(2 * most);
          for (const Row& row : rows) {
            many += query.find(list.boxes.data() + row.begin, list.boxes.data() + row.end,
                               some.data() + many);
          }
          std::sort(some.data(), some.data() + many);
          out.places_[static_cast<std::size_t>(list.boxes[k].upper.w)] = {
              task, static_cast<std::uint32_t>(found.size()), static_cast<std::uint32_t>(many)};
          found.insert(found.end(), some.data(), some.data() + many);
        });
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

struct BoxQuery {
  const AlignedBox& box;
  std::vector<int>& found;
  bool intersectVolume(const AlignedBox& b) const { return b.intersects(box); }
  bool intersectObject(const IndexedBox& o) {
    if (o.box.intersects(box)) found.push_back(o.index);
    return false;  // continue the search
  }
};
}  // namespace

struct AabbTree::Impl {
  Eigen::KdBVH<double, 3, IndexedBox> tree;
  Aabb bounds;
};

AabbTree::AabbTree(std::vector<Aabb> boxes) : impl_(std::make_unique<Impl>()) {
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
AabbTree::~AabbTree() = default;
AabbTree::AabbTree(AabbTree&&) noexcept = default;
AabbTree& AabbTree::operator=(AabbTree&&) noexcept = default;

void AabbTree::find(const Aabb& query, std::vector<int>& found) const {
  const std::size_t first = found.size();
  const AlignedBox box(query.lower, query.upper);
  BoxQuery q{box, found};
  Eigen::BVIntersect(impl_->tree, q);
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(first), found.end());
}

const Aabb& AabbTree::bounds() const { return impl_->bounds; }

}  // namespace firn
