#include "reports/documents/case_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/run/interference_check.h"
#include "experiments/run/particle_flow.h"
#include "experiments/run/placement.h"
#include "firn/rigid_motion.h"
#include "reports/rendering/simplify_mesh.h"
#include "reports/replay/replay_data.h"

namespace firn {
namespace {

using page::Cell;
using replay::Json;

// A stage, when it starts if every stage before takes its longest duration, and how long it is.
struct TimedStage {
  const Stage* stage = nullptr;
  double start = 0, end = 0;  // s
};
std::vector<TimedStage> timed_stages(const Case& c) {
  std::vector<TimedStage> stages;
  double at = 0;
  for (const Stage& stage : c.stages) {
    const double end = std::min(at + stage.max_duration, std::max(at, c.duration));
    stages.push_back({&stage, at, end});
    at = end;
  }
  return stages;
}
double end_of(const Case& c, const std::vector<TimedStage>& stages) {
  return stages.empty() ? c.duration : stages.back().end;
}

// Prescribed motions of frames and boundaries, those that stages start included.
class Prescribed {
 public:
  Prescribed(const Case& c, const std::vector<TimedStage>& stages)
      : model_(c.model), frames_(model_.frames.size()), boundaries_(model_.boundaries.size()) {
    for (std::size_t f = 0; f < frames_.size(); ++f) frames_[f] = model_.frames[f].motions;
    for (std::size_t b = 0; b < boundaries_.size(); ++b)
      boundaries_[b] = model_.boundaries[b].motions;
    for (const TimedStage& timed : stages) {
      for (const Stage::StartedMotion& start : timed.stage->motions) {
        Motion motion = start.motion;
        motion.start += timed.start;
        motion.stop += timed.start;
        if (std::isfinite(motion.end)) motion.end += timed.start;
        if (start.ends_with_stage) motion.end = std::min(motion.end, timed.end);
        (start.frame >= 0 ? frames_[index(start.frame)] : boundaries_[index(start.boundary)])
            .push_back(motion);
      }
    }
  }

  // Motion of a boundary from t = 0 to t, world axes.
  RigidMotion of_boundary(std::size_t b, double t) const {
    return of_frame(model_.boundaries[b].frame, t) * of_list(boundaries_[b], t);
  }
  bool any() const {
    const auto moves = [](const std::vector<Motion>& list) { return !list.empty(); };
    return std::ranges::any_of(frames_, moves) || std::ranges::any_of(boundaries_, moves);
  }

 private:
  static RigidMotion of_list(const std::vector<Motion>& motions, double t) {
    RigidMotion motion;
    for (const Motion& m : motions) motion.append(m, Vec3::Zero(), m.total_displacement(t));
    return motion;
  }
  RigidMotion of_frame(int frame, double t) const {
    if (frame < 0) return {};
    return of_frame(model_.frames[index(frame)].parent, t) * of_list(frames_[index(frame)], t);
  }

  const Model& model_;
  std::vector<std::vector<Motion>> frames_, boundaries_;
};

// The case with the first batch of every fill and inlet due at once, and no later one.
Case with_first_batches_at_once(const Case& c, int most) {
  Case first = c;
  for (Fill& fill : first.fills) {
    fill.batch = std::min(fill.batch > 0 ? fill.batch : fill.count, most);
    fill.start = 0;
    fill.interval = 1e9;
    fill.stage.clear();
  }
  for (Inlet& inlet : first.inlets) {
    inlet.start = 0;
    inlet.interval = 1e9;
    inlet.stage.clear();
  }
  return first;
}

void add_particles(const Case& c, const Solver& solver, const ParticleFlow& flow,
                   ScenePoses& poses) {
  const ParticleState& state = solver.particles();
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    if (state.presence[i] != Presence::present) continue;
    const Particle& particle = c.model.particles[i];
    ScenePoses::Body body;
    body.shape = particle.shape;
    body.tag = flow.state.passages.tag[i];
    body.batch = flow.state.passages.batch[i];
    body.position = state.position[i];
    body.orientation = solver.shape_orientation(static_cast<int>(i));
    poses.particles.push_back(body);
  }
}

std::array<float, 3> packed(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}
std::array<float, 4> packed(const Quat& q) {
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
          static_cast<float>(q.z())};
}

// s, when a stage removes a boundary; infinite: never.
double removal_time(const std::string& boundary, const std::vector<TimedStage>& stages) {
  for (const TimedStage& timed : stages) {
    if (std::ranges::find(timed.stage->remove, boundary) != timed.stage->remove.end())
      return timed.start;
  }
  return kUnbounded;
}

std::string text_of(const Vec3& v, double scale) {
  return fmt::format("{:.4g} {:.4g} {:.4g}", v.x() * scale, v.y() * scale, v.z() * scale);
}

std::string material_name(const Case& c, int material) {
  return c.model.materials[index(material)].name;
}

void add_shapes(page::Page& page, const Case& c) {
  page::Table table{"Shapes of particles",
                    {{"shape", ""},
                     {"material", ""},
                     {"box", "mm"},
                     {"mass", "g"},
                     {"contact parts", ""},
                     {"deviation", "mm"},
                     {"rounding", "mm"},
                     {"contact stiffness", "N/m"}},
                    {}};
  for (const Shape& s : c.model.shapes)
    table.rows.push_back({s.name, material_name(c, s.material), text_of(s.box, 1e3), s.mass * 1e3,
                          Cell(static_cast<double>(s.parts.size())), s.surface_deviation * 1e3,
                          s.rounding * 1e3, s.stiffness});
  if (table.rows.empty()) return;
  page::Content& content = page.section("Shapes");
  content.table(table);
  for (const Shape& s : c.model.shapes) {
    if (!s.deviation_reason.empty())
      content.paragraph(fmt::format("{}: {}.", s.name, s.deviation_reason));
  }
}

void add_boundaries(page::Page& page, const Case& c) {
  page::Table table{
      "Boundaries",
      {{"boundary", ""}, {"material", ""}, {"kind", ""}, {"triangles", ""}, {"motion frame", ""}},
      {}};
  for (const Boundary& b : c.model.boundaries)
    table.rows.push_back({b.name, material_name(c, b.material),
                          b.kind == Boundary::Kind::plane ? "plane" : "surface",
                          Cell(static_cast<double>(b.mesh.triangles.size())),
                          b.frame < 0 ? "" : c.model.frames[index(b.frame)].name});
  if (!table.rows.empty()) page.section("Boundaries").table(table);
}

void add_schedule(page::Page& page, const Case& c) {
  page::Content& content = page.section("Schedule");
  page::Table stages{"Stages. Starts assume that every stage before takes its longest duration.",
                     {{"stage", ""}, {"start", "s"}, {"longest", "s"}, {"removes", ""}},
                     {}};
  for (const TimedStage& timed : timed_stages(c)) {
    std::string removes;
    for (const std::string& name : timed.stage->remove)
      removes += (removes.empty() ? "" : ", ") + name;
    stages.rows.push_back({timed.stage->name, timed.start, timed.stage->max_duration, removes});
  }
  if (!stages.rows.empty()) content.table(stages);
  page::Table fills{"Particles that are added",
                    {{"what", ""},
                     {"shape", ""},
                     {"count", ""},
                     {"batch", ""},
                     {"from", "s"},
                     {"every", "s"},
                     {"stage", ""}},
                    {}};
  for (const Fill& f : c.fills)
    fills.rows.push_back({"fill", f.shape, Cell(static_cast<double>(f.count)),
                          Cell(static_cast<double>(f.batch > 0 ? f.batch : f.count)), f.start,
                          f.interval, f.stage});
  for (const Inlet& s : c.inlets) {
    std::string shapes;
    for (const Inlet::Piece& piece : s.pieces)
      shapes += (shapes.empty() ? "" : " + ") + piece.shape;
    const double batch = static_cast<double>(s.batch_size());
    fills.rows.push_back({"inlet " + s.name, shapes, Cell(batch * s.batches), Cell(batch), s.start,
                          s.interval, s.stage});
  }
  if (!fills.rows.empty()) content.table(fills);
  content.properties(
      {{"longest duration", fmt::format("{:.4g} s", c.duration)},
       {"time step", fmt::format("{} us", page::number_text(1e6 * c.model.timestep))},
       {"particles", fmt::format("{}", c.model.particles.size())},
       {"seed", fmt::format("{}", c.seed)}});
  if (!c.timestep_reason.empty()) content.paragraph(c.timestep_reason);
}

void add_interactions(page::Page& page, const Case& c) {
  page::Table table{
      "Contact parameters by pair of materials",
      {{"pair", ""}, {"static friction", ""}, {"dynamic friction", ""}, {"restitution", ""}},
      {}};
  const std::size_t n = c.model.materials.size();
  if (c.model.interactions.size() == n * n) {
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = a; b < n; ++b) {
        const Interaction& i = c.model.interactions[a * n + b];
        if (i.static_friction == 0 && i.dynamic_friction == 0 && i.restitution == 1) continue;
        table.rows.push_back({c.model.materials[a].name + " on " + c.model.materials[b].name,
                              i.static_friction, i.dynamic_friction, i.restitution});
      }
  }
  if (!table.rows.empty()) page.section("Contact parameters").table(table);
}

Json particle_facts(const Case& c, const ScenePoses& poses) {
  const std::size_t n = poses.particles.size();
  Json facts;
  facts["particles"] = n;
  for (const char* key : {"shape", "tag", "batch", "came", "left", "outlet", "peak_force"})
    facts[key] = Json::array();
  for (const ScenePoses::Body& body : poses.particles) {
    facts["shape"].push_back(body.shape);
    facts["tag"].push_back(body.tag);
    facts["batch"].push_back(body.batch);
    facts["came"].push_back(0);
    facts["left"].push_back(nullptr);
    facts["outlet"].push_back(-1);
    facts["peak_force"].push_back(0);
  }
  for (const char* key : {"outlets", "sensors", "bonds", "maps", "stages", "boundaries"})
    facts[key] = Json::array();
  for (const ScenePoses::StageStart& stage : poses.stages)
    facts["stages"].push_back({{"name", stage.name}, {"start", replay::micro(stage.start)}});
  facts["shapes"] = replay::shapes_json(c, n);
  for (std::size_t s = 0; s < c.model.shapes.size(); ++s)
    facts["shapes"][s]["parts"] = replay::parts_json(c.model.shapes[s]);
  const Eigen::AlignedBox3d box = replay::scene_extent(c, poses.tracks, true);
  facts["extent"] = replay::box_json(box);
  const std::size_t each =
      replay::kBoundaryTriangles / std::max<std::size_t>(c.model.boundaries.size(), 1);
  for (const Boundary& b : c.model.boundaries) {
    const bool plane = b.mesh.triangles.empty();
    Json mesh = replay::mesh_json(
        b.name, plane ? replay::plane_rectangle(b, box) : simplified_mesh(b.mesh, each),
        Vec3::Zero());
    mesh["plane"] = plane;
    facts["boundaries"].push_back(mesh);
  }
  facts["markers"] = replay::markers_json(c);
  facts["setup"] = true;  // markers are shown from the start
  return facts;
}

}  // namespace

ScenePoses scene_poses(const Case& c, int most) {
  ScenePoses poses;
  const std::vector<TimedStage> stages = timed_stages(c);
  for (const TimedStage& timed : stages) poses.stages.push_back({timed.stage->name, timed.start});

  Solver solver(unowned(c.model), 0);
  place_start(solver, c);
  const Case first = with_first_batches_at_once(c, most);
  ParticleFlow flow(first);
  const std::string no_stage;
  try {
    if (const auto blocked = flow.place_due(solver, {&no_stage, 0})) poses.problem = *blocked;
  } catch (const InputError& error) {
    poses.problem = error.what();
  }
  add_particles(c, solver, flow, poses);

  // Where [initial_state] puts boundaries; the motions carry on from there.
  std::vector<RigidMotion> started;
  for (std::size_t b = 0; b < c.model.boundaries.size(); ++b) {
    const Boundary& drawn = c.model.boundaries[b];
    const BoundaryState& now = solver.boundaries()[b];
    RigidMotion motion;
    motion.rotation = now.orientation * drawn.orientation.conjugate();
    motion.translation = now.position - motion.rotation * drawn.origin;
    started.push_back(motion);
  }

  const Prescribed prescribed(c, stages);
  const double end = end_of(c, stages);
  constexpr double kFramesPerSecond = 40;
  constexpr double kMostFrames = 1200;
  const bool moves = prescribed.any();
  const int frames =
      moves ? static_cast<int>(std::clamp(end * kFramesPerSecond, 60.0, kMostFrames)) : 2;
  PoseTracks& tracks = poses.tracks;
  tracks.bodies = poses.particles.size() + c.model.boundaries.size();
  for (int k = 0; k < frames; ++k) {
    const double t = end * k / (frames - 1);
    tracks.time.push_back(t);
    for (const ScenePoses::Body& body : poses.particles) {
      tracks.position.push_back(packed(body.position));
      tracks.orientation.push_back(packed(body.orientation));
    }
    for (std::size_t b = 0; b < c.model.boundaries.size(); ++b) {
      const Boundary& drawn = c.model.boundaries[b];
      const RigidMotion motion = started[b] * prescribed.of_boundary(b, t);
      const bool there = t < removal_time(drawn.name, stages);
      tracks.position.push_back(packed(there ? motion(drawn.origin) : Vec3::Constant(NAN)));
      tracks.orientation.push_back(packed(Quat(motion.rotation * drawn.orientation)));
    }
  }
  return poses;
}

page::Page case_page(const Case& c) {
  const ScenePoses poses = scene_poses(c);
  page::Page page(c.name, "case, before it runs");
  if (!poses.problem.empty()) page.top().note({page::Mark::caution, "placement"}, poses.problem);
  try {
    check_machine(c);
  } catch (const InputError& error) {
    page.alert().note({page::Mark::bad, "firn run refuses this case"}, error.what());
  }
  page::Content& scene = page.section("Scene", "scene");
  replay::place_view(page, scene, "case", c.name,
                     replay::data_text(particle_facts(c, poses), poses.tracks));
  scene.paragraph(fmt::format(
      "{} of {} particles: those placed at the start and the first batch of every fill and inlet. "
      "Nothing is simulated: the slider plays the prescribed motions, free bodies stay where they "
      "start. Meshes are drawn coarser than they are computed.",
      poses.particles.size(), c.model.particles.size()));
  add_schedule(page, c);
  add_shapes(page, c);
  add_boundaries(page, c);
  add_interactions(page, c);
  return page;
}

}  // namespace firn
