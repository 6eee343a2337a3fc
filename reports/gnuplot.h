// Pictures through the program gnuplot.
#pragma once

#include <filesystem>
#include <string>

#include "reports/mesh_renderer.h"

namespace firn {

// One folder of data files and the scripts that draw them. The folder goes when this goes.
class Gnuplot {
 public:
  Gnuplot();
  ~Gnuplot();
  Gnuplot(const Gnuplot&) = delete;
  Gnuplot& operator=(const Gnuplot&) = delete;

  // Path of a data file to be written for the script.
  std::filesystem::path data_file(const std::string& name) const { return folder_ / name; }

  // Writes an image as a data file; returns what a plot command names it by, to be drawn
  // "with rgbimage". Throws RunError when it cannot be written.
  std::string image(const std::string& name, const Image& image) const;

  // Throws InputError when gnuplot is not installed, RunError with its message when it fails.
  void run(const std::string& script) const;

  // As a single-quoted string of gnuplot's language, quotes included.
  static std::string quoted(const std::string& text);
  // "set terminal ..." and "set output ..." for FILE.png or FILE.svg; size in pixels. Throws
  // InputError for another extension.
  static std::string output(const std::string& file, int width, int height);

 private:
  std::filesystem::path folder_;
};

}  // namespace firn
