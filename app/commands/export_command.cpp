// firn export: a results file for ParaView, spreadsheets and Blender, and as a picture.
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/support/exit_status.h"
#include "app/support/known_words.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/export/export.h"
#include "experiments/system/terminal.h"
#include "experiments/text/units.h"
#include "reports/rendering/film.h"
#include "reports/rendering/heap_picture.h"
#include "reports/rendering/scene_picture.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  std::string file;
  std::string format;
  std::string folder;
  std::string time;
  VtkOptions vtk;
  double speed = 1;
};

double instant(const std::string& text) {
  try {
    return parse_quantity(text, dimension::time);
  } catch (const InputError& e) {
    throw InputError(fmt::format("--time: {}", e.what()));
  }
}

int export_picture(const Recording& recording, const ExportArguments& a) {
  const std::size_t frames = recording.frame_times().size();
  if (frames == 0)
    throw InputError(a.file + ": holds no frame to draw; expected a run that has begun");
  const std::string file =
      a.folder.empty() ? fs::path(a.file).replace_extension(".png").string() : a.folder;
  std::size_t frame = frames - 1;
  if (!a.time.empty()) {
    const double time = instant(a.time);
    const std::vector<double> times = recording.frame_times();
    frame = static_cast<std::size_t>(
        std::ranges::min_element(times, {}, [&](double t) { return std::abs(t - time); }) -
        times.begin());
  }
  if (read_case(recording).drained_repose)
    draw_heap(recording, frame, file);
  else
    draw_scene(recording, frame, file);
  print_lines(stderr, "drawn in {}\n", file);
  return ExitStatus::done;
}

int export_film(const Recording& recording, const ExportArguments& a) {
  const std::string file =
      a.folder.empty() ? fs::path(a.file).replace_extension(".mp4").string() : a.folder;
  FilmOptions options;
  options.speed = a.speed;
  const bool terminal = isatty(STDERR_FILENO) == 1;
  std::size_t tenth = 0;
  options.progress = [&](std::size_t done, std::size_t of) {
    if (terminal) {
      print(stderr, fmt::format("\r{} of {} pictures{}", done, of, done == of ? "\n" : ""));
    } else if (10 * done / of > tenth) {
      tenth = 10 * done / of;
      print_lines(stderr, "{} of {} pictures\n", done, of);
    }
  };
  write_film(recording, file, options);
  print_lines(stderr, "exported to {}\n", file);
  return ExitStatus::done;
}

int export_file(const ExportArguments& a) {
  const Recording recording(a.file);
  if (a.format == "png") return export_picture(recording, a);
  if (a.format == "gltf") {
    const std::string file =
        a.folder.empty() ? fs::path(a.file).replace_extension(".glb").string() : a.folder;
    export_gltf(recording, file, a.vtk.every);
    print_lines(stderr, "exported to {}\n", file);
    return ExitStatus::done;
  }
  if (a.format == "mp4") return export_film(recording, a);
  const std::string folder =
      a.folder.empty() ? fs::path(a.file).replace_extension().string() + "-" + a.format : a.folder;
  if (a.format == "csv") {
    export_csv(recording, folder);
  } else {
    export_vtk(recording, folder, a.vtk);
  }
  print_lines(stderr, "exported to {}\n", folder);
  return ExitStatus::done;
}

}  // namespace

void add_export_command(CLI::App& app, int& status) {
  auto a = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand(
      "export", "Write a results file for ParaView, spreadsheets or Blender, or as a picture");
  command->add_option("RUN.h5", a->file, "Results file of `firn run`")->required()->type_name("");
  command
      ->add_option("--to", a->format,
                   "vtk: particles.pvd and boundaries.pvd, the moving meshes, for ParaView;\n"
                   "csv: particles, frames, series and responses as tables; both also the\n"
                   "statistics of contacts that the case keeps;\n"
                   "gltf: one file (.glb) with the animated scene, for Blender, slides\n"
                   "and web pages;\n"
                   "mp4: a film from a fixed viewpoint, drawn by ffmpeg;\n"
                   "png: a picture of the drained heap, or of the whole scene, bodies\n"
                   "colored by their tags")
      ->check(one_of({"vtk", "csv", "gltf", "mp4", "png"}))
      ->required();
  command
      ->add_option("-o,--output", a->folder,
                   "Folder for the files, made if need be; by default the\nresults file's name "
                   "with -vtk or -csv. gltf, mp4, png: the file")
      ->type_name("PATH");
  command
      ->add_option(
          "--time", a->time,
          "png: the frame nearest to this time, e.g. \"2.5 s\"; by default\nthe last frame")
      ->type_name("TIME");
  command->add_option("--every", a->vtk.every, "vtk, gltf: write only every Nth frame")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--speed", a->speed,
                   "mp4: simulated seconds for each second of the film; 0.1 is ten\ntimes slower "
                   "than real time")
      ->type_name("NUMBER")
      ->capture_default_str();
  command->add_flag(
      "--contact-shapes", a->vtk.contact_parts,
      "vtk: instead of the meshes, the convex parts that touch,\nwithout their rounding");
  command->callback([a, &status] { status = export_file(*a); });
}

}  // namespace firn
