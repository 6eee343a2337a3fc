#include "experiments/results/results_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "experiments/results/checkpoint.h"
#include "experiments/results/recorder.h"
#include "experiments/results/results_writer.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

using ResultsFile = ResultsFolder;

Case case_of(int particles) {
  Case c;
  c.source = "made.toml";
  c.resolved = "[case]\nname = \"made\"\n";
  c.seed = 7;
  c.model.timestep = 1e-5;
  Shape shape;
  shape.name = "cube";
  shape.mass = 0.5;
  shape.volume = 1e-3;
  c.model.shapes.push_back(shape);
  for (int i = 0; i < particles; ++i) c.model.particles.push_back({0, 10 + i});
  Boundary floor;
  floor.name = "floor";
  c.model.boundaries.push_back(floor);
  return c;
}

// Every value of frame i is i, but for the time, which is i / 100, and rotations, half a turn.
std::vector<double> frame_row(const std::vector<Column>& columns, int i) {
  std::vector<double> row;
  for (const Column& column : columns) {
    std::size_t n = 1;
    for (std::size_t k : column.row) n *= k;
    const bool turned = column.path.ends_with("/orientation");
    for (std::size_t k = 0; k < n; ++k) row.push_back(!turned ? i : k % 4 == 1 ? 1 : 0);
  }
  row[0] = i / 100.0;
  return row;
}

Recorder new_recorder(const std::string& file, const Case& c) {
  Recorder recorder = Recorder::create(file, result_columns(c));
  recorder.with_file([&](hdf5::File& f) {
    write_header(f, c);
    f.flush();
  });
  return recorder;
}

std::string make_file(const std::string& file, int particles, int frames) {
  const Case c = case_of(particles);
  Recorder recorder = new_recorder(file, c);
  for (int i = 0; i < frames; ++i) recorder.push(frame_row(result_columns(c), i));
  recorder.close();
  return file;
}

std::string error_of(const std::string& file) {
  return test::error_if_any([&] {
    const Recording recording(file);
    if (recording.frame_times().size() > 0) recording.frame(0);
    recording.status();
    recording.stages();
  });
}

void write_bytes(const std::string& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST_F(ResultsFile, GivesBackWhatWasRecorded) {
  for (int particles : {2, 300}) {  // rows that share a chunk, and compressed ones
    const std::string file = make_file(path("run.h5"), particles, 25);
    const Recording recording(file);
    EXPECT_EQ(recording.status(), "running");
    EXPECT_EQ(recording.seed(), 7u);
    EXPECT_EQ(recording.timestep(), 1e-5);
    ASSERT_EQ(recording.particle_count(), static_cast<std::size_t>(particles));
    EXPECT_EQ(recording.tag()[1], 11);
    EXPECT_EQ(recording.mass()[1], 0.5);
    EXPECT_TRUE(std::isnan(recording.exit_time()[0]));
    const std::vector<double> times = recording.frame_times();
    ASSERT_EQ(times.size(), 25u);
    EXPECT_EQ(times[24], 0.24);
    const Frame frame = recording.frame(24);
    ASSERT_EQ(frame.position.size(), static_cast<std::size_t>(particles));
    EXPECT_THAT(frame.position.back(), ElementsAre(24, 24, 24));
    EXPECT_THAT(frame.orientation.back(), ElementsAre(0, 1, 0, 0));
    EXPECT_EQ(recording.series("/energy/kinetic")[3], 3);
    EXPECT_EQ(recording.boundary("floor", 7).force.z(), 7);
    EXPECT_TRUE(recording.stages().empty());
    EXPECT_FALSE(recording.has_checkpoint());
  }
}

TEST_F(ResultsFile, ListsItsSeriesWithUnits) {
  const Recording recording(make_file(path("run.h5"), 2, 3));
  std::vector<std::string> found;
  for (const Series& series : recording.series_list())
    found.push_back(series.path + " " + series.unit + " " + std::to_string(series.width));
  EXPECT_THAT(found, testing::IsSupersetOf({"/boundaries/floor/force N 3", "/energy/kinetic J 1",
                                            "/boundaries/floor/orientation 1 4"}));
}

TEST_F(ResultsFile, KeepsResponses) {
  const std::string file = make_file(path("run.h5"), 2, 3);
  Recorder recorder = Recorder::reopen(file, {});
  recorder.with_file([](hdf5::File& f) {
    write_responses(
        f, {{"angle", {31.5}, {0.5}, "deg", "line", 2}, {"mass", {1, 2}, {}, "kg", "sum", 1}});
  });
  recorder.close();
  const std::vector<Response> responses = Recording(file).responses();
  ASSERT_EQ(responses.size(), 2u);
  EXPECT_EQ(responses[0].name, "angle");
  EXPECT_THAT(responses[0].value, ElementsAre(31.5));
  EXPECT_THAT(responses[0].uncertainty, ElementsAre(0.5));
  EXPECT_EQ(responses[0].unit, "deg");
  EXPECT_EQ(responses[0].method_version, 2);
  EXPECT_THAT(responses[1].value, ElementsAre(1, 2));
  EXPECT_TRUE(responses[1].uncertainty.empty());
}

TEST_F(ResultsFile, DamagedOrForeignFileIsOneSentence) {
  const std::string whole = test::read_text(make_file(path("run.h5"), 300, 10));
  const std::string file = path("damaged.h5");
  for (std::size_t size :
       {std::size_t{0}, std::size_t{8}, std::size_t{96}, whole.size() / 2, whole.size() - 1}) {
    write_bytes(file, whole.substr(0, size));
    EXPECT_THAT(error_of(file), testing::StartsWith(file + ": ")) << size;
    EXPECT_THAT(error_of(file), testing::Not(HasSubstr("\n")));
  }
  for (std::size_t i = 0; i < 8; ++i) {
    std::string flipped = whole;
    flipped[i] = static_cast<char>(~flipped[i]);
    write_bytes(file, flipped);
    EXPECT_THAT(error_of(file), HasSubstr("not a results file")) << i;
  }
  write_bytes(file, "time,position\n0,1\n");
  EXPECT_THAT(error_of(file), HasSubstr("not a results file"));
  EXPECT_THAT(error_of(path("absent.h5")), HasSubstr("no such file"));
  EXPECT_THAT(error_of(directory_.string()), HasSubstr("is a folder"));
}

// Bytes overwritten anywhere: either an error or values, never a crash or a huge allocation.
TEST_F(ResultsFile, SurvivesScatteredDamage) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "HDF5 1.10.8 frees names that it has not read where a group's links are damaged; "
                  "see docs/testing.md";
#endif
  const std::string whole = test::read_text(make_file(path("run.h5"), 3, 5));
  const std::string file = path("damaged.h5");
  int refused = 0;
  for (std::size_t at = 8; at < std::min<std::size_t>(whole.size(), 12000); at += 37) {
    std::string flipped = whole;
    for (std::size_t i = at; i < std::min(at + 3, whole.size()); ++i) flipped[i] = '\xff';
    write_bytes(file, flipped);
    refused += !error_of(file).empty();
  }
  EXPECT_GT(refused, 10);
}

TEST_F(ResultsFile, NamesWhatIsMissingOrMisshaped) {
  const std::string whole = make_file(path("run.h5"), 3, 5);
  for (const char* object :
       {"/frames/velocity", "/frames/time", "/particles/id", "/particles/mass"}) {
    const std::string file = path("lacking.h5");
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    hdf5::File::open(file, hdf5::File::Access::write).remove(object);
    EXPECT_THAT(error_of(file), HasSubstr(std::string(object) + ": is missing"));
    hdf5::File::open(file, hdf5::File::Access::write)
        .write<double>(object, {2, 2, 2, 2}, std::vector<double>(16));
    EXPECT_THAT(error_of(file), HasSubstr(std::string(object) + ": h"));
  }
  const std::string foreign = path("foreign.h5");
  hdf5::File::create(foreign).write<double>("/x", {1}, std::vector<double>{1});
  EXPECT_THAT(error_of(foreign), HasSubstr("expected a file written by firn run"));
  const Recording recording(whole);
  EXPECT_THROW(recording.series("/energy/potential"), InputError);
  EXPECT_THROW(recording.frame(5), InputError);
}

TEST_F(ResultsFile, EarlierResultsAreKept) {
  const std::string file = make_file(path("run.h5"), 2, 3);
  EXPECT_EQ(rename_earlier_results(file), path("run.1.h5"));
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(Recording(path("run.1.h5")).frame_times().size(), 3u);
  make_file(file, 2, 4);
  EXPECT_EQ(rename_earlier_results(file), path("run.2.h5"));
  EXPECT_EQ(rename_earlier_results(file), "");
  write_bytes(path("case.toml"), "[case]\n");
  EXPECT_THROW(rename_earlier_results(path("case.toml")), InputError);
  EXPECT_EQ(test::read_text(path("case.toml")), "[case]\n");
}

TEST_F(ResultsFile, HasOneWriterAndAnyNumberOfReaders) {
  const Case c = case_of(2);
  Recorder recorder = new_recorder(path("run.h5"), c);
  EXPECT_THROW(Recorder::reopen(path("run.h5"), result_columns(c)), InputError);
  EXPECT_THROW(rename_earlier_results(path("run.h5")), InputError);
  const Recording first(path("run.h5")), second(path("run.h5"));
  EXPECT_EQ(second.status(), "running");
}

TEST_F(ResultsFile, HalfWrittenCheckpointLeavesTheOlderOne) {
  const std::string file = make_file(path("run.h5"), 2, 3);
  const std::vector<std::byte> payload(5001, std::byte{42});
  {
    hdf5::File f = hdf5::File::open(file, hdf5::File::Access::write);
    EXPECT_TRUE(read_checkpoints(f).empty());
    for (std::uint64_t i = 1; i <= 3; ++i) write_checkpoint(f, {i, payload});
    const std::vector<Checkpoint> both = read_checkpoints(f);
    ASSERT_EQ(both.size(), 2u);
    EXPECT_EQ(both[0].sequence, 3u);
    EXPECT_EQ(both[0].payload, payload);
    EXPECT_EQ(both[1].sequence, 2u);
    std::vector<std::byte> torn = f.read<std::byte>("/checkpoint/slot_1");
    torn.back() ^= std::byte{1};
    f.write<std::byte>("/checkpoint/slot_1", {torn.size()}, torn);
  }
  const hdf5::File f = hdf5::File::open(file, hdf5::File::Access::read);
  const std::vector<Checkpoint> left = read_checkpoints(f);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].sequence, 2u);
  EXPECT_TRUE(Recording(file).has_checkpoint());
}

// Writes frames and checkpoints as a run does, only as fast as it can, until killed. Payload:
// number of frames so far. A byte into the pipe after the second checkpoint, when 20 frames are
// safe.
[[noreturn]] void write_until_killed(const std::string& file, int particles, int pipe) {
  const Case c = case_of(particles);
  const std::vector<Column> columns = result_columns(c);
  Recorder recorder = new_recorder(file, c);
  for (int i = 0;; ++i) {
    if (i % 20 == 0) {
      ByteWriter bytes;
      bytes.put(i);
      bytes.put(std::vector<char>(static_cast<std::size_t>(100000 + 10 * i), 'x'));
      recorder.with_file([&](hdf5::File& f) {
        write_checkpoint(f, {static_cast<std::uint64_t>(i / 20 + 1), bytes.take()});
        recorder.lock().save_copy();
      });
      if (i == 20 && ::write(pipe, "x", 1) != 1) std::abort();
    }
    recorder.push(frame_row(columns, i));
  }
}

TEST_F(ResultsFile, KilledWriterLeavesAReadableFile) {
  for (int trial = 0; trial < 24; ++trial) {
    const std::string file = path("killed.h5");
    fs::remove(file);
    fs::remove(saved_copy(file));
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) write_until_killed(file, trial % 2 ? 2 : 300, ends[1]);
    char begun = 0;
    ASSERT_EQ(::read(ends[0], &begun, 1), 1);
    ::close(ends[0]);
    ::close(ends[1]);
    std::this_thread::sleep_for(std::chrono::milliseconds(5 * trial));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);

    const Recording recording(file);
    const std::size_t frames = recording.frame_times().size();
    for (std::size_t i = 0; i < frames; ++i) {
      const Frame frame = recording.frame(i);
      ASSERT_EQ(frame.time, static_cast<double>(i) / 100.0);
      ASSERT_EQ(frame.position.back()[2], static_cast<double>(i));
      ASSERT_EQ(frame.velocity.front()[0], static_cast<double>(i));
    }
    EXPECT_GE(frames, 20u);

    EXPECT_TRUE(recover_results(ResultsLock(file)));
    const std::vector<Checkpoint> checkpoints =
        read_checkpoints(hdf5::File::open(file, hdf5::File::Access::read));
    ASSERT_FALSE(checkpoints.empty());
    int at_checkpoint = -1;
    ByteReader(checkpoints.front().payload).get(at_checkpoint);
    EXPECT_GE(at_checkpoint, 20);
    EXPECT_LE(static_cast<std::size_t>(at_checkpoint), Recording(file).frame_times().size());
  }
}

}  // namespace
}  // namespace firn
