#include "experiments/results/results_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

#include "experiments/results/checkpoint.h"
#include "experiments/results/results_guard.h"
#include "experiments/results/results_lock.h"
#include "experiments/results/results_schema.h"
#include "experiments/storage/hdf5_file.h"
#include "experiments/system/input_file.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_aliases.h"

namespace firn {
namespace {

// `name` is what errors call the file.
hdf5::File open_results(const std::string& file, const std::string& name) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file + ": no such file");
  require_regular_file(file, "a results file (HDF5)");
  if (first_bytes(file, kHdf5Signature.size()) != kHdf5Signature)
    throw InputError(file + ": not a results file; expected HDF5 written by firn run");
  check_in_child(file, name);
  try {
    return results::open_file(file, hdf5::File::Access::read);
  } catch (const hdf5::Error& e) {
    throw InputError(fmt::format("{}: truncated or damaged results file: {}", file, e.what()));
  }
}

bool is_series(const std::string& path) {
  for (const char* group : {"/energy/", "/boundaries/", "/motion_frames/", "/couplings/",
                            "/boundary_contacts/", "/diagnostics/"})
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
  results::Contents contents;
  std::size_t particles = 0, frames = 0;

  // Every failure of a read is a sentence about this file.
  template <class Read>
  auto guarded(Read&& read) const {
    try {
      return read();
    } catch (const hdf5::Error& e) {
      throw InputError(fmt::format("{}: {}", name, e.what()));
    }
  }

  // `path` is the file itself or its backup copy; errors name `results_file`.
  Impl(const std::string& results_file, const std::string& path)
      : name(results_file), file(open_results(path, results_file)) {
    contents = guarded([&] { return results::check_file(file); });
    particles = contents.particles;
    frames = contents.frames;
  }

  // For a file whose writer may have been killed in the middle of a flush. Throws where a frame
  // cannot be read.
  void check_frames() const {
    constexpr std::size_t kBlock = 16;  // frames at a time
    guarded([&] {
      for (const auto& [path, dataset] : contents.datasets) {
        if (!dataset->shape.starts_with("T")) continue;
        for (std::size_t i = 0; i < frames; i += kBlock)
          file.read_rows(path, i, std::min(kBlock, frames - i));
      }
    });
  }

  // Rows [first, first + count) of a table, checked against the schema.
  std::vector<double> rows(const std::string& path, std::size_t first, std::size_t count) const {
    return guarded([&] {
      if (!contents.datasets.contains(path)) throw hdf5::Error(path + ": is missing");
      std::vector<double> values = file.read_rows(path, first, count);
      results::check_values(contents, path, values, first);
      return values;
    });
  }

  template <class T>
  std::vector<T> read(const std::string& path) const {
    return guarded([&] {
      if (!contents.datasets.contains(path)) throw hdf5::Error(path + ": is missing");
      return file.read<T>(path);
    });
  }

  std::vector<double> row(const std::string& path, std::size_t i) const {
    if (i >= frames)
      throw InputError(fmt::format("{}: no frame {}; the file has {}", name, i, frames));
    return rows(path, i, 1);
  }

  template <std::size_t Width>
  std::array<double, Width> short_row(const std::string& path, std::size_t i) const {
    const std::vector<double> values = row(path, i);
    std::array<double, Width> result;
    std::copy_n(values.begin(), Width, result.begin());
    return result;
  }

  // That what is there in one of two tables is there in the other, vector by vector.
  void check_same_presence(const std::string& path, std::span<const double> values,
                           std::size_t width, std::span<const double> positions) const {
    for (std::size_t i = 0; 3 * i < positions.size(); ++i)
      if (std::isnan(values[width * i]) != std::isnan(positions[3 * i]))
        throw InputError(fmt::format(
            "{}: {}: is NaN for other bodies than the positions; expected the same", name, path));
  }
};

Recording::Recording(const std::string& file) {
  // A backup copy exists while the run is active or after it was killed: the last flush may then
  // lack data of an earlier one. A run that ends meanwhile removes the copy.
  std::unique_ptr<Impl> copy;
  try {
    if (has_saved_copy(file)) copy = std::make_unique<Impl>(file, saved_copy(file));
  } catch (const InputError&) {
  }
  try {
    impl_ = std::make_unique<Impl>(file, file);
    if (copy) impl_->check_frames();
  } catch (const InputError&) {
    if (!copy) throw;
    impl_.reset();
  }
  if (copy && (!impl_ || impl_->frames < copy->frames)) impl_ = std::move(copy);
}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

const std::string& Recording::file() const { return impl_->name; }

std::string Recording::case_text() const {
  return impl_->guarded([&] { return impl_->file.text_attribute("/", "case"); });
}

void Recording::check_case(const Case& c) const {
  impl_->guarded([&] { results::check_case(impl_->contents, impl_->file, c); });
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

int Recording::contact_model() const {
  return impl_->guarded([&] {
    if (!impl_->file.has_attribute("/", "contact_model")) return 1;
    return static_cast<int>(impl_->file.integer_attribute("/", "contact_model"));
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
std::vector<double> Recording::discharge_time() const {
  return impl_->read<double>("/particles/discharge_time");
}

std::vector<double> Recording::insert_time() const {
  return impl_->read<double>("/particles/insert_time");
}
std::vector<int> Recording::batch() const { return impl_->read<int>("/particles/batch"); }
std::vector<int> Recording::outlet() const { return impl_->read<int>("/particles/outlet"); }

std::vector<double> Recording::sensor_time(const std::string& sensor) const {
  const std::vector<std::string> names =
      impl_->guarded([&] { return impl_->file.read_strings("/sensors/name"); });
  const auto found = std::ranges::find(names, sensor);
  if (found == names.end())
    throw InputError(fmt::format("{}: has no sensor \"{}\"", file(), sensor));
  const std::vector<double> all = impl_->read<double>("/particles/sensor_time");
  const auto first =
      all.begin() + (found - names.begin()) * static_cast<std::ptrdiff_t>(particle_count());
  return {first, first + static_cast<std::ptrdiff_t>(particle_count())};
}

std::size_t Recording::frame_count() const { return impl_->frames; }

std::vector<double> Recording::frame_times() const {
  return impl_->rows("/frames/time", 0, impl_->frames);
}

Frame Recording::frame(std::size_t i) const {
  Frame frame;
  frame.time = impl_->row("/frames/time", i).at(0);
  const std::vector<double> position = impl_->row("/frames/position", i);
  const auto of_those_present = [&](const std::string& path, std::size_t width) {
    std::vector<double> values = impl_->row(path, i);
    impl_->check_same_presence(path, values, width, position);
    return values;
  };
  frame.position = rows_of<3>(position);
  frame.orientation = rows_of<4>(of_those_present("/frames/orientation", 4));
  frame.velocity = rows_of<3>(of_those_present("/frames/velocity", 3));
  frame.angular_velocity = rows_of<3>(of_those_present("/frames/angular_velocity", 3));
  return frame;
}

double count_since(const std::vector<StageRecord>& begun, std::size_t stage,
                   const std::vector<double>& times) {
  if (stage >= begun.size()) return kUndefined;
  return static_cast<double>(
      std::ranges::count_if(times, [&](double time) { return time >= begun[stage].start; }));
}

std::vector<StageRecord> Recording::stages() const {
  return impl_->guarded([&] {
    const hdf5::File& file = impl_->file;
    const std::vector<std::string> name = file.read_strings("/stages/name");
    const std::vector<std::string> end_reason = file.read_strings("/stages/end_reason");
    const std::vector<double> start = file.read<double>("/stages/start");
    const std::vector<double> end = file.read<double>("/stages/end");
    std::vector<StageRecord> entered;
    for (std::size_t i = 0; i < name.size(); ++i)
      if (!std::isnan(start[i])) entered.push_back({name[i], start[i], end[i], end_reason[i]});
    return entered;
  });
}

std::vector<Response> Recording::responses() const {
  return impl_->guarded([&] {
    const hdf5::File& file = impl_->file;
    std::vector<Response> responses;
    for (const auto& [path, dataset] : impl_->contents.datasets) {
      const std::string group = "/responses/";
      if (!path.starts_with(group)) continue;
      Response response;
      response.name = current_response_name(path.substr(group.size()));
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
    std::ranges::sort(responses, {}, &Response::name);
    return responses;
  });
}

std::vector<double> Recording::series(const std::string& asked) const {
  const std::string path = results::current_path(asked);
  if (path != asked) warn_of_old_name(impl_->name, {asked, 0, asked, path, false});
  const auto known = impl_->contents.datasets.find(path);
  if (known != impl_->contents.datasets.end() && !known->second->shape.starts_with("T"))
    throw InputError(fmt::format("{}: {}: is not a series over frames", file(), path));
  std::vector<double> values = impl_->rows(path, 0, impl_->frames);
  if (path.starts_with("/frames/") && path != "/frames/time" && path != "/frames/position") {
    const std::size_t width = impl_->contents.shapes.at(path)[2];
    impl_->check_same_presence(path, values, width,
                               impl_->rows("/frames/position", 0, impl_->frames));
  }
  return values;
}

std::vector<Series> Recording::series_list() const {
  std::vector<Series> list;
  for (const auto& [path, dataset] : impl_->contents.datasets) {
    if (!is_series(path)) continue;
    const hdf5::Shape& shape = impl_->contents.shapes.at(path);
    list.push_back({path, std::string(dataset->unit), shape.size() > 1 ? shape[1] : 1});
  }
  return list;
}

BoundaryFrame Recording::boundary(const std::string& name, std::size_t frame) const {
  const std::string group = "/boundaries/" + name;
  const auto position = impl_->short_row<3>(group + "/position", frame);
  const auto orientation = impl_->short_row<4>(group + "/orientation", frame);
  const auto force = impl_->short_row<3>(group + "/force", frame);
  const auto torque = impl_->short_row<3>(group + "/torque", frame);
  impl_->check_same_presence(group + "/orientation", orientation, 4, position);
  BoundaryFrame result;
  result.position = Vec3(position.data());
  result.orientation = Quat(orientation[0], orientation[1], orientation[2], orientation[3]);
  result.force = Vec3(force.data());
  result.torque = Vec3(torque.data());
  result.peak_normal_force = impl_->short_row<1>(group + "/peak_normal_force", frame)[0];
  return result;
}

bool Recording::contains(const std::string& path) const {
  return impl_->contents.datasets.contains(path);
}

std::vector<double> Recording::values(const std::string& path) const {
  if (const auto rows = impl_->contents.growing_rows(path)) return impl_->rows(path, 0, *rows);
  const auto known = impl_->contents.datasets.find(path);
  if (known == impl_->contents.datasets.end() || known->second->type != hdf5::Type::integer)
    return impl_->read<double>(path);
  const std::vector<int> numbers = impl_->read<int>(path);
  return {numbers.begin(), numbers.end()};
}

std::vector<std::string> Recording::strings(const std::string& path) const {
  return impl_->guarded([&] { return impl_->file.read_strings(path); });
}

bool Recording::measured() const {
  return impl_->guarded([&] { return impl_->file.has_attribute("/", "responses_complete"); });
}

bool Recording::has_checkpoint() const { return !read_checkpoints(impl_->file).empty(); }

double Recording::wall_time() const {
  return impl_->guarded([&] { return impl_->file.number_attribute("/", "wall_time").at(0); });
}

}  // namespace firn
