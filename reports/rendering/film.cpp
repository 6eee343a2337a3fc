#include "reports/rendering/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/system/input_file.h"
#include "experiments/system/output_file.h"
#include "experiments/system/process.h"
#include "experiments/system/temporary_folder.h"
#include "reports/rendering/scene_picture.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kMostPictures = 100000;

// For each picture of the film, the recorded frame nearest to its time.
std::vector<std::size_t> frames_shown(const std::vector<double>& times, double step,
                                      std::size_t pictures) {
  std::vector<std::size_t> shown;
  std::size_t frame = 0;
  for (std::size_t k = 0; k < pictures; ++k) {
    const double time = times.front() + step * static_cast<double>(k);
    while (frame + 1 < times.size() &&
           std::abs(times[frame + 1] - time) <= std::abs(times[frame] - time))
      ++frame;
    shown.push_back(frame);
  }
  return shown;
}

}  // namespace

void write_film(const Recording& recording, const std::string& file, const FilmOptions& options) {
  if (fs::path(file).extension() != ".mp4")
    throw InputError(file + ": has another extension; expected FILE.mp4");
  if (!(options.speed > 0) || !std::isfinite(options.speed))
    throw InputError(fmt::format("speed: is {}; expected a number above 0", options.speed));
  const std::vector<double> times = recording.frame_times();
  if (times.empty())
    throw InputError(recording.file() + ": holds no frame to draw; expected a run that has begun");
  const double step = options.speed / options.pictures_per_second;
  const double count = std::floor((times.back() - times.front()) / step * (1 + 1e-9)) + 1;
  if (!(count <= kMostPictures)) {
    throw InputError(fmt::format("speed: is {}, which takes {:.3g} pictures; expected at most {}",
                                 options.speed, count, kMostPictures));
  }
  const auto pictures = static_cast<std::size_t>(count);
  if (run_command({"ffmpeg", "-version"}).status != 0)
    throw InputError("ffmpeg is not installed; expected the program of the package ffmpeg");

  const std::vector<std::size_t> shown = frames_shown(times, step, pictures);
  RecordedScenes scenes(recording);
  Eigen::AlignedBox3d bounds;
  for (std::size_t k = 0; k < pictures; ++k)
    if (k == 0 || shown[k] != shown[k - 1]) bounds.extend(scene_bounds(scenes.scene(shown[k])));
  if (bounds.isEmpty()) {
    throw InputError(recording.file() +
                     ": has neither solid boundaries nor bodies; expected something to draw");
  }
  const double margin = 0.02 * bounds.diagonal().norm();
  bounds.min().array() -= margin;
  bounds.max().array() += margin;

  const TemporaryFolder folder("film");
  const auto picture_file = [&](std::size_t k) {
    return folder.file(fmt::format("picture{:06}.png", k));
  };
  for (std::size_t k = 0; k < pictures; ++k) {
    if (k > 0 && shown[k] == shown[k - 1]) {
      fs::create_hard_link(picture_file(k - 1), picture_file(k));
    } else {
      ScenePicture picture = scenes.scene(shown[k]);
      picture.width = options.width;
      draw_film_picture(picture, bounds, picture_file(k));
    }
    if (options.progress) options.progress(k + 1, pictures);
  }
  const CommandResult result = run_repeatable_command(
      {"ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-framerate",
       fmt::format("{}", options.pictures_per_second), "-i", "picture%06d.png", "-c:v", "libx264",
       "-pix_fmt", "yuv420p", "-movflags", "+faststart", "film.mp4"},
      folder.path().string());
  if (result.status != 0) throw RunError("ffmpeg: " + failure_text(result));
  // More than a film of the most pictures can take.
  constexpr std::uintmax_t most_bytes = std::uintmax_t{64} << 30;
  write_file(file, read_input_file(folder.file("film.mp4"), "the film of ffmpeg", most_bytes));
}

}  // namespace firn
