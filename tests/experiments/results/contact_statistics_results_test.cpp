// Statistics of contacts in cases and results files.
#include "experiments/results/contact_statistics_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "experiments/responses/measure.h"
#include "experiments/run/run.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string refusal(const std::vector<Override>& overrides) {
  return test::error_of([&] { tray(overrides); });
}

TEST(StatisticsCase, ReadsWhatIsAskedFor) {
  const Case c = tray({{"statistics.events.threshold", "\"2.5 N\""},
                       {"statistics.boundary_maps.boundaries", "[\"lid\"]"},
                       {"statistics.energy_spectrum.decades", "4"}});
  const StatisticsOptions& asked = c.model.statistics;
  EXPECT_EQ(asked.merge_gap, 1e-4);
  EXPECT_TRUE(asked.events);
  EXPECT_EQ(asked.threshold, 2.5);
  EXPECT_TRUE(asked.compressive_loads);
  ASSERT_EQ(asked.monitored.size(), 1u);
  EXPECT_EQ(asked.monitored[0].boundary, 1);
  EXPECT_GT(asked.monitored[0].mesh.triangles.size(), 24u);
  EXPECT_EQ(asked.interval, 0.04);
  EXPECT_DOUBLE_EQ(c.wear_rate, 1e-13);
  ASSERT_EQ(asked.surfaces.size(), 1u);
  EXPECT_GT(asked.surfaces[0].triangles.size(), 24u);
  EXPECT_EQ(asked.energies.count(), 4 * 5 + 2);
  // The resolved text says the same.
  EXPECT_EQ(case_hash(read_case_text(c.resolved, "again.toml", ".")), case_hash(c));
}

TEST(StatisticsCase, WearIsACoefficientOverAHardness) {
  std::string text = kTray;
  const std::string rate = "specific_wear_rate = \"1e-13 m^2/N\"";
  text.replace(text.find(rate), rate.size(), "wear_coefficient = 2e-4\nhardness = \"20 MPa\"");
  EXPECT_DOUBLE_EQ(read_case_text(text, "tray.toml", ".").wear_rate, 1e-11);
  EXPECT_THAT(refusal({{"statistics.boundary_maps.hardness", "\"20 MPa\""}}),
              HasSubstr("specific_wear_rate: is given together with"));
}

TEST(StatisticsCase, IsOffWithoutItsTable) {
  std::string text = kTray;
  text.resize(text.find("[statistics]"));
  const Case c = read_case_text(text, "tray.toml", ".");
  EXPECT_FALSE(c.model.statistics.any());
  EXPECT_EQ(c.resolved.find("statistics"), std::string::npos);
}

TEST(StatisticsCase, RefusesWhatMakesNoSense) {
  const std::vector<std::array<const char*, 3>> mistakes = {
      {"statistics.events.threshold", "\"-1 N\"", "statistics.events.threshold: "},
      {"statistics.events.threshold", "\"1 J\"", "statistics.events.threshold: "},
      {"statistics.events.treshold", "\"1 N\"", "\"threshold\""},
      {"statistics.merge_gap", "3", "statistics.merge_gap: "},
      {"statistics.from_stage", "\"dorp\"",
       "statistics.from_stage: \"dorp\" is no stage of the case; expected one of \"settle\", "
       "\"drop\""},
      {"statistics.from_stage", "1", "statistics.from_stage: "},
      {"statistics.compressive_loads", "\"yes\"", "statistics.compressive_loads: "},
      {"statistics.boundary_maps.boundaries", "[\"flor\"]", "\"floor\""},
      {"statistics.boundary_maps.boundaries", "[]", "expected names of boundaries"},
      {"statistics.boundary_maps.boundaries", "[\"lid\", \"lid\"]", "names \"lid\" twice"},
      {"statistics.boundary_maps.edge", "\"1 um\"", "more than 1000000 triangles"},
      {"statistics.boundary_maps.interval", "\"0 s\"", "statistics.boundary_maps.interval: "},
      {"statistics.particle_maps.edge", "\"0 mm\"", "statistics.particle_maps.edge: "},
      {"statistics.energy_spectrum.lowest", "\"0 J\"", "statistics.energy_spectrum.lowest: "},
      {"statistics.energy_spectrum.per_decade", "0", "statistics.energy_spectrum.per_decade: "},
  };
  for (const auto& [key, value, message] : mistakes)
    EXPECT_THAT(refusal({{key, value}}), HasSubstr(message)) << key << " = " << value;
  std::string text = kTray;
  text +=
      "[[boundaries]]\nname = \"plane\"\nkind = \"plane\"\nmaterial = \"plastic\"\n"
      "point = \"0 0 -1 m\"\nnormal = [0, 0, 1]\n";
  EXPECT_THAT(test::error_of([&] {
                read_case_text(text, "tray.toml", ".",
                               {{"statistics.boundary_maps.boundaries", "[\"plane\"]"}});
              }),
              HasSubstr("\"plane\" is a plane, which has no triangles"));
}

class StatisticsFile : public ResultsFolder {
 protected:
  Recording recorded(const Case& c) {
    RunOptions options;
    options.results_file = (directory_ / "run.h5").string();
    const RunSummary summary = run(c, options);
    EXPECT_EQ(summary.status, RunStatus::finished) << summary.reason;
    return Recording(options.results_file);
  }
};

double response(const Recording& recording, const Case& c, const std::string& name) {
  const std::vector<Response> all = measure(recording, c);
  const auto it = std::ranges::find(all, name, &Response::name);
  return it == all.end() || it->value.empty() ? NAN : *std::ranges::max_element(it->value);
}

// With from_stage nothing of an earlier stage is in the file; a run that ends before it has no
// such responses.
TEST_F(StatisticsFile, CountFromTheStageThatTheCaseNames) {
  const char* const names[] = {"largest_compressive_load", "peak_normal_force",
                               "contacts_on_floor"};
  const Case all = tray();
  const Recording whole = recorded(all);
  const double start = whole.stages().at(1).start;
  const auto before = std::ranges::count_if(contact_events(whole),
                                            [&](const ContactEvent& e) { return e.start < start; });
  ASSERT_GT(before, 5);
  std::vector<double> of_whole;
  for (const char* name : names) of_whole.push_back(response(whole, all, name));

  const Case late = tray({{"statistics.from_stage", "\"drop\""}});
  EXPECT_EQ(case_hash(read_case_text(late.resolved, "again.toml", ".")), case_hash(late));
  const Recording dropped = recorded(late);
  EXPECT_EQ(dropped.stages().at(1).start, start);
  for (const ContactEvent& e : contact_events(dropped)) EXPECT_GE(e.start, start);
  for (const BoundaryLoads& loads : boundary_loads(dropped))
    for (const double t : loads.start) EXPECT_GE(t, start);
  for (std::size_t k = 0; k < std::size(names); ++k) {
    if (std::isnan(of_whole[k])) continue;
    EXPECT_LT(response(dropped, late, names[k]), of_whole[k]) << names[k];
  }
  EXPECT_GT(response(whole, all, "peak_normal_force"), 0);

  const Case never = tray({{"statistics.from_stage", "\"drop\""}, {"case.duration", "\"20 ms\""}});
  const Recording ended = recorded(never);
  ASSERT_EQ(ended.stages().size(), 1u);
  for (const char* name : names) EXPECT_TRUE(std::isnan(response(ended, never, name))) << name;
}

// What the file says of contacts is what boundaries and particles say of themselves.
TEST_F(StatisticsFile, HoldsEveryContactAboveTheThreshold) {
  const Case c =
      tray({{"statistics.events.threshold", "\"0.2 N\""}, {"case.duration", "\"0.2 s\""}});
  const Recording recording = recorded(c);
  const std::vector<ContactEvent> events = contact_events(recording);
  ASSERT_GT(events.size(), 13u);
  const std::vector<double> peaks = recording.peak_normal_force();
  std::vector<double> largest(peaks.size(), 0);
  double first = 1;
  for (const ContactEvent& e : events) {
    EXPECT_GE(e.peak_normal_force, 0.2);
    EXPECT_LT(e.a, e.b);
    largest.at(e.a) = std::max(largest[e.a], e.peak_normal_force);
    if (e.b < 13) largest[e.b] = std::max(largest[e.b], e.peak_normal_force);
    first = std::min(first, e.start);
    if (e.b >= 13) {  // on the floor: in its axes the top is half of its thickness up
      EXPECT_EQ(e.b, 13);
      EXPECT_NEAR(e.position_on_b.z(), 0.05, 1e-3);
      EXPECT_NEAR(e.position.z(), 0, 1e-3);
    }
    // On the surface of a cube of 20 mm, but for what it is pressed in.
    EXPECT_NEAR(e.position_on_a.lpNorm<Eigen::Infinity>(), 0.01, 1e-3);
  }
  // Cubes have one patch with each other: the largest of a particle's contacts is its peak.
  for (std::size_t i = 0; i < peaks.size(); ++i) EXPECT_NEAR(largest[i], peaks[i], 1e-9) << i;
  EXPECT_GT(first, 0);
  EXPECT_TRUE(events.back().open_at_end);
  EXPECT_FALSE(events.front().open_at_end);
}

double sum(const std::vector<double>& values, std::size_t first, std::size_t count) {
  double all = 0;
  for (std::size_t k = first; k < first + count; ++k) all += values.at(k);
  return all;
}

// Over all triangles and intervals the floor has had what its own series says.
TEST_F(StatisticsFile, TrianglesBearWhatTheBoundaryBears) {
  const Case c = tray();
  const Recording recording = recorded(c);
  const std::vector<BoundaryLoads> all = boundary_loads(recording);
  ASSERT_EQ(all.size(), 1u);
  const BoundaryLoads& floor = all[0];
  EXPECT_EQ(floor.boundary, "floor");
  const std::size_t triangles = floor.mesh.triangles.size(), intervals = floor.end.size();
  ASSERT_GE(intervals, 3u);
  EXPECT_EQ(floor.start[0], 0);
  for (std::size_t k = 1; k < intervals; ++k) EXPECT_EQ(floor.start[k], floor.end[k - 1]);
  const std::vector<double> times = recording.frame_times();
  EXPECT_EQ(floor.end.back(), times.back());
  double impulse = 0, from_triangles = 0, wear = 0, friction = 0;
  const std::vector<double> force = recording.series("/boundaries/floor/force");
  for (std::size_t k = 1; k < times.size(); ++k)
    impulse += force[3 * k + 2] * (times[k] - times[k - 1]);
  for (const TriangleField& field : floor.fields) {
    ASSERT_EQ(field.values.size(), triangles * intervals) << field.name;
    const double total = sum(field.values, 0, field.values.size());
    if (field.name == "impulse_z") from_triangles = total;
    if (field.name == "wear_depth")
      for (std::size_t k = 0; k < field.values.size(); ++k)
        wear += field.values[k] * floor.area[k % triangles];
    if (field.name == "frictional_power")
      for (std::size_t i = 0; i < intervals; ++i)
        friction += sum(field.values, i * triangles, triangles) * (floor.end[i] - floor.start[i]);
  }
  EXPECT_LT(impulse, -0.01);
  EXPECT_NEAR(from_triangles, impulse, 1e-9 * std::abs(impulse));
  // Sliding with the friction 0.3 of the floor: the work is 0.3 F s, and k / H is 1e-13 / Pa. What
  // sticks and springs does work as well.
  EXPECT_GT(wear, 0);
  EXPECT_NEAR(friction, 0.3 * wear / 1e-13, 0.2 * friction);
}

TEST_F(StatisticsFile, SumsAreThoseOfTheContacts) {
  const Case c = tray({{"statistics.events.threshold", "\"0 N\""}});
  const Recording recording = recorded(c);
  std::vector<ContactEvent> events = contact_events(recording);
  std::erase_if(events, [](const ContactEvent& e) { return e.open_at_end != 0; });
  ASSERT_GT(events.size(), 30u);
  double touches = 0;
  for (const ContactEvent& e : events) touches += e.b < 13 ? 2 : 1;
  const std::vector<SurfaceLoads> surfaces = surface_loads(recording);
  ASSERT_EQ(surfaces.size(), 1u);
  EXPECT_EQ(surfaces[0].shape, "cube");
  ASSERT_EQ(surfaces[0].fields[0].name, "contacts");
  EXPECT_EQ(sum(surfaces[0].fields[0].values, 0, surfaces[0].mesh.triangles.size()), touches);

  const auto spectrum = energy_spectrum(recording);
  ASSERT_TRUE(spectrum);
  EXPECT_EQ(spectrum->kind, (std::vector<std::string>{"particles", "floor", "lid"}));
  EXPECT_EQ(sum(spectrum->contacts, 0, spectrum->contacts.size()),
            static_cast<double>(events.size()));

  const std::vector<CompressiveLoad> opposed = compressive_loads(recording);
  ASSERT_EQ(opposed.size(), 13u);
  int loaded = 0;
  for (std::size_t i = 0; i < opposed.size(); ++i) {
    EXPECT_LE(opposed[i].load, recording.peak_normal_force()[i]);
    if (opposed[i].load == 0) continue;
    ++loaded;
    EXPECT_NE(opposed[i].bodies[0], static_cast<int>(i));
    EXPECT_GT(opposed[i].time, 0);
  }
  EXPECT_GT(loaded, 0);

  double largest = 0, on_floor = 0;
  std::vector<double> of_particle(13, 0);
  for (const ContactEvent& e : contact_events(recording)) {
    if (e.b != 13) continue;
    ++on_floor;
    largest = std::max(largest, e.peak_normal_force);
    double& one = of_particle[index(e.a)];
    one = std::max(one, e.peak_normal_force);
  }
  std::erase(of_particle, 0.0);
  std::ranges::sort(of_particle);
  std::map<std::string, double> responses;
  for (const Response& r : measure(recording)) {
    responses[r.name] = r.value[0];
    if (r.name == "largest_contacts_on_floor") {
      EXPECT_EQ(r.value, of_particle);
    }
  }
  ASSERT_GT(of_particle.size(), 1u);
  EXPECT_EQ(responses.at("largest_contacts_on_floor"), of_particle.front());
  EXPECT_FALSE(responses.contains("largest_contacts_between_particles"));
  EXPECT_FALSE(responses.contains("largest_contacts_on_lid"));
  EXPECT_EQ(responses.at("contacts_on_floor"), on_floor);
  EXPECT_EQ(responses.at("largest_contact_on_floor"), largest);
  EXPECT_EQ(responses.at("contacts_on_lid"), 0);
  EXPECT_FALSE(responses.contains("largest_contact_on_lid"));
  EXPECT_GT(responses.at("wear_depth_on_floor"), 0);
  EXPECT_GT(responses.at("wear_volume_on_floor"), 0);
  EXPECT_GT(responses.at("peak_stress_on_floor"), 0);
  EXPECT_GE(responses.at("largest_compressive_load"), responses.at("compressive_load_median"));
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in.is_open()) << file;
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST_F(StatisticsFile, IsExported) {
  const Recording recording = recorded(tray());
  export_csv(recording, (directory_ / "csv").string());
  const std::vector<ContactEvent> events = contact_events(recording);
  const auto contacts = lines_of(directory_ / "csv" / "contacts.csv");
  ASSERT_EQ(contacts.size(), events.size() + 1);
  EXPECT_EQ(std::ranges::count(contacts[0], ','), std::ranges::count(contacts[1], ','));
  const auto on_floor = std::ranges::find(events, 13, &ContactEvent::b);
  ASSERT_NE(on_floor, events.end());
  EXPECT_THAT(contacts[1 + (on_floor - events.begin())], HasSubstr(",floor,"));
  EXPECT_EQ(lines_of(directory_ / "csv" / "compressive_loads.csv").size(), 14u);
  const BoundaryLoads floor = boundary_loads(recording).at(0);
  const auto triangles = lines_of(directory_ / "csv" / "boundary_maps.csv");
  EXPECT_EQ(triangles.size(), 1 + floor.end.size() * floor.area.size());
  EXPECT_THAT(triangles[0], HasSubstr("wear_depth [m]"));
  EXPECT_EQ(lines_of(directory_ / "csv" / "particle_maps.csv").size(),
            1 + surface_loads(recording).at(0).mesh.triangles.size());
  EXPECT_EQ(lines_of(directory_ / "csv" / "energy_spectrum.csv").size(), 1u + 3 * 42);

  export_vtk(recording, (directory_ / "vtk").string(), {1000, false});
  EXPECT_EQ(lines_of(directory_ / "vtk" / "boundary_loads.pvd").size(), floor.end.size() + 5);
  const auto surface = lines_of(directory_ / "vtk" / "surface_cube.vtp");
  EXPECT_TRUE(std::ranges::any_of(surface, [](const std::string& line) {
    return line.find("Name=\"peak_normal_force\"") != line.npos;
  }));
}

}  // namespace
}  // namespace firn
