// Programs of other licenses that work on meshes (tools/), in processes of their own.
#pragma once

#include <string>

namespace firn {

// Runs the program `name` of Firn's installation on a file that holds `input`, and returns its
// standard output. Limits: 120 s of processor time, 4 GiB of memory. Throws InputError with the
// program's last line when it refuses the mesh, RunError when the program is missing.
std::string run_mesh_program(const std::string& name, const std::string& input);

}  // namespace firn
