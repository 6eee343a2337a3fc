// firn optimize, end to end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// The mass of two boxes grows with their density; more than 20 g is not allowed.
constexpr const char* heaviest = R"([optimization]
name = "boxes"
case = "case.toml"
maximize = "present_mass"
runs = 34
replicates_per_design = 2
confirmation_replicates = 4
[[parameters]]
name = "density"
keys = ["materials.ice.density"]
min = "900 kg/m^3"
max = "1800 kg/m^3"
[[limits]]
response = "present_mass"
above = "0.02 kg"
probability = 0.2
[[compare]]
name = "as it is"
values = { density = "917 kg/m^3" }
)";

struct Optimization : Folder {
  Optimization() {
    write("case.toml", two_boxes);
    write("optimization.toml", heaviest);
  }
  Outcome with(const std::string& part, const std::string& other) const {
    write("changed.toml", test::replaced(heaviest, part, other));
    return firn({"optimize", "changed.toml", "-o", "out", "--progress", "none"});
  }
};

TEST(OptimizeCommand, FindsTheBestDesignWithinItsLimit) {
  const Optimization folder;
  const Outcome o = folder.firn({"optimize", "optimization.toml", "-o", "out", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  EXPECT_EQ(result, json::parse(read_text(folder.path() / "out/results.json")));
  const json& best = result["best"];
  // Two boxes of 8 cm^3: 20 g at 1250 kg/m^3.
  EXPECT_LT(best["values"][0], 1300);
  EXPECT_GT(best["values"][0], 1000);
  EXPECT_NEAR(best["mean"], 16e-6 * best["values"][0].get<double>(), 1e-6);
  EXPECT_EQ(best["events"][0]["runs"], 4);
  EXPECT_EQ(result["runs"], 34);
  EXPECT_EQ(result["gains"][0]["over"], "as it is");
  EXPECT_NEAR(result["gains"][0]["mean"], 16e-6 * (best["values"][0].get<double>() - 917), 1e-6);
  const std::string page = read_text(folder.path() / "out/report.html");
  for (const char* part : {"The best design", "as it is", "Over each parameter", "refute"})
    EXPECT_THAT(page, HasSubstr(part));
  const Outcome again =
      folder.firn({"optimize", "optimization.toml", "-o", "out", "--progress", "json"});
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.err, testing::Not(HasSubstr("\"started\"")));
  EXPECT_THAT(again.out, HasSubstr("By fresh seeds"));
  EXPECT_THAT(again.out, HasSubstr("best minus as it is"));
}

TEST(OptimizeCommand, RefusesAResponseThatTheCaseDoesNotHave) {
  const Outcome o = Optimization().with("maximize = \"present_mass\"", "maximize = \"profit\"");
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_THAT(o.err, HasSubstr("\"profit\" is not a single-valued response"));
}

TEST(OptimizeCommand, RefusesAKeyThatTheCaseDoesNotHave) {
  const Outcome o = Optimization().with("materials.ice.density", "materials.ice.densities");
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_THAT(o.err, HasSubstr("densities"));
}

}  // namespace
}  // namespace firn::cli
