#include "reports/rendering/contact_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <list>
#include <numbers>
#include <set>

#include "experiments/system/gnuplot.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "reports/rendering/mesh_renderer.h"
#include "reports/rendering/picture_source.h"

namespace firn {
namespace {

constexpr Color kBody{0.98f, 0.80f, 0.42f};  // the one that is asked about
constexpr Color kIce{0.80f, 0.90f, 0.98f};
constexpr Color kContactWallColor{0.72f, 0.74f, 0.77f};
constexpr Color kNormal{0.80f, 0.12f, 0.10f};
constexpr Color kFriction{0.10f, 0.35f, 0.75f};
constexpr Color kWeight{0.25f, 0.27f, 0.30f};

// How much of the picture each layer makes: arrows alone, with the body, with its neighbors too.
constexpr double kLayers[] = {0.2, 0.48, 0.32};
constexpr double kFrictionScale = 4;      // arrows of friction are so much longer
constexpr double kTitle = 84, kKey = 44;  // pixels

// Adds the side faces of a truncated cone about the z axis and its base at `z_from` (unit: m).
void add_cone(double z_from, double r_from, double z_to, double r_to, TriangleMesh& mesh) {
  constexpr int kSides = 20;
  const int base = static_cast<int>(mesh.vertices.size());
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2 * std::numbers::pi * k / kSides;
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    mesh.vertices.push_back(r_from * out + z_from * Vec3::UnitZ());
    mesh.vertices.push_back(r_to * out + z_to * Vec3::UnitZ());
  }
  mesh.vertices.push_back(z_from * Vec3::UnitZ());
  const int center = static_cast<int>(mesh.vertices.size()) - 1;
  for (int k = 0; k < kSides; ++k) {
    const int a = base + 2 * k, b = base + 2 * ((k + 1) % kSides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    mesh.triangles.push_back({center, b, a});  // base at z_from
  }
}

// An arrow along z that ends at the origin.
TriangleMesh arrow(double length, double radius) {
  TriangleMesh mesh;
  const double head = std::min(0.5 * length, 5 * radius);
  add_cone(-length, radius, -head, radius, mesh);
  add_cone(-head, 2.4 * radius, 0, 1e-3 * radius, mesh);
  return mesh;
}

class ContactScene {
 public:
  ContactScene(const Case& c, const ContactSelection& choice, const ContactSnapshot& now)
      : model_(c.model), choice_(choice), now_(now) {
    const int main = is_particle(model_, choice.body) ? choice.body : choice.other;
    main_ = main;
    center_ = now.particles.position[index(main)];
    size_ = shape(main).bounding_radius;
    add_particle(main, kBody);
    for (const ContactView& view : now.contacts) {
      for (const ContactPointInfo& spot : view.contact.points)
        longest_ = std::max(longest_, spot.force);
      for (const int body : {view.contact.a, view.contact.b})
        if (body != main && shown_.insert(body).second) add_neighbor(body);
    }
    const double weight = (shape(main).mass * model_.gravity).norm();
    most_ = std::max(longest_, weight);
    add_forces(weight);
  }

  // The body shows through its neighbors, and the arrows through the body.
  Image draw(const View& view, const Vec3& direction, int width) const {
    Image image;
    std::vector<Eigen::Vector3d> sum;
    for (int layer : {0, 1, 2}) {
      image = render(make_scene(layer, direction), view, width);
      sum.resize(image.pixels.size(), Eigen::Vector3d::Zero());
      for (std::size_t k = 0; k < sum.size(); ++k) {
        for (int channel : {0, 1, 2})
          sum[k][channel] += kLayers[layer] * image.pixels[k][index(channel)];
      }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) {
      for (int channel : {0, 1, 2})
        image.pixels[k][index(channel)] = static_cast<std::uint8_t>(std::lround(sum[k][channel]));
    }
    return image;
  }

  View view(const Vec3& direction) const {
    const double span = 2.8 * size_;
    return View::parallel(center_, direction, Vec3::UnitZ(), span, span);
  }

  struct Label {
    double x, y;  // of the panel, 0 ... 1
    std::string text;
  };
  // One for each neighbor that bears, where its largest force acts.
  std::vector<Label> labels(const View& view) const {
    std::vector<Label> all;
    for (const int body : shown_) {
      double sum = 0, most = 0;
      Vec3 tail = Vec3::Zero();
      for (const ContactView& v : now_.contacts) {
        if (!v.is_active() || (v.contact.a != body && v.contact.b != body)) continue;
        sum += v.contact.normal_force;
        for (const ContactPointInfo& spot : v.contact.points) {
          if (spot.force <= most) continue;
          most = spot.force;
          tail = spot.position - length(most) * push_on_main(v);
        }
      }
      if (sum <= 0) continue;
      const Vec3 p = view.project(tail);
      const std::string name =
          is_particle(model_, body) ? std::to_string(body) : body_name(model_, body);
      all.push_back({std::clamp(p.x(), 0.04, 0.80), std::clamp(p.y(), 0.04, 0.96),
                     fmt::format("{}: {:.3g} N", name, sum)});
    }
    return all;
  }

  double longest() const { return longest_; }  // N, at one point
  int main() const { return main_; }

 private:
  const Shape& shape(int particle) const {
    return model_.shapes[index(model_.particles[index(particle)].shape)];
  }

  Pose pose(int particle) const {
    const std::size_t i = index(particle);
    Pose p;
    p.rotation = now_.shape_orientation[i].toRotationMatrix();
    p.translation = now_.particles.position[i] - p.rotation * shape(particle).centroid;
    return p;
  }

  void add_particle(int particle, const Color& color) {
    RenderedBody body{{&shape(particle).mesh, pose(particle)}, color};
    (particle == main_ ? body_ : outer_).push_back(body);
  }

  void add_neighbor(int body) {
    if (is_particle(model_, body)) return add_particle(body, kIce);
    const std::size_t b = index(body) - model_.particles.size();
    const BoundaryState& state = now_.boundaries[b];
    const Boundary& boundary = model_.boundaries[b];
    Pose p{state.orientation.toRotationMatrix(), state.position};
    const TriangleMesh* mesh = &boundary.mesh;
    if (boundary.mesh.triangles.empty()) {
      mesh = &square();
      const Vec3 normal = p.rotation.col(2);
      p.translation = center_ - normal.dot(center_ - state.position) * normal;
    }
    outer_.push_back({{mesh, p}, kContactWallColor, false});
  }

  // Of a plane: what lies near the body.
  const TriangleMesh& square() {
    const double r = 1.3 * size_;
    TriangleMesh mesh;
    mesh.vertices = {{-r, -r, 0}, {r, -r, 0}, {r, r, 0}, {-r, r, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 1}, {0, 3, 2}};  // seen from both sides
    meshes_.push_back(std::move(mesh));
    return meshes_.back();
  }

  // Direction of the normal force on the body that is drawn whole.
  Vec3 push_on_main(const ContactView& view) const {
    return view.contact.a == main_ ? Vec3(-view.contact.normal) : view.contact.normal;
  }
  double length(double force) const { return 0.9 * size_ * force / most_; }  // m

  void add_arrow(const Vec3& tip, const Vec3& force, const Color& color) {
    const double size = force.norm(), long_one = length(size);
    if (long_one < 0.02 * size_) return;  // too short to be seen
    const double radius = std::min(size_ * (0.012 + 0.022 * std::sqrt(size / most_)), long_one / 6);
    meshes_.push_back(arrow(long_one, radius));
    Pose p;
    p.rotation = shortest_rotation(Vec3::UnitZ(), force / size).toRotationMatrix();
    p.translation = tip;
    arrows_.push_back({{&meshes_.back(), p}, color, false});
  }

  void add_forces(double weight) {
    for (const ContactView& view : now_.contacts) {
      if (!view.is_active()) continue;
      const Contact& contact = view.contact;
      const Vec3 push = push_on_main(view);
      for (const ContactPointInfo& spot : contact.points)
        add_arrow(spot.position, spot.force * push, kNormal);
      const double sign = contact.a == main_ ? 1 : -1;
      const Vec3 friction = kFrictionScale * sign * contact.friction;
      // From the patch along the surface.
      add_arrow(contact.position + length(friction.norm()) * friction.stableNormalized(), friction,
                kFriction);
    }
    const Vec3 down = model_.gravity.norm() > 0 ? model_.gravity.normalized() : Vec3::UnitZ();
    add_arrow(center_ + length(weight) * down, weight * down, kWeight);
  }

  // Lit from over the viewer's shoulder.
  Scene make_scene(int layer, const Vec3& direction) const {
    Scene scene;
    const Vec3 right = direction.cross(Vec3::UnitZ()).normalized();
    scene.to_light = (-direction - 0.5 * right + 0.6 * Vec3::UnitZ()).normalized();
    scene.occlusion_radius = 0.5 * size_;
    scene.bodies = arrows_;
    if (layer >= 1) scene.bodies.insert(scene.bodies.end(), body_.begin(), body_.end());
    if (layer >= 2) scene.bodies.insert(scene.bodies.end(), outer_.begin(), outer_.end());
    return scene;
  }

  const Model& model_;
  const ContactSelection& choice_;
  const ContactSnapshot& now_;
  int main_ = 0;
  Vec3 center_ = Vec3::Zero();
  double size_ = 0;                // m
  double longest_ = 0, most_ = 0;  // N, at one point; the weight included
  std::set<int> shown_;
  std::list<TriangleMesh> meshes_;  // arrows and planes
  std::vector<RenderedBody> arrows_, body_, outer_;
};

std::string title_script(const std::string& title, const std::string& subtitle, double height) {
  return fmt::format(
      "set label 1 {} at screen 0.015, screen {:.5f} front font ',22' tc rgb '#1d2733' noenhanced\n"
      "set label 2 {} at screen 0.015, screen {:.5f} front font ',14' tc rgb '#5b6673' "
      "noenhanced\n",
      encode::gnuplot(title), 1 - 28 / height, encode::gnuplot(subtitle), 1 - 60 / height);
}

}  // namespace

void draw_contacts(const Case& c, const ContactSelection& choice, const ContactSnapshot& now,
                   const std::string& file, int panel_width) {
  const int width = 2 * panel_width;
  const double height = kTitle + panel_width + kKey;
  Gnuplot::check_picture(file);
  const ContactScene scene(c, choice, now);
  const Gnuplot gnuplot;
  const std::string who = body_name(c.model, choice.body) +
                          (choice.other >= 0 ? " and " + body_name(c.model, choice.other) : "");
  std::string script =
      "set multiplot\nunset key\nunset border\nunset tics\n"
      "set style textbox opaque noborder fillcolor rgb '#50ffffff' margins 0.4,0.3\n" +
      title_script(
          fmt::format("{}: {}", c.name, who),
          fmt::format("t = {:.6g} s, step {}; arrows push on {}, the longest red one is {:.3g} N; "
                      "labels: normal force by neighbor",
                      now.time, now.step, body_name(c.model, scene.main()), scene.longest()),
          height);
  const struct {
    const char* text;
    const char* color;
    double x;
  } key[] = {{"normal force at its points", "#cc1f1a", 0.015},
             {"friction of a patch, four times as long", "#1a59bf", 0.19},
             {"weight", "#40454d", 0.43}};
  for (const auto& k : key) {
    script += fmt::format(
        "set label '{}' at screen {:.3f}, screen {:.5f} front font ',14' tc rgb "
        "'{}'\n",
        k.text, k.x, 0.5 * kKey / height, k.color);
  }
  const Vec3 directions[] = {Vec3(0.45, 0.8, -0.45).normalized(),
                             Vec3(-0.45, -0.8, -0.12).normalized()};
  std::future<Image> images[2];  // side by side, too: they take seconds
  for (int panel : {0, 1}) {
    images[panel] = std::async(std::launch::async, [&scene, &directions, panel, panel_width] {
      return scene.draw(scene.view(directions[panel]), directions[panel], panel_width);
    });
  }
  for (int panel : {0, 1}) {
    const View view = scene.view(directions[panel]);
    const Image image = images[panel].get();
    const std::string source = image_source(gnuplot, fmt::format("panel{}", panel), image);
    script += fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {:.6f}\nset "
        "bmargin at screen {:.6f}\n",
        0.5 * panel, 0.5 * (panel + 1), 1 - kTitle / height, kKey / height);
    int number = 10;
    for (const ContactScene::Label& label : scene.labels(view)) {
      script += fmt::format(
          "set label {} {} at {:.2f},{:.2f} offset 0.6,0 front font ',13' tc rgb '#1d2733' "
          "noenhanced\n",
          number++, encode::gnuplot(label.text), label.x * image.width, label.y * image.height);
    }
    script += fmt::format(
        "set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\nplot {} with rgbimage\nunset label\n",
        image.width - 1, image.height - 1, source);
  }
  gnuplot.draw(script + "unset multiplot\n", file, width, static_cast<int>(height));
}

void draw_history(const Case& c, const ContactSelection& choice,
                  const std::vector<HistoryRow>& rows, const std::string& file) {
  constexpr int kWidth = 1500, kHeight = 760;
  Gnuplot::check_picture(file);
  const Gnuplot gnuplot;
  const std::filesystem::path data = gnuplot.data_file("rows");
  OutputFile out(data.string(), OutputFile::When::unsynced);
  for (const HistoryRow& r : rows) {
    // No body near: no overlap to draw.
    out << fmt::format("{:.12g} {:.9g} {:.9g} {} {:.9g} {:.9g}\n", 1e3 * r.time, r.normal_force,
                       r.friction, std::isnan(r.gap) ? "NaN" : fmt::format("{:.9g}", -1e6 * r.gap),
                       1e6 * r.work_normal, 1e6 * r.work_friction);
  }
  out.commit();
  const std::string who = body_name(c.model, choice.body) + " and " +
                          (choice.other >= 0 ? body_name(c.model, choice.other) : "its neighbors");
  const std::string source = "'rows'";
  const std::string script =
      "set multiplot\n" +
      title_script(fmt::format("{}: {}", c.name, who),
                   fmt::format("{:.6g} s to {:.6g} s; work is taken from the bodies",
                               rows.front().time, rows.back().time),
                   kHeight) +
      "set border 3 lc rgb '#8a929c'\nset tics nomirror out textcolor rgb '#30343b'\n"
      "set tmargin at screen 0.88\nset key top right\nset grid lc rgb '#e3e6ea'\n"
      "set lmargin at screen 0.07\nset rmargin at screen 0.5\nset bmargin at screen 0.46\n"
      "set ylabel 'force / N'\nset format x ''\n" +
      fmt::format(
          "plot {0} using 1:2 with lines lw 2 lc rgb '#cc1f1a' title 'normal force', {0} using 1:3 "
          "with lines lw 2 lc rgb '#1a59bf' title 'friction'\nunset label\n",
          source) +
      "set tmargin at screen 0.42\nset bmargin at screen 0.11\nset format x '%g'\n"
      "set xlabel 'time / ms'\nset ylabel 'work / µJ'\nset key bottom right\n" +
      fmt::format(
          "plot {0} using 1:5 with lines lw 2 lc rgb '#cc1f1a' title 'normal forces', {0} using "
          "1:6 with lines lw 2 lc rgb '#1a59bf' title 'friction'\n",
          source) +
      "set lmargin at screen 0.58\nset rmargin at screen 0.98\nset tmargin at screen 0.88\n"
      "set xlabel 'deepest overlap / µm (below 0: gap)'\nset ylabel 'normal force / N'\n" +
      fmt::format("plot {} using 4:2 with lines lw 2 lc rgb '#cc1f1a' notitle\n", source);
  gnuplot.draw(script + "unset multiplot\n", file, kWidth, kHeight);
}

}  // namespace firn
