#include "validation/verification/shots.h"

#include <algorithm>
#include <cmath>

#include "experiments/boundary_mesh.h"

namespace firn::verification {

TriangleMesh grid(double size, int cells) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      mesh.vertices.push_back(
          {size * (double(i) / cells - 0.5), size * (double(j) / cells - 0.5), 0});
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({a, d, c});
      }
    }
  }
  return mesh;
}

Boundary sheet(const Sheet& s) {
  Boundary b;
  b.name = "sheet";
  b.material = scenes::kPlastic;
  b.rigid = true;
  if (s.kind == Sheet::Kind::plane) return b;
  b.kind = Boundary::Kind::solid;
  if (s.kind == Sheet::Kind::box) {
    b.parts = {convex_part(box_half_spaces({s.size, s.size, s.thickness}), 0)};
    b.origin = Vec3(0, 0, -s.thickness / 2);
  } else {
    b.parts = boundary_parts(grid(s.size, s.cells), s.thickness);
  }
  return b;
}

double lowest_point(const Shape& shape, const Quat& turn) {
  double lowest = 0;
  for (const ConvexPart& part : shape.parts) {
    for (int i = 0; i < part.vertex_count; ++i) {
      const Vec3 v = turn * (shape.shape_from_body * part.vertex(i));
      lowest = std::min(lowest, v.z() - part.radius);
    }
  }
  return lowest;
}

Outcome fire(const Shape& shape, const Sheet& wall, const Shot& shot) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.1, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  model.boundaries.push_back(sheet(wall));
  model.gravity.setZero();
  model.timestep = advise_timestep(model, shot.steps).timestep;
  Solver solver(model);
  const Vec3 way(std::sin(shot.angle), 0, -std::cos(shot.angle));
  const double far = shape.bounding_radius + 1e-3;
  solver.insert(0, shot.target - far / std::cos(shot.angle) * way, shot.turn, shot.speed * way,
                shot.spin);
  const double before = solver.energy().kinetic;
  const double time = 10 * far / shot.speed + 1000 * model.timestep;
  Outcome out;
  Vec3 place;
  try {
    do {
      solver.step();
      place = solver.particles().position[0];
    } while (solver.time() < time && place.z() > -far - wall.thickness &&
             !(place.z() > far && solver.particles().velocity[0].z() > 0));
  } catch (const RunError& e) {
    out.end = End::failed;
    out.message = e.what();
    return out;
  }
  const double half = wall.size / 2;
  const bool inside = std::abs(place.x()) < half && std::abs(place.y()) < half;
  const bool below = place.z() < 0 && (inside || wall.kind == Sheet::Kind::plane);
  out.end = below ? End::through : End::held;
  out.energy = solver.energy().kinetic / before;
  return out;
}

void Tally::add(const Outcome& o) {
  ++shots;
  held += o.end == End::held;
  failed += o.end == End::failed;
  through += o.end == End::through;
  if (o.end == End::held) energy = std::max(energy, o.energy);
}

}  // namespace firn::verification
