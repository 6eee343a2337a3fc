// Results files with damage anywhere: every reader of them, as `firn measure` and `firn export` use
// them. An input is a list of edits to the file of a small run. Not covered: going on from a
// damaged file, which writes to it.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "experiments/responses/measure.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "experiments/storage/hdf5_file.h"
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
  fuzz::accepts([&] { recording.exit_time(), recording.discharge_time(); });
  fuzz::accepts([&] { read_frames(recording); });
  fuzz::accepts([&] { recording.stages(); });
  fuzz::accepts([&] { recording.responses(); });
  fuzz::accepts([&] {
    for (const Series& series : recording.series_list()) recording.series(series.path);
  });
  fuzz::accepts([&] { recording.has_checkpoint(); });
  fuzz::accepts([&] { read_case(recording); });
  fuzz::accepts([&] { measure(recording); });
  fuzz::accepts([&] { export_csv(recording, folder); });
  fuzz::accepts([&] { export_vtk(recording, folder); });
}

constexpr const char* kCase = R"([case]
duration = "3 ms"
[materials.ice]
density = "900 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.5
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 12 mm"
[[boundaries]]
name = "floor"
material = "ice"
kind = "plane"
normal = [0, 0, 1]
[output]
frame_interval = "1 ms"
)";

// The bytes of a small run's file, and where its metadata lie: half of the edits go there.
struct Whole {
  std::string bytes;
  std::vector<std::size_t> metadata;

  explicit Whole(const fuzz::Folder& folder) {
    const std::string file = folder.path("whole.h5");
    RunOptions options;
    options.results_file = file;
    run(read_case_text(kCase, "case.toml", "."), options);
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
    fuzz::require(bytes.size() > 2048, "a run leaves a results file");
    for (std::size_t i = 0; i < 2048; ++i) metadata.push_back(i);
    for (std::size_t i = 2048; i + 4 < bytes.size(); ++i) {
      const std::string_view word(&bytes[i], 4);
      if (word != "TREE" && word != "SNOD" && word != "HEAP" && word != "OHDR" && word != "GCOL") {
        continue;
      }
      for (std::size_t k = i; k < std::min(i + 512, bytes.size()); ++k) metadata.push_back(k);
    }
  }
};

// One edit is eight bytes: what, where (three), how much (four).
std::string damaged(const Whole& whole, std::string_view edits) {
  std::string bytes = whole.bytes;
  const auto* p = reinterpret_cast<const unsigned char*>(edits.data());
  for (; edits.size() >= 8 && !bytes.empty(); edits.remove_prefix(8), p += 8) {
    const std::size_t place = p[1] | p[2] << 8 | p[3] << 16;
    const std::size_t at =
        (p[0] & 8 ? place : whole.metadata[place % whole.metadata.size()]) % bytes.size();
    const std::size_t left = bytes.size() - at;
    switch (p[0] & 7) {
      case 0:
        bytes[at] = static_cast<char>(p[4]);
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ 1 << (p[4] & 7));
        break;
      case 2: {  // a number of eight bytes, near a power of two
        const std::uint64_t value = (std::uint64_t{1} << (p[4] & 63)) - (p[5] & 3);
        std::memcpy(&bytes[at], &value, std::min<std::size_t>(8, left));
        break;
      }
      case 3:
        std::memset(&bytes[at], p[4] & 1 ? 0xff : 0, std::min<std::size_t>(left, 1 + p[5] % 64));
        break;
      case 4:
        bytes[at] = static_cast<char>(bytes[at] + static_cast<signed char>(p[4]));
        break;
      case 5: {  // a piece of elsewhere
        const std::size_t from =
            whole.metadata[(p[4] | p[5] << 8 | p[6] << 16) % whole.metadata.size()] % bytes.size();
        std::memmove(&bytes[at], &bytes[from],
                     std::min({left, bytes.size() - from, std::size_t{1} + p[7] % 64}));
        break;
      }
      case 6:
        std::memcpy(&bytes[at], p + 4, std::min<std::size_t>(4, left));
        break;
      default:
        if (p[4] == 0) bytes.resize(at);
    }
  }
  return bytes;
}

// True when a child that only lists the objects of the file does not end as it should. HDF5 1.10
// crashes on some damaged files; the program lets a child read first, for the same reason.
bool breaks_hdf5(const std::string& file) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGALRM, SIG_DFL);
    alarm(10);
    if (!std::freopen("/dev/null", "w", stderr)) _exit(0);
    try {
      hdf5::File::open(file, hdf5::File::Access::read).objects();
    } catch (const std::exception&) {
    }
    _exit(0);
  }
  int status = 0;
  return child < 0 || waitpid(child, &status, 0) != child || status != 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const Whole whole(folder);
  const std::string file = folder.put("results.h5", damaged(whole, fuzz::text_of(data, size)));
  if (breaks_hdf5(file)) return 0;
  fuzz::accepts([&] {
    const Recording recording(file);
    read_all(recording, folder.path("exported"));
  });
  return 0;
}
