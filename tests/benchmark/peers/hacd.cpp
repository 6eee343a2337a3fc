// Convex decompositions of the same solids by Firn and by HACD (Mamou and Ghorbel 2009, the
// predecessor of V-HACD): parts, deviation over the smallest edge, processor time. Built by hand:
//   g++ -std=c++20 -O2 -I. -I/usr/include/eigen3 -I/usr/include/bullet/HACD
//       tests/benchmark/peers/hacd.cpp FIRN_LIBRARIES -lHACD
// HACD cuts the surface, not the volume: its hulls may overlap and need not fill the solid. It is
// asked for fewer and fewer concavity until the deviation is below 2 % or 64 parts are reached.
#include <hacdHACD.h>

#include <cstdio>
#include <ctime>

#include "solver/shapes/shape_builder.h"
#include "validation/verification/fixtures/solids.h"

namespace firn {
namespace {

double seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Peer {
  std::size_t parts = 0;
  double deviation = 0, seconds = 0;  // over the smallest edge; of processor time
};

Peer by_hacd(const TriangleMesh& mesh, const Shape& reference, double concavity) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> triangles;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  const std::clock_t begun = std::clock();
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(1e-4);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(1);
  hacd.SetNVerticesPerCH(100);
  hacd.SetConcavity(concavity);
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(true);
  hacd.SetAddFacesPoints(true);
  hacd.Compute();
  Peer peer;
  peer.seconds = seconds_since(begun);
  hacd.DenormalizeData();
  Shape shape = reference;
  shape.parts.clear();
  shape.rounding = 0;
  for (std::size_t i = 0; i < hacd.GetNClusters(); ++i) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(i));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(i));
    hacd.GetCH(i, corners.data(), faces.data());
    std::vector<Vec3> hull;
    for (const auto& p : corners) hull.emplace_back(p.X(), p.Y(), p.Z());
    try {
      add_part(shape, convex_hull(hull));
    } catch (const InputError&) {  // a flat one
    }
  }
  peer.parts = shape.parts.size();
  peer.deviation =
      shape.parts.empty() ? 1e9 : measure_deviation(shape).largest() / shape.box.minCoeff();
  return peer;
}

void compare(const std::string& family) {
  const TriangleMesh mesh = verification::solid(family, 0);
  ShapeOptions options;
  options.density = 916.7;
  options.young_modulus = 1e7;
  const std::clock_t begun = std::clock();
  const Shape own = make_mesh(mesh, options);
  const double seconds = seconds_since(begun);
  Peer peer;
  double spent = 0;
  // HACD scales its points to a box of 1000.
  for (double concavity = 100; concavity > 1; concavity *= 0.5) {
    const Peer next = by_hacd(mesh, own, concavity);
    spent += next.seconds;
    if (next.parts > 64) break;
    if (peer.parts == 0 || next.deviation < peer.deviation) peer = next;
    if (peer.deviation < 0.02 || spent > 60) break;
  }
  std::printf("| %s | %zu | %zu | %.2f | %.1f | %zu | %.1f | %.1f |\n", family.c_str(),
              mesh.triangles.size(), own.parts.size(),
              100 * own.surface_deviation / own.box.minCoeff(), seconds, peer.parts,
              100 * peer.deviation, peer.seconds);
  std::fflush(stdout);
}

}  // namespace
}  // namespace firn

int main() {
  for (const std::string& family : firn::verification::solid_families()) firn::compare(family);
}
