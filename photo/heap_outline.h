// The outline of a heap in a photograph: the highest point of the ice in each column of the wall.
// Choices: docs/photo.md.
#pragma once

#include <vector>

#include "photo/photo_setup.h"

namespace firn {

// A ledge as it is seen, drawn on the plane of the wall: distance from its begin to the right,
// height above the floor upwards, the pixels of the photograph averaged over square cells. The
// value is the channel of the setup, or how far the color is from that of the background; larger
// is the heap.
class RectifiedLedge {
 public:
  // `background`: nothing, or a picture of the same size. Throws InputError, which names the
  // photograph and the slope, when the photograph does not show the ledge.
  RectifiedLedge(const Photograph& photo, const Photograph* background, const WallCamera& camera,
                 const PhotoSetup& setup, const PhotoLedge& ledge);

  // Otsu (1979): the threshold with the largest variance between what is below and above.
  double threshold() const { return threshold_; }
  // Mean above the threshold less the mean below, levels of 255.
  double contrast() const { return contrast_; }

  // Points of the wall from the begin to the end, one a column of cells that the heap covers: the
  // top of the largest group of cells above the threshold, gaps of less than a quarter of a
  // particle bridged. There the edge is put where the value is halfway from what is above it to
  // what is below it, whatever the light; where the two hardly differ (glare), it is interpolated.
  // `shift` moves both levels by this part of their contrast. Throws InputError when there is no
  // heap, or not all of it.
  std::vector<Vec2> outline(double shift = 0) const;

 private:
  int cell(int column, int row) const { return column * rows_ + row; }
  double value(int column, int row) const {
    return value_[static_cast<std::size_t>(cell(column, row))];
  }
  // The size and number of the cells, from the pixels of a meter of the wall. Returns how many
  // samples a cell takes each way.
  int choose_cells(const WallCamera& camera, double height);
  void sample(const Photograph& photo, const Photograph* background, const WallCamera& camera,
              const PhotoSetup& setup, int samples);
  std::vector<char> largest_group(double threshold) const;
  struct Edge {
    double height = 0;  // m
    bool sharp = false;
  };
  Edge edge_near(int column, int top, double shift) const;
  // Throws InputError unless the photograph shows the column up to what is above the heap.
  void check_column(int column, int top, double x) const;
  // The upper edge of the heap, a point for each column that has one.
  struct TopEdge {
    std::vector<Vec2> points;
    std::vector<char> sharp;                         // of each point
    double covered = 0, unsharp = 0, in_window = 0;  // columns of the fit window
    double lowest = 0;                               // m, underside of the heap
  };
  TopEdge top_edge(const std::vector<char>& heap, double shift) const;
  void check_edge(const TopEdge& edge) const;
  [[noreturn]] void refuse(const std::string& what) const;

  std::string place_;  // begins messages
  PhotoLedge ledge_;
  double particle_size_ = 0, step_ = 0;  // m
  int columns_ = 0, rows_ = 0;
  std::vector<float> value_;   // [columns][rows] rows from the floor
  std::vector<char> visible_;  // the photograph shows the cell
  double threshold_ = 0, contrast_ = 0;
};

// The outline on the cells of outline_grid(), closed as a simulated surface is, and the lines
// through it. Cells without a point of the heap are floor.
HeapSlope outline_slope(const std::vector<Vec2>& outline, const PhotoLedge& ledge,
                        double particle_size);

}  // namespace firn
