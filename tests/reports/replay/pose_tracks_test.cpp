#include "reports/replay/pose_tracks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "reports/html/data_encoding.h"

namespace firn {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Reads what pack() wrote by the words of its header alone.
struct Decoded {
  std::vector<bool> there;  // [T * bodies]
  std::vector<Vec3> position;
  std::vector<Quat> orientation;
};
Decoded decode(const PackedTrajectories& p) {
  const std::size_t count = 7 * p.bodies * p.frames;
  EXPECT_EQ(p.bytes.size(), 2 * count);
  std::vector<int> number(count);  // [channel][body][frame]
  for (std::size_t series = 0; series < 7 * p.bodies; ++series) {
    int value = 0;
    for (std::size_t t = 0; t < p.frames; ++t) {
      const std::size_t at = series * p.frames + t;
      const int folded = p.bytes[at] + 256 * p.bytes[count + at];
      value += folded % 2 == 0 ? folded / 2 : -(folded + 1) / 2;
      while (value > 32767) value -= 65536;
      while (value < -32768) value += 65536;
      number[at] = value;
    }
  }
  Decoded d;
  for (std::size_t t = 0; t < p.frames; ++t) {
    for (std::size_t body = 0; body < p.bodies; ++body) {
      const auto n = [&](std::size_t k) { return number[(k * p.bodies + body) * p.frames + t]; };
      d.there.push_back(n(0) != -32768);
      Vec3 x;
      for (int k = 0; k < 3; ++k)
        x[k] =
            p.low[k] + (n(static_cast<std::size_t>(k)) + 32767) / 65534.0 * (p.high[k] - p.low[k]);
      d.position.push_back(x);
      d.orientation.push_back(Quat(n(3), n(4), n(5), n(6)).normalized());
    }
  }
  return d;
}

double angle_between(const Quat& a, const Quat& b) {
  return 2 * std::asin(std::min(1.0, (a.conjugate() * b).vec().norm()));
}

// Bodies that wander and tumble; every seventh is missing now and then, signs of quaternions
// change.
PoseTracks wandering(std::size_t bodies, std::size_t frames, double rate) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0, 1);
  PoseTracks tracks;
  tracks.bodies = bodies;
  std::vector<std::array<float, 3>> at(bodies);
  std::vector<Eigen::Quaternionf> turned(bodies, Eigen::Quaternionf::Identity());
  for (auto& x : at) x = {0.2F * normal(random), 0.1F * normal(random), 0.3F * normal(random)};
  for (std::size_t t = 0; t < frames; ++t) {
    tracks.time.push_back(static_cast<double>(t) / rate);
    for (std::size_t b = 0; b < bodies; ++b) {
      for (float& x : at[b]) x += 1e-3F * normal(random);
      const Eigen::Vector3f axis(normal(random), normal(random), normal(random));
      turned[b] = turned[b] * Eigen::AngleAxisf(0.1F * normal(random), axis.normalized());
      turned[b].normalize();
      const bool missing = b % 7 == 3 && t % 11 < 4;
      tracks.position.push_back(missing ? std::array<float, 3>{kNan, kNan, kNan} : at[b]);
      const float sign = (t + b) % 3 == 0 ? -1 : 1;
      const Eigen::Quaternionf& q = turned[b];
      tracks.orientation.push_back({sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z()});
    }
  }
  return tracks;
}

TEST(PoseTracks, PackedPosesAreWithinHalfAStep) {
  const PoseTracks tracks = wandering(20, 200, 30);
  const PackedTrajectories packed = pack(tracks);
  const Decoded decoded = decode(packed);
  const Vec3 step = (packed.high - packed.low) / 65534;
  for (std::size_t i = 0; i < tracks.position.size(); ++i) {
    const auto& p = tracks.position[i];
    ASSERT_EQ(decoded.there[i], !std::isnan(p[0])) << i;
    if (!decoded.there[i]) continue;
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(decoded.position[i][k] - p[static_cast<std::size_t>(k)]), 0.501 * step[k]);
    const auto& q = tracks.orientation[i];
    EXPECT_LT(angle_between(decoded.orientation[i], Quat(q[0], q[1], q[2], q[3]).normalized()),
              1e-4);
  }
}

TEST(PoseTracks, WhatRestsInAPlaneOrIsNeverThereIsPackedAsWell) {
  PoseTracks tracks;
  tracks.bodies = 2;
  tracks.time = {0, 1};
  for (int t = 0; t < 2; ++t) {
    tracks.position.push_back({0.5F, 0, 0});
    tracks.position.push_back({kNan, kNan, kNan});
    tracks.orientation.push_back({1, 0, 0, 0});
    tracks.orientation.push_back({kNan, kNan, kNan, kNan});
  }
  const Decoded decoded = decode(pack(tracks));
  EXPECT_EQ(decoded.there, (std::vector<bool>{true, false, true, false}));
  EXPECT_NEAR(decoded.position[2].x(), 0.5, 1e-9);
}

TEST(PoseTracks, ThinningKeepsTheLastFrameAndNoMoreThanItsRate) {
  const PoseTracks fast = wandering(1, 1001, 1000);  // a second
  const PoseTracks thin = fast.downsampled(30);
  EXPECT_EQ(thin.time.front(), 0);
  EXPECT_EQ(thin.time.back(), 1);
  EXPECT_NEAR(static_cast<double>(thin.time.size()), 31, 1);
  EXPECT_EQ(thin.position.size(), thin.time.size());
  // One that has no more than that is not thinned.
  EXPECT_EQ(wandering(1, 61, 30).downsampled(30).time.size(), 61U);
}

TEST(PoseTracks, AMinuteOf160MovingBodiesIsSmall) {
  const std::string text = base64(zlib_compressed(pack(wandering(160, 1801, 30)).bytes));
  EXPECT_LT(text.size(), 6'000'000U);  // all of them tumble at every instant: nothing to save
}

TEST(PoseTracks, Base64IsThatOfRfc4648) {
  const auto of = [](const std::string& text) {
    return base64(std::vector<std::uint8_t>(text.begin(), text.end()));
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foo"), "Zm9v");
  EXPECT_EQ(of("foob"), "Zm9vYg==");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace firn
