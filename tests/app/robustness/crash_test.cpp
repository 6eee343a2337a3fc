// The real program on disks that fail, machines that lose power, and under signals at any moment:
// nothing finished is lost, and what continues ends in the same bits.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <set>
#include <thread>

#include "experiments/results/results_lock.h"
#include "experiments/storage/hdf5_file.h"
#include "tests/app/program.h"
#include "tests/app/robustness/hostile_inputs.h"
#include "tests/app/robustness/io_faults.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using testing::AnyOf;
using testing::HasSubstr;

constexpr int errors[] = {EIO, ENOSPC, EFBIG, EDQUOT, EROFS};

// Every number and text of a results file.
std::map<std::string, std::string> bits(const std::string& results) {
  const hdf5::File file = hdf5::File::open(results, hdf5::File::Access::read);
  std::map<std::string, std::string> all;
  for (const std::string& path : file.datasets()) {
    std::string& text = all[path];
    try {
      for (const double x : file.read<double>(path)) text += fmt::format("{:a} ", x);
    } catch (const hdf5::Error&) {
      for (const std::string& x : file.read_strings(path)) text += x + '\n';
    }
  }
  all["status"] = file.text_attribute("/", "status");
  return all;
}

void expect_equal_bits(const std::string& a, const std::string& b) {
  const auto x = bits(a), y = bits(b);
  for (const auto& [path, text] : x) {
    ASSERT_TRUE(y.contains(path)) << path;
    EXPECT_TRUE(text == y.at(path))
        << path << " differs: " << text.substr(0, 200) << " and " << y.at(path).substr(0, 200);
  }
  EXPECT_EQ(x.size(), y.size());
}

// What a results.json says, but for times and places.
ordered_json without_times(const ordered_json& j) {
  if (j.is_array()) {
    ordered_json all = ordered_json::array();
    for (const ordered_json& item : j) all.push_back(without_times(item));
    return all;
  }
  if (!j.is_object()) return j;
  ordered_json all = ordered_json::object();
  for (const auto& [name, value] : j.items())
    if (!name.starts_with("wall") && name != "results" && name != "results_file" &&
        name != "directory")
      all[name] = without_times(value);
  return all;
}

// A run of some 20 ms and three stages, with everything in its file that one can hold.
class CrashTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("case.toml", hostile::rich_case);
    folder_.write("sweep.toml", hostile::sweep_file);
    folder_.write("study.toml", hostile::study_file);
    folder_.write("suite.toml", hostile::suite_file);
    folder_.write("mass.toml", hostile::mass_file);
    folder_.write("claims.toml", hostile::claims_file);
    fs::create_directory(run_folder());
  }

  fs::path run_folder() const { return fs::canonical(folder_.path()) / "r"; }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  void empty_run_folder() const {
    fs::remove_all(run_folder());
    fs::create_directory(run_folder());
  }

  // The results that every continued run must come to.
  std::string whole() {
    if (!fs::exists(path("whole.h5"))) {
      const Outcome o = folder_.firn(run_to("whole.h5"));
      EXPECT_EQ(o.status, 0) << o.err;
    }
    return path("whole.h5");
  }

  static std::vector<std::string> run_to(const std::string& file) {
    return {"run", "case.toml", "-o", file, "-q", "--threads", "1"};
  }
  static std::vector<std::string> resume(const std::string& file) {
    return {"run", "--resume", file, "-q", "--threads", "1"};
  }

  // After a run that stopped for whatever reason. `safe`: it said that a state is.
  void expect_continues(bool safe, const std::string& context) {
    const Outcome o = folder_.firn(resume("r/run.h5"));
    if (safe || o.status == 0) {
      ASSERT_EQ(o.status, 0) << context << "\n" << o.err;
      ASSERT_FALSE(has_saved_copy(path("r/run.h5"))) << context;
      return expect_equal_bits(path("r/run.h5"), whole());
    }
    EXPECT_EQ(o.status, 2) << context << "\n" << o.err;
    EXPECT_EQ(lines(o.err), 1u) << context << "\n" << o.err;
    const Outcome again = folder_.firn(run_to("r/run.h5"));
    ASSERT_EQ(again.status, 0) << context << "\n" << again.err;
    expect_equal_bits(path("r/run.h5"), whole());
  }

  // A run or a resumption met a fault: what it said, and that its advice holds.
  void expect_clear_end(const Outcome& o, int error, const std::string& context) {
    if (o.status == 0) return expect_equal_bits(path("r/run.h5"), whole());
    EXPECT_EQ(o.status, 1) << context << "\n" << o.err;
    EXPECT_EQ(lines(o.err), 1u) << context << "\n" << o.err;
    EXPECT_THAT(o.err, HasSubstr(std::string(": cannot write: ") + std::strerror(error)))
        << context;
    EXPECT_THAT(o.err, AnyOf(HasSubstr(" is safe in r/run.h5"), HasSubstr("no state of the run"),
                             HasSubstr("nothing was simulated")))
        << context;
    if (const std::size_t at = o.err.find("is safe in "); at != o.err.npos) {
      const std::string name = o.err.substr(at + 11, o.err.find(':', at) - at - 11);
      EXPECT_TRUE(fs::exists(path(name))) << context << "\n" << o.err;
    }
    expect_continues(o.err.find(" is safe in ") != o.err.npos, context);
  }

  void meet_faults(int tries, unsigned seed);
  void interrupt_a_run(const std::string& interrupted);
  void meet_faults_of_a_resumption(int tries, unsigned seed);
  void lose_power(std::size_t tries, unsigned seed);
  void meet_faults_of(const std::vector<std::string>& command, int tries, unsigned seed);
  void meet_faults_of_outputs(std::size_t tries, unsigned seed, bool pictures);
  void be_killed(int kills, unsigned seed);
  void be_killed_in(const std::vector<std::string>& command, int kills, unsigned seed);

  // Commands with many runs.
  static std::vector<std::string> batch(const std::string& name, const std::string& input) {
    return {name, input, "-o", "out", "--no-cache", "--jobs", "2", "--progress", "none"};
  }
  static std::vector<std::vector<std::string>> batches() {
    return {batch("calibrate", "study.toml"), batch("sweep", "sweep.toml"),
            batch("validate", "suite.toml")};
  }
  ordered_json answer(const std::string& directory) const {
    return without_times(ordered_json::parse(read_text(path(directory + "/results.json"))));
  }
  // Results files of finished runs, and when they were written.
  std::map<std::string, fs::file_time_type> finished() const {
    std::map<std::string, fs::file_time_type> files;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(path("out/runs"), none)) {
      const std::string file = entry.path().string();
      if (entry.path().extension() != ".h5" || has_saved_copy(file)) continue;
      try {
        const hdf5::File results = hdf5::File::open(file, hdf5::File::Access::read);
        if (results.has_attribute("/", "responses_complete"))
          files[file] = fs::last_write_time(file);
      } catch (const hdf5::Error&) {
        // Under way when it was stopped.
      }
    }
    return files;
  }
  static void expect_not_repeated(const std::map<std::string, fs::file_time_type>& known) {
    for (const auto& [file, written] : known)
      EXPECT_EQ(fs::last_write_time(file), written) << "a finished run was repeated: " << file;
  }
  // Processes whose command line names the folder of this test.
  std::vector<pid_t> processes() const {
    std::vector<pid_t> found;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      const pid_t pid = std::atoi(entry.path().filename().c_str());
      if (pid <= 0 || pid == getpid()) continue;
      try {
        if (read_text(entry.path() / "cmdline").find(folder_.path().string()) !=
                std::string::npos &&
            read_text(entry.path() / "stat").find(") Z ") == std::string::npos)
          found.push_back(pid);
      } catch (const std::ios_base::failure&) {
        // It ended while it was read.
      }
    }
    return found;
  }
  void expect_no_orphans() const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!processes().empty() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_THAT(processes(), testing::IsEmpty()) << "simulations without a parent";
  }

  // In memory: a disk would be waited for some hundred times a second.
  Folder folder_{fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()};
};
using CrashTestLong = CrashTest;

// Numbers from 1 to n in random order, the first `count` of them; all when there are fewer.
std::vector<std::uint64_t> some_of(std::uint64_t n, std::size_t count, std::mt19937_64& random) {
  std::vector<std::uint64_t> all(n);
  std::iota(all.begin(), all.end(), 1);
  std::shuffle(all.begin(), all.end(), random);
  all.resize(std::min(all.size(), count));
  return all;
}

constexpr std::size_t kAll = 1u << 30;

// Of a child process that has not been waited for.
bool has_ended(pid_t pid) {
  siginfo_t info = {};
  return waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
         info.si_pid == pid;
}

void CrashTest::meet_faults(int tries, unsigned seed) {
  std::mt19937_64 random(seed);
  empty_run_folder();
  const CountedOutcome good = firn_with(folder_, {run_folder(), {}, {}, ""}, run_to("r/run.h5"));
  ASSERT_EQ(good.status, 0) << good.err;
  ASSERT_GT(good.calls, 50u);
  int failed = 0;
  for (const std::uint64_t k : some_of(good.calls, static_cast<std::size_t>(tries), random)) {
    const int error = errors[random() % std::size(errors)];
    const std::uint64_t calls = random() % 2 ? 1 : kAll;
    empty_run_folder();
    const Outcome o = firn_with(folder_, {run_folder(), IoFaults::Fail{k, error, calls}, {}, ""},
                                run_to("r/run.h5"));
    failed += o.status != 0;
    expect_clear_end(o, error,
                     "call " + std::to_string(k) + " and " + std::to_string(calls - 1) +
                         " more: " + std::strerror(error));
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(failed, std::min<int>(tries, static_cast<int>(good.calls)) * 3 / 4);
}

TEST_F(CrashTest, RunWhoseWritesFailSaysSoAndContinues) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults(24, 1);
}

TEST_F(CrashTestLong, RunWhoseWritesFailSaysSoAndContinues) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  for (unsigned seed = 1; seed <= 3; ++seed) meet_faults(kAll, seed);
}

// A run that was interrupted about half way and has one file only.
void CrashTest::interrupt_a_run(const std::string& interrupted) {
  const CountedOutcome good = firn_with(folder_, {run_folder(), {}, {}, ""}, run_to("r/run.h5"));
  for (std::uint64_t k = good.calls / 3; !fs::exists(interrupted); ++k) {
    ASSERT_LT(k, good.calls);
    empty_run_folder();
    const Outcome o =
        firn_with(folder_, {run_folder(), {}, IoFaults::Signal{k, SIGINT}, ""}, run_to("r/run.h5"));
    // Before its first checkpoint a run ends at once and leaves no file.
    if (o.status != 130 || !fs::exists(path("r/run.h5"))) continue;
    EXPECT_THAT(o.err, HasSubstr("interrupted at t = "));
    ASSERT_FALSE(has_saved_copy(path("r/run.h5")));
    fs::rename(path("r/run.h5"), interrupted);
  }
}

void CrashTest::meet_faults_of_a_resumption(int tries, unsigned seed) {
  std::mt19937_64 random(seed);
  const std::string interrupted = path("interrupted.h5");
  ASSERT_NO_FATAL_FAILURE(interrupt_a_run(interrupted));
  const auto prepare = [&] {
    empty_run_folder();
    fs::copy(interrupted, path("r/run.h5"));
  };
  prepare();
  const CountedOutcome resumed = firn_with(folder_, {run_folder(), {}, {}, ""}, resume("r/run.h5"));
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  expect_equal_bits(path("r/run.h5"), whole());
  for (const std::uint64_t k : some_of(resumed.calls, static_cast<std::size_t>(tries), random)) {
    const int error = errors[random() % std::size(errors)];
    const std::uint64_t calls = random() % 2 ? 1 : kAll;
    prepare();
    const Outcome o = firn_with(folder_, {run_folder(), IoFaults::Fail{k, error, calls}, {}, ""},
                                resume("r/run.h5"));
    const std::string context =
        "resumption, call " + std::to_string(k) + ": " + std::strerror(error) + "\n" + o.err;
    expect_clear_end(o, error, context);
    if (o.status != 0) {
      EXPECT_THAT(o.err, HasSubstr(" is safe in ")) << context;
    }
    if (HasFatalFailure()) return;
    // A signal at the same place saves the state as well.
    prepare();
    const Outcome s =
        firn_with(folder_, {run_folder(), {}, IoFaults::Signal{k, k % 2 ? SIGTERM : SIGINT}, ""},
                  resume("r/run.h5"));
    EXPECT_THAT(s.status, AnyOf(0, 130)) << context << s.err;
    expect_continues(true, context);
    if (HasFatalFailure()) return;
  }
}

// A signal at any write of a new run, between the creation of a file and its registration as well.
TEST_F(CrashTest, RunThatGetsASignalLeavesAStateOrNothing) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  std::mt19937_64 random(15);
  empty_run_folder();
  const CountedOutcome counted = firn_with(folder_, {run_folder(), {}, {}, ""}, run_to("r/run.h5"));
  ASSERT_EQ(counted.status, 0) << counted.err;
  std::vector<std::uint64_t> calls = some_of(counted.calls, 12, random);
  for (std::uint64_t k = 1; k <= 12; ++k) calls.push_back(k);
  for (const std::uint64_t k : calls) {
    empty_run_folder();
    const Outcome o =
        firn_with(folder_, {run_folder(), {}, IoFaults::Signal{k, k % 2 ? SIGTERM : SIGINT}, ""},
                  run_to("r/run.h5"));
    const std::string context = "call " + std::to_string(k) + "\n" + o.err;
    EXPECT_THAT(o.status, AnyOf(0, 130)) << context;
    if (o.status == 0) continue;
    EXPECT_THAT(o.err, HasSubstr("interrupted")) << context;
    if (fs::exists(path("r/run.h5"))) {
      EXPECT_THAT(o.err, HasSubstr("--resume")) << context;
      expect_continues(true, context);
    } else {
      for (const auto& left : fs::directory_iterator(run_folder()))
        ADD_FAILURE() << left.path() << ", " << context;
    }
    if (HasFatalFailure()) return;
  }
}

TEST_F(CrashTest, ResumptionWhoseWritesFailCanBeRepeated) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of_a_resumption(12, 2);
}

TEST_F(CrashTestLong, ResumptionWhoseWritesFailCanBeRepeated) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of_a_resumption(kAll, 2);
}

TEST_F(CrashTest, ResumptionUnderALimitOfFileSizeCanBeRepeated) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  const auto size = fs::file_size(whole());
  ASSERT_NO_FATAL_FAILURE(interrupt_a_run(path("interrupted.h5")));
  std::mt19937_64 random(3);
  for (int i = 0; i < 8; ++i) {
    empty_run_folder();
    fs::copy(path("interrupted.h5"), path("r/run.h5"));
    const rlim_t limit = i == 0 ? fs::file_size(path("r/run.h5")) : 1000 + random() % size;
    const Outcome o = folder_.wait(folder_.start(resume("r/run.h5"), [limit] {
      const rlimit both = {limit, limit};
      setrlimit(RLIMIT_FSIZE, &both);
    }));
    expect_clear_end(o, EFBIG, "limit " + std::to_string(limit));
    if (HasFatalFailure()) return;
  }
}

TEST_F(CrashTest, RunOnAFullDiskSaysSoAndContinuesWithMoreRoom) {
  ASSERT_TRUE(fs::exists(whole()));
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", run_folder().c_str(), "tmpfs", 0, "size=40k") != 0)
    GTEST_SKIP() << "only root may mount a small disk";
  int stopped = 0;
  Outcome o{1, "", ""};
  for (int size = 40; size < 4000 && o.status != 0; size += 40) {
    mount("none", run_folder().c_str(), nullptr, MS_REMOUNT,
          ("size=" + std::to_string(size) + "k").c_str());
    const bool begun = has_saved_copy(path("r/run.h5"));
    o = folder_.firn(begun ? resume("r/run.h5") : run_to("r/run.h5"));
    if (o.status == 0) break;
    ++stopped;
    EXPECT_EQ(o.status, 1) << o.err;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_THAT(o.err, HasSubstr("cannot write: No space left on device; "));
    EXPECT_THAT(o.err, HasSubstr(": free space and "));
    if (!has_saved_copy(path("r/run.h5")))
      for (const auto& entry : fs::directory_iterator(run_folder())) fs::remove(entry.path());
  }
  EXPECT_GT(stopped, 2);
  EXPECT_EQ(o.status, 0) << o.err;
  if (fs::exists(path("r/run.h5"))) expect_equal_bits(path("r/run.h5"), whole());
  umount2(run_folder().c_str(), MNT_DETACH);
}

// Each prefix of the recorded writes, as a kill leaves it and as a power failure may.
void CrashTest::lose_power(std::size_t tries, unsigned seed) {
  std::mt19937_64 random(seed);
  const std::string log = path("log");
  fs::remove(log);
  empty_run_folder();
  ASSERT_EQ(firn_with(folder_, {run_folder(), {}, {}, log}, run_to("r/run.h5")).status, 0);
  const std::vector<IoCall> calls = read_io_log(log);
  ASSERT_GT(calls.size(), 50u);
  const std::string copy = (run_folder() / "run.h5.saved").string();
  std::size_t first_state = calls.size();  // calls after which a state must be safe
  for (std::size_t i = 0; i < calls.size(); ++i)
    if (calls[i].kind == 'R' && calls[i].other == copy) {
      first_state = i;
      break;
    }
  ASSERT_LT(first_state, calls.size());
  const std::size_t after_rename = first_state + 1;
  while (calls[first_state].kind != 'S') ++first_state;  // of the folder
  ++first_state;
  std::size_t continued = 0;
  for (const std::uint64_t k : some_of(calls.size(), tries, random)) {
    const Files left[] = {after_kill(calls, k), after_power_failure(calls, k),
                          after_power_failure(calls, k, random)};
    const char* const names[] = {"kill", "power failure", "power failure, some written"};
    for (std::size_t model = 0; model < std::size(left); ++model) {
      empty_run_folder();
      for (const auto& [file, text] : left[model]) std::ofstream(file, std::ios::binary) << text;
      const bool safe = k >= (model == 0 ? after_rename : first_state);
      continued += safe;
      expect_continues(safe, std::string(names[model]) + " after call " + std::to_string(k) +
                                 " of " + std::to_string(calls.size()) + ", seed " +
                                 std::to_string(seed));
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(continued, std::min(tries, calls.size()));
}

TEST_F(CrashTest, PowerFailureBetweenTwoWritesLosesNoState) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  lose_power(12, 4);
}

// In pieces that each end within the time limit of a test.
class PowerFailureLong : public CrashTest, public testing::WithParamInterface<unsigned> {};
TEST_P(PowerFailureLong, BetweenTwoWritesLosesNoState) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  lose_power(kAll, GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seeds, PowerFailureLong, testing::Range(4u, 7u));

// Processes of a batch share the count of calls: its own writes fail, and those of its runs.
void CrashTest::meet_faults_of(const std::vector<std::string>& command, int tries, unsigned seed) {
  std::mt19937_64 random(seed);
  const fs::path out = fs::canonical(folder_.path()) / "out";
  fs::remove_all(out);
  const CountedOutcome good = firn_with(folder_, {out, {}, {}, ""}, command);
  ASSERT_EQ(good.status, 0) << good.err;
  const ordered_json expected = answer("out");
  int failed = 0;
  for (const std::uint64_t k : some_of(good.calls, static_cast<std::size_t>(tries), random)) {
    const int error = errors[random() % std::size(errors)];
    const std::uint64_t calls = random() % 2 ? 1 : kAll;
    const std::string context = command[0] + ", call " + std::to_string(k) + " of " +
                                std::to_string(good.calls) + " and " + std::to_string(calls - 1) +
                                " more: " + std::strerror(error);
    fs::remove_all(out);
    const CountedOutcome o =
        firn_with(folder_, {out, IoFaults::Fail{k, error, calls}, {}, ""}, command);
    expect_no_orphans();
    if (o.status != 0) {  // the database survives some of them
      ++failed;
      EXPECT_EQ(o.status, 1) << context << "\n" << o.err;
      EXPECT_EQ(lines(o.err), 1u) << context << "\n" << o.err;
      EXPECT_THAT(o.err, HasSubstr(std::string(": cannot write: ") + std::strerror(error)))
          << context;
      EXPECT_THAT(o.err, HasSubstr("everything finished is kept in out: ")) << context;
    } else if (calls == 1) {
      EXPECT_EQ(answer("out"), expected) << context;
    }
    const auto known = finished();
    const Outcome again = folder_.firn(command);
    ASSERT_EQ(again.status, 0) << context << "\n" << again.err;
    EXPECT_EQ(answer("out"), expected) << context;
    expect_not_repeated(known);
  }
  EXPECT_GT(failed, 0);
}

TEST_F(CrashTest, BatchesWhoseWritesFailSaySoAndContinue) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  for (const auto& command : batches()) meet_faults_of(command, 4, 5);
}

// In pieces that each end within the time limit of a test: failing writes of a batch, by its
// command, their number and the seed that chooses them.
struct FailingWrites {
  const char* name;
  std::size_t batch;
  int tries;
  unsigned seed;
};
void PrintTo(const FailingWrites& piece, std::ostream* out) {
  *out << piece.name << ", seed " << piece.seed;
}

class BatchWritesLong : public CrashTest, public testing::WithParamInterface<FailingWrites> {};
TEST_P(BatchWritesLong, FailWithALineAndTheBatchContinues) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of(batches()[GetParam().batch], GetParam().tries, GetParam().seed);
}
INSTANTIATE_TEST_SUITE_P(
    Pieces, BatchWritesLong,
    testing::Values(FailingWrites{"calibrate", 0, 50, 6}, FailingWrites{"calibrate", 0, 50, 7},
                    FailingWrites{"calibrate", 0, 50, 8}, FailingWrites{"calibrate", 0, 50, 9},
                    FailingWrites{"sweep", 1, kAll, 10}, FailingWrites{"validate", 2, 100, 11},
                    FailingWrites{"validate", 2, 100, 12}, FailingWrites{"validate", 2, 100, 13},
                    FailingWrites{"validate", 2, 100, 14}));

// Commands that write tables, pages, pictures and databases: into the folder r alone.
void CrashTest::meet_faults_of_outputs(std::size_t tries, unsigned seed, bool pictures) {
  std::mt19937_64 random(seed);
  ASSERT_TRUE(fs::exists(whole()));
  folder_.write("record.json", hostile::record_file);
  std::vector<std::vector<std::string>> commands = {
      {"report", "whole.h5", "-o", "r/page.html", "--figures", "r/figures"},
      {"export", "whole.h5", "--to", "csv", "-o", "r/csv"},
      {"export", "whole.h5", "--to", "vtk", "-o", "r/vtk"},
      {"contacts", "whole.h5", "--time", "2 ms", "-o", "r/contacts.csv"},
      {"materials", "export", "paper-text", "-o", "r/records.json"},
      {"materials", "add", "record.json", "--database", "r/m.db"}};
  if (pictures)  // which take many seconds each
    commands = {
        {"export", "whole.h5", "--to", "png", "-o", "r/scene.png"},
        {"contacts", "whole.h5", "--particle", "0", "--time", "2 ms", "-o", "r/contacts.svg"}};
  const auto contents = [&] {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(run_folder()))
      if (entry.is_regular_file()) files[entry.path().string()] = read_text(entry.path());
    return files;
  };
  for (const auto& command : commands) {
    const std::string name = command[0] + " " + command.back();
    empty_run_folder();
    const CountedOutcome good = firn_with(folder_, {run_folder(), {}, {}, ""}, command);
    ASSERT_EQ(good.status, 0) << name << "\n" << good.err;
    const Files expected = contents();
    ASSERT_FALSE(expected.empty()) << name;
    const bool database = command[0] == "materials" && command[1] == "add";
    int failed = 0;
    for (const std::uint64_t k : some_of(good.calls, tries, random)) {
      const int error = errors[random() % std::size(errors)];
      const std::uint64_t calls = random() % 2 ? 1 : kAll;
      const std::string context = name + ", call " + std::to_string(k) + " and " +
                                  std::to_string(calls - 1) + " more: " + std::strerror(error);
      empty_run_folder();
      if (!database)
        for (const auto& [file, text] : expected) {
          fs::create_directories(fs::path(file).parent_path());
          std::ofstream(file) << "earlier";
        }
      const Outcome o =
          firn_with(folder_, {run_folder(), IoFaults::Fail{k, error, calls}, {}, ""}, command);
      failed += o.status != 0;
      if (o.status != 0 || !database) {
        EXPECT_EQ(o.status, 1) << context << "\n" << o.err;
        EXPECT_EQ(o.err.find("firn: "), o.err.rfind("firn: ")) << context << "\n" << o.err;
        EXPECT_THAT(
            o.err, testing::EndsWith(std::string(": cannot write: ") + std::strerror(error) + "\n"))
            << context;
      }
      if (database) {
        const Outcome again = folder_.firn(command);
        EXPECT_EQ(again.status, 0) << context << "\n" << again.err;
        EXPECT_THAT(folder_.firn({"materials", "list", "--database", "r/m.db"}).out,
                    HasSubstr("mine"));
        continue;
      }
      for (const auto& [file, text] : contents()) {
        if (file.ends_with(".writing")) {
          EXPECT_GT(calls, 1u) << context << " left " << file;
          continue;
        }
        EXPECT_TRUE(text == "earlier" || text == expected.at(file)) << context << " " << file;
      }
    }
    EXPECT_GT(failed, 0) << name;
  }
}

TEST_F(CrashTest, OutputsWhoseWritesFailStayWhole) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of_outputs(4, 15, false);
}

TEST_F(CrashTestLong, OutputsWhoseWritesFailStayWhole) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of_outputs(kAll, 16, false);
}

TEST_F(CrashTestLong, PicturesWhoseWritesFailStayWhole) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  meet_faults_of_outputs(kAll, 17, true);
}

constexpr int signals[] = {SIGKILL, SIGTERM, SIGINT};

// Kills a run and its resumptions until one comes to its end, again and again.
void CrashTest::be_killed(int kills, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(fs::exists(whole()));
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::steady_clock::now() - begin);
  int killed = 0;
  for (int session = 0; killed < kills; ++session) {
    ASSERT_LT(session, 20 * kills + 100) << "it ends before every kill";
    const bool begun = fs::exists(path("r/run.h5"));
    const pid_t pid = folder_.start(begun ? resume("r/run.h5") : run_to("r/run.h5"));
    std::this_thread::sleep_for(
        std::chrono::microseconds(random() % static_cast<std::uint64_t>(time.count() + 1)));
    const int signal = signals[random() % std::size(signals)];
    kill(pid, signal);
    const Outcome o = folder_.wait(pid);
    const std::string context = "seed " + std::to_string(seed) + ", session " +
                                std::to_string(session) + ", signal " + std::to_string(signal) +
                                ", status " + std::to_string(o.status) + "\n" + o.err;
    if (o.status == 130 && o.signal == 0) {
      // Before its first checkpoint a run ends at once and leaves no file.
      EXPECT_THAT(o.err, HasSubstr("interrupted")) << context;
      if (o.err.find("interrupted at t = ") != std::string::npos) {
        ASSERT_TRUE(fs::exists(path("r/run.h5"))) << context;
      }
    }
    killed += o.status == 130 || o.status == 128 + signal;
    if (o.status == 0) {
      expect_equal_bits(path("r/run.h5"), whole());
      ASSERT_FALSE(has_saved_copy(path("r/run.h5"))) << context;
      empty_run_folder();
      continue;
    }
    if (o.status == 2) {  // killed before the first state was saved
      EXPECT_EQ(lines(o.err), 1u) << context;
      ASSERT_TRUE(begun) << context;
      ASSERT_FALSE(has_saved_copy(path("r/run.h5"))) << context;
      empty_run_folder();
      continue;
    }
    // A second signal or one before the program listens kills as well.
    ASSERT_THAT(o.status, AnyOf(130, 128 + signal)) << context;
  }
  if (fs::exists(path("r/run.h5"))) expect_continues(false, "after all kills");
}

TEST_F(CrashTest, RunThatIsKilledContinues) { be_killed(8, 9); }

TEST_F(CrashTestLong, RunThatIsKilledContinues) { be_killed(400, 10); }

// Kills a batch, its runs, or both.
void CrashTest::be_killed_in(const std::vector<std::string>& command, int kills, unsigned seed) {
  std::mt19937_64 random(seed);
  fs::remove_all(path("out"));
  const auto begin = std::chrono::steady_clock::now();
  const Outcome good = folder_.firn(command);
  ASSERT_EQ(good.status, 0) << good.err;
  const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::steady_clock::now() - begin);
  const ordered_json expected = answer("out");
  fs::remove_all(path("out"));
  std::map<std::string, fs::file_time_type> known;
  int killed = 0;
  for (int session = 0; killed < kills; ++session) {
    ASSERT_LT(session, 20 * kills + 100) << "it ends before every kill";
    const pid_t pid = folder_.start(command);
    std::this_thread::sleep_for(
        std::chrono::milliseconds(random() % static_cast<std::uint64_t>(time.count() / 2 + 1)));
    const int signal = signals[random() % std::size(signals)];
    std::vector<pid_t> runs;
    std::ifstream children("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) +
                           "/children");
    for (pid_t child; children >> child;) runs.push_back(child);
    const auto whom = random() % 3;  // the parent, its runs, or all
    if (whom != 0)
      for (const pid_t run : runs) {
        kill(run, signal);
        ++killed;
      }
    if (whom != 1) {
      kill(pid, signal);
      ++killed;
    }
    const Outcome o = folder_.wait(pid);
    expect_no_orphans();
    const std::string context = command[0] + ", seed " + std::to_string(seed) + ", session " +
                                std::to_string(session) + ", signal " + std::to_string(signal) +
                                ", status " + std::to_string(o.status) + "\n" + o.err;
    const bool parent_killed = whom != 1;
    if (parent_killed)
      ASSERT_THAT(o.status, AnyOf(0, 1, 130, 128 + signal)) << context;
    else
      ASSERT_EQ(o.status, 0) << context;  // its runs are repeated
    expect_not_repeated(known);
    known = finished();
    if (o.status != 0) continue;
    EXPECT_EQ(answer("out"), expected) << context;
    fs::remove_all(path("out"));
    known.clear();
  }
  const Outcome last = folder_.firn(command);
  ASSERT_EQ(last.status, 0) << last.err;
  EXPECT_EQ(answer("out"), expected);
  expect_not_repeated(known);
}

TEST_F(CrashTest, BatchesThatAreKilledContinue) {
  for (const auto& command : batches()) be_killed_in(command, 4, 11);
}

TEST_F(CrashTestLong, CalibrationThatIsKilledContinues) { be_killed_in(batches()[0], 200, 12); }
TEST_F(CrashTestLong, SweepThatIsKilledContinues) { be_killed_in(batches()[1], 200, 13); }
TEST_F(CrashTestLong, ValidationThatIsKilledContinues) { be_killed_in(batches()[2], 200, 14); }

TEST_F(CrashTest, SecondProcessOnOneFolderIsRefused) {
  std::vector<std::vector<std::string>> commands = batches();
  commands.push_back({"run", "case.toml", "-o", "out/run.h5", "-q"});
  for (const auto& command : commands) {
    fs::remove_all(path("out"));
    const pid_t first = folder_.start(command);
    const std::string held = path(command[0] == "run" ? "out/run.h5.saved" : "out/runs");
    while (!fs::exists(held)) std::this_thread::yield();
    kill(first, SIGSTOP);  // at work, however fast this machine is
    const bool at_work = !has_ended(first);
    const Outcome second = folder_.firn(command);
    if (at_work) {
      EXPECT_EQ(second.status, 2) << command[0];
      EXPECT_EQ(lines(second.err), 1u) << second.err;
      EXPECT_THAT(second.err, HasSubstr("another ")) << command[0];
    }
    kill(first, SIGCONT);
    const Outcome o = folder_.wait(first);
    EXPECT_EQ(o.status, 0) << command[0] << "\n" << o.err;
  }
}

TEST_F(CrashTest, FolderThatIsRemovedIsNoSuccess) {
  for (const auto& command : batches()) {
    fs::remove_all(path("out"));
    ASSERT_EQ(folder_.firn(command).status, 0);
    const ordered_json expected = answer("out");
    fs::remove_all(path("out"));
    const pid_t pid = folder_.start(command);
    while (finished().empty() && !has_ended(pid))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::error_code raced;
    do fs::remove_all(path("out"), raced);
    while (raced);
    const Outcome o = folder_.wait(pid);
    EXPECT_EQ(o.status, 1) << command[0] << "\n" << o.err;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_THAT(o.err, HasSubstr("out: cannot write: it was removed or replaced during the work"));
    expect_no_orphans();
    // The journal is there again, with what was finished.
    std::vector<std::string> again = command;
    again.emplace_back("--resume");
    const Outcome next = folder_.firn(again);
    EXPECT_EQ(next.status, 0) << next.err;
    EXPECT_EQ(answer("out"), expected);
  }
}

TEST_F(CrashTest, ResultsFileThatIsRemovedIsNoSuccess) {
  if (!io_shim_works()) GTEST_SKIP() << "not into a program with the thread sanitizer";
  const CountedOutcome good = firn_with(folder_, {run_folder(), {}, {}, ""}, run_to("r/run.h5"));
  for (const bool whole_folder : {false, true}) {
    empty_run_folder();
    // It stops itself after the first checkpoint, and is robbed of its file.
    std::ofstream(path(".count"), std::ios::binary) << std::string(8, '\0');
    const pid_t pid = folder_.start(run_to("r/run.h5"), [&] {
      load_io_shim();
      setenv("FIRN_IO_FOLDER", run_folder().c_str(), 1);
      setenv("FIRN_IO_COUNT", path(".count").c_str(), 1);
      setenv("FIRN_IO_SIGNAL",
             (std::to_string(good.calls / 2) + ":" + std::to_string(SIGSTOP)).c_str(), 1);
    });
    int status = 0;
    ASSERT_EQ(waitpid(pid, &status, WUNTRACED), pid);
    ASSERT_TRUE(WIFSTOPPED(status));
    ASSERT_TRUE(has_saved_copy(path("r/run.h5")));
    fs::remove_all(whole_folder ? run_folder() : run_folder() / "run.h5");
    kill(pid, SIGCONT);
    const Outcome o = folder_.wait(pid);
    EXPECT_EQ(o.status, 1) << o.err;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_THAT(o.err,
                HasSubstr("cannot write: it was removed or replaced while the run wrote it"));
    EXPECT_THAT(o.err, HasSubstr("is safe in r/run.h5.saved: continue with"));
    expect_continues(true, whole_folder ? "folder removed" : "file removed");
  }
}

// A command whose results cannot be written does not succeed.
TEST_F(CrashTest, StandardOutputThatCannotBeWrittenIsAFailure) {
  ASSERT_TRUE(fs::exists(whole()));
  folder_.write("record.json", hostile::record_file);
  ASSERT_EQ(folder_.firn({"materials", "add", "record.json", "--database", "m.db"}).status, 0);
  ASSERT_EQ(
      folder_.firn({"run", "case.toml", "-o", "traced.h5", "-q", "--trace-hashes", "t"}).status, 0);
  std::vector<std::vector<std::string>> commands = batches();
  for (const auto& more : std::vector<std::vector<std::string>>{
           {"--version"},
           {"--help"},
           {"run", "--help"},
           {"run", "case.toml", "-o", "o.h5", "-q"},
           {"run", "case.toml", "-o", "o.h5", "-q", "--json"},
           {"run", "--resume", "whole.h5", "-q"},
           {"measure", "whole.h5"},
           {"report", "whole.h5", "-o", "o.html"},
           {"shape", "case.toml"},
           {"compare-traces", "t", "t"},
           {"contacts", "whole.h5", "--time", "2 ms"},
           {"verify", "--list"},
           {"materials", "list"},
           {"materials", "show", "mine", "--database", "m.db"},
           {"materials", "export", "mine", "--database", "m.db"},
           {"materials", "history", "mine", "--database", "m.db"}})
    commands.push_back(more);
  const std::pair<const char*, std::function<void()>> streams[] = {
      {"No space left on device", [] { dup2(open("/dev/full", O_WRONLY), 1); }},
      {"Bad file descriptor", [] { close(1); }},
      {"Broken pipe", [] {
         int ends[2];
         if (pipe(ends) != 0) _exit(99);
         close(ends[0]);
         dup2(ends[1], 1);
       }}};
  for (const auto& command : commands) {
    fs::remove_all(path("out"));
    const Outcome good = folder_.firn(command);
    ASSERT_EQ(good.status, 0) << command[0] << " " << command.back() << "\n" << good.err;
    ASSERT_FALSE(good.out.empty()) << command[0];
    for (const auto& [text, prepare] : streams) {
      const Outcome o = folder_.wait(folder_.start(command, prepare));
      EXPECT_EQ(o.status, 1) << command[0] << " " << command.back() << ": " << text;
      EXPECT_THAT(o.err, testing::EndsWith(std::string("firn: standard output: cannot write: ") +
                                           text + "\n"));
    }
  }
}

}  // namespace
}  // namespace firn::cli
