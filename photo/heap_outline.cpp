#include "photo/heap_outline.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace firn {
namespace {

// In particle sizes:
constexpr double kCell = 1.0 / 40;     // finest cells
constexpr double kReach = 0.25;        // gaps that do not part a heap, as in supported_particles()
constexpr double kSpeck = 0.15;        // edge of a square below which a group is noise
constexpr double kEdge = 0.12;         // to either side of the outline, where its contrast is read
constexpr double kCleared = 0.25;      // above the heap the photograph must still show
constexpr double kLeastPixels = 10;    // of a particle
constexpr double kLeastContrast = 12;  // levels of 255 between heap and background
constexpr double kLeastSharpness = 0.3;  // of the contrast, across a sharp outline
constexpr double kMostUnsharp = 0.4;     // of the columns of the window
constexpr double kMostCells = 2e7;

using Rgb = std::array<double, 3>;

bool shows(const Photograph& photo, const Vec2& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= photo.width && p.y() <= photo.height;
}

// Between the middles of pixels, linearly.
Rgb color_at(const Photograph& photo, const Vec2& p) {
  const double u = std::clamp(p.x() - 0.5, 0.0, photo.width - 1.0);
  const double v = std::clamp(p.y() - 0.5, 0.0, photo.height - 1.0);
  const int i = std::min(static_cast<int>(u), photo.width - 2);
  const int j = std::min(static_cast<int>(v), photo.height - 2);
  const double a = u - i, b = v - j;
  const auto p00 = photo.at(i, j), p10 = photo.at(i + 1, j), p01 = photo.at(i, j + 1),
             p11 = photo.at(i + 1, j + 1);
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = (1 - b) * ((1 - a) * p00[c] + a * p10[c]) + b * ((1 - a) * p01[c] + a * p11[c]);
  return color;
}

double channel_value(const Rgb& color, PhotoChannel channel) {
  const auto [low, high] = std::minmax({color[0], color[1], color[2]});
  switch (channel) {
    case PhotoChannel::red:
      return color[0];
    case PhotoChannel::green:
      return color[1];
    case PhotoChannel::blue:
      return color[2];
    case PhotoChannel::saturation:
      return high > 0 ? 255 * (high - low) / high : 0;
    case PhotoChannel::luminance:
      break;
  }
  return 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2];  // ITU-R BT.601
}

double color_distance(const Rgb& a, const Rgb& b) {
  double squares = 0;
  for (std::size_t c = 0; c < 3; ++c) squares += (a[c] - b[c]) * (a[c] - b[c]);
  return std::sqrt(squares / 3);
}

struct OtsuThreshold {
  double threshold = 0, contrast = 0;
};
OtsuThreshold otsu(const std::vector<float>& value, const std::vector<char>& used) {
  constexpr int kBins = 512;
  double low = INFINITY, high = -INFINITY, count = 0;
  for (std::size_t k = 0; k < value.size(); ++k) {
    if (!used[k]) continue;
    low = std::min<double>(low, value[k]);
    high = std::max<double>(high, value[k]);
    ++count;
  }
  if (!(high > low)) return {low, 0};
  std::array<double, kBins> number{}, sum{};
  double total = 0;
  for (std::size_t k = 0; k < value.size(); ++k) {
    if (!used[k]) continue;
    const int bin = std::min(kBins - 1, static_cast<int>(kBins * (value[k] - low) / (high - low)));
    number[static_cast<std::size_t>(bin)] += 1;
    sum[static_cast<std::size_t>(bin)] += value[k];
    total += value[k];
  }
  // Thresholds within an empty stretch of the histogram are equally good: its middle is taken.
  OtsuThreshold best;
  double below = 0, sum_below = 0, most = -1, first = 0;
  for (int bin = 0; bin + 1 < kBins; ++bin) {
    below += number[static_cast<std::size_t>(bin)];
    sum_below += sum[static_cast<std::size_t>(bin)];
    if (below == 0 || below == count) continue;
    const double contrast = (total - sum_below) / (count - below) - sum_below / below;
    const double between = below * (count - below) * contrast * contrast;
    const double at = low + (bin + 1) * (high - low) / kBins;
    if (between > most) {
      most = between;
      first = at;
      best.contrast = contrast;
    }
    if (between >= most) best.threshold = (first + at) / 2;
  }
  return best;
}

// Gaussian of one cell over the cells that are visible.
std::vector<float> smoothed(const std::vector<float>& value, const std::vector<char>& visible,
                            int columns, int rows) {
  constexpr std::array<double, 4> kWeight{0.3989, 0.2420, 0.0540, 0.0044};
  std::vector<float> result = value;
  for (const bool along_rows : {true, false}) {
    const std::vector<float> from = result;
    for (int i = 0; i < columns; ++i) {
      for (int k = 0; k < rows; ++k) {
        double sum = 0, weight = 0;
        for (int offset = -3; offset <= 3; ++offset) {
          const int a = along_rows ? i : i + offset, b = along_rows ? k + offset : k;
          if (a < 0 || b < 0 || a >= columns || b >= rows) continue;
          const auto at = static_cast<std::size_t>(a) * rows + b;
          if (!visible[at]) continue;
          const double w = kWeight[static_cast<std::size_t>(std::abs(offset))];
          sum += w * from[at];
          weight += w;
        }
        if (weight > 0)
          result[static_cast<std::size_t>(i) * rows + k] = static_cast<float>(sum / weight);
      }
    }
  }
  return result;
}

// Numbers the groups of cells that are set and share edges; -1 elsewhere. Returns their number.
int number_groups(const std::vector<char>& set, int columns, int rows, std::vector<int>& group) {
  group.assign(set.size(), -1);
  int groups = 0;
  std::vector<int> front;
  for (int start = 0; start < columns * rows; ++start) {
    if (!set[static_cast<std::size_t>(start)] || group[static_cast<std::size_t>(start)] >= 0)
      continue;
    const auto enter = [&](int at) {
      if (!set[static_cast<std::size_t>(at)] || group[static_cast<std::size_t>(at)] >= 0) return;
      group[static_cast<std::size_t>(at)] = groups;
      front.push_back(at);
    };
    enter(start);
    while (!front.empty()) {
      const int at = front.back();
      front.pop_back();
      const int column = at / rows, row = at % rows;
      if (column > 0) enter(at - rows);
      if (column + 1 < columns) enter(at + rows);
      if (row > 0) enter(at - 1);
      if (row + 1 < rows) enter(at + 1);
    }
    ++groups;
  }
  return groups;
}

std::vector<int> sizes_of(const std::vector<int>& group, int groups, const std::vector<char>& set) {
  std::vector<int> sizes(static_cast<std::size_t>(groups), 0);
  for (std::size_t k = 0; k < group.size(); ++k)
    if (set[k] && group[k] >= 0) ++sizes[static_cast<std::size_t>(group[k])];
  return sizes;
}

// Cells within `half` columns and rows of one that is set.
std::vector<char> widened_cells(const std::vector<char>& set, int columns, int rows, int half) {
  std::vector<char> result = set;
  for (const bool along_rows : {true, false}) {
    const std::vector<char> from = result;
    const int lines = along_rows ? columns : rows, length = along_rows ? rows : columns;
    for (int line = 0; line < lines; ++line) {
      const auto at = [&](int k) {
        return along_rows ? static_cast<std::size_t>(line) * rows + k
                          : static_cast<std::size_t>(k) * rows + line;
      };
      int last = -2 * half - 2;  // the set cell before
      for (int k = 0; k < length; ++k) {
        if (from[at(k)]) last = k;
        if (k - last <= half) result[at(k)] = 1;
      }
      last = length + 2 * half + 1;
      for (int k = length - 1; k >= 0; --k) {
        if (from[at(k)]) last = k;
        if (last - k <= half) result[at(k)] = 1;
      }
    }
  }
  return result;
}

}  // namespace

void RectifiedLedge::refuse(const std::string& what) const { throw InputError(place_ + what); }

RectifiedLedge::RectifiedLedge(const Photograph& photo, const Photograph* background,
                               const WallCamera& camera, const PhotoSetup& setup,
                               const PhotoLedge& ledge)
    : place_(fmt::format("{}: slope \"{}\": ", photo.file, ledge.name)),
      ledge_(ledge),
      particle_size_(setup.particle_size) {
  sample(photo, background, camera, setup, choose_cells(camera, setup.height));
  value_ = smoothed(value_, visible_, columns_, rows_);
  for (int i = 0; i < columns_; ++i) {
    if (!visible_[static_cast<std::size_t>(cell(i, 0))])
      refuse(
          fmt::format("the floor at x = {:.4g} m is outside of the photograph; expected all of it",
                      ledge.x((i + 0.5) * step_)));
  }
  const OtsuThreshold found = otsu(value_, visible_);
  threshold_ = found.threshold;
  contrast_ = found.contrast;
  if (contrast_ < kLeastContrast) {
    refuse(
        fmt::format("no heap is seen: light and dark parts differ by {:.2g} of 255 levels; "
                    "expected at least {}",
                    contrast_, kLeastContrast));
  }
}

int RectifiedLedge::choose_cells(const WallCamera& camera, double height) {
  // Pixels of a meter of the wall, where they are most.
  double finest = 0, coarsest = INFINITY;
  for (const double s : {0.0, ledge_.length()}) {
    for (const double z : {0.0, height}) {
      const Vec2 at(ledge_.x(s), z), e(1e-4 * particle_size_, 0);
      for (const Vec2& side : {e, Vec2(0, e.x())}) {
        const double scale = (camera.pixel(at + side) - camera.pixel(at)).norm() / e.x();
        finest = std::max(finest, scale);
        coarsest = std::min(coarsest, scale);
      }
    }
  }
  if (!std::isfinite(finest) || !(coarsest > 0))
    refuse("lies behind the camera; expected it in front");
  if (coarsest * particle_size_ < kLeastPixels) {
    refuse(
        fmt::format("a particle covers {:.2g} pixels; expected at least {} (a nearer or sharper "
                    "photograph, or the right `particle_size`)",
                    coarsest * particle_size_, kLeastPixels));
  }
  step_ = std::max(kCell * particle_size_, 1 / finest);
  columns_ = static_cast<int>(std::lround(ledge_.length() / step_));
  rows_ = static_cast<int>(std::lround(height / step_));
  if (static_cast<double>(columns_) * rows_ > kMostCells)
    refuse(
        "is too large for a particle of this size; expected a shorter slope or a lower `height`");
  rows_ = std::max(rows_, 2);
  return std::clamp(static_cast<int>(std::ceil(step_ * finest - 1e-6)), 1, 8);
}

void RectifiedLedge::sample(const Photograph& photo, const Photograph* background,
                            const WallCamera& camera, const PhotoSetup& setup, int samples) {
  value_.resize(static_cast<std::size_t>(columns_) * rows_);
  visible_.assign(value_.size(), 1);
  for (int i = 0; i < columns_; ++i) {
    for (int k = 0; k < rows_; ++k) {
      double sum = 0;
      const auto at = static_cast<std::size_t>(cell(i, k));
      for (int a = 0; a < samples && visible_[at]; ++a) {
        for (int b = 0; b < samples; ++b) {
          const Vec2 p = camera.pixel(
              {ledge_.x((i + (a + 0.5) / samples) * step_), (k + (b + 0.5) / samples) * step_});
          if (!shows(photo, p)) {
            visible_[at] = 0;
            break;
          }
          const Rgb color = color_at(photo, p);
          sum += background ? color_distance(color, color_at(*background, p))
                            : channel_value(color, setup.channel);
        }
      }
      const double mean = sum / (samples * samples);
      value_[at] = static_cast<float>(background || setup.heap_is_brighter ? mean : 255 - mean);
    }
  }
}

std::vector<char> RectifiedLedge::largest_group(double threshold) const {
  std::vector<char> set(value_.size());
  for (std::size_t k = 0; k < set.size(); ++k) set[k] = visible_[k] && value_[k] >= threshold;
  std::vector<int> group;
  std::vector<int> sizes = sizes_of(group, number_groups(set, columns_, rows_, group), set);
  const double speck = std::pow(kSpeck * particle_size_ / step_, 2);
  for (std::size_t k = 0; k < set.size(); ++k)
    set[k] = set[k] && sizes[static_cast<std::size_t>(group[k])] >= speck;
  const int half = static_cast<int>(std::lround(0.5 * kReach * particle_size_ / step_));
  const std::vector<char> joined = widened_cells(set, columns_, rows_, half);
  const int groups = number_groups(joined, columns_, rows_, group);
  sizes = sizes_of(group, groups, set);
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  if (largest == sizes.end() || *largest < std::pow(particle_size_ / step_, 2))
    refuse("no heap is seen; expected one of at least the size of a particle");
  const int chosen = static_cast<int>(largest - sizes.begin());
  for (std::size_t k = 0; k < set.size(); ++k) set[k] = set[k] && group[k] == chosen;
  return set;
}

RectifiedLedge::Edge RectifiedLedge::edge_near(int column, int top, double shift) const {
  const int apart = std::max(2, static_cast<int>(std::lround(kEdge * particle_size_ / step_)));
  const auto level = [&](int row) {  // of three cells
    double sum = 0;
    for (int k = row - 1; k <= row + 1; ++k) sum += value(column, std::clamp(k, 0, rows_ - 1)) / 3;
    return sum;
  };
  const double below = level(top - apart), above = level(top + 1 + apart);
  Edge edge{(top + 1) * step_, below - above >= kLeastSharpness * contrast_};
  if (!edge.sharp) return edge;
  const double wanted = above + (0.5 + shift) * (below - above);
  int row = top;  // the value of the row is at least `wanted`, that of the next one below it
  for (; row + 1 < std::min(rows_ - 1, top + apart) && value(column, row + 1) >= wanted;) ++row;
  for (; row > std::max(0, top - apart) && value(column, row) < wanted;) --row;
  const double inside = value(column, row), outside = value(column, row + 1);
  const double part = inside > outside ? (inside - wanted) / (inside - outside) : 0.5;
  edge.height = (row + 0.5 + std::clamp(part, 0.0, 1.0)) * step_;
  return edge;
}

void RectifiedLedge::check_column(int column, int top, double x) const {
  const int cleared = static_cast<int>(std::lround(kCleared * particle_size_ / step_));
  for (int k = 0; k <= std::min(top + cleared, rows_ - 1); ++k) {
    if (!visible_[static_cast<std::size_t>(cell(column, k))])
      refuse(
          fmt::format("the border of the photograph cuts the heap at x = {:.4g} m; expected "
                      "all of it",
                      x));
  }
  if (top + 1 >= rows_)
    refuse(
        fmt::format("the heap reaches the top of what is searched at x = {:.4g} m; expected a "
                    "larger `height`, or no bright background there",
                    x));
}

RectifiedLedge::TopEdge RectifiedLedge::top_edge(const std::vector<char>& heap,
                                                 double shift) const {
  TopEdge found;
  found.lowest = INFINITY;
  for (int i = 0; i < columns_; ++i) {
    int top = rows_ - 1;
    while (top >= 0 && !heap[static_cast<std::size_t>(cell(i, top))]) --top;
    const double distance = (i + 0.5) * step_, x = ledge_.x(distance);
    const bool wanted = distance >= ledge_.window.from && distance <= ledge_.window.to;
    found.in_window += wanted;
    if (top < 0) continue;
    found.covered += wanted;
    check_column(i, top, x);
    const Edge edge = edge_near(i, top, shift);
    found.unsharp += wanted && !edge.sharp;
    found.points.push_back({x, edge.height});
    found.sharp.push_back(edge.sharp);
    int bottom = 0;
    while (!heap[static_cast<std::size_t>(cell(i, bottom))]) ++bottom;
    found.lowest = std::min(found.lowest, bottom * step_);
  }
  return found;
}

void RectifiedLedge::check_edge(const TopEdge& edge) const {
  if (edge.lowest > particle_size_) {
    refuse(fmt::format(
        "the lowest point of the outline is {:.3g} m above the floor; expected a heap on z = 0",
        edge.lowest));
  }
  constexpr double kLeastCovered = 0.5;
  if (edge.covered < kLeastCovered * edge.in_window) {
    refuse(fmt::format("the heap covers {:.0f} % of the window; expected at least {:.0f} %",
                       100 * edge.covered / edge.in_window, 100 * kLeastCovered));
  }
  if (edge.unsharp > kMostUnsharp * edge.covered) {
    refuse(
        fmt::format("{:.0f} % of the outline is not sharp; expected at most {:.0f} % (glare, "
                    "shadows or a background that resembles the ice)",
                    100 * edge.unsharp / edge.covered, 100 * kMostUnsharp));
  }
}

std::vector<Vec2> RectifiedLedge::outline(double shift) const {
  TopEdge edge = top_edge(largest_group(threshold_ + shift * contrast_), shift);
  check_edge(edge);
  // Between the nearest sharp points of either side.
  std::vector<Vec2>& points = edge.points;
  const std::vector<char>& sharp = edge.sharp;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (sharp[k]) continue;
    std::size_t before = k, after = k;
    while (before > 0 && !sharp[before]) --before;
    while (after + 1 < points.size() && !sharp[after]) ++after;
    if (!sharp[before] || !sharp[after]) continue;
    const Vec2 &a = points[before], &b = points[after];
    points[k].y() = a.y() + (points[k].x() - a.x()) / (b.x() - a.x()) * (b.y() - a.y());
  }
  return std::move(edge.points);
}

HeapSlope outline_slope(const std::vector<Vec2>& outline, const PhotoLedge& ledge,
                        double particle_size) {
  const PlanGrid grid = outline_grid(ledge.length(), particle_size);
  // Points by distance from the begin: mapped by another camera they may have changed places.
  std::vector<std::array<double, 2>> points;
  for (const Vec2& p : outline)
    points.push_back({ledge.end > ledge.begin ? p.x() - ledge.begin : ledge.begin - p.x(), p.y()});
  std::sort(points.begin(), points.end());
  Eigen::ArrayXd height = Eigen::ArrayXd::Zero(grid.nx);
  Eigen::Array<bool, Eigen::Dynamic, 1> covered =
      Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(grid.nx, false);
  for (int i = 0; i < grid.nx; ++i) {
    const double s = grid.x(i);
    const auto after =
        std::lower_bound(points.begin(), points.end(), std::array<double, 2>{s, -INFINITY});
    const bool has_after = after != points.end() && (*after)[0] - s <= grid.step_x;
    const bool has_before = after != points.begin() && s - (*(after - 1))[0] <= grid.step_x;
    if (!has_after && !has_before) continue;
    covered(i) = true;
    if (has_after && has_before) {
      const auto& a = *(after - 1);
      const auto& b = *after;
      const double part = b[0] > a[0] ? (s - a[0]) / (b[0] - a[0]) : 0.5;
      height(i) = (1 - part) * a[1] + part * b[1];
    } else {
      height(i) = has_after ? (*after)[1] : (*(after - 1))[1];
    }
  }
  return surface_slope(closed_outline(height, covered, ledge.length(), particle_size),
                       ledge.window);
}

}  // namespace firn
