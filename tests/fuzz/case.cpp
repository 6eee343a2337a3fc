// Case files: any text. What is accepted resolves to a text that is the same case.
#include "experiments/case/case.h"

#include "experiments/case_reader/read_case.h"
#include "tests/fuzz/case_promises.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const fuzz::CaseFolder folder;
  const std::string text(fuzz::text_of(data, size));
  fuzz::accepts([&] {
    fuzz::require_round_trip(read_case_text(text, "case.toml", folder.path(".")), folder);
  });
  return 0;
}
