// firn contacts and firn compare-traces, end to end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Exit status 2, nothing on standard output, one line on standard error.
void expect_one_line(const Outcome& o, const std::string& about) {
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr(about));
}

// Two boxes that have come to rest on each other, and their results file.
class ContactsCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("case.toml", two_boxes);
    const Outcome o = folder_.firn({"run", "case.toml", "-o", "run.h5", "-q", "--set",
                                    "case.duration=0.4s", "--set", "output.state_interval=0.1s"});
    ASSERT_EQ(o.status, 0) << o.err;
  }
  Outcome contacts(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "contacts");
    return folder_.firn(arguments);
  }
  Folder folder_;
};

TEST_F(ContactsCommand, ParticleAtRestIsHeldByItsNeighbors) {
  const Outcome o = contacts({"run.h5", "--particle", "0", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("came out the same, bit for bit"));
  EXPECT_THAT(o.err, HasSubstr("replayed from 0.39"));  // the state kept last
  const json audit = json::parse(o.out);
  EXPECT_EQ(audit["body"], 0);
  ASSERT_EQ(audit["contacts"].size(), 2U);
  EXPECT_EQ(audit["contacts"][0]["neighbor"], 1);
  EXPECT_EQ(audit["contacts"][1]["neighbor"], "floor");
  const double weight = 916.7 * 8e-6 * 9.81;
  double up = 0;  // N
  for (const json& c : audit["contacts"]) {
    up += c["force"][2].get<double>();
    double sum = 0;
    for (const json& p : c["points"]) sum += p["force"].get<double>();
    EXPECT_NEAR(sum, c["normal_force"], 1e-12);
  }
  const json& balance = audit["balance"];
  EXPECT_NEAR(up, balance["contact_force"][2], 1e-12);
  EXPECT_NEAR(balance["weight"][2], -weight, 1e-12);
  EXPECT_LT(audit["balance"]["force_error"], 1e-12);
  EXPECT_LT(audit["balance"]["moment_error"], 1e-12);
}

// The boxes ring on their springs (unloading and loading again go along one line), but on average
// the lower one bears the upper one, and the floor both: to m dv / T, some 1e-4 N.
TEST_F(ContactsCommand, MeanForceIsTheWeight) {
  const double weight = 916.7 * 8e-6 * 9.81;
  const std::pair<std::vector<std::string>, double> pairs[] = {{{"1", "0"}, weight},
                                                               {{"0", "floor"}, 2 * weight}};
  for (const auto& [pair, expected] : pairs) {
    const Outcome o = contacts({"run.h5", "--pair", pair[0], pair[1], "--history", "0.3s", "0.4s",
                                "--every", "1", "--json"});
    ASSERT_EQ(o.status, 0) << o.err;
    const json rows = json::parse(o.out)["rows"];
    double sum = 0;
    for (const json& row : rows) sum += row["force"][2].get<double>();
    EXPECT_NEAR(sum / static_cast<double>(rows.size()), expected, 3e-3 * expected);
  }
}

TEST_F(ContactsCommand, TextStatesTheSame) {
  const Outcome o = contacts({"run.h5", "--pair", "floor", "0", "-q"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err, "");
  EXPECT_THAT(o.out, HasSubstr("floor and particle 0"));
  EXPECT_THAT(o.out, HasSubstr("sticks: friction"));
  EXPECT_THAT(o.out, HasSubstr("4 points"));
  const Outcome whole = contacts({"run.h5"});
  EXPECT_THAT(whole.out, HasSubstr("2 pairs touch in 2 patches"));
  const Outcome particle = contacts({"run.h5", "--particle", "1"});
  EXPECT_THAT(particle.out, HasSubstr("mass x acceleration over the next step"));
}

// The same instant of the case, of the run, and by its number of steps.
TEST_F(ContactsCommand, CaseAndRunAgree) {
  const Outcome run = contacts({"run.h5", "--time", "30 ms", "--json"});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string step = std::to_string(json::parse(run.out)["step"].get<int>());
  const Outcome text = contacts({"case.toml", "--time", "30ms", "--json", "--threads", "2"});
  EXPECT_EQ(run.out, text.out);
  EXPECT_EQ(run.out, contacts({"run.h5", "--step", step, "--json"}).out);
}

TEST_F(ContactsCommand, HistoryStatesBirthsAndWork) {
  const Outcome o = contacts(
      {"run.h5", "--pair", "1", "0", "--history", "0s", "100ms", "--every", "10", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json history = json::parse(o.out);
  ASSERT_FALSE(history["events"].empty());
  EXPECT_EQ(history["events"][0]["before"], 0);
  EXPECT_EQ(history["rows"][1]["step"], 10);
  EXPECT_EQ(history["rows"][0]["gap"], nullptr);  // no other body is near
  EXPECT_GT(history["rows"].back()["work_normal"], 0.0);
  const Outcome table =
      contacts({"run.h5", "--particle", "1", "--history", "0s", "100ms", "-o", "h.csv"});
  ASSERT_EQ(table.status, 0) << table.err;
  EXPECT_GT(lines(read_text(folder_.path() / "h.csv")), 200U);
}

TEST_F(ContactsCommand, WritesPictureAndTable) {
  ASSERT_EQ(contacts({"run.h5", "--particle", "0", "-o", "audit"}).status, 0);
  EXPECT_GT(std::filesystem::file_size(folder_.path() / "audit/contacts.png"), 10000U);
  EXPECT_EQ(lines(read_text(folder_.path() / "audit/contacts.csv")), 9U);  // 8 points
  const std::string points = read_text(folder_.path() / "audit/contacts.vtp");
  EXPECT_THAT(points, HasSubstr("NumberOfPoints=\"8\" NumberOfVerts=\"8\""));
  EXPECT_THAT(points, HasSubstr("Name=\"force\" NumberOfComponents=\"3\""));
  // Of each point: place, vertex, end of the vertex, 2 vectors and 8 numbers; 13 blocks.
  const std::size_t data = points.find("\n_") + 2, tail = points.rfind("\n</AppendedData>");
  EXPECT_EQ(tail - data, 13U * 8U + 8U * (12U + 4U + 4U + 2U * 12U + 8U * 4U));
  ASSERT_EQ(contacts({"run.h5", "-o", "all"}).status, 0);
  EXPECT_FALSE(folder_.contains("all/contacts.png"));
  EXPECT_EQ(lines(read_text(folder_.path() / "all/contacts.csv")), 9U);
  const Outcome o =
      contacts({"run.h5", "--pair", "0", "1", "--history", "0s", "0.1s", "-o", "h.svg"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(read_text(folder_.path() / "h.svg"), HasSubstr("deepest overlap"));
}

TEST_F(ContactsCommand, MistakesAreOneLine) {
  using Words = std::vector<std::string>;
  const std::pair<Words, std::string> mistakes[] = {
      {{"run.h5", "--particle", "2"}, "--particle 2: no such body; expected a particle 0 ... 1"},
      {{"run.h5", "--particle", "floor"}, "expected a particle's id"},
      {{"run.h5", "--pair", "0", "flor"}, "or a boundary, \"floor\""},
      {{"run.h5", "--pair", "0", "0"}, "cannot touch each other"},
      {{"run.h5", "--time", "3 s"}, "--time 3 s: is outside the run"},
      {{"run.h5", "--time", "3"}, "--time 3"},
      {{"run.h5", "--time", "-1ms"}, "--time"},
      {{"run.h5", "--step", "99999999"}, "--step 99999999: is outside the run"},
      {{"case.toml", "--time", "1 s"}, "is outside the run"},
      {{"run.h5", "--time", "1ms", "--step", "3"}, "--time"},
      {{"run.h5", "--particle", "0", "--pair", "0", "1"}, "--particle"},
      {{"run.h5", "--history", "0s", "1ms"}, "--history: needs a body"},
      {{"run.h5", "--particle", "0", "--every", "5"}, "--every"},
      {{"run.h5", "--particle", "0", "--history", "2ms", "1ms"}, "ends before it begins"},
      {{"run.h5", "--set", "case.seed=3"}, "--set"},
      {{"run.h5", "-o", "all.png"}, "expected --particle or --pair"},
      {{"run.h5", "--particle", "0", "-o", "a.gif"}, "a.gif"},
      {{"nowhere.h5"}, "nowhere.h5"},
      {{"nowhere.toml"}, "nowhere.toml"},
  };
  for (const auto& [arguments, about] : mistakes) {
    SCOPED_TRACE(about);
    expect_one_line(contacts(arguments), about);
  }
}

TEST_F(ContactsCommand, ParticleThatIsStillToComeIsAMistake) {
  folder_.write("fill.toml", std::string(two_boxes) + R"(
[[fills]]
shape = "cube"
count = 1
start = "40 ms"
region_min = "-0.1 -0.1 0.2 m"
region_max = "0.1 0.1 0.3 m"
)");
  expect_one_line(contacts({"fill.toml", "--particle", "2", "--time", "20ms"}),
                  "--particle 2: is not there at 0.0");
  // The results file knows it before anything is simulated again.
  ASSERT_EQ(folder_.firn({"run", "fill.toml", "-o", "fill.h5", "-q"}).status, 0);
  expect_one_line(contacts({"fill.h5", "--particle", "2", "--time", "20ms"}), "it comes at 0.0400");
}

TEST_F(ContactsCommand, TracesOfTwoThreadCountsAreEqual) {
  for (const std::string threads : {"1", "3"}) {
    ASSERT_EQ(folder_
                  .firn({"run", "case.toml", "-o", "t.h5", "-q", "--threads", threads,
                         "--trace-hashes", "trace" + threads})
                  .status,
              0);
  }
  const Outcome equal = folder_.firn({"compare-traces", "trace1", "trace3"});
  EXPECT_EQ(equal.status, 0) << equal.out;
  EXPECT_THAT(equal.out, HasSubstr("equal: "));
}

TEST_F(ContactsCommand, TracesShowTheFirstDifference) {
  ASSERT_EQ(folder_
                .firn({"run", "case.toml", "-o", "t.h5", "-q", "--trace-hashes", "a",
                       "--trace-numbers", "0:10"})
                .status,
            0);
  ASSERT_EQ(folder_
                .firn({"run", "case.toml", "-o", "t.h5", "-q", "--trace-hashes", "b",
                       "--trace-numbers", "0", "--set", "particles.1.velocity=1e-12 0 0 m/s"})
                .status,
            0);
  const Outcome o = folder_.firn({"compare-traces", "a", "b", "--json"});
  EXPECT_EQ(o.status, 1) << o.err;
  const json difference = json::parse(o.out);
  EXPECT_EQ(difference["same_case"], false);
  EXPECT_EQ(difference["first_difference"]["step"], 0);
  EXPECT_THAT(difference["first_difference"]["numbers"][0].get<std::string>(),
              HasSubstr("particle 1: velocity_x 0 against "));
  EXPECT_THAT(folder_.firn({"compare-traces", "a", "b"}).out,
              HasSubstr("first difference at step 0"));
  expect_one_line(folder_.firn({"compare-traces", "a", "case.toml"}),
                  "case.toml:1: is not a trace");
  expect_one_line(
      folder_.firn({"run", "case.toml", "--trace-hashes", "c", "--trace-numbers", "5:3"}),
      "--trace-numbers 5:3");
  expect_one_line(folder_.firn({"run", "case.toml", "--trace-numbers", "5"}), "--trace-hashes");
}

}  // namespace
}  // namespace firn::cli
