#include "reports/rendering/scene_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <list>

#include "experiments/system/gnuplot.h"
#include "experiments/system/text_encoding.h"
#include "reports/rendering/picture_source.h"
#include "reports/rendering/scene_layout.h"
#include "reports/rendering/scene_legend.h"

namespace firn {
namespace {

using Bounds = Eigen::AlignedBox3d;

// What of a mesh lies on the side of the plane that its normal points away from, in world axes.
TriangleMesh cut_mesh(const PlacedMesh& placed, const Vec3& normal, double offset) {
  TriangleMesh kept;
  for (const auto& t : placed.mesh->triangles) {
    std::vector<Vec3> loop;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = placed.pose * placed.mesh->vertices[t[k]];
      const Vec3 b = placed.pose * placed.mesh->vertices[t[(k + 1) % 3]];
      const double over_a = normal.dot(a) - offset, over_b = normal.dot(b) - offset;
      if (over_a <= 0) loop.push_back(a);
      if (over_a * over_b < 0) loop.emplace_back(a + over_a / (over_a - over_b) * (b - a));
    }
    const int first = static_cast<int>(kept.vertices.size());
    kept.vertices.insert(kept.vertices.end(), loop.begin(), loop.end());
    for (int k = 1; k + 1 < static_cast<int>(loop.size()); ++k) {
      kept.triangles.push_back({first, first + k, first + k + 1});
    }
  }
  return kept;
}

Bounds bounds_of(const PlacedMesh& placed) {
  Bounds bounds;
  for (const Vec3& v : placed.mesh->vertices) bounds.extend(placed.pose * v);
  return bounds;
}

// About the walls, and the bodies that are not far from them: one that has fallen out of the scene
// would make the rest small.
Bounds bounds_of(const ScenePicture& picture) {
  constexpr double kNear = 0.25;  // of the diagonal of the walls
  Bounds bounds;
  for (const auto& wall : picture.walls) bounds.extend(bounds_of(wall.placed));
  Bounds near = bounds;
  if (!bounds.isEmpty()) {
    near.min().array() -= kNear * bounds.diagonal().norm();
    near.max().array() += kNear * bounds.diagonal().norm();
  }
  for (const PlacedMesh& particle : picture.particles) {
    const Bounds body = bounds_of(particle);
    if (picture.walls.empty() || near.contains(body)) bounds.extend(body);
  }
  return bounds;
}

Scene make_scene(const ScenePicture& picture, const Bounds& bounds) {
  Scene scene;
  for (std::size_t i = 0; i < picture.walls.size(); ++i) {
    scene.bodies.push_back({picture.walls[i].placed, wall_color(i), true});
  }
  const std::vector<Color> colors = particle_colors(picture);
  for (std::size_t k = 0; k < picture.particles.size(); ++k) {
    scene.bodies.push_back({picture.particles[k], colors[k], true});
  }
  scene.occlusion_radius = 0.05 * bounds.diagonal().norm();
  return scene;
}

// The same triangles seen from behind: where they show, a solid is cut.
TriangleMesh turned(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Around the picture of a panel: title, axes and their labels.
constexpr PanelMargins kPanelMargins = {
    .left = 92, .below = 62, .above = 40, .right = 18, .title_width = 300};

// A view along an axis, and the axes that run right and up in it.
struct Panel {
  const char* title;
  Vec3 direction = Vec3::Zero(), up = Vec3::Zero();
  int right_axis, up_axis;
  bool cut;  // through the middle, what is nearer left out
};
const std::array<Panel, 3> kPanels = {
    {{"from above", -Vec3::UnitZ(), Vec3::UnitY(), 0, 1, false},
     {"section along x, seen from the back", Vec3::UnitY(), Vec3::UnitZ(), 0, 2, true},
     {"section across x, seen from its end", -Vec3::UnitX(), Vec3::UnitZ(), 1, 2, true}}};

Image draw_panel(const Scene& whole, const Panel& panel, const Bounds& bounds, int width) {
  Scene scene = whole;
  std::list<TriangleMesh> cut;  // keeps the meshes where they are
  if (panel.cut) {
    scene.bodies.clear();
    for (const RenderedBody& body : whole.bodies) {
      cut.push_back(cut_mesh(body.placed, -panel.direction, -panel.direction.dot(bounds.center())));
      scene.bodies.push_back({{&cut.back(), {}}, body.color, false});
      cut.push_back(turned(cut.back()));
      const Color dark{0.45f * body.color.r, 0.45f * body.color.g, 0.5f * body.color.b};
      scene.bodies.push_back({{&cut.back(), {}}, dark, false});
    }
    scene.to_light = (Vec3(0.2, 0, 0.5) - panel.direction).normalized();
  }
  const Vec3 size = bounds.sizes();
  return render(scene,
                View::parallel(bounds.center(), panel.direction, panel.up, size[panel.right_axis],
                               size[panel.up_axis]),
                width);
}

// From above, from the side of positive x and y; the box fills the picture.
View overview(const Bounds& bounds) {
  constexpr double kMargin = 0.02;  // of the picture
  const Vec3 middle = bounds.center();
  const Vec3 eye = middle + 1.6 * bounds.diagonal().norm() * Vec3(0.5, 0.7, 0.9).normalized();
  const View unit = View::perspective(eye, middle, Vec3::UnitZ(), 1, 1);
  Eigen::AlignedBox2d part;
  for (int k = 0; k < 8; ++k)
    part.extend(unit.project(bounds.corner(static_cast<Bounds::CornerType>(k))).head<2>());
  const Eigen::Vector2d margin = kMargin * part.sizes();
  part.extend((part.min() - margin).eval());
  part.extend((part.max() + margin).eval());
  return unit.cropped(part);
}

std::string frame_script(const CanvasBox& f, double canvas_width, double canvas_height) {
  return fmt::format(
      "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\n"
      "set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}\n",
      f.left / canvas_width, (f.left + f.width) / canvas_width, 1 - f.top / canvas_height,
      1 - (f.top + f.height) / canvas_height);
}

// 1, 2 or 5 times a power of ten, not below `least`.
double tick_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least) return factor * power;
  return 10 * power;
}

std::string panel_script(const Panel& panel, const Bounds& bounds, const Image& image,
                         const std::string& source) {
  // Pixels for the label of a tick; a narrow picture has labels as close as they may be.
  const double label_width = image.width < 200 ? 36 : 52, label_height = 24;
  const int right = panel.right_axis, up = panel.up_axis;
  const double step = 1e3 * bounds.sizes()[right] / image.width;  // mm a pixel
  const double left = 1e3 * bounds.min()[right], bottom = 1e3 * bounds.min()[up];
  return fmt::format(
      "set border 3 lc rgb '#8a929c'\nset xtics out nomirror textcolor rgb '#30343b'\n"
      "set ytics out nomirror textcolor rgb '#30343b'\n"
      "set title '{}' offset 0,-0.6 textcolor rgb '#5b6673'\n"
      "set xlabel '{} / mm' offset 0,0.5\nset ylabel '{} / mm' offset 1,0\n"
      "set xrange [{:.4f}:{:.4f}]\nset yrange [{:.4f}:{:.4f}]\n"
      "set xtics {:g}\nset ytics {:g}\n"
      "plot {} origin=({:.5f},{:.5f}) dx={:.6f} dy={:.6f} with rgbimage\n",
      panel.title, "xyz"[right], "xyz"[up], left, left + step * image.width, bottom,
      bottom + step * image.height, tick_step(label_width * step), tick_step(label_height * step),
      source, left + step / 2, bottom + step / 2, step, step);
}

// Lit from the side, so that faces differ.
Image draw_overview(Scene scene, const View& view, int width) {
  scene.to_light = Vec3(0.75, 0.5, 0.8).normalized();
  return render(scene, view, width);
}

std::string overview_script(const CanvasBox& box, double canvas_width, double canvas_height,
                            const Image& image, const std::string& source) {
  return frame_script(box, canvas_width, canvas_height) +
         fmt::format(
             "unset border\nunset tics\nunset xlabel\nunset ylabel\nunset title\n"
             "set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\nplot {} with rgbimage\n",
             image.width - 1, image.height - 1, source);
}

// The begin of a script: several plots on one canvas, under title and subtitle.
std::string title_script(const ScenePicture& picture, double canvas_height) {
  return fmt::format(
      "set multiplot\nunset key\n"
      "set label 1 {} at screen 0.015, screen {:.5f} front font ',22' tc rgb '#1d2733' "
      "noenhanced\n"
      "set label 2 {} at screen 0.015, screen {:.5f} front font ',14' tc rgb '#5b6673' "
      "noenhanced\n",
      encode::gnuplot(picture.title), 1 - 28 / canvas_height, encode::gnuplot(picture.subtitle),
      1 - 58 / canvas_height);
}

}  // namespace

void draw_scene(const ScenePicture& picture, const std::string& file) {
  Gnuplot::check_picture(file);  // refuses a wrong extension before the work begins
  Bounds bounds = bounds_of(picture);
  if (bounds.isEmpty()) {
    throw InputError(picture.title +
                     ": has neither solid boundaries nor bodies; expected something to draw");
  }
  bounds.min().array() -= 0.02 * bounds.diagonal().norm();
  bounds.max().array() += 0.02 * bounds.diagonal().norm();
  const Scene scene = make_scene(picture, bounds);
  const SceneLegend legend = legend_of(picture);

  constexpr double kTitle = 78, kBottom = 20;
  const View outside = overview(bounds);
  const SceneLayout layout =
      arrange_scene(bounds.sizes(), outside.height_over_width(), picture.width, kPanelMargins);
  std::array<CanvasBox, 3> frames = {layout.plan, layout.front, layout.side};
  CanvasBox over = layout.overview;
  for (CanvasBox* box : {&frames[0], &frames[1], &frames[2], &over}) box->top += kTitle;
  const double width = picture.width;
  const double height = kTitle + layout.height + kBottom + SceneLegend::kRow * legend.rows;

  std::future<Image> images[3];  // side by side: they take seconds
  for (std::size_t k = 0; k < 3; ++k) {
    images[k] = std::async(std::launch::async, [&, k] {
      return draw_panel(scene, kPanels[k], bounds, std::max(1, static_cast<int>(frames[k].width)));
    });
  }
  const Image whole = draw_overview(scene, outside, std::max(1, static_cast<int>(over.width)));
  const Gnuplot gnuplot;
  std::string script = title_script(picture, height) + legend_script(legend, width, height);
  for (std::size_t k = 0; k < 3; ++k) {
    const Image image = images[k].get();
    script += frame_script(frames[k], width, height) +
              panel_script(kPanels[k], bounds, image,
                           image_source(gnuplot, fmt::format("panel{}", k), image)) +
              "unset label\n";
  }
  script += overview_script(over, width, height, whole, image_source(gnuplot, "overview", whole));
  gnuplot.draw(script + "unset multiplot\n", file, picture.width, static_cast<int>(height));
}

Bounds scene_bounds(const ScenePicture& picture) { return bounds_of(picture); }

void draw_film_picture(const ScenePicture& picture, const Bounds& bounds, const std::string& file) {
  constexpr double kTitle = 74, kMargin = 16, kAxisX = 96, kAxisY = 62, kPanelTitle = 30;
  const double width = picture.width, height = film_height(picture.width);
  const Scene scene = make_scene(picture, bounds);
  const SceneLegend legend = legend_of(picture);
  const double bottom = height - SceneLegend::kRow * legend.rows - kMargin;
  const View outside = overview(bounds);
  const double left_width =
      std::floor(std::min(0.5 * width, (bottom - kTitle) / outside.height_over_width()));
  std::future<Image> whole = std::async(std::launch::async, [&] {
    return draw_overview(scene, outside, static_cast<int>(left_width));
  });
  const Panel& panel = kPanels[1];
  const Vec3 size = bounds.sizes();
  const double room = width - left_width - kAxisX - kMargin;
  const double tall = bottom - kTitle - kPanelTitle - kAxisY;
  const double scale = std::min(room / size[panel.right_axis], tall / size[panel.up_axis]);
  const Image section = draw_panel(scene, panel, bounds,
                                   std::max(1, static_cast<int>(scale * size[panel.right_axis])));
  const CanvasBox right{left_width + kAxisX, kTitle + kPanelTitle + (tall - section.height) / 2,
                        static_cast<double>(section.width), static_cast<double>(section.height)};
  const Image image = whole.get();
  const CanvasBox over{0, kTitle + (bottom - kTitle - image.height) / 2, left_width,
                       static_cast<double>(image.height)};
  const Gnuplot gnuplot;
  const std::string script =
      title_script(picture, height) + legend_script(legend, width, height) +
      frame_script(right, width, height) +
      panel_script(panel, bounds, section, image_source(gnuplot, "section", section)) +
      "unset label\n" +
      overview_script(over, width, height, image, image_source(gnuplot, "overview", image));
  gnuplot.draw(script + "unset multiplot\n", file, picture.width, static_cast<int>(height));
}

}  // namespace firn
