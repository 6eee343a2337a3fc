// Two convex parts and a pose out of the input's bytes, degenerate ones by preference, against the
// slow referee.
#include <cstring>

#include "tests/fuzz/fuzz_target.h"
#include "tests/solver/collision/narrowphase_properties.h"

namespace {

using namespace firn;

// The bytes one by one, then zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int below(int n) { return static_cast<int>(next() % static_cast<unsigned>(n)); }
  // Of [-1, 1]: a multiple of 1/8 mostly, so that features meet exactly; else any.
  double fraction() {
    const unsigned kind = next();
    if (kind < 192) return (static_cast<int>(kind % 17) - 8) / 8.0;
    std::uint32_t bits = 0;
    for (int i = 0; i < 4; ++i) bits = bits << 8 | next();
    return bits / 2147483647.5 - 1;
  }
  // A power of ten from -15 to 0, either sign, or zero.
  double tiny() {
    const int k = below(33);
    return k == 32 ? 0 : (k % 2 ? 1 : -1) * std::pow(10.0, -k / 2);
  }
  Vec3 vector() {
    const double x = fraction(), y = fraction();
    return {x, y, fraction()};
  }

 private:
  unsigned next() { return at_ < size_ ? data_[at_++] : 0; }
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

ConvexPart make_part(Bytes& bytes) {
  switch (bytes.below(4)) {
    case 0:
      return sphere_part(bytes.vector(), 0);
    case 1: {
      Vec3 half = bytes.vector().cwiseAbs();
      for (int i = 0; i < 3; ++i) half[i] = std::max(half[i], 1e-3);
      return testing::box(half, 0);
    }
    default: {
      std::vector<Vec3> points;
      for (int n = 4 + bytes.below(16); n > 0; --n) points.push_back(bytes.vector());
      return convex_part(convex_hull(points), 0);
    }
  }
}

Pose make_pose(Bytes& bytes) {
  Pose pose;
  switch (bytes.below(3)) {
    case 0:
      break;
    case 1: {  // axes onto axes
      for (int i = bytes.below(4); i > 0; --i) {
        pose.rotation = Eigen::AngleAxisd(M_PI / 2, Vec3::Unit(bytes.below(3))) * pose.rotation;
      }
      pose.rotation = pose.rotation.array().round();
      break;
    }
    default: {
      const Vec3 axis = bytes.vector();
      const double angle = bytes.below(2) ? bytes.tiny() : M_PI * bytes.fraction();
      if (axis.norm() > 1e-6) pose.rotation = Eigen::AngleAxisd(angle, axis.normalized());
    }
  }
  pose.translation = 2 * bytes.vector();
  if (bytes.below(2)) {
    const double amount = bytes.tiny();
    pose.translation += amount * bytes.vector();
  }
  return pose;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  fuzz::accepts([&] {
    const double scale = std::pow(10.0, -bytes.below(4));  // 1 m to 1 mm
    const ConvexPart a = make_part(bytes), b = bytes.below(8) ? make_part(bytes) : a;
    Pose pose = make_pose(bytes);
    const ConvexPart sa = testing::scaled(a, scale), sb = testing::scaled(b, scale);
    pose.translation *= scale;
    const testing::CollideVerdict verdict = testing::judge(sa, sb, pose);
    if (!verdict.sound()) fuzz::broken(verdict.sentence());
  });
  return 0;
}
