#include "reports/rendering/scene_legend.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>

#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

// Dull, so that the ice stands out.
constexpr std::array<Color, 10> kWallColors = {{{0.63f, 0.70f, 0.76f},
                                                {0.75f, 0.66f, 0.55f},
                                                {0.64f, 0.72f, 0.63f},
                                                {0.73f, 0.63f, 0.68f},
                                                {0.75f, 0.73f, 0.61f},
                                                {0.61f, 0.63f, 0.68f},
                                                {0.60f, 0.71f, 0.71f},
                                                {0.77f, 0.64f, 0.62f},
                                                {0.69f, 0.68f, 0.66f},
                                                {0.70f, 0.68f, 0.77f}}};

// Ice, each body a little lighter or darker than the next.
Color ice_shade(std::size_t k) {
  const auto shade = static_cast<float>(0.08 * static_cast<double>(k * 7919 % 13) / 12);
  return {0.84f + shade, 0.92f + 0.7f * shade, 0.99f};
}

// From dark blue over green to yellow, ascending in lightness: readable without color, too.
Color by_rank(double share) {
  constexpr std::array<Color, 5> kScale = {{{0.20f, 0.12f, 0.40f},
                                            {0.19f, 0.40f, 0.56f},
                                            {0.15f, 0.62f, 0.53f},
                                            {0.50f, 0.80f, 0.36f},
                                            {0.99f, 0.90f, 0.20f}}};
  const double at = share * (kScale.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kScale.size() - 2);
  const auto f = static_cast<float>(at - static_cast<double>(i));
  const Color &a = kScale[i], &b = kScale[i + 1];
  return {a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b)};
}

// With an entry that may be the only one.
std::vector<LegendItem> legend_items(const ScenePicture& picture) {
  constexpr std::size_t kMostTags = 8;
  std::vector<LegendItem> items;
  for (std::size_t i = 0; i < picture.walls.size(); ++i)
    items.push_back({picture.walls[i].name, wall_color(i)});
  if (picture.particles.empty()) return items;
  const std::set<int> known(picture.tags.begin(), picture.tags.end());
  if (known.size() < 2) {
    items.push_back({"bodies", ice_shade(0)});
    return items;
  }
  std::size_t rank = 0;
  for (const int tag : known) {
    const bool end = rank == 0 || rank + 1 == known.size();
    if (end || known.size() <= kMostTags)
      items.push_back({fmt::format("tag {}", tag),
                       by_rank(static_cast<double>(rank) / static_cast<double>(known.size() - 1))});
    ++rank;
  }
  return items;
}

}  // namespace

Color wall_color(std::size_t wall) { return kWallColors[wall % kWallColors.size()]; }

std::vector<Color> particle_colors(const ScenePicture& picture) {
  std::vector<Color> colors;
  const std::set<int> known(picture.tags.begin(), picture.tags.end());
  for (std::size_t k = 0; k < picture.particles.size(); ++k) {
    if (known.size() < 2) {
      colors.push_back(ice_shade(k));
      continue;
    }
    const auto rank = std::distance(known.begin(), known.find(picture.tags[k]));
    colors.push_back(by_rank(static_cast<double>(rank) / static_cast<double>(known.size() - 1)));
  }
  return colors;
}

SceneLegend legend_of(const ScenePicture& picture) {
  constexpr double kMargin = 20;
  SceneLegend legend;
  double x = kMargin;
  std::vector<LegendItem> items = legend_items(picture);
  const bool says_nothing =
      items.size() == 1 && (picture.walls.empty() || items.front().name == picture.title);
  if (says_nothing) return legend;
  legend.rows = items.empty() ? 0 : 1;
  for (LegendItem& item : items) {
    const double wide = 42 + 9.0 * static_cast<double>(item.name.size());
    if (x > kMargin && x + wide > picture.width - kMargin) {
      x = kMargin;
      ++legend.rows;
    }
    legend.placed.push_back({std::move(item), x, legend.rows - 1});
    x += wide;
  }
  return legend;
}

std::string legend_script(const SceneLegend& legend, double width, double height) {
  std::string script;
  int label = 100;
  for (const SceneLegend::PlacedItem& p : legend.placed) {
    const double y = height - SceneLegend::kRow * (legend.rows - p.row);
    const Color c = p.item.color;
    const auto byte = [](float v) {
      return static_cast<int>(std::lround(255 * std::clamp(v, 0.0f, 1.0f)));
    };
    script += fmt::format(
        "set label {} '■ ' at screen {:.5f}, screen {:.5f} front font ',15' tc rgb "
        "'#{:02x}{:02x}{:02x}'\n"
        "set label {} {} at screen {:.5f}, screen {:.5f} front font ',13' tc rgb '#1d2733' "
        "noenhanced\n",
        label, p.x / width, 1 - y / height, byte(c.r), byte(c.g), byte(c.b), label + 1,
        encode::gnuplot(p.item.name), (p.x + 24) / width, 1 - y / height);
    label += 2;
  }
  return script;
}

}  // namespace firn
