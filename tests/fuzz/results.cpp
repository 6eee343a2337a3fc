// Results files with damage anywhere: every reader of them, as `firn measure` and `firn export` use
// them. Not covered: going on from a damaged file, which writes to it.
#include <cmath>
#include <cstring>
#include <random>

#include "experiments/export.h"
#include "experiments/recording.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

using namespace firn;

void read_frames(const Recording& recording) {
  const std::size_t frames = recording.frame_times().size();
  for (std::size_t i : {std::size_t{0}, frames / 2, frames}) {
    fuzz::accepts([&] {
      const Frame frame = recording.frame(i);
      for (std::size_t n : {frame.position.size(), frame.orientation.size(), frame.velocity.size(),
                            frame.angular_velocity.size()}) {
        fuzz::require(n == recording.particle_count(), "a frame has all particles");
      }
    });
    fuzz::accepts([&] { recording.boundary("floor", i); });
  }
}

void read_all(const Recording& recording, const std::string& folder) {
  fuzz::accepts([&] { fuzz::require_one_line("status: " + recording.status()); });
  fuzz::accepts([&] { recording.seed(); });
  fuzz::accepts([&] { recording.timestep(); });
  fuzz::accepts([&] { recording.shape(), recording.tag(); });
  fuzz::accepts([&] { recording.mass(), recording.peak_normal_force(); });
  fuzz::accepts([&] { recording.exit_time(), recording.door_time(); });
  fuzz::accepts([&] { read_frames(recording); });
  fuzz::accepts([&] { recording.stages(); });
  fuzz::accepts([&] { recording.responses(); });
  fuzz::accepts([&] {
    for (const Series& series : recording.series_list()) recording.series(series.path);
  });
  fuzz::accepts([&] { recording.has_checkpoint(); });
  fuzz::accepts([&] { recording.read_case(); });
  fuzz::accepts([&] { measure(recording); });
  fuzz::accepts([&] { export_csv(recording, folder); });
  fuzz::accepts([&] { export_vtk(recording, folder); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const std::string file = folder.put("results.h5", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const Recording recording(file);
    read_all(recording, folder.path("exported"));
  });
  return 0;
}

#ifdef FIRN_LIBFUZZER
// Places in the file refer to each other: damage keeps them where they are, but for the end.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t,
                                               unsigned seed) {
  std::minstd_rand random(seed);
  const auto below = [&](std::size_t n) { return random() % std::max<std::size_t>(n, 1); };
  for (std::size_t edits = 1 + below(4); edits > 0 && size > 0; --edits) {
    const std::size_t at = below(size);
    switch (below(8)) {
      case 0:
        data[at] = static_cast<std::uint8_t>(data[at] ^ 1u << below(8));
        break;
      case 1:
        data[at] = static_cast<std::uint8_t>(below(256));
        break;
      case 2:
        std::memset(data + at, below(2) ? 0xff : 0, std::min(size - at, 1 + below(8)));
        break;
      case 3:
        data[at] = static_cast<std::uint8_t>(data[at] + below(9) - 4);
        break;
      case 4:
      case 5: {  // a piece of elsewhere
        const std::size_t from = below(size);
        std::memmove(data + at, data + from, std::min({size - at, size - from, 1 + below(16)}));
        break;
      }
      case 6: {  // a number of eight bytes, small or near a power of two
        const std::uint64_t value = (std::uint64_t{1} << below(64)) - below(3);
        std::memcpy(data + at / 8 * 8, &value, std::min<std::size_t>(8, size - at / 8 * 8));
        break;
      }
      default:
        if (below(20) == 0) size = at;
    }
  }
  return std::max<std::size_t>(size, 1);
}
#endif
