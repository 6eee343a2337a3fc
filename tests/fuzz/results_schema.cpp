// Results files that HDF5 can read and that break the schema in one to three places: every reader
// of them. An input decides what is changed in the file of a run with everything in it.
#include <cstdio>
#include <filesystem>

#include "tests/fuzz/fuzz_target.h"
#include "tests/support/results_mutations.h"
#include "tests/support/results_readers.h"

namespace {

using namespace firn;

// A finished run and an interrupted one.
struct Runs {
  explicit Runs(const fuzz::Folder& folder)
      : whole(folder.path("whole.h5")), half(folder.path("half.h5")) {
    test::run_full_case(whole);
    test::run_half_of_full_case(half);
  }
  std::string whole, half;
};

// Bytes of the input as numbers; zeros when they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : next_(data), end_(data + size) {}
  std::size_t below(std::size_t limit) {
    const std::size_t value = byte() + (limit > 256 ? std::size_t{256} * byte() : 0);
    return value % limit;
  }

 private:
  std::size_t byte() { return next_ < end_ ? *next_++ : 0; }
  const std::uint8_t *next_, *end_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const Runs runs(folder);
  Bytes bytes(data, size);
  const std::string file = folder.path("member.h5");
  const std::size_t kind = bytes.below(64);
  std::filesystem::copy_file(kind % 4 == 3 ? runs.half : runs.whole, file,
                             std::filesystem::copy_options::overwrite_existing);
  std::string did;
  {
    test::ResultsMutator mutator(file, [&](std::size_t below) { return bytes.below(below); });
    did = mutator.mutate();
  }
  try {
    test::read_everything(file, folder.path("out"), kind == 0);
  } catch (const test::Broken& broken) {
    fuzz::broken(did + broken.what());
  }
  return 0;
}
