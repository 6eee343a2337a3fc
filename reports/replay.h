// The interactive replay of a run: a three-dimensional view on a page, with its data.
#pragma once

#include <cstddef>

#include "experiments/recording.h"
#include "reports/page.h"

namespace firn {

struct ReplayOptions {
  // Frames at most: so many a second of simulated time, or so many where that would be fewer (an
  // impact is looked at slowly).
  double rate = 30;
  double at_least = 900;
  std::size_t budget = 12'000'000;  // characters of data on the page, at most: frames are left out
};

// What has been left out to make it fit.
struct ReplaySize {
  std::size_t frames = 0, recorded_frames = 0;
  std::size_t characters = 0;  // of data
};

// Adds a section with the replay, its scripts and data. A run without a frame gets none.
ReplaySize add_replay(page::Page& page, const Recording& recording, const Case& c,
                      const ReplayOptions& options = {});

}  // namespace firn
