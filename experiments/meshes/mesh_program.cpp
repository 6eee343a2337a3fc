#include "experiments/meshes/mesh_program.h"

#include <fmt/format.h>

#include <filesystem>

#include "experiments/system/output_file.h"
#include "experiments/system/process.h"
#include "experiments/system/temporary_folder.h"
#include "firn/math.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Of the build folder, or of the installation.
std::string path_of(const std::string& name) {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& place :
       {folder, folder / "../libexec/firn", folder / "..", folder / "../.."}) {
    const fs::path program = place / name;
    if (fs::exists(program, error)) return program.string();
  }
  throw RunError(fmt::format("{} is missing; expected it where firn is installed", name));
}

}  // namespace

std::string run_mesh_program(const std::string& name, const std::string& input) {
  const TemporaryFolder folder("mesh");
  const std::string file = folder.file("facets");
  write_file(file, input);
  ProcessLimits limits;
  limits.processor_time = 120;
  limits.address_space = std::size_t{4} << 30;
  const CommandResult result = run_repeatable_command({path_of(name), file}, {}, limits);
  if (ended_from_outside(result)) throw RunError(name + ": " + failure_text(result));
  if (result.status == 1) throw InputError(last_line(result.err));
  if (result.status != 0) throw InputError(fmt::format("{} fails on this mesh", name));
  return result.out;
}

}  // namespace firn
