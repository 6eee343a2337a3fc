// Pictures of a whole scene: boundaries and bodies, from outside and cut open.
#pragma once

#include <Eigen/Geometry>
#include <memory>
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
  std::vector<int> tags;  // of the particles; empty, or all the same: the color of ice
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

// The scenes of the frames of a results file, which stays open as long.
class RecordedScenes {
 public:
  explicit RecordedScenes(const Recording& recording);
  ~RecordedScenes();
  // Particles have their tags. The scene refers to meshes of this object and is valid until the
  // next call. Throws InputError when the frame does not exist.
  ScenePicture scene(std::size_t frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// One frame of a results file, particles colored by their tags. Throws InputError when the frame
// does not exist.
void draw_scene(const Recording& recording, std::size_t frame, const std::string& file);

// m, world: box about the boundaries that are drawn and the particles near them, or about all
// particles where there are no boundaries.
Eigen::AlignedBox3d scene_bounds(const ScenePicture& picture);

// One picture of a film: the overview and the section along x, both of this box of the world, with
// title and legend. The height is film_height(width). Throws as draw_scene().
void draw_film_picture(const ScenePicture& picture, const Eigen::AlignedBox3d& bounds,
                       const std::string& file);
// Pixels: 9/16 of the width, an even number as video encoders need.
inline int film_height(int width) { return width * 9 / 32 * 2; }

}  // namespace firn
