// How a photograph of a heap was taken, as a file of the user. Format: docs/photo.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/responses/heap_slope.h"
#include "photo/photograph.h"
#include "photo/wall_camera.h"

namespace firn {

// One slope of the heap: a strip of the floor along x, on which an angle is measured.
struct PhotoLedge {
  std::string name;
  double begin = 0, end = 0;  // m, x; distances count from `begin`, the angle rises towards `end`
  FitWindow window;

  double length() const { return end > begin ? end - begin : begin - end; }
  double x(double distance) const { return end > begin ? begin + distance : begin - distance; }
};

enum class PhotoChannel { luminance, red, green, blue, saturation };

struct PhotoSetup {
  std::string file;  // it was read from
  std::string hash;  // SHA-256 of its bytes
  std::string name, response;
  std::string experiment, source, apparatus, notes;  // copied into the measurement; may be empty
  double particle_size = 0;                          // m: middle edge of the bounding box
  double height = 0;                                 // m above the floor that is searched
  double depth = 0;                                  // m of the ice behind the front wall
  double camera_distance = 0;                        // m from the lens to the front wall

  std::vector<WallPoint> corners;
  double pixel_uncertainty = 0;     // of a corner's column and row, one standard deviation
  double position_uncertainty = 0;  // m, of a corner's x and z
  double level_uncertainty = 0;     // rad, of the direction of z against gravity

  // Without a calibration of the lens the principal point is the middle of the picture, and the
  // focal length its width.
  std::optional<Vec2> principal_point;  // pixels
  std::optional<double> focal_length;   // pixels
  double k1 = 0, k2 = 0, k1_uncertainty = 0;

  PhotoChannel channel = PhotoChannel::luminance;
  bool heap_is_brighter = true;
  std::string background;            // file of the same view without a heap; empty: none
  double threshold_uncertainty = 0;  // part of the contrast of heap and background

  std::vector<PhotoLedge> ledges;

  // Throws InputError at the key when the lens cannot be undone over the whole picture.
  Lens lens(int width, int height) const;
};

// Throws InputError with one line `FILE:LINE: KEY: what is wrong; what is expected`.
PhotoSetup read_photo_setup_text(const std::string& text, const std::string& source);
PhotoSetup read_photo_setup(const std::string& file);

}  // namespace firn
