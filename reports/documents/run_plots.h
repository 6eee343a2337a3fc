// Plots of one run.
#pragma once

#include <vector>

#include "experiments/results/response.h"
#include "experiments/results/results_file.h"
#include "reports/html/page.h"

namespace firn {

// Each is empty where the run has no data for it.
std::vector<page::Figure> energy_figures(const Recording& recording);
std::vector<page::Figure> load_figures(const Recording& recording, const Case& c);
// Forces on what is sampled, and accelerations of its joints.
std::vector<page::Figure> sample_figures(const Recording& recording, const Case& c);
std::vector<page::Figure> motion_figures(const Recording& recording, const Case& c);
std::vector<page::Figure> passage_figures(const Recording& recording, const Case& c);
// Of measures of the kind "curve"; a folded one with its least and largest values as a band.
std::vector<page::Figure> measured_curve_figures(const std::vector<Response>& responses,
                                                 const Case& c);

// Fewer points for drawing: the first, lowest and highest of equal stretches, in order, so that no
// peak is lost. Lists of at most `most` points stay as they are.
struct Curve {
  std::vector<double> x, y;
};
Curve downsampled_curve(const std::vector<double>& x, const std::vector<double>& y,
                        std::size_t most = 1500);

}  // namespace firn
