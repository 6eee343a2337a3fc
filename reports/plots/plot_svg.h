// Common parts of plots: gnuplot scripts, and the conversion of its SVG to an element of a page.
#pragma once

#include <array>
#include <fstream>
#include <string>
#include <vector>

#include "experiments/system/gnuplot.h"

namespace firn::plots {

// Colors are names for those of the page's style sheet: gnuplot gets a placeholder color,
// which the SVG replaces by var(--ink). Quoted for gnuplot.
namespace color {
constexpr const char* text = "'#010203'";
constexpr const char* muted = "'#010204'";
constexpr const char* line = "'#010205'";
}  // namespace color
std::string series_color(int k);  // from 0; eight of them, then again

// Dash and marker of series k, as gnuplot numbers them.
std::string dash(int k);
int marker(int k);

std::string palette_script();  // dark blue to yellow, ascending in lightness

class Drawing {
 public:
  Drawing(int width, int height) : width_(width), height_(height) {}

  // Writes rows as columns of a file; returns its name, quoted.
  template <std::size_t Columns>
  std::string data(const std::string& name,
                   const std::vector<std::array<double, Columns>>& rows) const;

  // The drawing of the script as an SVG element with unique ids, for any place in a page.
  std::string svg(const std::string& script) const;
  // Axes with the note that there are no data.
  std::string empty_plot(const std::string& x_title, const std::string& y_title) const;

 private:
  std::string write(const std::string& name, const double* values, std::size_t rows,
                    std::size_t columns) const;
  Gnuplot gnuplot_;
  int width_, height_;
};

template <std::size_t Columns>
std::string Drawing::data(const std::string& name,
                          const std::vector<std::array<double, Columns>>& rows) const {
  return write(name, rows.empty() ? nullptr : rows.front().data(), rows.size(), Columns);
}

}  // namespace firn::plots
