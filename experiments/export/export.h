// Export of results to ParaView, spreadsheets and Blender.
#pragma once

#include <string>

#include "experiments/results/results_file.h"

namespace firn {

struct VtkOptions {
  int every = 1;  // interval of exported frames
  // Export the convex parts (core polyhedra without rounding) in place of the meshes.
  bool contact_parts = false;
};

// Writes particles.pvd and boundaries.pvd: indexes of one VTK XML file (.vtp, binary) per frame in
// the folder of the same name. Surfaces in world axes, m; point data:
//   particles:  id, tag, velocity (m/s, of the center of mass), speed (m/s), peak_normal_force (N,
//   of the
//               whole run)
//   boundaries: index (order of the case), force (N), peak_normal_force (N), both of the interval
// A plane is a square of the half-width drawn_plane_extent(). Throws as OutputFile.
void export_vtk(const Recording& recording, const std::string& directory,
                const VtkOptions& options = {});

// Writes a binary glTF 2.0 file (.glb) with an animation of every `every`-th frame, for Blender,
// presentations and web pages: one node per particle and boundary, in m, with the vertical axis y
// of glTF as z. Positions are interpolated linearly between frames, orientations along the shorter
// arc. The color of a particle depends on its tag; boundaries are translucent. A body that does not
// exist has scale 0. Bonds are not exported. Throws InputError for a recording without frames and
// for a file above 4 GiB, and as OutputFile.
void export_gltf(const Recording& recording, const std::string& file, int every = 1);

// Writes frames.csv (one row per frame and particle), particles.csv, series.csv (one row per frame)
// and responses.csv (one row per value). Headers have the units. Numbers read back to the same
// bits. Throws as OutputFile.
void export_csv(const Recording& recording, const std::string& directory);

// The same for contact statistics (docs/statistics.md); nothing for a case without them.
// export_vtk() and export_csv() include these. boundary_loads.pvd: triangles of the boundaries with
// statistics at the end of each interval, in world axes. surface_SHAPE.vtp: each shape in its axes.
// Values on the triangles in SI.
void export_statistics_vtk(const Recording& recording, const std::string& directory);
// contacts.csv, compressive_loads.csv, boundary_maps.csv, particle_maps.csv, energy_spectrum.csv.
void export_statistics_csv(const Recording& recording, const std::string& directory);

}  // namespace firn
