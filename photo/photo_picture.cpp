// The picture by which a user checks what was found in a photograph.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "experiments/system/gnuplot.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "photo/heap_photo.h"

namespace firn {
namespace {

constexpr int kMostWidth = 1600;  // pixels of the drawn photograph
constexpr double kTitleHeight = 92;
constexpr const char* kOutlineColor = "#d0189a";
constexpr const char* kLineColor = "#e02a10";
constexpr const char* kLedgeColor = "#ffb300";
constexpr const char* kCornerColor = "#12a03c";

// Every `factor` pixels each way as one, rows from the bottom up.
std::vector<std::array<std::uint8_t, 3>> reduced_rows(const Photograph& photo, int factor,
                                                      int width, int height) {
  std::vector<std::array<std::uint8_t, 3>> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * height);
  for (int row = height - 1; row >= 0; --row) {
    for (int column = 0; column < width; ++column) {
      std::array<int, 3> sum{};
      for (int b = 0; b < factor; ++b) {
        for (int a = 0; a < factor; ++a) {
          const auto p = photo.at(column * factor + a, row * factor + b);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += p[c];
        }
      }
      const int n = factor * factor;
      pixels.push_back({static_cast<std::uint8_t>(sum[0] / n),
                        static_cast<std::uint8_t>(sum[1] / n),
                        static_cast<std::uint8_t>(sum[2] / n)});
    }
  }
  return pixels;
}

// Curves and labels over a photograph that is shown reduced by a whole factor.
class PhotoOverlay {
 public:
  PhotoOverlay(const WallCamera& camera, int factor, int height)
      : camera_(camera), factor_(factor), height_(height) {}

  // Through points of the photograph.
  void curve(const std::vector<Vec2>& pixels, const std::string& style) {
    data_ += fmt::format("$curve{} << EOD\n", blocks_);
    for (const Vec2& p : pixels)
      data_ +=
          fmt::format("{:.2f} {:.2f}\n", p.x() / factor_ - 0.5, height_ - 0.5 - p.y() / factor_);
    data_ += "EOD\n";
    curves_ += fmt::format(", $curve{} with {}", blocks_++, style);
  }

  // Ledge, fit window, outline and fitted line of a slope, and its angle. `height`: that of the
  // ledge's picture, m.
  void add_slope(const PhotoSlope& slope, double height) {
    const PhotoLedge& ledge = slope.ledge;
    const double from = slope.lines.window.from, to = slope.lines.window.to;
    const auto z = [&](double s) {
      return slope.lines.robust.intercept + slope.lines.robust.slope * s;
    };
    const std::string thin = fmt::format("lines lw 1.5 lc rgb '{}'", kLedgeColor);
    line(ledge, {0, 0}, {ledge.length(), 0}, thin);
    for (const double s : {0.0, from, to, ledge.length()})
      line(ledge, {s, 0}, {s, height}, thin + (s == from || s == to ? "" : " dt 2"));
    std::vector<Vec2> outline;
    for (const Vec2& p : slope.outline) outline.push_back(camera_.pixel(p));
    curve(outline, fmt::format("lines lw 2 lc rgb '{}'", kOutlineColor));
    line(ledge, {from, z(from)}, {to, z(to)}, "lines lw 5 lc rgb '#ffffff'");
    line(ledge, {from, z(from)}, {to, z(to)}, fmt::format("lines lw 2.5 lc rgb '{}'", kLineColor));
    const Vec2 above = camera_.pixel({ledge.x((from + to) / 2), 0.93 * height});
    labels_ += fmt::format(
        "set label {} at {:.1f},{:.1f} center front font 'DejaVu Sans:Bold,16' tc rgb '{}'\n",
        encode::gnuplot(measured_text(slope.lines.robust_angle, slope.lines.robust_uncertainty) +
                        " deg"),
        above.x() / factor_, height_ - above.y() / factor_, kLineColor);
  }

  std::string commands() const { return data_ + labels_; }  // before the plot
  const std::string& curves() const { return curves_; }     // of the plot

 private:
  // Between two points (distance, height) of the wall, which the lens may bend.
  void line(const PhotoLedge& ledge, const Vec2& a, const Vec2& b, const std::string& style) {
    constexpr int kPieces = 40;
    std::vector<Vec2> pixels;
    for (int k = 0; k <= kPieces; ++k) {
      const Vec2 p = a + (b - a) * k / kPieces;
      pixels.push_back(camera_.pixel({ledge.x(p.x()), p.y()}));
    }
    curve(pixels, style);
  }

  const WallCamera& camera_;
  int factor_, height_;
  std::string data_, curves_, labels_;
  int blocks_ = 0;
};

// Three lines above a picture of `canvas` pixels of height.
std::string photo_captions(const HeapPhotoResult& result, const PhotoAngle& heap, double canvas) {
  const auto title = [&](double row, int size, const char* color, const std::string& text) {
    return fmt::format(
        "set label {} at screen 0.012, screen {:.5f} font ',{}' tc rgb '{}' noenhanced\n",
        encode::gnuplot(text), 1 - row / canvas, size, color);
  };
  return title(22, 16, "#1d2733", result.setup.name) +
         title(50, 13, "#1d2733",
               fmt::format("{}: {} deg from the roughness of the outline; camera and threshold "
                           "± {:.2g} deg",
                           std::filesystem::path(heap.file).filename().string(),
                           measured_text(heap.angle, heap.roughness), result.systematic)) +
         title(74, 12, "#5b6673",
               "purple: outline of the ice; red: fitted line; yellow: floor, ledge and fit "
               "window; green crosses: corners");
}

}  // namespace

void draw_heap_photo(const HeapPhotoResult& result, std::size_t number, const Photograph& photo,
                     const std::string& file) {
  Gnuplot::check_picture(file);
  const PhotoAngle& heap = result.heaps.at(number);
  const WallCamera camera = wall_camera(result.setup, photo.width, photo.height);
  const int factor = (photo.width + kMostWidth - 1) / kMostWidth;
  const int width = photo.width / factor, height = photo.height / factor;
  const Gnuplot gnuplot;
  PhotoOverlay overlay(camera, factor, height);
  for (const PhotoSlope& slope : heap.slopes) overlay.add_slope(slope, result.setup.height);
  std::vector<Vec2> corners;
  for (const WallPoint& c : result.setup.corners) corners.push_back(c.pixel);
  overlay.curve(corners, fmt::format("points pt 1 ps 2.5 lw 2.5 lc rgb '{}'", kCornerColor));

  const double canvas = height + kTitleHeight;
  std::string script = overlay.commands() + photo_captions(result, heap, canvas);
  script += fmt::format(
      "unset key\nunset border\nunset tics\nset lmargin at screen 0\nset rmargin at screen 1\n"
      "set bmargin at screen 0\nset tmargin at screen {:.6f}\n"
      "set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\nplot {} with rgbimage{}\n",
      height / canvas, width - 1, height - 1,
      gnuplot.image("photo", width, height, reduced_rows(photo, factor, width, height)),
      overlay.curves());
  gnuplot.draw(script, file, width, static_cast<int>(canvas));
}

}  // namespace firn
