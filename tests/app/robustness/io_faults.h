// A program whose writes fail, stop it, or are recorded (tests/io_shim), and what a power failure
// leaves of recorded ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace firn::cli {

// Whether the shim can be loaded into this build of the program. The thread sanitizer's runtime
// must see the calls of all libraries first, so not into a program with that.
bool io_shim_works();
// Sets the environment of a child that is to load it.
void load_io_shim();

struct IoFaults {
  struct Fail {
    std::uint64_t first = 0;  // call, from 1
    int error = 0;            // errno
    std::uint64_t calls = 1;  // that fail, one after another
  };
  struct Signal {
    std::uint64_t at = 0;  // call, from 1
    int signal = 0;
  };
  std::filesystem::path folder;  // absolute; only calls on files below it count
  std::optional<Fail> fail;
  std::optional<Signal> signal;
  std::string log;  // file of the record; empty: none
};

struct CountedOutcome : Outcome {
  std::uint64_t calls = 0;  // of all its processes, that change files below the folder
};

// firn ARGUMENTS... in the folder under the faults.
CountedOutcome firn_with(const Folder& folder, const IoFaults& faults,
                         const std::vector<std::string>& arguments);

// A call that changed a file: C creates, W writes, T truncates, S syncs a file or a folder,
// R renames, U removes.
struct IoCall {
  char kind = 0;
  std::string path, other;   // absolute
  std::uint64_t offset = 0;  // of W; the size of T
  std::string bytes;         // of W
};
std::vector<IoCall> read_io_log(const std::string& file);

// Contents by absolute path.
using Files = std::map<std::string, std::string>;

// The files after the first `count` calls, when everything reached the device: what a kill leaves.
Files after_kill(const std::vector<IoCall>& calls, std::size_t count);
// When only what was synced before reached it: contents by a sync of the file, names by a sync of
// the folder.
Files after_power_failure(const std::vector<IoCall>& calls, std::size_t count);
// When any part of the rest reached it as well: of the writes to a file each or not, in blocks; of
// the changes of names the first few.
Files after_power_failure(const std::vector<IoCall>& calls, std::size_t count,
                          std::mt19937_64& random);

}  // namespace firn::cli
