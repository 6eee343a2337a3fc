#include "reports/heap_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "experiments/drained_repose_responses.h"
#include "experiments/heap_slope.h"
#include "reports/gnuplot.h"
#include "reports/mesh_renderer.h"

namespace firn {
namespace {

constexpr int kCanvasWidth = 1600;  // pixels
constexpr double kWall = 8e-3;      // m, drawn thickness of end walls and floor
constexpr double kRim = 25e-3;      // m of empty space around the elevation

TriangleMesh slab(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) {
    mesh.vertices.emplace_back(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(),
                               k & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// Height up to which the box is drawn: all of a full one, little more than a drained heap.
double drawn_height(const HeapPicture& picture) {
  double top = 0.1;
  for (const PlacedMesh& p : picture.particles) {
    for (const Vec3& v : p.mesh->vertices) top = std::max(top, (p.pose * v).z());
  }
  return top + 15e-3;
}

// Ice, each cube a little lighter or darker than the next.
Color ice(std::size_t k) {
  const auto shade = static_cast<float>(0.08 * static_cast<double>(k * 7919 % 13) / 12);
  return {0.80f + shade, 0.90f + 0.7f * shade, 0.98f};
}

struct Stand {
  std::vector<TriangleMesh> floors, walls;
};
Stand stand(const HeapPicture& picture, double height) {
  const DrainedRepose& s = picture.setup;
  const double x = s.box.x() / 2, y = s.box.y() / 2, lip = s.door_width / 2;
  Stand result;
  result.floors = {slab({-x - kWall, -y, -kWall}, {-lip, y, 0}),
                   slab({lip, -y, -kWall}, {x + kWall, y, 0})};
  if (!picture.door_open) result.floors.push_back(slab({-lip, -y, -kWall}, {lip, y, 0}));
  result.walls = {slab({-x - kWall, -y, 0}, {-x, y, height}), slab({x, -y, 0}, {x + kWall, y, height})};
  return result;
}

Scene scene_of(const HeapPicture& picture, const Stand& stand, bool with_walls) {
  Scene scene;
  for (std::size_t k = 0; k < picture.particles.size(); ++k) {
    scene.bodies.push_back({picture.particles[k], ice(k)});
  }
  for (const TriangleMesh& m : stand.floors) {
    scene.bodies.push_back({{&m, {}}, {0.70f, 0.72f, 0.75f}, false});
  }
  if (with_walls) {
    for (const TriangleMesh& m : stand.walls) {
      scene.bodies.push_back({{&m, {}}, {0.70f, 0.72f, 0.75f}, false});
    }
  }
  scene.occlusion_radius = picture.particle_size;
  return scene;
}

// Edges of the box up to the drawn height.
void add_box_lines(const DrainedRepose& s, double height, Scene& scene) {
  const double x = s.box.x() / 2, y = s.box.y() / 2, top = std::min(height, s.box.z());
  const Color color{0.45f, 0.49f, 0.55f};
  const auto line = [&](const Vec3& a, const Vec3& b) {
    scene.lines.push_back({a, b, color, 1.1e-3});
  };
  for (double sx : {-x, x}) {
    for (double sy : {-y, y}) line({sx, sy, 0}, {sx, sy, top});
    line({sx, -y, 0}, {sx, y, 0});
    line({sx, -y, top}, {sx, y, top});
  }
  for (double sy : {-y, y}) line({-x, sy, top}, {x, sy, top});
  line({-x, y, 0}, {-s.door_width / 2, y, 0});
  line({s.door_width / 2, y, 0}, {x, y, 0});
}

View overview(const HeapPicture& picture, double height) {
  const DrainedRepose& s = picture.setup;
  const Vec3 middle(0, 0, 0.45 * height);
  const Vec3 eye = middle + Vec3(-0.42, -1.25, 0.72) * (s.box.x() / 0.6);
  const View unit = View::perspective(eye, middle, Vec3::UnitZ(), 1, 1);
  double width = 0, tall = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner((k & 1 ? 0.5 : -0.5) * s.box.x(), (k & 2 ? 0.5 : -0.5) * s.box.y(),
                      k & 4 ? height : -kWall);
    const Vec3 p = unit.project(corner);
    width = std::max(width, 2 * std::abs(p.x() - 0.5));
    tall = std::max(tall, 2 * std::abs(p.y() - 0.5));
  }
  return View::perspective(eye, middle, Vec3::UnitZ(), 1.06 * width, 1.06 * tall);
}

void write_image(const Image& image, const std::filesystem::path& file) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(image.pixels.data()),
               static_cast<std::streamsize>(3 * image.pixels.size()));
  if (!stream) throw RunError(fmt::format("{}: cannot be written", file.string()));
}

// gnuplot's lines for one ledge: the mean surface as a data block, the fitted line, its angle.
std::string slope_script(const HeapSlope& slope, const DrainedRepose& setup, double sign,
                         double label_height) {
  const auto x_mm = [&](double distance) {
    return 1e3 * sign * (setup.door_width / 2 + distance);
  };
  const auto z_mm = [&](double distance) {
    return 1e3 * (slope.robust.intercept + slope.robust.slope * distance);
  };
  const std::string name = sign > 0 ? "right" : "left";
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t i = 0; i < slope.distance.size(); ++i) {
    text += fmt::format("{:.3f} {:.3f}\n", x_mm(slope.distance[i]), 1e3 * slope.mean_height[i]);
  }
  text += "EOD\n";
  const double a = slope.window.from, b = slope.window.to;
  const double ledge = (setup.box.x() - setup.door_width) / 2;
  const auto arrow = [&](double from, double z_from, double to, double z_to, const char* style) {
    text += fmt::format("set arrow from {:.3f},{:.3f} to {:.3f},{:.3f} nohead front {}\n",
                        x_mm(from), z_from, x_mm(to), z_to, style);
  };
  arrow(a, z_mm(a), a + 0.62 * (b - a), z_mm(a), "lw 1.2 dt 3 lc rgb '#30343b'");
  for (const char* style : {"lw 6 lc rgb '#ffffff'", "lw 3 lc rgb '#d1351b'"}) {
    arrow(a, z_mm(a), b, z_mm(b), style);
  }
  arrow(0, z_mm(0), a, z_mm(a), "lw 2 dt 2 lc rgb '#d1351b'");
  arrow(b, z_mm(b), ledge, z_mm(ledge), "lw 2 dt 2 lc rgb '#d1351b'");
  text += fmt::format(
      "set label \"{{/:Bold {:.1f}° ± {:.1f}°}}\" at {:.3f},{:.3f} center front font ',19' "
      "tc rgb '#d1351b'\n",
      slope.robust_angle, slope.robust_uncertainty, x_mm(0.5 * (a + b)), label_height);
  return text;
}

// A picture without axes over a part of the canvas.
std::string image_script(const Image& image, const std::filesystem::path& file) {
  return fmt::format("{} binary array=({},{}) format='%uchar%uchar%uchar'",
                     Gnuplot::quoted(file.string()), image.width, image.height);
}

// The elevation in mm with the mean surfaces and fitted lines, between given parts of the canvas.
std::string elevation_script(const HeapPicture& picture, const Image& image,
                             const std::filesystem::path& image_file, double width, double height,
                             double bottom) {
  const DrainedRepose& s = picture.setup;
  std::string text;
  std::string plots;
  const double top = 1e3 * (height - kWall - kRim);  // mm
  if (picture.door_open) {
    std::vector<PlacedMesh> heap;
    const std::vector<bool> stands = standing(picture.particles, s, picture.particle_size, true);
    for (std::size_t k = 0; k < stands.size(); ++k) {
      if (stands[k]) heap.push_back(picture.particles[k]);
    }
    for (Side side : {Side::left, Side::right}) {
      const HeapSlope slope = heap_slope(heap, s, side, picture.particle_size, picture.mean_volume);
      text += slope_script(slope, s, side == Side::right ? 1 : -1, top - 4);
    }
    plots = ", $left with lines lw 2 lc rgb '#123a63', $right with lines lw 2 lc rgb '#123a63'";
  }
  const double step = 1e3 * width / image.width;
  text += fmt::format(
      "set border 3 lc rgb '#60666f'\nset tics out nomirror tc rgb '#30343b'\n"
      "set xtics 50\nset ytics 25\nset xlabel 'x / mm'\nset ylabel 'z / mm'\n"
      "set lmargin at screen 0.06\nset rmargin at screen 0.985\n"
      "set bmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
      "set xrange [{:.3f}:{:.3f}]\nset yrange [{:.3f}:{:.3f}]\n"
      "plot {} origin=({:.5f},{:.5f}) dx={:.6f} dy={:.6f} with rgbimage{}\n",
      bottom, bottom + 0, -500 * width, 500 * width, -1e3 * (kWall + kRim), top,
      image_script(image, image_file), -500 * width + step / 2, -1e3 * (kWall + kRim) + step / 2,
      step, step, plots);
  return text;
}

}  // namespace
}  // namespace firn
