// The real program, killed and starved at any moment: the study continues to the same answer.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "experiments/results/results_file.h"
#include "experiments/results/results_lock.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using testing::HasSubstr;

const char* const balls = R"([case]
name = "balls"
duration = "0.15 s"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
young_modulus = "2 GPa"
[interactions.ice-ice]
static_friction = 0.1
dynamic_friction = 0.1
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.3
dynamic_friction = 0.3
restitution = 0.3
[shapes.ball]
kind = "sphere"
radius = "10 mm"
material = "ice"
[[fills]]
shape = "ball"
count = 3
region_min = "-30 -30 20 mm"
region_max = "30 30 60 mm"
[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
point = "0 0 0 m"
normal = [0, 0, 1]
[output]
frame_interval = "5 ms"
)";

std::string crash_study_text(int design_points, int replicates_per_point, int refine_rounds,
                             int confirmation_replicates) {
  return "[study]\nname = \"balls\"\ncase = \"balls.toml\"\n[budget]\ncenter_replicates = 2\n"
         "design_points = " +
         std::to_string(design_points) +
         "\nreplicates_per_point = " + std::to_string(replicates_per_point) +
         "\nrefine_rounds = " + std::to_string(refine_rounds) +
         "\nrefine_points = 2\nconfirmation_replicates = " +
         std::to_string(confirmation_replicates) +
         "\n[[parameters]]\nname = \"bounce\"\n"
         "keys = [\"interactions.ice-plastic.restitution\"]\nmin = 0.1\nmax = 0.9\n"
         "[[targets]]\nresponse = \"peak_normal_force\"\nvalue = \"6.5 N\"\n"
         "uncertainty = \"0.3 N\"\n";
}

class KillTest : public testing::Test {
 protected:
  void SetUp() override { folder_.write("balls.toml", balls); }

  // firn calibrate in the background; its standard error goes to `err`. `prepare` runs in the
  // child.
  pid_t start(const std::string& directory, const std::function<void()>& prepare = {}) const {
    const std::string err = folder_ / "err", out = folder_ / "out";
    const std::vector<std::string> args = {
        FIRN_PROGRAM, "calibrate", folder_ / "study.toml", "-o",  folder_ / directory, "--no-cache",
        "--jobs",     "2",         "--progress",           "none"};
    std::vector<char*> argv;
    for (const std::string& a : args) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const pid_t pid = fork();
    if (pid != 0) return pid;
    if (!std::freopen(err.c_str(), "w", stderr) || !std::freopen(out.c_str(), "w", stdout))
      _exit(98);
    if (prepare) prepare();
    execv(argv[0], argv.data());
    _exit(99);
  }
  // Exit status; -1 when it was killed.
  static int wait(pid_t pid) {
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int run(const std::string& directory, const std::function<void()>& prepare = {}) const {
    return wait(start(directory, prepare));
  }
  std::string err() const { return read_text(folder_ / "err"); }

  // What was found, but for the time that it took.
  ordered_json results(const std::string& directory) const {
    ordered_json j = ordered_json::parse(read_text(folder_ / (directory + "/results.json")));
    j.erase("wall_seconds");
    return j;
  }
  std::set<std::string> runs(const std::string& directory) const {
    std::set<std::string> keys;
    std::ifstream csv(folder_ / (directory + "/runs.csv"));
    for (std::string line; std::getline(csv, line);) keys.insert(line.substr(0, line.find(',')));
    return keys;
  }
  // Runs inherit the lock of their study, and give it back when they are gone.
  void wait_until_no_process_writes(const std::string& directory) const {
    const int lock = open((folder_ / (directory + "/lock")).c_str(), O_RDWR | O_CLOEXEC);
    if (lock < 0) return;  // killed before there was one
    flock(lock, LOCK_EX);
    close(lock);
  }
  // Results files of runs that have come to their end, and when they were written last.
  std::map<std::string, fs::file_time_type> finished(const std::string& directory) const {
    std::map<std::string, fs::file_time_type> files;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder_ / (directory + "/runs"), none)) {
      if (entry.path().extension() != ".h5") continue;
      // The copy goes last of all: with it there, the run was killed before it had come to its end.
      if (has_saved_copy(entry.path().string())) continue;
      try {
        const Recording recording(entry.path().string());
        if (recording.status() == "finished" && !recording.responses().empty())
          files[entry.path().string()] = fs::last_write_time(entry.path());
      } catch (const InputError&) {
        // Under way when it was killed.
      }
    }
    return files;
  }

  void kill_and_resume(int kills, unsigned seed) {
    ASSERT_EQ(run("whole"), 0) << err();
    std::mt19937 random(seed);
    std::map<std::string, fs::file_time_type> known;
    int killed = 0;
    while (killed < kills) {
      const pid_t pid = start("killed");
      std::this_thread::sleep_for(std::chrono::milliseconds(5 + random() % 400));
      std::vector<pid_t> victims = {pid};
      std::ifstream children("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) +
                             "/children");
      if (killed % 2 == 0)  // its runs, too; else they find themselves without a parent
        for (pid_t child; children >> child;) victims.push_back(child);
      for (const pid_t victim : victims) kill(victim, SIGKILL);
      if (wait(pid) != -1) break;  // it came to its end
      ++killed;
      for (const auto& [file, written] : known)
        EXPECT_EQ(fs::last_write_time(file), written) << "a finished run was repeated: " << file;
      if (killed % 2 == 0) continue;  // the next session meets what still saves its state
      wait_until_no_process_writes("killed");
      known = finished("killed");
    }
    EXPECT_GT(killed, kills / 2);
    ASSERT_EQ(run("killed"), 0) << err();
    EXPECT_EQ(results("killed"), results("whole"));
    EXPECT_EQ(runs("killed"), runs("whole"));
    for (const auto& [file, written] : known)
      EXPECT_EQ(fs::last_write_time(file), written) << "a finished run was repeated: " << file;
  }

  Folder folder_{"killed"};
};
using KillTestLong = KillTest;

TEST_F(KillTest, KilledAFewTimesItReachesTheSameAnswer) {
  folder_.write("study.toml", crash_study_text(3, 1, 0, 2));
  kill_and_resume(3, 1);
}

TEST_F(KillTestLong, KilledManyTimesItReachesTheSameAnswer) {
  folder_.write("study.toml", crash_study_text(12, 3, 2, 6));
  for (unsigned seed = 1; seed <= 4; ++seed) {
    kill_and_resume(40, seed);
    fs::remove_all(folder_ / "whole");
    fs::remove_all(folder_ / "killed");
  }
}

// Lines for a failure. A results file that was cut short before has one, too: it is renamed.
int failures(const std::string& said) {
  std::istringstream lines(said);
  int count = 0;
  for (std::string line; std::getline(lines, line);)
    count += line.find("; renamed to ") == line.npos ? 1 : 0;
  return count;
}

// A limit on the size of files stands for a full disk: every write beyond it fails.
TEST_F(KillTest, WithoutRoomOnTheDiskItStopsAndGoesOnLater) {
  folder_.write("study.toml", crash_study_text(3, 1, 0, 2));
  ASSERT_EQ(run("whole"), 0) << err();
  for (const rlim_t size : {2000, 80000, 140000}) {
    EXPECT_NE(run("full",
                  [size] {
                    const rlimit limit = {size, size};
                    setrlimit(RLIMIT_FSIZE, &limit);
                  }),
              0);
    const std::string said = err();
    EXPECT_THAT(said, HasSubstr("firn: ")) << size;
    EXPECT_EQ(failures(said), 1) << said;
  }
  ASSERT_EQ(run("full"), 0) << err();
  EXPECT_EQ(results("full"), results("whole"));
}

// A disk that is truly full, and grows while it is looked at.
TEST_F(KillTestLong, OnADiskThatIsFullItStopsAndGoesOnLater) {
  const std::string disk = folder_ / "disk";
  fs::create_directories(disk);
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", disk.c_str(), "tmpfs", 0, "size=200k") != 0)
    GTEST_SKIP() << "only root may mount a small disk";
  struct Unmount {
    const std::string& disk;
    ~Unmount() { umount2(disk.c_str(), MNT_DETACH); }
  } const unmount{disk};
  folder_.write("study.toml", crash_study_text(8, 2, 1, 3));
  ASSERT_EQ(run("whole"), 0) << err();
  int stopped = 0;
  for (int size = 250; size < 8000; size += 250) {
    mount("none", disk.c_str(), nullptr, MS_REMOUNT,
          ("size=" + std::to_string(size) + "k").c_str());
    const int status = run("disk/full");
    if (status == 0) break;
    ++stopped;
    const std::string said = err();
    EXPECT_EQ(failures(said), 1) << said;
    EXPECT_THAT(said, testing::AnyOf(HasSubstr("No space left"), HasSubstr("full"))) << said;
  }
  EXPECT_GT(stopped, 3);
  mount("none", disk.c_str(), nullptr, MS_REMOUNT, "size=100m");
  ASSERT_EQ(run("disk/full"), 0) << err();
  EXPECT_EQ(results("disk/full"), results("whole"));
}

TEST_F(KillTest, ARunThatTimedOutGoesOnUnderAHigherLimit) {
  const auto outcome = [&](const std::string& folder, double limit,
                           const std::string& program = FIRN_PROGRAM) {
    const auto executor = local_executor({program, 1, nullptr});
    Job job;
    job.key = "k";
    job.text = executor->resolve(folder_ / "balls.toml", {{"case.duration", "\"15 s\""}}, {}).text;
    job.folder = folder_ / folder;
    job.limits.time = limit;
    JobResult result;
    JobEvents events;
    events.started = [](const Job&) {};
    events.ended = [&](const Job&, const JobResult& r) { result = r; };
    executor->run({job}, events);
    return result;
  };
  // On a busy machine a short limit is over before the run has begun.
  JobResult cut;
  for (double limit = 0.2; !(cut.simulated > 0); limit *= 2) {
    fs::remove_all(folder_ / "cut");
    cut = outcome("cut", limit);
    ASSERT_EQ(cut.status, JobStatus::timed_out) << cut.reason;
  }
  EXPECT_GE(cut.wall, 0.2);
  EXPECT_LT(cut.simulated, 15);
  // What cannot be gone on with is no failure of the run: it is started afresh.
  fs::copy(folder_ / "cut", folder_ / "unusable");
  const std::string refuses = folder_.write("refuses", "#!/bin/sh\nexit 2\n");
  chmod(refuses.c_str(), 0755);
  EXPECT_EQ(outcome("unusable", 0, refuses).status, JobStatus::lost);
  EXPECT_FALSE(fs::exists(folder_ / "unusable/k.h5"));
  const JobResult whole = outcome("whole", 0), resumed = outcome("cut", 1000);
  ASSERT_EQ(resumed.status, JobStatus::finished) << resumed.reason;
  EXPECT_GT(resumed.wall, cut.wall);  // of all sessions
  ASSERT_EQ(resumed.responses.size(), whole.responses.size());
  for (std::size_t i = 0; i < whole.responses.size(); ++i)
    EXPECT_EQ(resumed.responses[i].value, whole.responses[i].value) << whole.responses[i].name;
}

TEST_F(KillTest, AFolderThatCannotBeWrittenIsOneClearLine) {
  folder_.write("study.toml", crash_study_text(3, 1, 0, 2));
  // No process may write here, not even as root.
  EXPECT_EQ(run("/proc/self"), 2);
  EXPECT_THAT(err(), HasSubstr("/proc/self"));
  EXPECT_EQ(run("/proc/firn/in/it"), 2);
  EXPECT_THAT(err(), HasSubstr("cannot be made"));
}

TEST_F(KillTest, ASecondStudyInTheSameFolderIsRefused) {
  folder_.write("study.toml", crash_study_text(8, 2, 0, 2));
  const pid_t first = start("both");
  while (!fs::exists(folder_ / "both/runs"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(first, SIGSTOP);  // at work, however fast this machine is
  EXPECT_EQ(run("both"), 2);
  EXPECT_THAT(err(), HasSubstr("another process is at work here"));
  kill(first, SIGCONT);
  EXPECT_EQ(wait(first), 0);
}

}  // namespace
}  // namespace firn
