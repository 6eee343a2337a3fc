// Figures drawn by the program gnuplot. No other source starts it.
//
// gnuplot starts without a shell and without the user's start-up files. It runs in a temporary
// folder and writes its figures there; scripts contain no paths. Scripts contain text of the user
// only in the form that encode::gnuplot() returns.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "experiments/system/temporary_folder.h"

namespace firn {

// A temporary folder with data files for scripts. The destructor removes it.
class Gnuplot {
 public:
  // Path of the data file with this name in scripts. `name`: letters, digits, `-`, `_` and `.`
  // only.
  std::filesystem::path data_file(const std::string& name) const { return folder_.path() / name; }

  // Writes pixels (8 bits per channel, rows from the bottom up) as a data file. Returns the source
  // of a plot command "with rgbimage". Throws as write_file().
  std::string image(const std::string& name, int width, int height,
                    std::span<const std::array<std::uint8_t, 3>> pixels) const;

  // Runs a script in the folder. Throws InputError when gnuplot is not installed, and RunError with
  // the last line of its output when it fails.
  void run(const std::string& script) const;
  // Runs a script that draws `file` (.png or .svg); size in pixels. Throws as run(),
  // check_picture() and save().
  void draw(const std::string& script, const std::string& file, int width, int height) const;
  // The bytes of a figure (.png or .svg) that a script drew. Throws WriteError for an incomplete
  // file.
  std::string picture(const std::string& name) const;
  // Copies a figure to `file`. Throws as picture() and write_file().
  void save(const std::string& name, const std::filesystem::path& file) const;

  // Throws InputError unless the extension is .png or .svg.
  static void check_picture(const std::string& file);

 private:
  TemporaryFolder folder_{"gnuplot"};
};

}  // namespace firn
