#include "experiments/system/gnuplot.h"

#include <fmt/core.h>
#include <stdlib.h>

#include <fstream>

#include "experiments/system/input_file.h"
#include "experiments/system/output_file.h"
#include "experiments/system/process.h"
#include "firn/math.h"

namespace firn {
namespace {

std::string extension_of(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

// Whether the end of a picture is there.
bool is_whole_picture(const std::string& bytes, const std::string& extension) {
  const std::string end = extension == ".png" ? std::string("IEND\xae\x42\x60\x82") : "</svg>";
  return bytes.rfind(end) != bytes.npos && bytes.size() - bytes.rfind(end) <= end.size() + 2;
}

}  // namespace

std::string Gnuplot::image(const std::string& name, int width, int height,
                           std::span<const std::array<std::uint8_t, 3>> pixels) const {
  const std::filesystem::path file = data_file(name);
  write_file(file.string(), {reinterpret_cast<const char*>(pixels.data()), pixels.size_bytes()},
             OutputFile::When::unsynced);
  return fmt::format("'{}' binary array=({},{}) format='%uchar%uchar%uchar'", name, width, height);
}

void Gnuplot::run(const std::string& script) const {
  const std::filesystem::path file = data_file("script.gp");
  write_file(file.string(), script, OutputFile::When::unsynced);
  const CommandResult r = run_repeatable_command({"gnuplot", "--default-settings", "script.gp"},
                                                 folder_.path().string());
  if (r.status == 127) {
    throw InputError(
        "pictures need the program gnuplot, which is not installed; expected it on "
        "the PATH (Debian: gnuplot-nox)");
  }
  if (r.status != 0) throw RunError("gnuplot: " + failure_text(r));
}

void Gnuplot::draw(const std::string& script, const std::string& file, int width,
                   int height) const {
  check_picture(file);
  const bool png = extension_of(file) == ".png";
  const std::string picture = png ? "picture.png" : "picture.svg";
  run(fmt::format(
          "set encoding utf8\nset terminal {} size {},{} font 'DejaVu Sans,13' rounded noenhanced "
          "{}\nset output '{}'\n",
          png ? "pngcairo" : "svg", width, height, png ? "" : "background 'white'", picture) +
      script + "\nset output\n");
  save(picture, file);
}

std::string Gnuplot::picture(const std::string& name) const {
  std::string picture = read_own_file(data_file(name));
  // gnuplot ends well also when a disk was full.
  if (!is_whole_picture(picture, extension_of(name)))
    throw WriteError(data_file(name).string(), "gnuplot left no whole picture");
  return picture;
}

void Gnuplot::save(const std::string& name, const std::filesystem::path& file) const {
  write_file(file.string(), picture(name));
}

void Gnuplot::check_picture(const std::string& file) {
  const std::string extension = extension_of(file);
  if (extension != ".png" && extension != ".svg")
    throw InputError(fmt::format("{}: no format of pictures; expected FILE.png or FILE.svg", file));
}

}  // namespace firn
