// Real runs, end to end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "experiments/results/results_file.h"
#include "experiments/text/number_text.h"
#include "tests/app/program.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(RunCommand, TwoBoxesEndToEnd) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const Outcome o = folder.firn(
      {"run", "case.toml", "--json", "--seed", "7", "--set", "case.duration=\"30 ms\""});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  EXPECT_EQ(result["status"], "finished");
  EXPECT_EQ(result["results_file"], "runs/two-boxes-seed7.h5");
  EXPECT_EQ(result["particles"], 2);
  EXPECT_NEAR(result["simulated"], 0.03, 1e-4);
  EXPECT_GT(result["diagnostics"]["largest_overlap"], 0.0);
  EXPECT_THAT(o.err, HasSubstr("cube: box, 20.00 x 20.00 x 20.00 mm, 7.33 g"));
  EXPECT_THAT(o.err, HasSubstr("time step"));
  const int late = result["diagnostics"]["late_contacts"];
  EXPECT_THAT(o.err, HasSubstr("), " + std::to_string(late) +
                               (late == 1 ? " late contact, " : " late contacts, ")));

  const Recording recording((folder.path() / "runs/two-boxes-seed7.h5").string());
  EXPECT_EQ(recording.status(), "finished");
  EXPECT_EQ(recording.seed(), 7U);
  // Both boxes have fallen 2 mm and lie on each other: 10 and 30 mm, less the elastic overlap.
  const Frame last = recording.frame(recording.frame_times().size() - 1);
  EXPECT_NEAR(last.position[0][2], 0.010, 2e-4);
}

// Nothing is printed before the line that says what is wrong, and no results file is made.
TEST(RunCommand, RefusesBadInputInOneLine) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  folder.write("notes.txt", "kept");
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", "case.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = folder.firn(arguments);
    EXPECT_EQ(o.status, 2);
    EXPECT_EQ(lines(o.err), 1U) << o.err;
    EXPECT_EQ(o.out, "");
    EXPECT_FALSE(folder.contains("a.h5"));
    return o.err;
  };
  EXPECT_THAT(refused({"-o", "case.toml"}), HasSubstr("case.toml: exists and is not a results"));
  EXPECT_THAT(refused({"-o", "notes.txt"}), HasSubstr("notes.txt: exists and is not a results"));
  EXPECT_EQ(read_text(folder.path() / "notes.txt"), "kept");
  EXPECT_THAT(refused({"-o", "a.h5", "--set", "particles.1.position=\"0 0 12 mm\""}),
              HasSubstr("particle 1 lies more than 1 mm inside particle 0; expected a free place"));
}

TEST(RunCommand, QuietRunPrintsOnlyResults) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const Outcome o = folder.firn({"run", "case.toml", "-o", "a.h5", "--quiet"});
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.err, "");
}

TEST(RunCommand, WarnsInOneLineOfPartsThatDeviate) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const auto run = [&](const std::string& rounding) {
    return folder.firn({"run", "case.toml", "-o", "a.h5", "--quiet", "--set",
                        "shapes.cube.rounding=\"" + rounding + "\"", "--set",
                        "case.duration=\"1 ms\""});
  };
  EXPECT_EQ(run("0.2 mm").err, "");
  const Outcome rounded = run("2 mm");
  EXPECT_EQ(rounded.status, 0);
  EXPECT_EQ(lines(rounded.err), 1U) << rounded.err;
  EXPECT_THAT(rounded.err, HasSubstr("shape cube: the contact parts deviate by "));
}

TEST(RunCommand, NamesTheLikelyCauseOfDeepOverlapsAtItsEnd) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const auto run = [&](const std::string& key_and_value) {
    return folder.firn(
        {"run", "case.toml", "-o", "a.h5", "--quiet", "--json", "--set", key_and_value});
  };
  const Outcome soft = run("materials.ice.young_modulus=\"2 kPa\"");
  EXPECT_EQ(soft.status, 0) << soft.err;
  EXPECT_EQ(lines(soft.err), 1U) << soft.err;
  EXPECT_THAT(soft.err, HasSubstr("likely cause: the stiffness"));
  const std::string warning = nlohmann::json::parse(soft.out)["diagnostics"]["warning"];
  EXPECT_THAT(warning, HasSubstr("likely cause: the stiffness"));
  const Outcome good = run("case.duration=\"50 ms\"");
  EXPECT_EQ(good.err, "");
  EXPECT_EQ(nlohmann::json::parse(good.out)["diagnostics"]["warning"], "");
}

// A motor without max_load turns a link slowly against the friction of a pin.
TEST(RunCommand, WarnsOfJointsThatDoNotConvergeAtItsEnd) {
  const Folder folder;
  folder.write("case.toml", std::string(two_boxes) + R"(
[[motion_frames]]
name = "link"
position = "0 0 0.5 m"
[motion_frames.free]
mass = "0.3 kg"
center = "0.1 0 0.5 m"
inertia = "1e-3 1e-3 1e-3 kg m^2"
joints = [{ kind = "rotation", direction = [0, 1, 0], motors = [{ speed = "1e-3 rad/s" }] }]
[[couplings]]
name = "pin"
kind = "ball"
between = ["world", "link"]
position = "0 0 0.5 m"
direction = [0, 1, 0]
friction = "1 N m"
)");
  const auto run = [&](const std::string& friction) {
    return folder.firn({"run", "case.toml", "-o", "a.h5", "--quiet", "--json", "--set",
                        "case.duration=\"4 ms\"", "--set",
                        "couplings.pin.friction=\"" + friction + "\""});
  };
  const Outcome good = run("1 N m");
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(good.err, "");
  EXPECT_EQ(json::parse(good.out)["diagnostics"]["unconverged_steps"], 0);
  const Outcome bad = run("1e12 N m");
  EXPECT_EQ(bad.status, 0) << bad.err;
  EXPECT_EQ(lines(bad.err), 1U) << bad.err;
  EXPECT_THAT(bad.err, HasSubstr("did not converge in "));
  const json result = json::parse(bad.out);
  EXPECT_EQ(result["diagnostics"]["unconverged_steps"], result["steps"]);
  EXPECT_THAT(std::string(result["diagnostics"]["warning"]), HasSubstr("likely cause: a motor"));
}

TEST(RunCommand, EarlierResultsAreKept) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "a.h5"}).status, 0);
  const Outcome again = folder.firn({"run", "case.toml", "-o", "a.h5"});
  ASSERT_EQ(again.status, 0);
  EXPECT_TRUE(folder.contains("a.1.h5"));
  EXPECT_THAT(again.err, HasSubstr("a.1.h5"));
}

TEST(RunCommand, TruncatedResultsFileIsRefused) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "a.h5"}).status, 0);
  const auto file = folder.path() / "a.h5";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"measure", "a.h5"}, {"run", "--resume", "a.h5"}}) {
    const Outcome o = folder.firn(arguments);
    EXPECT_EQ(o.status, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(lines(o.err), 1U) << o.err;
    EXPECT_THAT(o.err, HasSubstr("a.h5"));
  }
}

TEST(RunCommand, ExportsTables) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "a.h5"}).status, 0);
  ASSERT_EQ(folder.firn({"export", "a.h5", "--to", "csv"}).status, 0);
  // A header and two particles.
  EXPECT_EQ(lines(read_text(folder.path() / "a-csv" / "particles.csv")), 3U);
  ASSERT_EQ(folder.firn({"export", "a.h5", "--to", "vtk", "-o", "view"}).status, 0);
  EXPECT_TRUE(folder.contains("view/particles.pvd"));
}

TEST(RunCommand, RequirementsDecideTheStatus) {
  const Folder folder;
  folder.write("case.toml", small_drain);
  const Outcome met = folder.firn({"run", "case.toml", "-o", "a.h5", "--json", "--require",
                                   "discharged_count>=1", "--require", "discharged_count <= 29"});
  ASSERT_EQ(met.status, 0) << met.err;
  const json result = json::parse(met.out);
  const double count = result["responses"]["discharged_count"]["value"];
  EXPECT_EQ(result["requirements"][0]["met"], true);

  const Outcome missed = folder.firn({"measure", "a.h5", "--response", "discharged_count", "--json",
                                      "--require", "discharged_count>30"});
  EXPECT_EQ(missed.status, 3);
  const json measured = json::parse(missed.out);
  EXPECT_EQ(measured["responses"].size(), 1U);
  EXPECT_EQ(measured["responses"]["discharged_count"]["value"], count);
  EXPECT_EQ(measured["requirements"][0]["met"], false);

  const Outcome unknown = folder.firn({"measure", "a.h5", "--require", "angle_of_rest<=3"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("angle_of_rest: no such response"));

  const Outcome old = folder.firn({"measure", "a.h5", "--require", "covered_fraction_left<=2"});
  EXPECT_EQ(old.status, 0) << old.err;
  EXPECT_THAT(old.err, HasSubstr("\"covered_fraction_left\" is now \"window_coverage_left\""));
}

// Tables show 0 below the resolution of the unit, JSON all digits.
TEST(RunCommand, TablesShowZeroForRoundingAlone) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  int zeros = 0;
  for (const std::string gravity : {"1e-13", "3e-11", "1e-9", "2e-7", "1e-4", "1"}) {
    const std::string file = "g" + gravity + ".h5";
    const Outcome run = folder.firn({"run", "case.toml", "-o", file, "--quiet", "--set",
                                     "case.gravity=\"0 0 -" + gravity + " m/s^2\""});
    ASSERT_EQ(run.status, 0) << run.err;
    const json measured = json::parse(folder.firn({"measure", file, "--json"}).out);
    const double energy = measured["responses"]["kinetic_energy_end"]["value"];
    EXPECT_GT(energy, 0) << gravity;
    std::istringstream table(folder.firn({"measure", file}).out);
    std::string shown;
    for (std::string line; std::getline(table, line);) {
      std::istringstream words(line);
      std::string name, value;
      if (words >> name >> value && name == "kinetic_energy_end") shown = value;
    }
    EXPECT_EQ(shown, number_text(resolved(energy, "J"))) << gravity;
    zeros += shown == "0";
  }
  EXPECT_GE(zeros, 1);
  EXPECT_LE(zeros, 5);
}

// The first column of each line.
std::vector<std::string> first_words(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    words.push_back(line.substr(0, line.find(' ')));
  return words;
}

// Sensors at random heights: each has many responses, and nothing passes some of them.
TEST(RunCommand, LongTablesEndWithTheMainResults) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> height(-0.01, 0.03);
  const Folder folder;
  for (const int sensors : {0, 1, 2, 4, 7}) {
    std::string text = two_boxes;
    for (int i = 0; i < sensors; ++i)
      text += "[[sensors]]\nname = \"s" + std::to_string(i) + "\"\npoint = \"0 0 " +
              std::to_string(i == 0 ? 0.0115 : height(random)) + " m\"\nnormal = [0, 0, -1]\n";
    folder.write("case.toml", text);
    const Outcome run = folder.firn({"run", "case.toml", "-o", "run.h5", "--quiet"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(folder.firn({"measure", "run.h5"}).out, run.out);
    const json measured = json::parse(folder.firn({"measure", "run.h5", "--json"}).out);
    std::vector<std::string> rows = first_words(run.out);
    const std::size_t all = measured["responses"].size();
    ASSERT_GE(rows.size(), all);
    const std::vector<std::string> rest(rows.begin() + static_cast<std::ptrdiff_t>(all),
                                        rows.end());
    rows.resize(all);
    for (const std::string& row : rows) EXPECT_TRUE(measured["responses"].contains(row)) << row;
    if (sensors > 0) {
      EXPECT_EQ(rows[0], "s0_count");
    }
    if (all <= 25) {
      EXPECT_TRUE(rest.empty()) << sensors;
      continue;
    }
    ASSERT_GE(rest.size(), 3u) << sensors;
    EXPECT_LE(rest.size(), 8u);
    EXPECT_EQ(rest[0], "");
    EXPECT_EQ(rest[1], "Main");
    for (std::size_t i = 2; i < rest.size(); ++i) EXPECT_EQ(rest[i], rows[i - 2]);
    // A response that is asked for by name is all that is printed.
    EXPECT_THAT(first_words(folder.firn({"measure", "run.h5", "--response", "present_mass"}).out),
                testing::ElementsAre("present_mass"));
  }
}

TEST(RunCommand, InterruptedRunIsSavedAndGoesOn) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  // A million steps: seconds, so that it cannot end before it is interrupted.
  const pid_t pid = folder.start({"run", "case.toml", "--json", "-o", "a.h5", "--set",
                                  "case.duration=30s", "--set", "output.frame_interval=1s"});
  while (!folder.contains("a.h5")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  kill(pid, SIGINT);
  const Outcome stopped = folder.wait(pid);
  ASSERT_EQ(stopped.status, 130) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("firn run --resume a.h5"));
  const json interrupted = json::parse(stopped.out);
  EXPECT_EQ(interrupted["status"], "interrupted");
  EXPECT_LT(interrupted["simulated"], 29);

  const Outcome resumed = folder.firn({"run", "--resume", "a.h5", "--json"});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  const json finished = json::parse(resumed.out);
  EXPECT_EQ(finished["status"], "finished");
  EXPECT_NEAR(finished["simulated"], 30, 1e-3);
  EXPECT_GT(finished["steps"], interrupted["steps"]);
}

// A run that is finished has nothing left to do, and says again what it found.
TEST(RunCommand, ResumingAFinishedRunPrintsItsResponses) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const Outcome first = folder.firn({"run", "case.toml", "-o", "a.h5", "--json"});
  ASSERT_EQ(first.status, 0) << first.err;
  const Outcome again = folder.firn({"run", "--resume", "a.h5", "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(json::parse(again.out)["responses"], json::parse(first.out)["responses"]);
}

// As on a full disk: the file cannot grow beyond a limit.
TEST(RunCommand, FullDiskIsAFailureThatSaysSo) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100 * 1024, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Outcome o = folder.firn({"run", "case.toml", "-o", "run.h5", "-q"});
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(o.status, 1) << o.err;
  EXPECT_THAT(o.err, HasSubstr("run.h5: cannot write: File too large"));
}

}  // namespace
}  // namespace firn::cli
