// Ctrl-C and SIGTERM end the program within two seconds, whatever it is doing, and leave no
// temporary files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <thread>

#include "tests/app/program.h"
#include "tests/app/robustness/hostile_inputs.h"

namespace firn::cli {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;
using testing::AnyOf;
using testing::HasSubstr;

// s. The thread sanitizer makes a program about ten times slower.
#ifdef __SANITIZE_THREAD__
constexpr double kLimit = 20;
#else
constexpr double kLimit = 2;
#endif

class Interrupt : public testing::Test {
 protected:
  Interrupt() {
    std::filesystem::create_directory(folder_.path() / "tmp");
    setenv("TMPDIR", (folder_.path() / "tmp").c_str(), 1);
    const std::string base = hostile::rich_case;
    folder_.write("case.toml", base);
    folder_.write("study.toml", hostile::study_file);
    folder_.write("suite.toml", hostile::suite_file);
    folder_.write("mass.toml", hostile::mass_file);
    folder_.write("claims.toml", hostile::claims_file);
  }
  ~Interrupt() override { unsetenv("TMPDIR"); }

  // Starts a command, signals it after some seconds, and checks how it ends.
  Outcome interrupt(const std::vector<std::string>& command, double after, int signal,
                    bool must_be_at_work = true) {
    SCOPED_TRACE(command[0] + " " + command[1] + " after " + std::to_string(after) + " s");
    const pid_t pid = folder_.start(command);
    std::this_thread::sleep_for(duration<double>(after));
    kill(pid, signal);
    const auto signaled = steady_clock::now();
    const Outcome o = folder_.wait(pid);
    const double seconds = duration<double>(steady_clock::now() - signaled).count();
    EXPECT_LT(seconds, kLimit);
    if (must_be_at_work) {
      EXPECT_EQ(o.status, 130) << o.err;
    } else {
      EXPECT_THAT(o.status, AnyOf(130, 0, 128 + signal)) << o.err;  // before main(), the last
    }
    const bool before_main = signal == SIGINT && o.err.empty();  // 130 is its usual effect, too
    if (o.status == 130 && (must_be_at_work || !before_main)) {
      EXPECT_THAT(o.err + o.out, HasSubstr("interrupted"));
    }
    for (const auto& left : std::filesystem::directory_iterator(folder_.path() / "tmp"))
      ADD_FAILURE() << left.path();
    return o;
  }

  Folder folder_;
};

// Tens of thousands of tables are read in seconds.
TEST_F(Interrupt, WhileACaseIsRead) {
  std::string text = hostile::rich_case;
  for (int i = 0; i < 90000; ++i)
    text += "[[particles]]\nshape = \"cube\"\nposition = \"0 0 " + std::to_string(i + 1) + " m\"\n";
  folder_.write("many.toml", text);
  for (const double after : {0.05, 0.2, 0.5})
    interrupt({"run", "many.toml", "-o", "many.h5"}, after, SIGTERM, false);
}

// A ball with many dents is cut into parts for minutes.
TEST_F(Interrupt, WhileAMeshIsDecomposed) {
  std::string obj;
  constexpr int kRows = 70, kColumns = 140;
  for (int i = 0; i <= kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      const double a = std::numbers::pi * i / kRows, b = 2 * std::numbers::pi * j / kColumns;
      const double r = 10 + std::sin(9 * a) * std::sin(9 * b) * std::sin(a);
      obj += "v " + std::to_string(r * std::sin(a) * std::cos(b)) + " " +
             std::to_string(r * std::sin(a) * std::sin(b)) + " " + std::to_string(r * std::cos(a)) +
             "\n";
    }
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      const int a = i * kColumns + j + 1, b = i * kColumns + (j + 1) % kColumns + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(a + kColumns) + " " +
             std::to_string(b) + "\nf " + std::to_string(b) + " " + std::to_string(a + kColumns) +
             " " + std::to_string(b + kColumns) + "\n";
    }
  folder_.write("ball.obj", obj);
  interrupt({"shape", "ball.obj", "--length-unit", "mm"}, 0.5, SIGINT);
}

std::string filled(const char* base, int count) {
  return std::string(base) + "\n[[fills]]\nshape = \"cube\"\ncount = " + std::to_string(count) +
         "\nregion_min = \"-3 -3 1 m\"\nregion_max = \"3 3 7 m\"\n";
}

// Nothing was simulated: the results file has its first checkpoint, or is not there.
TEST_F(Interrupt, WhileBodiesArePlaced) {
  folder_.write("fill.toml", filled(hostile::rich_case, 1000000));
  for (const double after : {0.3, 2.0, 6.0}) {
    const Outcome o = interrupt({"run", "fill.toml", "-o", "fill.h5"}, after, SIGTERM);
    EXPECT_EQ(folder_.contains("fill.h5"), o.err.find("--resume") != o.err.npos) << o.err;
    std::filesystem::remove(folder_.path() / "fill.h5");
  }
}

TEST_F(Interrupt, WhileASweepIsPlanned) {
  std::string sweep =
      "[sweep]\nname = \"many\"\ncase = \"case.toml\"\nresponses = [\"present_mass\"]\nseeds = "
      "9000\n";
  folder_.write("sweep.toml", sweep);
  interrupt({"sweep", "sweep.toml"}, 0.5, SIGINT);
}

// Reading, simulating, fitting, drawing, writing the page: at any moment.
TEST_F(Interrupt, AtAnyMomentOfStudiesValidationsAndPages) {
  std::mt19937_64 random(5);
  const auto moment = [&](double most) {
    return std::uniform_real_distribution<double>(0.01, most)(random);
  };
  for (int i = 0; i < 6; ++i) {
    const int signal = i % 2 ? SIGINT : SIGTERM;
    interrupt({"calibrate", "study.toml", "-o", "study"}, moment(3), signal, false);
    interrupt({"validate", "suite.toml", "-o", "suite"}, moment(2), signal, false);
    interrupt({"shape", "case.toml", "--picture", "scene.png"}, moment(0.5), signal, false);
  }
  ASSERT_EQ(folder_.firn({"calibrate", "study.toml", "-o", "study"}).status, 0);
  for (int i = 0; i < 6; ++i)
    interrupt({"report", "study"}, moment(0.5), i % 2 ? SIGINT : SIGTERM, false);
  EXPECT_FALSE(folder_.contains("study/report.html.writing"));
}

TEST_F(Interrupt, WhileTheProgramIsVerified) { interrupt({"verify", "--json"}, 0.5, SIGTERM); }

}  // namespace
}  // namespace firn::cli
