#include "experiments/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "experiments/checkpoint.h"
#include "experiments/hdf5_file.h"

namespace firn {
namespace {

hdf5::File open_results(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file + ": no such file");
  if (std::filesystem::is_directory(file, error))
    throw InputError(file + ": is a directory; expected a results file (HDF5)");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file + ": cannot be read; check its permissions");
  char signature[8] = {};
  stream.read(signature, sizeof(signature));
  if (stream.gcount() != sizeof(signature) ||
      std::string_view(signature, sizeof(signature)) != std::string_view("\x89HDF\r\n\x1a\n", 8))
    throw InputError(file + ": not a results file; expected HDF5 written by firn run");
  try {
    return hdf5::File::open(file, hdf5::File::Access::read);
  } catch (const hdf5::Error& e) {
    throw InputError(fmt::format("{}: truncated or damaged results file: {}", file, e.what()));
  }
}

// Row tables that every frame has, and the shape of one row.
struct FrameTable {
  const char* path;
  std::size_t width;  // values a particle; 0: one value a frame
};
constexpr FrameTable kFrameTables[] = {{"/frames/time", 0},
                                       {"/frames/position", 3},
                                       {"/frames/orientation", 4},
                                       {"/frames/velocity", 3},
                                       {"/frames/angular_velocity", 3}};

bool is_series(const std::string& path) {
  for (const char* group : {"/energy/", "/boundaries/", "/motion_frames/", "/health/"})
    if (path.starts_with(group)) return true;
  return false;
}

template <std::size_t Width>
std::vector<std::array<double, Width>> rows_of(const std::vector<double>& flat) {
  std::vector<std::array<double, Width>> rows(flat.size() / Width);
  for (std::size_t i = 0; i < flat.size(); ++i) rows[i / Width][i % Width] = flat[i];
  return rows;
}

}  // namespace

struct Recording::Impl {
  std::string name;
  hdf5::File file;
  std::size_t particles = 0, frames = 0;

  // Every failure of a read is a sentence about this file.
  template <class Read>
  auto guarded(Read&& read) const {
    try {
      return read();
    } catch (const hdf5::Error& e) {
      throw InputError(fmt::format("{}: damaged or foreign results file: {}", name, e.what()));
    }
  }

  // `path` is the file itself or the copy kept beside it; errors name `results_file`.
  Impl(const std::string& results_file, const std::string& path)
      : name(results_file), file(open_results(path)) {
    guarded([&] { check_layout(); });
  }

  // For a file whose writer may have been killed in the middle of a flush: cuts the frames back to
  // those that arrived whole. Throws where one of them cannot be read.
  void keep_whole_frames() {
    constexpr std::size_t kBlock = 16;  // frames at a time
    guarded([&] {
      std::vector<std::string> tables;
      for (const std::string& path : file.datasets())
        if (path.starts_with("/frames/") || is_series(path)) tables.push_back(path);
      for (const std::string& path : tables) frames = std::min(frames, file.rows_written(path));
      for (const std::string& path : tables)
        for (std::size_t i = 0; i < frames; i += kBlock)
          file.read_rows(path, i, std::min(kBlock, frames - i));
    });
  }

  void check_layout() {
    if (!file.has_attribute("/", "firn_version"))
      throw hdf5::Error("no attribute firn_version; expected a file written by firn run");
    for (const char* path : {"/particles/id", "/frames/time"})
      if (!file.contains(path)) throw hdf5::Error(fmt::format("{} is missing", path));
    const hdf5::Shape ids = file.shape("/particles/id");
    if (ids.size() != 1) throw hdf5::Error("/particles/id has the wrong shape; expected [N]");
    particles = ids[0];
    for (const char* path :
         {"/particles/shape", "/particles/tag", "/particles/mass", "/particles/peak_normal_force",
          "/particles/exit_time", "/particles/door_time"})
      expect_shape(path, {particles}, "[N]");
    frames = std::numeric_limits<std::size_t>::max();
    for (const FrameTable& table : kFrameTables) {
      const hdf5::Shape shape = rows_at(table.path);
      const hdf5::Shape expected =
          table.width ? hdf5::Shape{shape[0], particles, table.width} : hdf5::Shape{shape[0]};
      expect_shape(table.path, expected, table.width ? "[T,N,...]" : "[T]");
      frames = std::min(frames, shape[0]);
    }
    for (const std::string& path : file.datasets())
      if (is_series(path)) frames = std::min(frames, rows_at(path)[0]);
    // A writer killed in the middle of a flush leaves rows whose time never arrived.
    const std::vector<double> time = file.read_rows("/frames/time", 0, frames);
    while (frames > 0 && std::isnan(time[frames - 1])) --frames;
  }

  hdf5::Shape rows_at(const std::string& path) const {
    if (!file.contains(path)) throw hdf5::Error(path + " is missing");
    hdf5::Shape shape = file.shape(path);
    if (shape.empty()) throw hdf5::Error(path + " has the wrong shape; expected one row a frame");
    return shape;
  }

  void expect_shape(const std::string& path, const hdf5::Shape& shape, const char* words) const {
    if (!file.contains(path)) throw hdf5::Error(path + " is missing");
    if (file.shape(path) != shape)
      throw hdf5::Error(fmt::format("{} has the wrong shape; expected {}", path, words));
  }

  template <class T>
  std::vector<T> read(const char* path) const {
    return guarded([&] { return file.read<T>(path); });
  }

  std::vector<double> row(const std::string& path, std::size_t i) const {
    if (i >= frames)
      throw InputError(fmt::format("{}: no frame {}; the file has {}", name, i, frames));
    return guarded([&] { return file.read_rows(path, i, 1); });
  }

  template <std::size_t Width>
  std::array<double, Width> short_row(const std::string& path, std::size_t i) const {
    const std::vector<double> values = row(path, i);
    if (values.size() != Width)
      throw InputError(
          fmt::format("{}: {} has the wrong shape; expected {} values a frame", name, path, Width));
    return rows_of<Width>(values).front();
  }
};

Recording::Recording(const std::string& file) {
  // With a copy beside it, the run is under way or was killed: what the last flush left may lack
  // what an earlier one had. A run that ends meanwhile takes the copy away.
  std::unique_ptr<Impl> copy;
  try {
    if (has_kept_copy(file)) copy = std::make_unique<Impl>(file, kept_copy(file));
  } catch (const InputError&) {
  }
  try {
    impl_ = std::make_unique<Impl>(file, file);
    if (copy) impl_->keep_whole_frames();
  } catch (const InputError&) {
    if (!copy) throw;
    impl_.reset();
  }
  if (copy && (!impl_ || impl_->frames < copy->frames)) impl_ = std::move(copy);
}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

const std::string& Recording::file() const { return impl_->name; }

Case Recording::read_case() const {
  const std::string text = impl_->guarded([&] { return impl_->file.text_attribute("/", "case"); });
  return read_case_text(text, impl_->name, ".");
}

std::string Recording::status() const {
  return impl_->guarded([&] { return impl_->file.text_attribute("/", "status"); });
}

std::string Recording::program() const {
  return impl_->guarded([&] {
    return fmt::format("Firn {} ({})", impl_->file.text_attribute("/", "firn_version"),
                       impl_->file.text_attribute("/", "git_commit"));
  });
}

std::uint64_t Recording::seed() const {
  return impl_->guarded([&] { return impl_->file.integer_attribute("/", "seed"); });
}

double Recording::timestep() const {
  return impl_->guarded([&] { return impl_->file.number_attribute("/", "timestep").at(0); });
}

std::size_t Recording::particle_count() const { return impl_->particles; }

std::vector<int> Recording::shape() const { return impl_->read<int>("/particles/shape"); }
std::vector<int> Recording::tag() const { return impl_->read<int>("/particles/tag"); }
std::vector<double> Recording::mass() const { return impl_->read<double>("/particles/mass"); }
std::vector<double> Recording::peak_normal_force() const {
  return impl_->read<double>("/particles/peak_normal_force");
}
std::vector<double> Recording::exit_time() const {
  return impl_->read<double>("/particles/exit_time");
}
std::vector<double> Recording::door_time() const {
  return impl_->read<double>("/particles/door_time");
}

std::vector<double> Recording::insert_time() const {
  return impl_->read<double>("/particles/insert_time");
}
std::vector<int> Recording::batch() const { return impl_->read<int>("/particles/batch"); }
std::vector<int> Recording::outlet() const { return impl_->read<int>("/particles/outlet"); }

std::vector<double> Recording::gate_time(const std::string& gate) const {
  const std::vector<std::string> names =
      impl_->guarded([&] { return impl_->file.read_strings("/gates/name"); });
  const auto found = std::ranges::find(names, gate);
  if (found == names.end()) throw InputError(fmt::format("{}: has no gate \"{}\"", file(), gate));
  const std::vector<double> all = impl_->read<double>("/particles/gate_time");
  const auto first =
      all.begin() + (found - names.begin()) * static_cast<std::ptrdiff_t>(particle_count());
  return {first, first + static_cast<std::ptrdiff_t>(particle_count())};
}

std::vector<double> Recording::frame_times() const {
  return impl_->guarded([&] { return impl_->file.read_rows("/frames/time", 0, impl_->frames); });
}

Frame Recording::frame(std::size_t i) const {
  Frame frame;
  frame.time = impl_->row("/frames/time", i).at(0);
  frame.position = rows_of<3>(impl_->row("/frames/position", i));
  frame.orientation = rows_of<4>(impl_->row("/frames/orientation", i));
  frame.velocity = rows_of<3>(impl_->row("/frames/velocity", i));
  frame.angular_velocity = rows_of<3>(impl_->row("/frames/angular_velocity", i));
  return frame;
}

std::vector<StageRecord> Recording::stages() const {
  return impl_->guarded([&] {
    const hdf5::File& file = impl_->file;
    const std::vector<std::string> name = file.read_strings("/stages/name");
    const std::vector<std::string> ended_by = file.read_strings("/stages/ended_by");
    const std::vector<double> start = file.read<double>("/stages/start");
    const std::vector<double> end = file.read<double>("/stages/end");
    if (ended_by.size() != name.size() || start.size() != name.size() || end.size() != name.size())
      throw hdf5::Error("/stages has lists of different lengths");
    std::vector<StageRecord> entered;
    for (std::size_t i = 0; i < name.size(); ++i)
      if (!std::isnan(start[i])) entered.push_back({name[i], start[i], end[i], ended_by[i]});
    return entered;
  });
}

std::vector<Response> Recording::responses() const {
  return impl_->guarded([&] {
    const hdf5::File& file = impl_->file;
    std::vector<Response> responses;
    for (const std::string& path : file.datasets()) {
      const std::string group = "/responses/";
      if (!path.starts_with(group)) continue;
      Response response;
      response.name = path.substr(group.size());
      response.value = file.read<double>(path);
      response.uncertainty = file.number_attribute(path, "uncertainty");
      if (std::all_of(response.uncertainty.begin(), response.uncertainty.end(),
                      [](double u) { return std::isnan(u); }))
        response.uncertainty.clear();
      response.unit = file.text_attribute(path, "unit");
      response.method = file.text_attribute(path, "method");
      response.method_version = static_cast<int>(file.integer_attribute(path, "method_version"));
      responses.push_back(std::move(response));
    }
    return responses;
  });
}

std::vector<double> Recording::series(const std::string& path) const {
  return impl_->guarded([&] {
    impl_->rows_at(path);
    return impl_->file.read_rows(path, 0, impl_->frames);
  });
}

std::vector<Series> Recording::series_list() const {
  return impl_->guarded([&] {
    std::vector<Series> list;
    for (const std::string& path : impl_->file.datasets()) {
      if (!is_series(path)) continue;
      const hdf5::Shape shape = impl_->file.shape(path);
      list.push_back(
          {path, impl_->file.text_attribute(path, "unit"), shape.size() > 1 ? shape[1] : 1});
    }
    return list;
  });
}

BoundaryFrame Recording::boundary(const std::string& name, std::size_t frame) const {
  const std::string group = "/boundaries/" + name;
  const auto position = impl_->short_row<3>(group + "/position", frame);
  const auto orientation = impl_->short_row<4>(group + "/orientation", frame);
  const auto force = impl_->short_row<3>(group + "/force", frame);
  const auto torque = impl_->short_row<3>(group + "/torque", frame);
  BoundaryFrame result;
  result.position = Vec3(position.data());
  result.orientation = Quat(orientation[0], orientation[1], orientation[2], orientation[3]);
  result.force = Vec3(force.data());
  result.torque = Vec3(torque.data());
  result.peak_normal_force = impl_->short_row<1>(group + "/peak_normal_force", frame)[0];
  return result;
}

bool Recording::contains(const std::string& path) const { return impl_->file.contains(path); }

std::vector<double> Recording::values(const std::string& path) const {
  return impl_->read<double>(path.c_str());
}

std::vector<std::string> Recording::strings(const std::string& path) const {
  return impl_->guarded([&] { return impl_->file.read_strings(path); });
}

bool Recording::measured() const {
  return impl_->guarded([&] { return impl_->file.has_attribute("/", "measured"); });
}

bool Recording::has_checkpoint() const { return !read_checkpoints(impl_->file).empty(); }

double Recording::wall_time() const {
  return impl_->guarded([&] { return impl_->file.number_attribute("/", "wall_time").at(0); });
}

}  // namespace firn
