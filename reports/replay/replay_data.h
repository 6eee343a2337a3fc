// The data of a three-dimensional view on a page: facts as JSON and poses over time.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiments/case/case.h"
#include "reports/html/page.h"
#include "reports/replay/pose_tracks.h"

namespace firn::replay {

using Json = nlohmann::ordered_json;

// What reports/assets/replay_data.js reads. `tracks` holds the particles, then the boundaries.
struct Data {
  Json facts;
  PoseTracks tracks;
};

// Integer millionths (um, us). null for a value that is not finite.
Json micro(double value);
Json micro(const std::vector<double>& values);

// A mesh with its vertices relative to `origin` (m), in um.
Json mesh_json(const std::string& name, const TriangleMesh& mesh, const Vec3& origin);
// The shapes of a case, simplified for `particles` bodies.
Json shapes_json(const Case& c, std::size_t particles);
// The convex parts of a shape that contact uses, without their rounding, axes of the shape about
// the center of mass.
Json parts_json(const Shape& shape);
// A plane, z = 0 of its axes, as the rectangle over which the box (m, world) stands, a little
// wider: no plane makes the scene larger.
TriangleMesh plane_rectangle(const Boundary& plane, const Eigen::AlignedBox3d& box);
// The box that the camera shows at first, m, world. It contains the boundaries with a mesh in the
// first frame, and the places of the particles, which come first in the tracks, but for a tenth at
// either end of each axis: not all the way that some of them fall. It contains the regions of fills
// and inlets if `with_regions`, or if no particle is there. Never empty. `tracks` has a frame.
Eigen::AlignedBox3d scene_extent(const Case& c, const PoseTracks& tracks,
                                 bool with_regions = false);
Json box_json(const Eigen::AlignedBox3d& box);  // m
// Regions, planes and axes of a case: fills, inlets, sensors, outlets, tag rules, measurement
// regions, and the axes of motions and free bodies. Lengths in m, world at t = 0.
Json markers_json(const Case& c);

// The length of the JSON text (4 bytes, little endian), the text, the packed poses;
// zlib_compressed, in base64.
std::string data_text(Json facts, const PoseTracks& tracks);

// The view and its scripts on a page. `anchor`: letters, digits and hyphens, unique on the page.
void place_view(page::Page& page, page::Content& content, const std::string& anchor,
                const std::string& title, const std::string& data);

// Triangles of all boundaries together, for machines without a graphics processor.
inline constexpr std::size_t kBoundaryTriangles = 24'000;

}  // namespace firn::replay
