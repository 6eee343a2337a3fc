#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/export/export.h"
#include "experiments/results/bond_results.h"
#include "experiments/results/results_writer.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv/csv_writer.h"

namespace firn {
namespace {

void export_frames(const Recording& recording, const std::string& directory) {
  CsvFile csv(directory, "frames.csv");
  csv.line(
      "time [s],particle,x [m],y [m],z [m],qw,qx,qy,qz,vx [m/s],vy [m/s],vz [m/s],"
      "wx [rad/s],wy [rad/s],wz [rad/s]");
  for (std::size_t k = 0; k < recording.frame_count(); ++k) {
    const Frame frame = recording.frame(k);
    for (std::size_t i = 0; i < frame.position.size(); ++i) {
      if (std::isnan(frame.position[i][0])) continue;
      std::string line = fmt::format("{},{}", frame.time, i);
      append(line, frame.position[i]);
      append(line, frame.orientation[i]);
      append(line, frame.velocity[i]);
      append(line, frame.angular_velocity[i]);
      csv.line(line);
    }
  }
  csv.close();
}

void export_particles(const Recording& recording, const std::string& directory) {
  CsvFile csv(directory, "particles.csv");
  const Case c = read_case(recording);
  std::string header =
      "particle,shape,tag,mass [kg],peak_normal_force [N],exit_time [s],discharge_time [s],batch,"
      "insert_time [s],outlet";
  std::vector<std::vector<double>> sensors;
  for (const Sensor& sensor : c.sensors) {
    header += "," + encode::csv_field(sensor.name + "_time [s]");
    sensors.push_back(recording.sensor_time(sensor.name));
  }
  csv.line(header);
  const std::vector<int> shape = recording.shape(), tag = recording.tag(),
                         batch = recording.batch(), outlet = recording.outlet();
  const std::vector<double> mass = recording.mass(), peak = recording.peak_normal_force(),
                            exit = recording.exit_time(), door = recording.discharge_time(),
                            came = recording.insert_time();
  const auto or_empty = [](double t) {
    return std::isnan(t) ? std::string() : fmt::format("{}", t);
  };
  for (std::size_t i = 0; i < recording.particle_count(); ++i) {
    const std::string by =
        outlet[i] < 0 ? "" : encode::csv_field(c.outlets[static_cast<std::size_t>(outlet[i])].name);
    std::string line =
        fmt::format("{},{},{},{},{},{},{},{},{},{}", i, shape[i], tag[i], mass[i], peak[i],
                    or_empty(exit[i]), or_empty(door[i]), batch[i], or_empty(came[i]), by);
    for (const std::vector<double>& times : sensors) line += "," + or_empty(times[i]);
    csv.line(line);
  }
  csv.close();
}

// E.g. "boundaries/floor/force.x [N]".
std::string column_name(std::string_view path, std::string_view unit, std::size_t width,
                        std::size_t component) {
  std::string name(path.substr(1));
  if (width > 1) {
    name.push_back('.');
    name.push_back((width == 4 ? "wxyz" : "xyz")[component]);
  }
  if (unit != "1") name.append(" [").append(unit).append("]");
  return name;
}

// Datasets with a row for each time.
struct Rows {
  std::string path, unit;
  std::size_t width = 1;
  std::vector<double> values;
};

void export_rows(const std::vector<double>& times, const std::vector<Rows>& all,
                 const std::string& directory, const std::string& file) {
  std::string header = "time [s]";
  for (const Rows& one : all) {
    for (std::size_t k = 0; k < one.width; ++k) {
      header.push_back(',');
      header.append(encode::csv_field(column_name(one.path, one.unit, one.width, k)));
    }
  }
  CsvFile csv(directory, file);
  csv.line(header);
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::string line = fmt::format("{}", times[i]);
    for (const Rows& one : all)
      append(line, std::span(one.values).subspan(i * one.width, one.width));
    csv.line(line);
  }
  csv.close();
}

void export_series(const Recording& recording, const std::string& directory) {
  std::vector<Rows> all;
  for (const Series& series : recording.series_list())
    all.push_back({series.path, series.unit, series.width, recording.series(series.path)});
  export_rows(recording.frame_times(), all, directory, "series.csv");
}

void export_samples(const Recording& recording, const std::string& directory) {
  std::vector<Rows> all;
  // Under the names of series.csv.
  constexpr std::size_t kGroup = std::string_view("/samples").size();
  for (const Column& column : sample_columns(read_case(recording)))
    all.push_back({column.path.substr(kGroup), column.unit, column.row.empty() ? 1 : column.row[0],
                   recording.values(column.path)});
  if (all.empty()) return;
  const std::vector<double> times = std::move(all.front().values);
  all.erase(all.begin());
  export_rows(times, all, directory, "samples.csv");
}

void export_bonds(const Recording& recording, const std::string& directory) {
  const std::vector<BondOutcome> outcomes = bond_outcomes(recording);
  if (outcomes.empty()) return;
  CsvFile csv(directory, "bonds.csv");
  csv.line(
      "bond,name,a,b,break_mode,break_time [s],break_stress [Pa],break_x [m],break_y [m],"
      "break_z [m]");
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const BondOutcome& one = outcomes[k];
    std::string line =
        fmt::format("{},{},{},{},{}", k, encode::csv_field(one.name), one.a, one.b, one.mode);
    const double numbers[] = {one.time, one.stress, one.position.x(), one.position.y(),
                              one.position.z()};
    for (double value : numbers)
      line += std::isnan(value) ? std::string(",") : fmt::format(",{}", value);
    csv.line(line);
  }
  csv.close();
}

void export_responses(const Recording& recording, const std::string& directory) {
  CsvFile csv(directory, "responses.csv");
  csv.line("name,index,value,uncertainty,unit,method,method_version");
  for (const Response& r : recording.responses())
    for (std::size_t i = 0; i < r.value.size(); ++i)
      csv.line(fmt::format("{},{},{},{},{},{},{}", encode::csv_field(r.name), i, r.value[i],
                           i < r.uncertainty.size() ? fmt::format("{}", r.uncertainty[i]) : "",
                           encode::csv_field(r.unit), encode::csv_field(r.method),
                           r.method_version));
  csv.close();
}

}  // namespace

void export_csv(const Recording& recording, const std::string& directory) {
  export_frames(recording, directory);
  export_particles(recording, directory);
  export_series(recording, directory);
  export_samples(recording, directory);
  export_bonds(recording, directory);
  export_responses(recording, directory);
  export_statistics_csv(recording, directory);
}

}  // namespace firn
