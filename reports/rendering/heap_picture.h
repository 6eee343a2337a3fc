// Pictures of the drained angle of repose test: the particles as they lie, and the angle measured.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/case/case.h"
#include "experiments/results/results_file.h"

namespace firn {

// What is drawn, as plain data.
struct HeapPicture {
  std::string title, subtitle;
  DrainedRepose setup;
  std::vector<PlacedMesh> particles;
  bool door_open = true;     // draws the fitted lines; a closed door is drawn instead
  double particle_size = 0;  // m, for the fit
  double mean_volume = 0;    // m^3 of a particle, for the fit's uncertainty
  int width = 1600;          // pixels of the whole picture; the height follows
};

// Above, the box seen from the front and above; below, its elevation to scale with the mean surface
// of either ledge, the robust lines and their angles. FILE.png or FILE.svg. Throws InputError for
// another extension or without gnuplot.
void draw_heap(const HeapPicture& picture, const std::string& file);

// The same of one frame of a results file. Throws InputError when its case is another experiment or
// the frame does not exist.
void draw_heap(const Recording& recording, std::size_t frame, const std::string& file);

}  // namespace firn
