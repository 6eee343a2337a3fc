// Suite files of validations, with a case and measurements that exist.
#include <cmath>

#include "experiments/responses/response_expression.h"
#include "tests/fuzz/fuzz_target.h"
#include "validation/suite/suite_file.h"

namespace {

// The names that the corpus refers to.
class SuiteFolder : public firn::fuzz::Folder {
 public:
  SuiteFolder() {
    namespace fs = std::filesystem;
    const fs::path shipped = fs::path(FIRN_SOURCE_DIR) / "cases";
    fs::create_directories(path("measurements"));
    fs::copy_file(shipped / "bounce" / "case.toml", path("case.toml"));
    for (const char* name :
         {"breaking_force.toml", "half_of_the_ice.toml", "columns_in_the_container.toml"})
      fs::copy_file(shipped / "measurements" / name, path(std::string("measurements/") + name));
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const SuiteFolder folder;
  const std::string file = folder.put("suite.toml", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const Suite suite = read_suite(file);
    fuzz::require(!suite.comparisons.empty(), "a suite compares something");
    fuzz::require(!suite.parameter_sets.empty(), "a suite has parameters");
    for (const SuiteExperiment& e : suite.experiments) {
      fuzz::require(!e.seeds.empty(), "an experiment has runs");
      for (const double factor : e.refine.timesteps)
        fuzz::require(factor > 0 && factor < 1, "a finer time step is finer");
      for (const double modulus : e.refine.stiffness)
        fuzz::require(modulus > 0 && std::isfinite(modulus), "a modulus is above zero");
    }
    for (const SuiteComparison& c : suite.comparisons) {
      fuzz::require(c.experiment < suite.experiments.size(), "a comparison has its experiment");
      fuzz::require(!c.tolerance || (*c.tolerance > 0 && std::isfinite(*c.tolerance)),
                    "a tolerance is above zero");
      for (const std::string& operand : c.responses)
        if (c.kind != ComparisonKind::value) parse_response_expression(operand);
    }
  });
  return 0;
}
