// results.json of earlier versions.
#include "calibrate/output/study_document.h"

#include <gtest/gtest.h>

#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

TEST(StudyDocument, ReadsTheResidualOfASurrogateByEachOfItsNames) {
  const Folder folder("old-results");
  for (const char* key : {"departure_sd", "discrepancy_sd", "gp_residual_sd"}) {
    const std::string name = key;
    const std::string file =
        folder.write(name + ".json", R"({"study": "s", "verdict": "calibrated", "parameters": [],
           "targets": [{"response": "y", "value": 1, "uncertainty": 0.1, "discrepancy": 0.5}],
           "models": [{"response": "y", "points": 8, ")" +
                                         name + R"(": 0.25}]})");
    const StudyDocument d = read_study_document(read_results_json(file));
    ASSERT_EQ(d.models.size(), 1u) << name;
    EXPECT_EQ(d.models[0].gp_residual_sd, 0.25) << name;
    // The systematic error of the simulation is another one.
    EXPECT_EQ(d.targets.at(0).discrepancy, 0.5) << name;
    EXPECT_EQ(render_json(d).find("discrepancy_sd"), std::string::npos);
  }
}

}  // namespace
}  // namespace firn
