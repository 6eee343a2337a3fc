// The interactive replay of a run: a three-dimensional view on a page, with its data.
#pragma once

#include <cstddef>
#include <string>

#include "experiments/results/results_file.h"
#include "reports/html/page.h"

namespace firn {

struct ReplayViewOptions {
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

struct ReplayName {
  std::string anchor;  // in ids and links: letters, digits, hyphens; unique on a page
  std::string title;   // for people
};

// A replay at the end of `content`, with its data and, once on a page, its scripts. Where a page
// has several, each is unpacked when it is opened. A run without a frame gets none.
ReplaySize add_replay_view(page::Page& page, page::Content& content, const ReplayName& name,
                           const Recording& recording, const Case& c,
                           const ReplayViewOptions& options = {});
// A section with the only replay of a page.
ReplaySize add_replay(page::Page& page, const Recording& recording, const Case& c,
                      const ReplayViewOptions& options = {});

}  // namespace firn
