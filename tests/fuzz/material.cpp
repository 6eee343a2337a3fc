// Files of material records. What is accepted is written and read again without a bit lost, and can
// be sampled wherever it has an ensemble.
#include <cmath>

#include "experiments/material_records/material_json.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  std::vector<MaterialRecord> records;
  const bool accepted = fuzz::accepts([&] {
    for (const ReadRecord& r : read_records_text(fuzz::text_of(data, size), "records.json"))
      records.push_back(r.record);
  });
  if (!accepted) return 0;
  const std::string text = export_text(records);
  std::vector<ReadRecord> again;
  fuzz::require(fuzz::accepts([&] { again = read_records_text(text, "again.json"); }),
                "what was written is read");
  fuzz::require(again.size() == records.size(), "no record is lost");
  for (std::size_t i = 0; i < records.size(); ++i) {
    fuzz::require(canonical_text(again[i].record) == canonical_text(records[i]),
                  "nor a bit of one");
    fuzz::require(again[i].sha256 == record_hash(records[i]), "its hash is its content's");
    if (!records[i].ensemble) continue;
    MaterialChoice choice;
    choice.sample = 1 + size;
    fuzz::accepts([&] {
      for (const double value : chosen_values(records[i], choice))
        fuzz::require(std::isfinite(value), "a sampled value is finite");
    });
  }
  return 0;
}
