// Rendered images as data of gnuplot scripts.
#pragma once

#include <string>

#include "experiments/system/gnuplot.h"
#include "reports/rendering/mesh_renderer.h"

namespace firn {

// Writes the image as the data file NAME; returns the source of a plot command "with rgbimage".
inline std::string image_source(const Gnuplot& gnuplot, const std::string& name,
                                const Image& image) {
  return gnuplot.image(name, image.width, image.height, image.pixels);
}

}  // namespace firn
