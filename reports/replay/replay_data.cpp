#include "reports/replay/replay_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/system/text_encoding.h"
#include "experiments/text/vector_json.h"
#include "reports/html/assets.h"
#include "reports/html/data_encoding.h"
#include "reports/rendering/simplify_mesh.h"
namespace firn::replay {
namespace {

// Triangles of all particles together, for machines without a graphics processor.
constexpr std::size_t kParticleTriangles = 80'000;

Json box_marker(const char* kind, const std::string& name, const Vec3& low, const Vec3& high) {
  return {{"kind", kind},
          {"form", "box"},
          {"name", name},
          {"low", vector_json(low)},
          {"high", vector_json(high)}};
}
Json plane_marker(const char* kind, const std::string& name, const Vec3& point,
                  const Vec3& normal) {
  return {{"kind", kind},
          {"form", "plane"},
          {"name", name},
          {"point", vector_json(point)},
          {"normal", vector_json(normal)}};
}
// A direction through a point. `turns`: a rotation about it, otherwise a translation along it.
Json axis_marker(const char* kind, const std::string& name, const Vec3& point,
                 const Vec3& direction, bool turns) {
  return {{"kind", kind},
          {"form", "axis"},
          {"name", name},
          {"turns", turns},
          {"point", vector_json(point)},
          {"direction", vector_json(direction.normalized())}};
}

void add_motion(Json& markers, const std::string& mover, const Motion& m, const Vec3& place) {
  if (m.kind == Motion::Kind::rotation) {
    const double sense = m.profile == Motion::Profile::constant && m.angular_speed < 0 ? -1 : 1;
    markers.push_back(axis_marker("motion", mover, m.center, sense * m.axis, true));
    return;
  }
  const Vec3 along = m.profile == Motion::Profile::constant ? m.velocity : m.axis;
  if (along.norm() > 0) markers.push_back(axis_marker("motion", mover, place, along, false));
}

// The middle of what a frame carries, m, world at t = 0.
Vec3 middle_of(const Case& c, int frame) {
  Eigen::AlignedBox3d box;
  for (const Boundary& b : c.model.boundaries) {
    if (!descends_from(c.model.frames, b.frame, frame)) continue;
    for (const Vec3& v : b.mesh.vertices) box.extend(b.origin + b.orientation * v);
  }
  return box.isEmpty() ? c.model.frames[index(frame)].origin : Vec3(box.center());
}
Vec3 middle_of(const Boundary& b) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : b.mesh.vertices) box.extend(b.origin + b.orientation * v);
  return box.isEmpty() ? b.origin : Vec3(box.center());
}

std::string range_text(const Joint& axis) {
  const bool turns = axis.kind == Joint::Kind::rotation;
  const double scale = turns ? 180 / M_PI : 1e3;
  const char* unit = turns ? "deg" : "mm";
  std::string text;
  if (std::isfinite(axis.lower) || std::isfinite(axis.upper))
    text += fmt::format(", {:.4g} to {:.4g} {}", axis.lower * scale, axis.upper * scale, unit);
  if (axis.stiffness > 0) text += ", spring";
  if (axis.damping > 0) text += ", damper";
  if (axis.friction > 0) text += ", friction";
  if (!axis.motors.empty()) text += ", drive";
  return text;
}

// Where the axis of a joint of a free frame is drawn, m, world at t = 0.
Vec3 place_of_joint(const Case& c, int frame, int joint) {
  const MotionFrame& owner = c.model.frames[index(frame)];
  return owner.free->joints[index(joint)].kind == Joint::Kind::rotation ? owner.origin
                                                                        : middle_of(c, frame);
}

// The ratio of a gear in the units of the case file: mm in place of m.
std::string gear_text(const Case& c, const Coupling& gear) {
  const auto slides = [&](int frame, int joint) {
    return c.model.frames[index(frame)].free->joints[index(joint)].kind == Joint::Kind::translation;
  };
  const bool a = slides(gear.a, gear.joint_a), b = slides(gear.b, gear.joint_b);
  if (a == b) return fmt::format("gear {:.4g}", gear.ratio);
  return b ? fmt::format("gear {:.4g} mm/rad", gear.ratio * 1e3)
           : fmt::format("gear {:.4g} rad/mm", gear.ratio * 1e-3);
}

void add_couplings(Json& markers, const Case& c) {
  for (const Coupling& coupling : c.model.couplings) {
    using Kind = Coupling::Kind;
    const auto named = [&](const std::string& kind) { return coupling.name + ", " + kind; };
    const auto axis = [&](const char* kind, bool turns) {
      return axis_marker("coupling", named(kind), coupling.position, coupling.direction, turns);
    };
    const auto point = [&](const char* kind) {
      return Json{{"kind", "coupling"},
                  {"form", "point"},
                  {"name", named(kind)},
                  {"point", vector_json(coupling.position)}};
    };
    const auto tie = [&](const std::string& kind) {
      return Json{{"kind", "coupling"},
                  {"form", "line"},
                  {"name", named(kind)},
                  {"low", vector_json(place_of_joint(c, coupling.a, coupling.joint_a))},
                  {"high", vector_json(place_of_joint(c, coupling.b, coupling.joint_b))}};
    };
    switch (coupling.kind) {
      case Kind::ball:
        markers.push_back(point("ball"));
        break;
      case Kind::weld:
        markers.push_back(point("weld"));
        break;
      case Kind::hinge:
        markers.push_back(axis("hinge", true));
        break;
      case Kind::slot:
        markers.push_back(axis("slot", false));
        break;
      case Kind::gear:
        markers.push_back(tie(gear_text(c, coupling)));
        break;
      case Kind::cam:
        markers.push_back(tie("cam"));
        break;
    }
  }
}

void add_axes(Json& markers, const Case& c) {
  const Model& model = c.model;
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const MotionFrame& frame = model.frames[f];
    const Vec3 middle = middle_of(c, static_cast<int>(f));
    for (const Motion& m : frame.motions) add_motion(markers, frame.name, m, middle);
    if (!frame.free) continue;
    for (std::size_t j = 0; j < frame.free->joints.size(); ++j) {
      const Joint& axis = frame.free->joints[j];
      markers.push_back(axis_marker("free body", frame.name + range_text(axis),
                                    place_of_joint(c, static_cast<int>(f), static_cast<int>(j)),
                                    axis.direction, axis.kind == Joint::Kind::rotation));
    }
  }
  for (const Boundary& b : model.boundaries)
    for (const Motion& m : b.motions) add_motion(markers, b.name, m, middle_of(b));
  for (const Stage& stage : c.stages) {
    for (const Stage::StartedMotion& start : stage.motions) {
      const bool by_frame = start.frame >= 0;
      const std::string& mover = by_frame ? model.frames[index(start.frame)].name
                                          : model.boundaries[index(start.boundary)].name;
      add_motion(markers, mover + ", stage " + stage.name, start.motion,
                 by_frame ? middle_of(c, start.frame)
                          : middle_of(model.boundaries[index(start.boundary)]));
    }
  }
}

// Where particles are inserted. Empty for an inlet without positions.
Eigen::AlignedBox3d region_of(const Inlet& inlet) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : inlet.positions) {
    box.extend(p - inlet.position_jitter);
    box.extend(p + inlet.position_jitter);
  }
  return box;
}

// The places of all particles along each axis but for the lowest and the highest tenth, and the
// largest shape around them. Empty without particles.
Eigen::AlignedBox3d extent_of_particles(const Case& c, const PoseTracks& tracks,
                                        std::size_t particles) {
  constexpr std::size_t kMostFrames = 40;
  constexpr double kLowest = 0.1, kHighest = 0.9;
  const std::size_t stride = (tracks.time.size() + kMostFrames - 1) / kMostFrames;
  std::array<std::vector<double>, 3> along;
  for (std::size_t f = 0; f < tracks.time.size(); f += stride)
    for (std::size_t i = 0; i < particles; ++i) {
      const auto& p = tracks.position[f * tracks.bodies + i];
      if (std::isnan(p[0])) continue;
      for (std::size_t k = 0; k < 3; ++k) along[k].push_back(p[k]);
    }
  Eigen::AlignedBox3d box;
  if (along[0].empty()) return box;
  double reach = 0;
  for (const Shape& shape : c.model.shapes)
    for (const Vec3& v : shape.mesh.vertices) reach = std::max(reach, (v - shape.centroid).norm());
  for (std::size_t k = 0; k < 3; ++k) {
    std::ranges::sort(along[k]);
    const auto at = [&](double share) {
      const auto last = static_cast<double>(along[k].size() - 1);
      return along[k][static_cast<std::size_t>(std::lround(share * last))];
    };
    box.min()[static_cast<int>(k)] = at(kLowest) - 2 * reach;
    box.max()[static_cast<int>(k)] = at(kHighest) + 2 * reach;
  }
  return box;
}

}  // namespace

Json micro(double value) {
  return std::isfinite(value) ? Json(std::llround(std::clamp(value * 1e6, -9e18, 9e18)))
                              : Json(nullptr);
}
Json micro(const std::vector<double>& values) {
  Json all = Json::array();
  for (const double value : values) all.push_back(micro(value));
  return all;
}

Json mesh_json(const std::string& name, const TriangleMesh& mesh, const Vec3& origin) {
  Json vertices = Json::array(), triangles = Json::array();
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) vertices.push_back(micro(v[k] - origin[k]));
  for (const auto& t : mesh.triangles)
    for (const int corner : t) triangles.push_back(corner);
  return {{"name", name}, {"vertices", vertices}, {"triangles", triangles}};
}

Json shapes_json(const Case& c, std::size_t particles) {
  const std::size_t each =
      std::clamp<std::size_t>(kParticleTriangles / std::max<std::size_t>(particles, 1), 60, 400);
  Json shapes = Json::array();
  for (const Shape& shape : c.model.shapes)
    shapes.push_back(mesh_json(shape.name, simplified_mesh(shape.mesh, each), shape.centroid));
  return shapes;
}

TriangleMesh plane_rectangle(const Boundary& plane, const Eigen::AlignedBox3d& box) {
  constexpr double kMargin = 0.05;  // of the diagonal of the box
  Eigen::AlignedBox2d covered;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    covered.extend((plane.orientation.conjugate() * (corner - plane.origin)).head<2>().eval());
  }
  const double margin = kMargin * box.diagonal().norm();
  const Eigen::Vector2d low = covered.min().array() - margin, high = covered.max().array() + margin;
  TriangleMesh mesh;
  mesh.vertices = {{low.x(), low.y(), 0},
                   {high.x(), low.y(), 0},
                   {high.x(), high.y(), 0},
                   {low.x(), high.y(), 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Eigen::AlignedBox3d scene_extent(const Case& c, const PoseTracks& tracks, bool with_regions) {
  const std::size_t particles = tracks.bodies - c.model.boundaries.size();
  Eigen::AlignedBox3d box = extent_of_particles(c, tracks, particles);
  if (with_regions || box.isEmpty()) {
    for (const Fill& fill : c.fills) {
      box.extend(fill.region_min);
      box.extend(fill.region_max);
    }
    for (const Inlet& inlet : c.inlets) box.extend(region_of(inlet));
  }
  for (std::size_t b = 0; b < c.model.boundaries.size(); ++b) {
    const auto& p = tracks.position[particles + b];
    const auto& q = tracks.orientation[particles + b];
    if (std::isnan(p[0])) continue;
    const Vec3 origin(p[0], p[1], p[2]);
    const Quat orientation(q[0], q[1], q[2], q[3]);
    for (const Vec3& v : c.model.boundaries[b].mesh.vertices) box.extend(origin + orientation * v);
  }
  if (box.isEmpty()) box.extend(Vec3::Zero());
  constexpr double kLeast = 0.05;  // m, of a scene of one point
  if (box.diagonal().norm() > 0) return box;
  return {box.min() - Vec3::Constant(kLeast), box.max() + Vec3::Constant(kLeast)};
}

Json box_json(const Eigen::AlignedBox3d& box) {
  return {{"low", vector_json(box.min())}, {"high", vector_json(box.max())}};
}

Json parts_json(const Shape& shape) {
  Json parts = Json::array();
  for (const ConvexPart& part : shape.parts) {
    TriangleMesh mesh = surface_mesh(part);
    for (Vec3& v : mesh.vertices) v = shape.shape_from_body * v;
    parts.push_back(mesh_json("", mesh, Vec3::Zero()));
  }
  return parts;
}

Json markers_json(const Case& c) {
  Json markers = Json::array();
  for (const Fill& fill : c.fills)
    markers.push_back(box_marker("fill", fmt::format("{} {}", fill.count, fill.shape),
                                 fill.region_min, fill.region_max));
  for (const Inlet& inlet : c.inlets) {
    const Eigen::AlignedBox3d box = region_of(inlet);
    if (!box.isEmpty()) markers.push_back(box_marker("inlet", inlet.name, box.min(), box.max()));
  }
  for (const Sensor& sensor : c.sensors)
    markers.push_back(sensor.is_box
                          ? box_marker("sensor", sensor.name, sensor.region_min, sensor.region_max)
                          : plane_marker("sensor", sensor.name, sensor.point, sensor.normal));
  for (const Outlet& outlet : c.outlets)
    markers.push_back(plane_marker("outlet", outlet.name, outlet.point, outlet.normal));
  for (const TagRule& rule : c.tag_rules)
    markers.push_back(
        box_marker("tag rule", "tags, stage " + rule.stage, rule.region_min, rule.region_max));
  for (const Measure& m : c.measures) {
    if (m.kind == Measure::Kind::heap)
      markers.push_back(
          box_marker("measurement", m.name.empty() ? "heap" : m.name, m.region_min, m.region_max));
  }
  add_axes(markers, c);
  add_couplings(markers, c);
  return markers;
}

std::string data_text(Json facts, const PoseTracks& tracks) {
  const PackedTrajectories packed = pack(tracks);
  facts["bodies"] = packed.bodies;
  facts["time"] = micro(tracks.time);
  facts["low"] = {packed.low.x(), packed.low.y(), packed.low.z()};
  facts["high"] = {packed.high.x(), packed.high.y(), packed.high.z()};
  const std::string text = facts.dump();
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 + text.size() + packed.bytes.size());
  for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<std::uint8_t>(text.size() >> (8 * k)));
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.insert(bytes.end(), packed.bytes.begin(), packed.bytes.end());
  return base64(zlib_compressed(bytes));
}

void place_view(page::Page& page, page::Content& content, const std::string& anchor,
                const std::string& title, const std::string& data) {
  const std::string id = encode::markup(anchor);
  content.html(fmt::format(
      "<div class=\"replay\" id=\"replay-{0}\" data-name=\"{0}\" data-title=\"{1}\" "
      "data-source=\"replay-data-{0}\"><p class=\"replay-message\" role=\"status\">The replay "
      "needs a browser with JavaScript and WebGL.</p></div>\n",
      id, encode::markup(title)));
  page.add_data("replay-data-" + anchor, data);
  page.add_style(asset("replay.css"));
  for (const char* script : {"three_license.js", "three.min.js", "replay_data.js",
                             "replay_colors.js", "replay_markers.js", "replay_orbit.js",
                             "replay_scene.js", "replay_maps.js", "replay.js", "replay_views.js"})
    page.add_script(asset(script));
}

}  // namespace firn::replay
