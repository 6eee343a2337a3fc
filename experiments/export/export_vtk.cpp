#include <cmath>
#include <cstdint>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/export/export.h"
#include "experiments/export/scene_extent.h"
#include "experiments/meshes/wall_solids.h"
#include "experiments/results/body_number.h"
#include "experiments/results/bond_results.h"
#include "experiments/storage/vtk_file.h"

namespace firn {
namespace {

// A body's polygons in its own axes.
struct Body {
  std::vector<Vec3> points;
  std::vector<std::int32_t> connectivity, offsets;

  void add_face(std::initializer_list<int> corners) {
    connectivity.insert(connectivity.end(), corners.begin(), corners.end());
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
  }
};

Body body_of(const TriangleMesh& mesh, const Vec3& origin) {
  Body body;
  for (const Vec3& v : mesh.vertices) body.points.push_back(v - origin);
  for (const auto& t : mesh.triangles) body.add_face({t[0], t[1], t[2]});
  return body;
}

Body body_of(const std::vector<ConvexPart>& parts, const Quat& to_shape) {
  Body body;
  for (const ConvexPart& part : parts) {
    const auto base = static_cast<std::int32_t>(body.points.size());
    for (int i = 0; i < part.vertex_count; ++i) body.points.push_back(to_shape * part.vertex(i));
    for (const ConvexPart::Face& face : part.faces) {
      if (face.internal) continue;
      for (int k = face.first; k < face.first + face.count; ++k)
        body.connectivity.push_back(base + part.face_vertices[static_cast<std::size_t>(k)]);
      body.offsets.push_back(static_cast<std::int32_t>(body.connectivity.size()));
    }
  }
  return body;
}

// Half-space z <= 0: the square |x|, |y| <= reach of its surface.
Body square(double reach) {
  Body body;
  body.points = {{-reach, -reach, 0}, {reach, -reach, 0}, {reach, reach, 0}, {-reach, reach, 0}};
  body.add_face({0, 1, 2, 3});
  return body;
}

void append(VtkSurface& surface, const Body& body, const Vec3& position, const Quat& orientation,
            std::initializer_list<float> values) {
  const auto base = static_cast<std::int32_t>(surface.point_count());
  const auto corners = static_cast<std::int32_t>(surface.connectivity.size());
  const Mat3 rotation = orientation.toRotationMatrix();
  for (const Vec3& point : body.points) {
    const Eigen::Vector3f p = (rotation * point + position).cast<float>();
    surface.points.insert(surface.points.end(), {p.x(), p.y(), p.z()});
  }
  for (std::int32_t i : body.connectivity) surface.connectivity.push_back(base + i);
  for (std::int32_t end : body.offsets) surface.offsets.push_back(corners + end);
  const float* value = values.begin();
  for (VtkSurface::Field& field : surface.fields) {
    for (std::size_t i = 0; i < body.points.size(); ++i)
      field.values.insert(field.values.end(), value, value + field.width);
    value += field.width;
  }
}

std::vector<Body> particle_bodies(const Model& model, bool contact_parts) {
  std::vector<Body> bodies;
  for (const Shape& shape : model.shapes) {
    Body body;
    if (contact_parts) body = body_of(shape.parts, shape.shape_from_body);
    // A sphere's only part is a point, which has no faces to draw.
    if (body.offsets.empty()) body = body_of(shape.mesh, shape.centroid);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

std::vector<Body> boundary_bodies(const Model& model, double reach) {
  std::vector<Body> bodies;
  for (const Boundary& b : model.boundaries)
    bodies.push_back(b.mesh.triangles.empty() ? square(reach) : body_of(b.mesh, Vec3::Zero()));
  return bodies;
}

VtkSurface particle_surface(const Frame& frame, const Model& model, const std::vector<Body>& bodies,
                            const std::vector<double>& peak_normal_force) {
  VtkSurface surface;
  surface.fields = {{"id", 1, {}},
                    {"tag", 1, {}},
                    {"velocity", 3, {}},
                    {"speed", 1, {}},
                    {"peak_normal_force", 1, {}}};
  for (std::size_t i = 0; i < frame.position.size(); ++i) {
    if (std::isnan(frame.position[i][0])) continue;
    const Particle& particle = model.particles[i];
    const auto& q = frame.orientation[i];
    const Eigen::Vector3f v = Vec3(frame.velocity[i].data()).cast<float>();
    append(surface, bodies[static_cast<std::size_t>(particle.shape)],
           Vec3(frame.position[i].data()), Quat(q[0], q[1], q[2], q[3]),
           {static_cast<float>(i), static_cast<float>(particle.tag), v.x(), v.y(), v.z(),
            static_cast<float>(Vec3(frame.velocity[i].data()).norm()),
            static_cast<float>(peak_normal_force[i])});
  }
  return surface;
}

VtkSurface boundary_surface(const Recording& recording, std::size_t frame, const Model& model,
                            const std::vector<Body>& bodies) {
  VtkSurface surface;
  surface.fields = {{"index", 1, {}}, {"force", 3, {}}, {"peak_normal_force", 1, {}}};
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BoundaryFrame state = recording.boundary(model.boundaries[b].name, frame);
    if (state.position.hasNaN()) continue;
    const Eigen::Vector3f force = state.force.cast<float>();
    append(surface, bodies[b], state.position, state.orientation,
           {static_cast<float>(b), force.x(), force.y(), force.z(),
            static_cast<float>(state.peak_normal_force)});
  }
  return surface;
}

VtkSurface bond_surface(const Case& c, const std::vector<BondOutcome>& outcomes, double time,
                        const Frame& frame) {
  VtkSurface surface;
  surface.fields = {{"bond", 1, {}}, {"a", 1, {}}, {"b", 1, {}}};
  for (const BondBox& bridge : intact_bonds_at(c, outcomes, time, frame)) {
    const Bond& bond = c.model.bonds[static_cast<std::size_t>(bridge.bond)];
    const int b = number_of_body(bond.b, c.model.particles.size());
    append(surface, body_of(box_mesh(bridge.size), Vec3::Zero()), bridge.position,
           bridge.orientation,
           {static_cast<float>(bridge.bond), static_cast<float>(bond.a), static_cast<float>(b)});
  }
  return surface;
}

void export_bonds_vtk(const Recording& recording, const Case& c, const std::string& directory,
                      std::size_t every) {
  const std::vector<BondOutcome> outcomes = bond_outcomes(recording);
  if (outcomes.empty()) return;
  const std::vector<double> times = recording.frame_times();
  VtkTimeSeries bonds(directory, "bonds");
  for (std::size_t i = 0; i < times.size(); i += every)
    bonds.add(times[i], i, bond_surface(c, outcomes, times[i], recording.frame(i)));
  bonds.save();
}

}  // namespace

void export_vtk(const Recording& recording, const std::string& directory,
                const VtkOptions& options) {
  if (options.every < 1) throw InputError("every: is below 1; expected each how many frames");
  const auto every = static_cast<std::size_t>(options.every);
  const Case c = read_case(recording);
  if (c.model.particles.size() != recording.particle_count())
    throw InputError(
        recording.file() +
        ": its case has another number of particles; expected as many as the file has");
  const std::vector<double> times = recording.frame_times();
  const std::vector<double> peaks = recording.peak_normal_force();
  const std::vector<Body> bodies = particle_bodies(c.model, options.contact_parts);
  const std::vector<Body> walls =
      boundary_bodies(c.model, drawn_plane_extent(recording, c.model, every));
  VtkTimeSeries particles(directory, "particles"), boundaries(directory, "boundaries");
  for (std::size_t i = 0; i < times.size(); i += every) {
    particles.add(times[i], i, particle_surface(recording.frame(i), c.model, bodies, peaks));
    boundaries.add(times[i], i, boundary_surface(recording, i, c.model, walls));
  }
  particles.save();
  boundaries.save();
  export_bonds_vtk(recording, c, directory, every);
  export_statistics_vtk(recording, directory);
}

}  // namespace firn
