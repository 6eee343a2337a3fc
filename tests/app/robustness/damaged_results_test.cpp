// Results files whose bytes are damaged, read by the real program: whatever happens inside the HDF5
// library ends in one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>

#include "experiments/results/results_guard.h"
#include "firn/math.h"
#include "tests/app/program.h"
#include "tests/support/error_of.h"
#include "tests/support/full_case.h"
#include "tests/support/results_mutations.h"

// Exported by the library, not declared in its headers: what object headers are sealed with.
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size,
                                              std::uint32_t initial);

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Where a structure of the format is, and how many bytes of it may be damaged.
struct Piece {
  std::size_t at, size;
  std::size_t sealed;  // bytes before a checksum that is made good again; 0: none
};

// Object headers (with their checksums), B-trees, heaps and the superblock.
std::vector<Piece> pieces_of(const std::string& bytes) {
  std::vector<Piece> pieces = {{8, 88, 0}};
  for (std::size_t i = 0; i + 64 < bytes.size(); ++i) {
    const std::string_view word(&bytes[i], 4);
    if (word == "OHDR") {
      const auto flags = static_cast<unsigned char>(bytes[i + 5]);
      std::size_t head = 6 + (flags & 0x20 ? 16 : 0) + (flags & 0x10 ? 4 : 0), size = 0;
      const std::size_t width = std::size_t{1} << (flags & 3);
      std::memcpy(&size, &bytes[i + head], width);
      head += width;
      if (i + head + size + 4 <= bytes.size()) pieces.push_back({i, head + size, head + size});
    }
    if (word == "TREE" || word == "GCOL" || word == "HEAP" || word == "SNOD" || word == "OCHK" ||
        word == "BTHD" || word == "BTLF" || word == "FRHP" || word == "FHDB" || word == "FSHD")
      pieces.push_back(
          {i, std::min<std::size_t>(word == "GCOL" ? 4096 : 512, bytes.size() - i), 0});
  }
  return pieces;
}

std::string damaged(std::string bytes, const std::vector<Piece>& pieces, std::mt19937_64& random) {
  for (std::size_t left = 1 + random() % 3; left > 0; --left) {
    const Piece& piece = pieces[random() % pieces.size()];
    const std::size_t at = piece.at + random() % piece.size;
    switch (random() % 5) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
        break;
      case 2: {
        const std::uint64_t value = (std::uint64_t{1} << random() % 64) - random() % 3;
        std::memcpy(&bytes[at], &value, std::min<std::size_t>(8, bytes.size() - at));
        break;
      }
      case 3:
        std::memset(&bytes[at], random() % 2 ? 0xff : 0,
                    std::min<std::size_t>(1 + random() % 16, bytes.size() - at));
        break;
      default: {
        const Piece& from = pieces[random() % pieces.size()];
        std::memmove(&bytes[at], &bytes[from.at],
                     std::min({bytes.size() - at, bytes.size() - from.at, from.size,
                               std::size_t{1} + random() % 64}));
      }
    }
    if (piece.sealed == 0) continue;
    const std::uint32_t sum = H5_checksum_metadata(&bytes[piece.at], piece.sealed, 0);
    std::memcpy(&bytes[piece.at + piece.sealed], &sum, sizeof(sum));
  }
  return bytes;
}

class DamagedResults : public testing::Test {
 protected:
  // Everything that a command may do with a file that it is given.
  void expect_promise(const std::string& file, const std::vector<std::string>& arguments) {
    const Outcome o = folder_.firn(arguments);
    ++statuses_[o.status];
    EXPECT_TRUE(o.status == 0 || o.status == 2) << arguments[0] << ": " << o.status << " " << o.err;
    if (o.status != 2) return;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_THAT(o.err, HasSubstr(file)) << arguments[0];
    // No exception and no allocation that Firn did not foresee: those end with status 1.
    EXPECT_THAT(o.err, testing::Not(HasSubstr("(no result)")));
    crashes_ += o.err.find("the HDF5 library failed") != std::string::npos;
  }

  void try_members(std::uint64_t first, int count) {
    test::run_full_case((folder_.path() / "whole.h5").string());
    test::run_half_of_full_case((folder_.path() / "half.h5").string());
    const std::string whole = read_text(folder_.path() / "whole.h5"),
                      half = read_text(folder_.path() / "half.h5");
    const std::vector<Piece> of_whole = pieces_of(whole), of_half = pieces_of(half);
    EXPECT_GT(of_whole.size(), 100u);
    for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
      std::mt19937_64 random(seed);
      const bool is_half = seed % 4 == 3;
      folder_.write("damaged.h5",
                    damaged(is_half ? half : whole, is_half ? of_half : of_whole, random));
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      expect_promise("damaged.h5", {"measure", "damaged.h5"});
      if (seed % 8 == 0) expect_promise("damaged.h5", {"export", "damaged.h5", "--to", "csv"});
      if (seed % 8 == 1) expect_promise("damaged.h5", {"export", "damaged.h5", "--to", "vtk"});
    }
    RecordProperty("crashes_inside_hdf5", crashes_);
    std::printf("%d of %d ended in a crash of the checking process; status 0: %d, 2: %d\n",
                crashes_, count, statuses_[0], statuses_[2]);
    EXPECT_GT(statuses_[0], count / 50);
    EXPECT_GT(statuses_[2], count / 5);
  }

  Folder folder_;
  std::map<int, int> statuses_;
  int crashes_ = 0;
};

TEST_F(DamagedResults, EndInOneLine) { try_members(1, 150); }

using DamagedResultsLong = DamagedResults;
// In pieces that each end within the time limit of a test.
class DamagedMembersLong : public DamagedResults,
                           public testing::WithParamInterface<std::uint64_t> {};
TEST_P(DamagedMembersLong, EndInOneLine) { try_members(1000000 + 750 * GetParam(), 750); }
INSTANTIATE_TEST_SUITE_P(Members, DamagedMembersLong,
                         testing::Range(std::uint64_t{0}, std::uint64_t{8}));

// Every command that opens results files, over files that break the schema.
TEST_F(DamagedResults, AreNamedByEveryCommand) {
  const std::string whole = (folder_.path() / "whole.h5").string();
  test::run_full_case(whole);
  const auto draw = [](std::size_t) { return std::size_t{0}; };
  const std::vector<std::pair<std::string, std::function<void(test::ResultsMutator&)>>> changes = {
      {"/bonds/a: has 2 entries; expected 1, as /bonds/name",
       [](auto& m) { m.replace("/bonds/a", {2}, H5T_NATIVE_INT); }},
      {"/particles/mass: entry 0 is -26; expected a finite number above 0",
       [](auto& m) { m.overwrite("/particles/mass", 0, 1, -26); }},
      {"groups deep; expected at most 32", [](auto& m) { m.nest_groups("/deep", 5000); }},
      {"/stages/start: has no values and no shape; expected [S]",
       [](auto& m) { m.replace("/stages/start", {}, H5T_NATIVE_DOUBLE, H5S_NULL); }},
  };
  std::string start = test::kFullCase;
  start.replace(start.find("[[particles]]"),
                start.find("[[motion_frames]]") - start.find("[[particles]]"),
                "[initial_state]\nfile = \"bad.h5\"\n");
  start.resize(start.find("[[bonds]]"));
  folder_.write("start.toml", start);
  for (const auto& [message, change] : changes) {
    fs::copy_file(whole, folder_.path() / "bad.h5", fs::copy_options::overwrite_existing);
    {
      test::ResultsMutator mutator((folder_.path() / "bad.h5").string(), draw);
      change(mutator);
    }
    for (const std::vector<std::string>& arguments :
         std::vector<std::vector<std::string>>{{"measure", "bad.h5"},
                                               {"export", "bad.h5", "--to", "csv"},
                                               {"export", "bad.h5", "--to", "vtk"},
                                               {"export", "bad.h5", "--to", "png"},
                                               {"report", "bad.h5"},
                                               {"contacts", "bad.h5", "--time", "2 ms"},
                                               {"run", "--resume", "bad.h5"},
                                               {"run", "start.toml", "-o", "new.h5"}}) {
      const Outcome o = folder_.firn(arguments);
      EXPECT_EQ(o.status, 2) << arguments[0] << " " << o.err;
      EXPECT_EQ(lines(o.err), 1u) << o.err;
      EXPECT_THAT(o.err, HasSubstr("bad.h5"));
      EXPECT_THAT(o.err, HasSubstr(message)) << arguments[0];
    }
  }
  EXPECT_EQ(fs::exists(folder_.path() / "new.h5"), false);
}

// Gives a file the attribute without which no reader continues to its objects; in a separate
// process, as the library may crash over it.
void mark_as_results(const std::string& file) {
  const pid_t child = fork();
  if (child == 0) {
    test::ResultsMutator(file, [](std::size_t) {
      return std::size_t{0};
    }).set_text("/", "firn_version", "0.1.0");
    _exit(0);
  }
  waitpid(child, nullptr, 0);
}

// The malformed files of the library's own tests: scripts/fetch-hdf5-corpus.sh.
TEST_F(DamagedResultsLong, CorpusOfTheLibraryEndsInOneLine) {
  const char* const corpus = std::getenv("FIRN_HDF5_CORPUS");
  if (!corpus) GTEST_SKIP() << "FIRN_HDF5_CORPUS is not set; see docs/testing.md";
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
    if (entry.path().extension() != ".h5") continue;
    ++files;
    const std::string name = entry.path().filename().string();
    fs::copy_file(entry.path(), folder_.path() / name, fs::copy_options::overwrite_existing);
    expect_promise(name, {"measure", name});
    mark_as_results((folder_.path() / name).string());
    expect_promise(name, {"measure", name});
  }
  std::printf("%d files, %d crashes of the checking process\n", files, crashes_);
  EXPECT_GT(files, 100);
  EXPECT_EQ(statuses_[2], 2 * files);
}

// Scripts in place of the program show what becomes of it.
class ResultsGuard : public DamagedResults {
 protected:
  ~ResultsGuard() override { guard_results_with(""); }
  std::string message_with(const std::string& script) {
    const std::string file = folder_.write("run.h5", "bytes " + script);
    const fs::path program = folder_.path() / folder_.write("checker", "#!/bin/sh\n" + script);
    fs::permissions(program, fs::perms::owner_all);
    guard_results_with(program.string());
    return test::error_if_any([&] { check_in_child((folder_.path() / file).string(), "RUN.h5"); });
  }
};

TEST_F(ResultsGuard, PassesOnWhatTheChildSays) {
  EXPECT_EQ(message_with("exit 0\n"), "");
  EXPECT_EQ(message_with("echo '/x: is wrong'; exit 2\n"), "RUN.h5: /x: is wrong");
}

TEST_F(ResultsGuard, TurnsACrashIntoOneLine) {
  EXPECT_EQ(message_with("kill -SEGV $$\n"),
            "RUN.h5: damaged: the HDF5 library failed while reading it (Segmentation fault); "
            "expected a whole file");
  EXPECT_THAT(message_with("kill -ABRT $$\n"), HasSubstr("(Aborted)"));
  EXPECT_THAT(message_with("exit 1\n"), HasSubstr("the HDF5 library failed"));
}

TEST_F(ResultsGuard, RepeatsACheckThatWasEndedFromOutside) {
  for (const std::string signal : {"INT", "TERM", "HUP", "KILL"}) {
    const std::string calls = (folder_.path() / ("calls" + signal)).string();
    const std::string count = "echo >> " + calls + "; ";
    EXPECT_EQ(message_with(count + "[ $(wc -l < " + calls + ") -gt 2 ] || kill -" + signal +
                           " $$\nexit 0\n"),
              "")
        << signal;
    EXPECT_EQ(lines(read_text(calls)), 3u) << signal;
    EXPECT_THAT(
        [&] { message_with("kill -" + signal + " $$\n"); },
        testing::ThrowsMessage<RunError>(HasSubstr("RUN.h5: the process that checks it: signal ")))
        << signal;
  }
}

TEST_F(ResultsGuard, LimitsTimeAndMemory) {
  EXPECT_THAT(message_with("ulimit -S -t 1; while :; do :; done\n"),
              HasSubstr("the HDF5 library failed while reading it ("));
  EXPECT_THAT(message_with("echo \"/x: $(ulimit -t)\"; exit 2\n"), HasSubstr("/x: 30"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_THAT(message_with("echo \"/x: $(ulimit -v)\"; exit 2\n"), HasSubstr("/x: 39062"));
#endif
  EXPECT_THAT(message_with("echo \"/x: $MALLOC_PERTURB_\"; exit 2\n"), HasSubstr("/x: 165"));
}

TEST_F(ResultsGuard, ChecksAFileOnceUntilItChanges) {
  const std::string script = "echo >> " + (folder_.path() / "calls").string() + "\n";
  EXPECT_EQ(message_with(script), "");
  const std::string file = (folder_.path() / "run.h5").string();
  check_in_child(file, "RUN.h5");
  EXPECT_EQ(lines(read_text(folder_.path() / "calls")), 1u);
  std::ofstream(file, std::ios::app) << "more";
  check_in_child(file, "RUN.h5");
  EXPECT_EQ(lines(read_text(folder_.path() / "calls")), 2u);
}

}  // namespace
}  // namespace firn::cli
