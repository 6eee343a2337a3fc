#include "reports/rendering/heap_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/responses/drained_repose_responses.h"
#include "experiments/responses/heap_slope.h"
#include "experiments/system/gnuplot.h"
#include "experiments/system/text_encoding.h"
#include "reports/rendering/mesh_renderer.h"
#include "reports/rendering/picture_source.h"

namespace firn {
namespace {

constexpr double kWallThickness = 8e-3;         // m, drawn thickness of end walls and floor
constexpr double kRim = 14e-3;                  // m of empty space around the elevation
constexpr double kLeft = 0.06, kRight = 0.985;  // of the canvas' width: the elevation's frame

constexpr Color kWallColor{0.70f, 0.72f, 0.75f};

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
Color ice_color(std::size_t k) {
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
  result.floors = {slab({-x - kWallThickness, -y, -kWallThickness}, {-lip, y, 0}),
                   slab({lip, -y, -kWallThickness}, {x + kWallThickness, y, 0})};
  if (!picture.door_open) result.floors.push_back(slab({-lip, -y, -kWallThickness}, {lip, y, 0}));
  result.walls = {slab({-x - kWallThickness, -y, 0}, {-x, y, height}),
                  slab({x, -y, 0}, {x + kWallThickness, y, height})};
  return result;
}

Scene heap_scene(const HeapPicture& picture, const std::vector<TriangleMesh>& floors) {
  Scene scene;
  for (std::size_t k = 0; k < picture.particles.size(); ++k) {
    scene.bodies.push_back({picture.particles[k], ice_color(k)});
  }
  for (const TriangleMesh& m : floors) scene.bodies.push_back({{&m, {}}, kWallColor, false});
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
  const Vec3 eye = middle + Vec3(-0.32, -1.3, 0.75) * (s.box.x() / 0.6);
  const View unit = View::perspective(eye, middle, Vec3::UnitZ(), 1, 1);
  double width = 0, tall = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner((k & 1 ? 0.5 : -0.5) * s.box.x(), (k & 2 ? 0.5 : -0.5) * s.box.y(),
                      k & 4 ? height : -kWallThickness);
    const Vec3 p = unit.project(corner);
    width = std::max(width, 2 * std::abs(p.x() - 0.5));
    tall = std::max(tall, 2 * std::abs(p.y() - 0.5));
  }
  return View::perspective(eye, middle, Vec3::UnitZ(), 1.06 * width, 1.06 * tall);
}

// gnuplot's lines for one ledge: the mean surface as a data block, the fitted line, its angle.
std::string slope_script(const HeapSlope& slope, const DrainedRepose& setup, Side side,
                         double label_height) {
  const double sign = side == Side::right ? 1 : -1;
  const auto x = [&](double distance) { return 1e3 * sign * (setup.door_width / 2 + distance); };
  const auto z = [&](double distance) {
    return 1e3 * (slope.robust.intercept + slope.robust.slope * distance);
  };
  std::string text = side == Side::right ? "$right << EOD\n" : "$left << EOD\n";
  for (std::size_t i = 0; i < slope.distance.size(); ++i) {
    text += fmt::format("{:.3f} {:.3f}\n", x(slope.distance[i]), 1e3 * slope.mean_height[i]);
  }
  text += "EOD\n";
  const auto line = [&](double from, double z_from, double to, double z_to, const char* style) {
    text += fmt::format("set arrow from {:.3f},{:.3f} to {:.3f},{:.3f} nohead front {}\n", x(from),
                        z_from, x(to), z_to, style);
  };
  const double a = slope.window.from, b = slope.window.to;
  const double ledge = (setup.box.x() - setup.door_width) / 2;
  line(a, z(a), b, z(a), "lw 1.5 dt 3 lc rgb '#30343b'");
  line(a, z(a), b, z(b), "lw 7 lc rgb '#ffffff'");
  line(a, z(a), b, z(b), "lw 3.5 lc rgb '#d1351b'");
  line(0, z(0), a, z(a), "lw 2 dt 2 lc rgb '#d1351b'");
  line(b, z(b), ledge, z(ledge), "lw 2 dt 2 lc rgb '#d1351b'");
  text += fmt::format(
      "set label '{:.1f}° ± {:.1f}°' at {:.3f},{:.3f} center front font 'DejaVu Sans:Bold,20' "
      "tc rgb '#d1351b'\n",
      slope.robust_angle, slope.robust_uncertainty, x(0.5 * (a + b)), label_height);
  return text;
}

std::string slopes_script(const HeapPicture& picture, double label_height) {
  const DrainedRepose& s = picture.setup;
  const std::vector<bool> stands =
      supported_particles(picture.particles, s, picture.particle_size, true);
  std::vector<PlacedMesh> heap;
  for (std::size_t k = 0; k < stands.size(); ++k) {
    if (stands[k]) heap.push_back(picture.particles[k]);
  }
  std::string text;
  for (Side side : {Side::left, Side::right}) {
    text += slope_script(heap_slope(heap, s, side, picture.particle_size, picture.mean_volume), s,
                         side, label_height);
  }
  return text;
}

// One rectangle of the canvas, pixels from the top.
std::string frame_script(double left, double right, double top, double bottom, double height) {
  return fmt::format(
      "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\n"
      "set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}\n",
      left, right, 1 - top / height, 1 - bottom / height);
}

}  // namespace

void draw_heap(const HeapPicture& picture, const std::string& file) {
  Gnuplot::check_picture(file);  // refuses a wrong extension before the work begins
  const DrainedRepose& s = picture.setup;
  const double height = drawn_height(picture);
  const Stand solids = stand(picture, height);
  Scene above = heap_scene(picture, solids.floors), front = above;
  add_box_lines(s, height, above);
  for (const TriangleMesh& m : solids.walls) front.bodies.push_back({{&m, {}}, kWallColor, false});

  // The elevation's frame in m, and its place on the canvas.
  const double width = s.box.x() + 2 * (kWallThickness + kRim), low = -kWallThickness - kRim,
               high = height + kRim;
  const int plot_width = static_cast<int>((kRight - kLeft) * picture.width);
  const View elevation = View::parallel(Vec3(0, 0, 0.5 * (low + high)), Vec3::UnitY(),
                                        Vec3::UnitZ(), width, high - low);
  const Image top_image = render(above, overview(picture, height), picture.width);
  const Image front_image = render(front, elevation, plot_width);
  constexpr double kTitle = 78, kGap = 16, kAxis = 62;  // pixels
  const double split = kTitle + top_image.height + kGap;
  const double canvas_height = split + front_image.height + kAxis;

  const Gnuplot gnuplot;
  const std::string top_source = image_source(gnuplot, "top", top_image);
  const std::string front_source = image_source(gnuplot, "front", front_image);
  std::string script = "set multiplot\nunset key\nunset border\nunset tics\n";
  script += fmt::format(
      "set label 1 {} at screen 0.02, screen {:.5f} front font ',22' tc rgb '#1d2733' noenhanced\n"
      "set label 2 {} at screen 0.02, screen {:.5f} front font ',14' tc rgb '#5b6673' noenhanced\n",
      encode::gnuplot(picture.title), 1 - 28 / canvas_height, encode::gnuplot(picture.subtitle),
      1 - 58 / canvas_height);
  script += frame_script(0, 1, kTitle, kTitle + top_image.height, canvas_height);
  script += fmt::format("set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\nplot {} with rgbimage\n",
                        top_image.width - 1, top_image.height - 1, top_source);

  script += "unset label\n" +
            frame_script(kLeft, kRight, split, split + front_image.height, canvas_height);
  if (picture.door_open) script += slopes_script(picture, 1e3 * (high - 0.8 * kRim));
  const double step = 1e3 * width / front_image.width;  // mm a pixel
  const double left = -500 * width, bottom = 1e3 * low;
  script += fmt::format(
      "set border 3 lc rgb '#8a929c'\nset xtics 50 out nomirror textcolor rgb '#30343b'\n"
      "set ytics 25 out nomirror textcolor rgb '#30343b'\nset xlabel 'x / mm' offset 0,0.3\nset "
      "ylabel 'z / mm'\n"
      "set xrange [{:.4f}:{:.4f}]\nset yrange [{:.4f}:{:.4f}]\n"
      "plot {} origin=({:.5f},{:.5f}) dx={:.6f} dy={:.6f} with rgbimage{}\n",
      left, -left, bottom, bottom + step * front_image.height, front_source, left + step / 2,
      bottom + step / 2, step, step,
      picture.door_open
          ? ", $left with lines lw 2 lc rgb '#123a63', $right with lines lw 2 lc rgb '#123a63'"
          : "");
  gnuplot.draw(script + "unset multiplot\n", file, picture.width, static_cast<int>(canvas_height));
}

void draw_heap(const Recording& recording, std::size_t frame, const std::string& file) {
  const Case c = read_case(recording);
  if (!c.drained_repose) {
    throw InputError(
        fmt::format("{}: is not a drained angle of repose test; expected one to draw its "
                    "heap",
                    recording.file()));
  }
  const std::vector<double> times = recording.frame_times();
  if (frame >= times.size()) {
    throw InputError(fmt::format("{}: has no frame {}; expected less than {}", recording.file(),
                                 frame, times.size()));
  }
  HeapPicture picture;
  picture.setup = *c.drained_repose;
  const auto particles = particles_in_box(recording, c, frame);
  for (const auto& p : particles) {
    picture.particles.push_back(p.placed);
    picture.mean_volume += p.volume / static_cast<double>(particles.size());
  }
  const std::optional<double> opening = opening_time(recording, c);
  picture.door_open = opening && times[frame] > *opening;
  picture.particle_size = mean_particle_size(recording, c);
  picture.title = c.name;
  picture.subtitle = fmt::format(
      "{} of {} particles in the box, seed {}, {}", particles.size(), recording.particle_count(),
      recording.seed(),
      picture.door_open ? fmt::format("{:.2f} s after the door opened", times[frame] - *opening)
                        : fmt::format("door closed, {:.2f} s after the start", times[frame]));
  draw_heap(picture, file);
}

}  // namespace firn
