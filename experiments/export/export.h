// Results for other programs: ParaView, spreadsheets, Blender.
#pragma once

#include <string>

#include "experiments/results/results_file.h"

namespace firn {

struct VtkOptions {
  int every = 1;  // each how many frames
  bool contact_parts =
      false;  // the convex parts (their cores, without the sweep radius) for the mesh
};

// Writes particles.pvd and boundaries.pvd, each an index over one VTK XML file (.vtp, binary) a
// frame in the sub-folder of the same name. Surfaces in world axes, m; point data:
//   particles:  id, tag, velocity (m/s, of the centre of mass), speed (m/s), peak_normal_force (N,
//               over the whole run)
//   boundaries: index (order of the case), force (N), peak_normal_force (N), both of the interval
// A plane is drawn as a square about what the particles reach.
// Throws InputError when the directory cannot be written.
void export_vtk(const Recording& recording, const std::string& directory,
                const VtkOptions& options = {});

// Writes one binary glTF 2.0 file (.glb) with an animation of all `every`-th frames, for Blender,
// presentations and web pages: a node for each particle and boundary, in m, z turned to glTF's
// vertical axis y. Between frames, positions are interpolated linearly and orientations on the
// shorter arc. Particles have a color for each tag; boundaries are translucent. A body that does
// not exist has scale 0. Bonds are not drawn. Throws InputError for a recording without frames, for
// a file that would exceed 4 GiB, and when the file cannot be written.
void export_gltf(const Recording& recording, const std::string& file, int every = 1);

// Writes frames.csv (one row a frame and present particle), particles.csv, series.csv (one row a
// frame) and responses.csv (one row a value). Headers name the units; numbers read back exactly.
// Throws InputError when the directory cannot be written.
void export_csv(const Recording& recording, const std::string& directory);

// The same for what the case keeps of its contacts (docs/statistics.md); nothing where it asks for
// none. Both are part of the two above.
// boundary_loads.pvd: the triangles of the watched boundaries at the end of each interval, in world
// axes; surface_SHAPE.vtp: each shape as drawn. Values on the triangles, in SI.
void export_statistics_vtk(const Recording& recording, const std::string& directory);
// contacts.csv, compressive_loads.csv, boundary_maps.csv, particle_maps.csv, energy_spectrum.csv.
void export_statistics_csv(const Recording& recording, const std::string& directory);

}  // namespace firn
