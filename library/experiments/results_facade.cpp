#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/responses/measure.h"
#include "experiments/results/results_file.h"
#include "experiments/results/results_writer.h"
#include "experiments/text/json_aliases.h"
#include "firn/experiments/results.h"
#include "library/experiments/convert_response.h"

namespace firn::experiments {

constexpr std::string_view kSamples = "/samples";

struct Results::Impl {
  explicit Impl(const std::string& file) : recording(file), checked(read_case(recording)) {}
  Recording recording;
  firn::Case checked;
};

Results::Results(const std::string& file) : impl_(std::make_shared<const Impl>(file)) {}

std::string Results::file() const { return impl_->recording.file(); }
std::string Results::status() const { return impl_->recording.status(); }
std::string Results::program() const { return impl_->recording.program(); }
std::uint64_t Results::seed() const { return impl_->recording.seed(); }
double Results::timestep() const { return impl_->recording.timestep(); }
double Results::wall_time() const { return impl_->recording.wall_time(); }
std::string Results::case_text() const { return impl_->checked.resolved; }
std::size_t Results::particle_count() const { return impl_->recording.particle_count(); }
std::vector<double> Results::times() const { return impl_->recording.frame_times(); }

std::vector<std::string> Results::shapes() const {
  std::vector<std::string> names;
  for (const Shape& shape : impl_->checked.model.shapes) names.push_back(shape.name);
  return names;
}

std::vector<std::string> Results::boundaries() const {
  std::vector<std::string> names;
  for (const Boundary& b : impl_->checked.model.boundaries) names.push_back(b.name);
  return names;
}

Particles Results::particles() const {
  const Recording& r = impl_->recording;
  return {r.shape(), r.tag(), r.mass(), r.insert_time(), r.exit_time(), r.peak_normal_force()};
}

Frame Results::frame(std::size_t index) const {
  const std::size_t frames = times().size();
  if (index >= frames)
    throw InputError(
        fmt::format("{}: frame {} does not exist; expected one below {}", file(), index, frames));
  firn::Frame f = impl_->recording.frame(index);
  return {f.time, std::move(f.position), std::move(f.orientation), std::move(f.velocity),
          std::move(f.angular_velocity)};
}

std::vector<Stage> Results::stages() const {
  std::vector<Stage> all;
  for (const StageRecord& s : impl_->recording.stages())
    all.push_back({s.name, s.start, s.end, s.end_reason});
  return all;
}

std::vector<Response> Results::responses() const {
  return public_responses(impl_->recording.responses());
}

std::vector<Response> Results::measure() const {
  return public_responses(firn::measure(impl_->recording));
}

std::vector<Series> Results::series() const {
  std::vector<Series> all;
  for (const firn::Series& s : impl_->recording.series_list())
    all.push_back({s.path, s.unit, s.width});
  return all;
}

std::vector<double> Results::series(const std::string& path) const {
  return impl_->recording.series(path);
}

std::vector<double> Results::sample_times() const {
  if (impl_->checked.samples.interval == 0) return {};
  return impl_->recording.values("/samples/time");
}

std::vector<Series> Results::samples() const {
  std::vector<Series> all;
  for (const Column& column : sample_columns(impl_->checked))
    if (!column.row.empty())
      all.push_back({column.path.substr(kSamples.size()), column.unit, column.row[0]});
  return all;
}

std::vector<double> Results::samples(const std::string& path) const {
  const std::vector<Series> all = samples();
  if (std::ranges::count(all, path, &Series::path) == 0)
    throw InputError(
        fmt::format("{}: {} is not sampled; expected one of [output.samples] of the "
                    "case",
                    file(), path));
  return impl_->recording.values(std::string(kSamples) + path);
}

std::string current_results_json(const std::string& text) {
  nlohmann::ordered_json document = nlohmann::ordered_json::parse(text, nullptr, false);
  if (document.is_discarded()) return text;
  use_current_json_names(document);
  return document.dump();
}

}  // namespace firn::experiments
