// firn export: a results file for ParaView and for spreadsheets.
#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/exit_status.h"
#include "experiments/export.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string file;
  std::string format;
  std::string folder;
  VtkOptions vtk;
};

int export_file(const Arguments& a) {
  const Recording recording(a.file);
  const std::string folder =
      a.folder.empty() ? fs::path(a.file).replace_extension().string() + "-" + a.format : a.folder;
  if (a.format == "csv") {
    export_csv(recording, folder);
  } else {
    export_vtk(recording, folder, a.vtk);
  }
  fmt::print(stderr, "exported to {}\n", folder);
  return ExitStatus::done;
}

}  // namespace

void add_export_command(CLI::App& app, int& status) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("export", "Write a results file for ParaView or for spreadsheets");
  command->add_option("RUN.h5", a->file, "Results file of `firn run`")->required()->type_name("");
  command
      ->add_option("--to", a->format,
                   "vtk: particles.pvd and boundaries.pvd, the moving meshes, for ParaView;\n"
                   "csv: particles, frames, series and responses as tables")
      ->check(CLI::IsMember({"vtk", "csv"}))
      ->required();
  command
      ->add_option("-o,--output", a->folder,
                   "Folder for the files, made if need be; by default the\nresults file's name "
                   "with -vtk or -csv")
      ->type_name("DIR");
  command->add_option("--every", a->vtk.every, "vtk: only every Nth frame")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag(
      "--parts", a->vtk.contact_parts,
      "vtk: instead of the meshes, the convex parts that touch,\nwithout their rounding");
  command->callback([a, &status] { status = export_file(*a); });
}

}  // namespace firn
