// Scenes of cases and of results files.
#include <fmt/core.h>

#include <algorithm>
#include <list>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/meshes/wall_solids.h"
#include "experiments/results/bond_results.h"
#include "experiments/run/placement.h"
#include "reports/rendering/scene_picture.h"

namespace firn {
namespace {

// Boundaries with a mesh where they are at the start; of one name unless it is empty.
std::vector<ScenePicture::Wall> walls_at_start(const Case& c, const Solver& start,
                                               const std::string& name = {}) {
  std::vector<ScenePicture::Wall> result;
  const std::vector<BoundaryState>& walls = start.boundaries();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Boundary& b = c.model.boundaries[i];
    if (b.mesh.triangles.empty() || (!name.empty() && b.name != name)) continue;
    const Mat3 rotation = walls[i].orientation.toRotationMatrix();
    result.push_back({b.name, {&b.mesh, {rotation, walls[i].position}}});
  }
  return result;
}

// A bond about as thick as its bodies joins pieces of one body: the pieces show it.
bool is_within_its_bodies(const Model& model, const BondBox& bond) {
  const Shape& shape = shape_of(model, model.bonds[index(bond.bond)].a);
  return std::min(bond.size.y(), bond.size.z()) > 0.5 * middle_edge(shape);
}

}  // namespace

void draw_boundary(const Case& c, const std::string& name, const std::string& file) {
  Solver start(unowned(c.model), 0);
  place_start(start, c);
  ScenePicture picture;
  picture.title = name;
  picture.subtitle = fmt::format("of {}, at the start", c.name);
  picture.walls = walls_at_start(c, start, name);
  draw_scene(picture, file);
}

void draw_scene(const Case& c, const std::string& file) {
  ScenePicture picture;
  picture.title = c.name;
  Solver start(unowned(c.model), 0);
  place_start(start, c);
  picture.walls = walls_at_start(c, start);
  for (const Case::InitialParticle& p : c.placed) {
    const Shape& shape = c.model.shapes[c.model.particles[p.particle].shape];
    const Mat3 rotation = p.orientation.toRotationMatrix();
    picture.particles.push_back({&shape.mesh, {rotation, p.position - rotation * shape.centroid}});
  }
  picture.subtitle =
      fmt::format("at the start, {} of {} bodies", c.placed.size(), c.model.particles.size());
  draw_scene(picture, file);
}

struct RecordedScenes::Impl {
  explicit Impl(const Recording& of) : recording(of) {}

  const Recording& recording;
  Case c = read_case(recording);
  std::vector<double> times = recording.frame_times();
  std::vector<int> tags = recording.tag();
  std::vector<BondOutcome> outcomes = bond_outcomes(recording);
  std::list<TriangleMesh> bridges;  // of the last scene
};

RecordedScenes::RecordedScenes(const Recording& recording)
    : impl_(std::make_unique<Impl>(recording)) {}
RecordedScenes::~RecordedScenes() = default;

ScenePicture RecordedScenes::scene(std::size_t index) {
  const Case& c = impl_->c;
  const std::vector<double>& times = impl_->times;
  const std::vector<int>& tags = impl_->tags;
  if (index >= times.size()) {
    throw InputError(fmt::format("{}: has no frame {}; expected less than {}",
                                 impl_->recording.file(), index, times.size()));
  }
  const Frame frame = impl_->recording.frame(index);
  ScenePicture picture;
  picture.title = c.name;
  for (const Boundary& b : c.model.boundaries) {
    const BoundaryFrame now = impl_->recording.boundary(b.name, index);
    if (b.mesh.triangles.empty() || now.position.hasNaN()) continue;
    picture.walls.push_back(
        {b.name, {&b.mesh, {now.orientation.toRotationMatrix(), now.position}}});
  }
  for (std::size_t i = 0; i < frame.position.size(); ++i) {
    if (std::isnan(frame.position[i][0])) continue;
    const Shape& shape = c.model.shapes[c.model.particles[i].shape];
    const auto& q = frame.orientation[i];
    const Mat3 rotation = Quat(q[0], q[1], q[2], q[3]).toRotationMatrix();
    picture.particles.push_back(
        {&shape.mesh, {rotation, Vec3(frame.position[i].data()) - rotation * shape.centroid}});
    picture.tags.push_back(tags[i]);
  }
  picture.subtitle = fmt::format("at {:.4g} s, {} of {} bodies", times[index],
                                 picture.particles.size(), frame.position.size());
  impl_->bridges.clear();
  const std::vector<BondBox> bonds = intact_bonds_at(c, impl_->outcomes, times[index], frame);
  for (const BondBox& bridge : bonds) {
    if (is_within_its_bodies(c.model, bridge)) continue;
    impl_->bridges.push_back(box_mesh(bridge.size));
    picture.particles.push_back(
        {&impl_->bridges.back(), {bridge.orientation.toRotationMatrix(), bridge.position}});
    picture.tags.push_back(
        tags[static_cast<std::size_t>(c.model.bonds[static_cast<std::size_t>(bridge.bond)].a)]);
  }
  if (!c.model.bonds.empty()) {
    picture.subtitle += bonds.size() == 1 ? std::string(", 1 bond holds")
                                          : fmt::format(", {} bonds hold", bonds.size());
  }
  return picture;
}

void draw_scene(const Recording& recording, std::size_t index, const std::string& file) {
  draw_scene(RecordedScenes(recording).scene(index), file);
}

}  // namespace firn
