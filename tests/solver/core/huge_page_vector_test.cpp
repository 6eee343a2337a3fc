#include "solver/core/huge_page_vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

namespace firn {
namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;

struct alignas(64) Line {
  std::uint64_t number = 0;
};

std::uintptr_t place(const void* at) { return reinterpret_cast<std::uintptr_t>(at); }

TEST(HugePageVector, BeginsOnALargePageFromAQuarterOfOneOn) {
  for (const std::size_t bytes : {kPage / 4, kPage / 2, kPage + 1, 5 * kPage}) {
    // Several at once, so that chance alone does not put them there.
    const HugePageVector<std::uint8_t> a(bytes), b(bytes), c(bytes);
    for (const auto* array : {&a, &b, &c}) EXPECT_EQ(place(array->data()) % kPage, 0u) << bytes;
  }
  const HugePageVector<std::uint8_t> a(kPage / 4 - 1), b(kPage / 4 - 1);
  EXPECT_FALSE(place(a.data()) % kPage == 0 && place(b.data()) % kPage == 0);
}

TEST(HugePageVector, SmallOnesAreAlignedAsTheirElements) {
  for (std::size_t n = 1; n < 40; ++n) {
    const HugePageVector<Line> lines(n);
    EXPECT_EQ(place(lines.data()) % alignof(Line), 0u);
  }
}

TEST(HugePageVector, KeepsWhatItHoldsWhileItGrowsAndMoves) {
  HugePageVector<Line> numbers;
  for (std::uint64_t k = 0; k < 100000; ++k)
    numbers.push_back({k});  // through both kinds of memory
  HugePageVector<Line> taken = std::move(numbers), copy = taken;
  taken.clear();
  taken.shrink_to_fit();
  ASSERT_EQ(copy.size(), 100000u);
  for (std::uint64_t k = 0; k < copy.size(); ++k) ASSERT_EQ(copy[k].number, k);
}

TEST(HugePageVector, ResizedAfreshHasRoomToGrow) {
  HugePageVector<double> v;
  resize_discarding(v, 1000);
  std::iota(v.begin(), v.end(), 0.0);
  const double* const at = v.data();
  resize_discarding(v, 1100);
  EXPECT_EQ(v.data(), at);
  EXPECT_EQ(v.size(), 1100u);
  resize_discarding(v, 10);
  EXPECT_EQ(v.size(), 10u);
  resize_discarding(v, 1000000);
  EXPECT_EQ(v.size(), 1000000u);
  EXPECT_GE(v.capacity(), 1125000u);
}

}  // namespace
}  // namespace firn
