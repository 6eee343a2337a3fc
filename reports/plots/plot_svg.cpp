#include "reports/plots/plot_svg.h"

#include <fmt/format.h>

#include <atomic>
#include <sstream>

#include "experiments/system/output_file.h"
#include "firn/math.h"
#include "reports/plots/plot_text.h"

namespace firn::plots {
namespace {

constexpr int kSeries = 8;
constexpr int kFirstSeries = 16;  // blue channel of the stand-in of series 0

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

// gnuplot writes a color as rgb(1,2,3) or rgb(  1,   2,   3).
void name_color(std::string& svg, int blue, const std::string& variable) {
  for (const std::string& written :
       {fmt::format("rgb(1,2,{})", blue), fmt::format("rgb(  1,   2, {:3})", blue)})
    replace_all(svg, written, variable);
}

std::string for_page(std::string svg) {
  const auto start = svg.find("<svg"), canvas = svg.find("<g id=\"gnuplot_canvas\">");
  if (start == std::string::npos || canvas == std::string::npos)
    throw RunError("gnuplot: wrote another kind of SVG than is known");
  const auto view_box = svg.find("viewBox=");
  const std::string size = svg.substr(view_box, svg.find('"', view_box + 9) - view_box + 1);
  svg = fmt::format(
            "<svg {} xmlns=\"http://www.w3.org/2000/svg\" "
            "xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
            "aria-hidden=\"true\">",
            size) +
        svg.substr(canvas);

  static std::atomic<int> drawn = 0;
  const std::string prefix = fmt::format("plot{}-", ++drawn);
  for (const std::string start_of_id : {"id='", "id=\"", "href='#", "url(#"})
    replace_all(svg, start_of_id, start_of_id + prefix);
  replace_all(svg, " font-family=\"Arial\"", "");
  // Behind markers.
  for (const std::string white : {"\"white\"", "'white'"})
    replace_all(svg, white, "\"var(--ground)\"");
  name_color(svg, 3, "var(--ink)");
  name_color(svg, 4, "var(--faint)");
  name_color(svg, 5, "var(--line)");
  for (int k = 0; k < kSeries; ++k)
    name_color(svg, kFirstSeries + k, fmt::format("var(--series-{})", k + 1));
  return svg;
}

std::string prologue(int width, int height) {
  return fmt::format(
      "set encoding utf8\nset terminal svg size {},{} font ',17' rounded noenhanced\n"
      "set datafile missing 'nan'\nset border 3 lc rgb {text} lw 1\n"
      "set tics nomirror out textcolor rgb {text}\nset grid lc rgb {line} lw 1 dt 1\n"
      "set xlabel textcolor rgb {text}\nset ylabel textcolor rgb {text}\n"
      "set key outside top left horizontal Left reverse samplen 3 font ',16' textcolor rgb "
      "{text}\n",
      width, height, fmt::arg("text", color::text), fmt::arg("line", color::line));
}

}  // namespace

std::string series_color(int k) { return fmt::format("'#0102{:02x}'", kFirstSeries + k % kSeries); }

std::string dash(int k) {
  static constexpr std::array<const char*, 6> kDashes = {"1",     "'-'",    "(8,3,2,3)",
                                                         "(2,3)", "(12,4)", "(8,3,2,3,2,3)"};
  return kDashes[static_cast<std::size_t>(k) % kDashes.size()];
}

int marker(int k) {
  static constexpr std::array<int, 8> kMarkers = {7, 4, 9, 12, 11, 6, 5, 8};
  return kMarkers[static_cast<std::size_t>(k) % kMarkers.size()];
}

std::string palette_script() {
  return "set palette defined (0 '#440154', 1 '#482878', 2 '#3e4989', 3 '#31688e', 4 '#26828e', "
         "5 '#1f9e89', 6 '#35b779', 7 '#6ece58', 8 '#b5de2b', 9 '#fde725') maxcolors 64\n";
}

std::string Drawing::write(const std::string& name, const double* values, std::size_t rows,
                           std::size_t columns) const {
  const std::filesystem::path file = gnuplot_.data_file(name);
  OutputFile stream(file.string(), OutputFile::When::unsynced);
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j)
      stream << fmt::format("{}{:.9g}", j ? " " : "", values[i * columns + j]);
    stream << '\n';
  }
  stream.commit();
  return fmt::format("'{}'", name);
}

std::string Drawing::svg(const std::string& script) const {
  gnuplot_.run(prologue(width_, height_) + "set output 'plot.svg'\n" + script + "unset output\n");
  return for_page(gnuplot_.picture("plot.svg"));
}

std::string Drawing::empty_plot(const std::string& x_title, const std::string& y_title) const {
  return svg(
      fmt::format("set xlabel {}\nset ylabel {}\nunset tics\nset xrange [0:1]\nset yrange [0:1]\n"
                  "set label 'no finite values' at graph 0.5, graph 0.5 center textcolor rgb "
                  "{}\nplot -1 notitle\n",
                  gnuplot_lines(wrap_text(x_title, 48, 2)),
                  gnuplot_lines(wrap_text(y_title, 28, 2)), color::muted));
}

}  // namespace firn::plots
