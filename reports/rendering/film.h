// Films of runs.
#pragma once

#include <functional>
#include <string>

#include "experiments/results/results_file.h"

namespace firn {

struct FilmOptions {
  double speed = 1;  // simulated seconds for each second of the film
  double pictures_per_second = 25;
  int width = 1280;  // pixels, a multiple of 32; the height is film_height(width)
  // Called after each picture: how many of how many are drawn.
  std::function<void(std::size_t done, std::size_t of)> progress;
};

// Writes FILE.mp4 (H.264) with the program ffmpeg, which runs without a shell. Each picture shows
// the recorded frame that is nearest in time; the viewpoint does not move. Throws InputError for
// another extension, for a recording without frames or without anything to draw, for a speed that
// is not above 0, for a film of more than 100 000 pictures, and where ffmpeg is not installed;
// RunError with the last line of its messages when ffmpeg fails; WriteError when the file cannot be
// written.
void write_film(const Recording& recording, const std::string& file, const FilmOptions& options);

}  // namespace firn
