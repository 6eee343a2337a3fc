// Sweep files, with a case that exists.
#include "experiments/batch/sweep/sweep.h"

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const fuzz::FolderWithCase folder;
  const std::string file = folder.put("sweep.toml", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const Sweep sweep = read_sweep(file);
    fuzz::require(!sweep.name.empty() && !sweep.seeds.empty(), "a sweep has a name and seeds");
    fuzz::require(sweep.combinations() >= 1, "a sweep has something to run");
    const std::size_t last = sweep.combinations() - 1;
    for (const std::size_t c : {std::size_t{0}, last})
      fuzz::require(sweep.values(c).size() == sweep.vary.size(), "every key has its value");
  });
  return 0;
}
