// Colors of the boundaries and bodies of a scene, and the legend below its pictures.
#pragma once

#include <string>
#include <vector>

#include "reports/rendering/scene_picture.h"

namespace firn {

Color wall_color(std::size_t wall);
// By tag; ice where there are not two.
std::vector<Color> particle_colors(const ScenePicture& picture);

struct LegendItem {
  std::string name;
  Color color;
};

struct SceneLegend {
  static constexpr double kRow = 20;  // pixels
  struct PlacedItem {
    LegendItem item;
    double x = 0;
    int row = 0;
  };
  std::vector<PlacedItem> placed;
  int rows = 0;
};

// Every boundary, and the ice: by tag, of many tags the first and the last. Empty where one entry
// would be all and says nothing: the only kind of bodies, or what the title says.
SceneLegend legend_of(const ScenePicture& picture);

// At the lower end of a canvas.
std::string legend_script(const SceneLegend& legend, double width, double height);

}  // namespace firn
