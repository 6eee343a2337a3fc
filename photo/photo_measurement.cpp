// The measurement file of photographs.
#include <fmt/core.h>

#include <filesystem>

#include "experiments/storage/version.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "photo/heap_photo.h"

namespace firn {
namespace {

// A string of TOML on one line; what a terminal would not print is shown as it would be there.
std::string toml_line(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : encode::terminal(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string in_degrees(double angle) { return fmt::format("{:.4f} deg", angle); }

std::string file_name_of(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

std::string source_text(const HeapPhotoResult& result) {
  std::string text = result.setup.source.empty() ? "" : result.setup.source + "; ";
  for (const PhotoAngle& heap : result.heaps)
    text += fmt::format("photograph {} (SHA-256 {}), ", file_name_of(heap.file), heap.hash);
  return text + fmt::format("setup {} (SHA-256 {}), measured by firn {} ({})",
                            file_name_of(result.setup.file), result.setup.hash, firn_version(),
                            firn_git_commit());
}

std::string notes_text(const HeapPhotoResult& result) {
  std::string text = result.setup.notes.empty() ? "" : result.setup.notes + " ";
  for (const PhotoAngle& heap : result.heaps) {
    text += file_name_of(heap.file) + ":";
    for (const PhotoSlope& slope : heap.slopes) {
      text += fmt::format(" {} {} deg,", slope.ledge.name,
                          measured_text(slope.lines.robust_angle, slope.lines.robust_uncertainty));
    }
    text.back() = '.';
    text += ' ';
  }
  return text + "The uncertainty of each slope is that of the roughness of its outline.";
}

}  // namespace

std::string measurement_text(const HeapPhotoResult& result) {
  const PhotoSetup& setup = result.setup;
  std::string text = "# Written by `firn measure --photo`. Format: docs/measurements.md.\n";
  const auto line = [&](const char* key, const std::string& value) {
    if (!value.empty()) text += fmt::format("{} = {}\n", key, toml_line(value));
  };
  const bool single = result.heaps.size() == 1;
  line("name", setup.name);
  line("response", setup.response);
  if (single) {
    text += fmt::format("value = \"{}\"\nrepeats = 1\n", in_degrees(result.angle));
  } else {
    text += "values = [";
    for (std::size_t k = 0; k < result.heaps.size(); ++k)
      text += fmt::format("{}\"{}\"", k == 0 ? "" : ", ", in_degrees(result.heaps[k].angle));
    text += "]\n";
  }
  line("status", "measured");
  line("source", source_text(result));
  line("experiment", setup.experiment);
  line("apparatus", setup.apparatus);
  line("notes", notes_text(result));
  if (single) {
    text += fmt::format("\n[scatter]\nkind = \"not stated\"\nassumed_standard_deviation = \"{}\"\n",
                        in_degrees(result.scatter()));
    line("assumption",
         "what the roughness of the outline of this one heap leaves open; another heap of the same "
         "ice may differ by more, which several photographs would show");
  }
  if (result.systematic > 0) {
    text += fmt::format("\n[systematic]\nuncertainty = \"{}\"\n", in_degrees(result.systematic));
    line("rationale",
         fmt::format("sum of squares of {:.2g} deg (corners read to {:.3g} pixels and known to "
                     "{:.3g} mm, distortion k1 to {:.3g}, level to {:.2g} deg) and {:.2g} deg "
                     "(threshold of ice and background to {:.2g} of their contrast)",
                     result.camera_uncertainty, setup.pixel_uncertainty,
                     1e3 * setup.position_uncertainty, setup.k1_uncertainty,
                     setup.level_uncertainty * kRadToDeg, result.threshold_uncertainty,
                     setup.threshold_uncertainty));
  }
  return text;
}

}  // namespace firn
