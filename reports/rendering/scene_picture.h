// Pictures of a whole scene: boundaries and bodies, from outside and cut open.
#pragma once

#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/results_file.h"
#include "reports/rendering/mesh_renderer.h"

namespace firn {

// Input of the drawing as plain data. The caller owns the meshes. Half-spaces have no mesh and
// are not drawn.
struct ScenePicture {
  struct Wall {
    std::string name;
    PlacedMesh placed;
  };
  std::string title, subtitle;
  std::vector<Wall> walls;
  std::vector<PlacedMesh> particles;
  std::vector<int> tags;  // of the particles; empty, or all the same: the colour of ice
  int width = 1800;       // pixels of the whole picture; the height follows
};

// An overview, the view from above, and two sections, along x and across, through the middle of the
// walls, with axes in mm. FILE.png or FILE.svg. Throws InputError for another extension, for a
// scene without anything to draw, or without gnuplot.
void draw_scene(const ScenePicture& picture, const std::string& file);

// A case as it begins: boundaries, and the particles that are there from the start.
void draw_scene(const Case& c, const std::string& file);
// One boundary of it alone, where it is at the start. Throws InputError for one without a mesh.
void draw_boundary(const Case& c, const std::string& name, const std::string& file);

// One frame of a results file, particles coloured by their tags. Throws InputError when the frame
// does not exist.
void draw_scene(const Recording& recording, std::size_t frame, const std::string& file);

}  // namespace firn
