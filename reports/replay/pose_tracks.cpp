#include "reports/replay/pose_tracks.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

constexpr int kChannels = 7;
constexpr double kHalf = 32767;
constexpr std::int16_t kAbsent = -32768;

Eigen::AlignedBox3d box_of(const PoseTracks& tracks) {
  Eigen::AlignedBox3d box;
  for (const auto& p : tracks.position)
    if (!std::isnan(p[0])) box.extend(Vec3(p[0], p[1], p[2]));
  if (box.isEmpty()) box.extend(Vec3::Zero());
  // Nothing that moves in a plane divides by 0.
  box.min().array() -= 1e-6;
  box.max().array() += 1e-6;
  return box;
}

// Writes the channels of one body over all frames. In frames without the body, they repeat its
// last pose, and only the mark changes.
void quantize(const PoseTracks& tracks, std::size_t body, const PackedTrajectories& packed,
              std::array<std::vector<std::int16_t>, kChannels>& channel) {
  std::array<std::int16_t, kChannels> now{};
  std::array<float, 4> before{};
  for (std::size_t t = 0; t < packed.frames; ++t) {
    const auto& p = tracks.position[t * packed.bodies + body];
    auto q = tracks.orientation[t * packed.bodies + body];
    if (std::isnan(p[0])) {
      now[0] = kAbsent;
    } else {
      for (int k = 0; k < 3; ++k) {
        const double share = (p[k] - packed.low[k]) / (packed.high[k] - packed.low[k]);
        now[k] = static_cast<std::int16_t>(std::lround(2 * kHalf * share - kHalf));
      }
      float along = 0;
      for (int k = 0; k < 4; ++k) along += q[k] * before[k];
      for (int k = 0; k < 4; ++k) {
        if (along < 0) q[k] = -q[k];
        now[3 + k] = static_cast<std::int16_t>(std::lround(kHalf * q[k]));
      }
      before = q;
    }
    for (int k = 0; k < kChannels; ++k) channel[k][t] = now[k];
  }
}

}  // namespace

PoseTracks PoseTracks::downsampled(double rate) const {
  PoseTracks kept;
  kept.bodies = bodies;
  double due = time.empty() ? 0 : time.front();
  for (std::size_t t = 0; t < time.size(); ++t) {
    // Rounding shall not skip every other frame of a run that has just this rate.
    if (time[t] < due - 1e-6 / rate && t + 1 < time.size()) continue;
    due = std::max(due + 1 / rate, time[t]);
    kept.time.push_back(time[t]);
    const auto first = static_cast<std::ptrdiff_t>(t * bodies);
    const auto last = first + static_cast<std::ptrdiff_t>(bodies);
    kept.position.insert(kept.position.end(), position.begin() + first, position.begin() + last);
    kept.orientation.insert(kept.orientation.end(), orientation.begin() + first,
                            orientation.begin() + last);
  }
  return kept;
}

PackedTrajectories pack(const PoseTracks& tracks) {
  PackedTrajectories packed;
  packed.bodies = tracks.bodies;
  packed.frames = tracks.time.size();
  const Eigen::AlignedBox3d box = box_of(tracks);
  packed.low = box.min();
  packed.high = box.max();
  const std::size_t count = kChannels * packed.bodies * packed.frames;
  packed.bytes.resize(2 * count);
  std::array<std::vector<std::int16_t>, kChannels> channel;
  for (auto& c : channel) c.resize(packed.frames);
  for (std::size_t body = 0; body < packed.bodies; ++body) {
    quantize(tracks, body, packed, channel);
    for (std::size_t k = 0; k < kChannels; ++k) {
      std::size_t at = (k * packed.bodies + body) * packed.frames;
      std::uint16_t before = 0;
      for (const std::int16_t value : channel[k]) {
        const auto now = static_cast<std::uint16_t>(value);
        const auto step = static_cast<std::uint16_t>(now - before);
        const auto folded =
            static_cast<std::uint16_t>((step << 1) ^ ((step & 0x8000) != 0 ? 0xffff : 0));
        packed.bytes[at] = static_cast<std::uint8_t>(folded & 0xff);
        packed.bytes[count + at] = static_cast<std::uint8_t>(folded >> 8);
        before = now;
        ++at;
      }
    }
  }
  return packed;
}

}  // namespace firn
