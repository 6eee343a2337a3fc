#include <fmt/format.h>

#include <cmath>
#include <span>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/export/export.h"
#include "experiments/results/bond_results.h"
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
std::string column_name(const Series& series, std::size_t component) {
  std::string name = series.path.substr(1);
  if (series.width > 1) {
    name.push_back('.');
    name.push_back((series.width == 4 ? "wxyz" : "xyz")[component]);
  }
  if (series.unit != "1") name.append(" [").append(series.unit).append("]");
  return name;
}

void export_series(const Recording& recording, const std::string& directory) {
  const std::vector<Series> list = recording.series_list();
  std::vector<std::vector<double>> values;
  std::string header = "time [s]";
  for (const Series& series : list) {
    values.push_back(recording.series(series.path));
    for (std::size_t k = 0; k < series.width; ++k) {
      header.push_back(',');
      header.append(encode::csv_field(column_name(series, k)));
    }
  }
  CsvFile csv(directory, "series.csv");
  csv.line(header);
  const std::vector<double> times = recording.frame_times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::string line = fmt::format("{}", times[i]);
    for (std::size_t s = 0; s < list.size(); ++s)
      append(line, std::span(values[s]).subspan(i * list[s].width, list[s].width));
    csv.line(line);
  }
  csv.close();
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
  export_bonds(recording, directory);
  export_responses(recording, directory);
  export_statistics_csv(recording, directory);
}

}  // namespace firn
