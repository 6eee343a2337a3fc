// The angle of repose of heaps in photographs, by the estimator of simulated heaps, and the
// measurement that follows. Equations, choices and their measured accuracy: docs/photo.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "photo/heap_outline.h"

namespace firn {

struct PhotoSlope {
  PhotoLedge ledge;
  HeapSlope lines;             // of the outline; its uncertainties are those of the roughness
  std::vector<Vec2> outline;   // m, points of the wall
  double threshold = 0;        // that parts heap and background, levels of 255
  double contrast = 0;         // of heap and background, levels of 255
  double threshold_shift = 0;  // deg: half of what the threshold's uncertainty moves the angle
};

// One heap.
struct PhotoAngle {
  std::string file, hash;          // of the photograph; the hash is SHA-256
  std::vector<PhotoSlope> slopes;  // in the order of the setup
  double angle = 0;                // deg, mean of the slopes
  double roughness = 0;            // deg, one standard deviation of that mean
};

struct HeapPhotoResult {
  PhotoSetup setup;
  std::vector<PhotoAngle> heaps;  // at least one
  double angle = 0;               // deg, mean of the heaps
  // One standard deviation, deg, common to all heaps: of the corners, the lens and the level; of
  // the threshold; both together.
  double camera_uncertainty = 0, threshold_uncertainty = 0, systematic = 0;
  double corner_residual = 0;  // pixels, of more than four corners
  // Of the mean angle: sqrt(s^2 / n + systematic^2) with the scatter s of the heaps, of a single
  // one its roughness.
  double uncertainty() const;
  double scatter() const;  // s
};

// The camera of a setup. Throws InputError for corners that none can see so.
WallCamera wall_camera(const PhotoSetup& setup, int width, int height);

// Photographs of heaps by a camera that stays; each is loaded once, and only one is kept at a time.
// Deterministic. Throws InputError, one line that begins with the file and names the slope.
HeapPhotoResult measure_heap_photos(const PhotoSetup& setup, std::size_t photos,
                                    const std::function<Photograph(std::size_t)>& load);

// The measurement file (docs/measurements.md) that a calibration reads.
std::string measurement_text(const HeapPhotoResult& result);

// The photograph with the outlines, the lines through them, the windows and the corners: FILE.png
// or FILE.svg. `photo` is that of the heap. Throws as Gnuplot::draw().
void draw_heap_photo(const HeapPhotoResult& result, std::size_t heap, const Photograph& photo,
                     const std::string& file);

}  // namespace firn
