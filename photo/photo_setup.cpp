#include "photo/photo_setup.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"

namespace firn {
namespace {

constexpr std::size_t kMostCorners = 100, kMostSlopes = 20;

Vec2 pixel_pair(const TomlTable& t, std::string_view key) {
  const std::array<double, 2> p = t.pair(key);
  constexpr double kMost = 1e6;
  for (const double v : p)
    if (!(std::abs(v) <= kMost)) t.fail(key, "is too large; expected pixels of the picture");
  return {p[0], p[1]};
}

double number_from(const TomlTable& t, std::string_view key, double least, double most,
                   double fallback) {
  const double value = t.number(key, fallback);
  if (!(value >= least && value <= most))
    t.fail(key, fmt::format("is {}; expected {} to {}", value, least, most));
  return value;
}

std::vector<WallPoint> read_corners(const TomlTable& root) {
  std::vector<WallPoint> corners;
  const std::vector<TomlTable> tables = root.tables("corners");
  if (tables.size() < 4) {
    root.fail("corners", fmt::format("has {} entries; expected at least four corners of the wall, "
                                     "each {{ pixel = [column, row], x = \"...\", z = \"...\" }}",
                                     tables.size()));
  }
  if (tables.size() > kMostCorners)
    root.fail("corners",
              fmt::format("has {} entries; expected at most {}", tables.size(), kMostCorners));
  for (const TomlTable& t : tables) {
    t.allow({"pixel", "x", "z"});
    corners.push_back({pixel_pair(t, "pixel"),
                       {t.quantity("x", dimension::length, Sign::any),
                        t.quantity("z", dimension::length, Sign::any)}});
  }
  return corners;
}

// Ice at the back wall appears nearer to the middle of the box than it is, by what grows with the
// distance from there; beyond the last of it the outline ends. The window must end before.
void check_perspective(const TomlTable& t, const PhotoLedge& ledge, double middle,
                       const PhotoSetup& setup) {
  constexpr double kOfMargin = 0.8;  // at most this part of the margin is missing
  const bool end_is_far = std::abs(ledge.end - middle) > std::abs(ledge.begin - middle);
  const double farthest = std::abs((end_is_far ? ledge.end : ledge.begin) - middle);
  const double margin =
      kOfMargin * (end_is_far ? ledge.length() - ledge.window.to : ledge.window.from);
  const double shift = farthest * setup.depth / (setup.camera_distance + setup.depth);
  if (shift <= margin) return;
  t.fail(end_is_far ? "end_margin" : "begin_margin",
         fmt::format("is too small: from {:.4g} m, ice at the back wall appears {:.3g} m nearer to "
                     "the middle; expected a margin of at least {:.3g} m, or a camera farther away",
                     setup.camera_distance, shift, shift / kOfMargin));
}

std::vector<PhotoLedge> read_ledges(const TomlTable& root, const PhotoSetup& setup) {
  const double particle_size = setup.particle_size;
  double middle = 0;
  for (const WallPoint& c : setup.corners)
    middle += c.wall.x() / static_cast<double>(setup.corners.size());
  const std::vector<TomlTable> tables = root.tables("slopes");
  if (tables.empty()) root.fail("slopes", "is missing; expected tables [[slopes]]");
  if (tables.size() > kMostSlopes)
    root.fail("slopes",
              fmt::format("holds {} tables; expected at most {}", tables.size(), kMostSlopes));
  std::vector<PhotoLedge> ledges;
  std::set<std::string> names;
  for (const TomlTable& t : tables) {
    t.allow({"name", "begin", "end", "begin_margin", "end_margin"});
    PhotoLedge ledge;
    ledge.name = t.string("name");
    if (ledge.name.empty()) t.fail("name", "is empty; expected a word");
    if (!names.insert(ledge.name).second)
      t.fail("name", "is that of another slope; expected its own");
    ledge.begin = t.quantity("begin", dimension::length, Sign::any);
    ledge.end = t.quantity("end", dimension::length, Sign::any);
    const double begin_margin =
        t.quantity("begin_margin", dimension::length, Sign::non_negative, "25 mm");
    const double end_margin =
        t.quantity("end_margin", dimension::length, Sign::non_negative, "25 mm");
    ledge.window = t.at("end", [&] {
      return fit_window(ledge.length(), begin_margin, end_margin, particle_size,
                        fmt::format("margins of {:.4g} m at the begin and {:.4g} m at the end",
                                    begin_margin, end_margin));
    });
    constexpr double kMostParticles = 1000;
    if (ledge.length() > kMostParticles * particle_size)
      t.fail("end",
             fmt::format("makes a slope of more than {} particle sizes; expected a shorter one",
                         kMostParticles));
    check_perspective(t, ledge, middle, setup);
    ledges.push_back(ledge);
  }
  return ledges;
}

void read_camera(const TomlTable& t, PhotoSetup& setup) {
  t.allow({"focal_length", "principal_point", "k1", "k2", "k1_uncertainty"});
  constexpr double kMostPixels = 1e6;
  if (t.has("focal_length")) setup.focal_length = number_from(t, "focal_length", 1, kMostPixels, 0);
  if (t.has("principal_point")) setup.principal_point = pixel_pair(t, "principal_point");
  for (const char* key : {"k1", "k2"}) {
    if (t.has(key) && !setup.focal_length)
      t.fail(key, "goes with a focal length; expected the key `focal_length`, in pixels");
  }
  setup.k1 = number_from(t, "k1", -1, 1, 0);
  setup.k2 = number_from(t, "k2", -1, 1, 0);
  setup.k1_uncertainty = number_from(t, "k1_uncertainty", 0, 0.2, 0.01);
}

void read_segmentation(const TomlTable& t, const std::string& directory, PhotoSetup& setup) {
  t.allow({"channel", "heap", "background", "threshold_uncertainty"});
  const std::string channel =
      t.choice("channel", {"luminance", "red", "green", "blue", "saturation"}, "luminance");
  setup.channel = channel == "red"          ? PhotoChannel::red
                  : channel == "green"      ? PhotoChannel::green
                  : channel == "blue"       ? PhotoChannel::blue
                  : channel == "saturation" ? PhotoChannel::saturation
                                            : PhotoChannel::luminance;
  setup.heap_is_brighter = t.choice("heap", {"brighter", "darker"}, "brighter") == "brighter";
  const std::string background = t.string("background", "");
  if (!background.empty())
    setup.background = (std::filesystem::path(directory) / background).string();
  setup.threshold_uncertainty = number_from(t, "threshold_uncertainty", 0, 0.4, 0.1);
}

}  // namespace

Lens PhotoSetup::lens(int width, int picture_height) const {
  Lens lens;
  const Vec2 size(width, picture_height);
  lens.principal_point = principal_point.value_or(size / 2);
  lens.focal_length = focal_length.value_or(width);
  lens.k1 = k1;
  lens.k2 = k2;
  double farthest = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const Vec2 at(corner & 1 ? width : 0, corner & 2 ? picture_height : 0);
    farthest = std::max(farthest, (at - lens.principal_point).norm());
  }
  if (!lens.invertible_to(farthest)) {
    throw InputError(
        fmt::format("{}: camera: k1 = {} and k2 = {} fold the picture at its edges; expected those "
                    "of a calibration with this focal length",
                    file, k1, k2));
  }
  return lens;
}

PhotoSetup read_photo_setup_text(const std::string& text, const std::string& source) {
  TomlDocument document(text, source);
  const TomlTable t = TomlTable::root(document);
  t.allow({"name", "response", "experiment", "source", "apparatus", "notes", "particle_size",
           "height", "depth", "camera_distance", "corners", "pixel_uncertainty",
           "position_uncertainty", "level_uncertainty", "camera", "segmentation", "slopes"});
  PhotoSetup setup;
  setup.file = source;
  setup.hash = sha256(text);
  setup.name = t.string("name");
  if (setup.name.empty()) t.fail("name", "is empty; expected what was measured, in words");
  setup.response = t.string("response", "angle_of_repose_outline");
  setup.experiment = t.string("experiment", "");
  setup.source = t.string("source", "");
  setup.apparatus = t.string("apparatus", "");
  setup.notes = t.string("notes", "");
  setup.particle_size = t.quantity("particle_size", dimension::length, Sign::positive);
  setup.height = t.quantity("height", dimension::length, Sign::positive);
  constexpr double kMostParticles = 1000;
  if (setup.height > kMostParticles * setup.particle_size)
    t.fail("height", fmt::format("is more than {} particle sizes; expected less", kMostParticles));
  setup.depth = t.quantity("depth", dimension::length, Sign::non_negative);
  setup.camera_distance = t.quantity("camera_distance", dimension::length, Sign::positive);
  setup.corners = read_corners(t);
  setup.pixel_uncertainty = number_from(t, "pixel_uncertainty", 0, 1000, 2);
  setup.position_uncertainty =
      t.quantity("position_uncertainty", dimension::length, Sign::non_negative, "0.5 mm");
  setup.level_uncertainty =
      t.quantity("level_uncertainty", dimension::angle, Sign::non_negative, "0.3 deg");
  read_camera(t.table("camera"), setup);
  read_segmentation(t.table("segmentation"), std::filesystem::path(source).parent_path().string(),
                    setup);
  setup.ledges = read_ledges(t, setup);
  // Their order does not depend on the lens: it is checked here, where the line is known.
  t.at("corners", [&] { WallCamera(Lens{}, setup.corners); });
  return setup;
}

PhotoSetup read_photo_setup(const std::string& file) {
  return read_photo_setup_text(
      read_input_file(file, "the setup of a photograph", input_limits::toml_bytes), file);
}

}  // namespace firn
