// Study files, with a case and a measurement that exist.
#include <cmath>

#include "calibrate/study/study_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

// The names that the shipped study refers to.
class StudyFolder : public firn::fuzz::Folder {
 public:
  StudyFolder() {
    namespace fs = std::filesystem;
    const fs::path shipped = fs::path(FIRN_SOURCE_DIR) / "cases";
    fs::create_directories(path("drained_repose"));
    fs::create_directories(path("measurements"));
    fs::copy_file(shipped / "drained_repose" / "case.toml", path("drained_repose/case.toml"));
    fs::copy_file(shipped / "measurements" / "drained_angle_of_repose.toml",
                  path("measurements/drained_angle_of_repose.toml"));
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const StudyFolder folder;
  const std::string file = folder.put("drained_repose/study.toml", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const Study study = read_study(file);
    fuzz::require(study.largest_total() > 0, "a study has runs");
    for (const Parameter& p : study.parameters) {
      fuzz::require(p.min < p.max && std::isfinite(p.max - p.min), "a range is finite");
      fuzz::require_one_line(p.name);
    }
    for (const Target& t : study.targets) {
      fuzz::require(std::isfinite(t.value) && t.uncertainty > 0 && std::isfinite(t.uncertainty),
                    "a target has a value and an uncertainty");
      fuzz::require(t.discrepancy >= 0 && std::isfinite(t.sd()), "a discrepancy is finite");
    }
    if (study.choice) {
      double sum = 0;
      for (const double p : study.choice->prior) sum += p;
      fuzz::require(study.choice->values.size() >= 2 && std::abs(sum - 1) < 1e-5,
                    "choices have probabilities");
      for (const std::string& label : study.choice->labels) fuzz::require_one_line(label);
    }
    for (const CompareSet& set : study.compare) {
      fuzz::require(set.values.size() == study.parameters.size(), "a compare set is complete");
      for (double v : set.values) fuzz::require(std::isfinite(v), "its values are finite");
    }
  });
  return 0;
}
