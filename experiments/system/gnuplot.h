// Pictures through the program gnuplot: the only place that starts it.
//
// gnuplot starts without a shell and without the user's start-up files. It runs in a temporary
// folder and draws into that folder, so that a script holds no path. Text of the user stands in a
// script only as encode::gnuplot() returns it.
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
  // Path of a file that scripts name NAME: letters, digits, `-`, `_` and `.` only.
  std::filesystem::path data_file(const std::string& name) const { return folder_.path() / name; }

  // Writes pixels (8 bits a channel, rows from the bottom up) as the data file NAME. Returns the
  // source of a plot command "with rgbimage". Throws as write_file().
  std::string image(const std::string& name, int width, int height,
                    std::span<const std::array<std::uint8_t, 3>> pixels) const;

  // Runs a script in the folder. Throws InputError when gnuplot is not installed, RunError with
  // the last line of its messages when it fails.
  void run(const std::string& script) const;
  // Draws a script into FILE.png or FILE.svg; size in pixels. Throws as run(),
  // check_picture() and save().
  void draw(const std::string& script, const std::string& file, int width, int height) const;
  // The bytes of the picture NAME, .png or .svg, that a script drew. Throws WriteError when gnuplot
  // did not write it whole.
  std::string picture(const std::string& name) const;
  // Copies the picture NAME to FILE. Throws as picture() and write_file().
  void save(const std::string& name, const std::filesystem::path& file) const;

  // Throws InputError for a name with another extension than .png or .svg.
  static void check_picture(const std::string& file);

 private:
  TemporaryFolder folder_{"gnuplot"};
};

}  // namespace firn
