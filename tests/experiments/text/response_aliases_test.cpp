// Renamed responses: earlier names are read wherever a file or a command names a response.
#include "experiments/text/response_aliases.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/measurements/measurement.h"
#include "experiments/text/toml_document.h"
#include "tests/support/read_text.h"

namespace firn {
namespace {

using testing::HasSubstr;

// With the name of a sensor where the table has an ending.
std::string full_name(std::string_view name) {
  return name.starts_with('_') ? "low" + std::string(name) : std::string(name);
}

TEST(ResponseAliases, EachNameIsFoundBothWays) {
  std::set<std::string> current, first;
  for (const RenamedResponse& r : renamed_responses()) {
    const std::string old = full_name(r.old_name), now = full_name(r.name);
    EXPECT_EQ(current_response_name(old), now);
    EXPECT_EQ(current_response_name(now), now);
    EXPECT_EQ(first_response_name(now), old);
    EXPECT_EQ(first_response_name(old), old);
    EXPECT_EQ(current_response_name("max " + old), "max " + now);
    EXPECT_EQ(current_response_name(old + "[2]"), now + "[2]");
    EXPECT_EQ(first_response_name("median " + now), "median " + old);
    EXPECT_TRUE(current.insert(now).second) << now;
    EXPECT_TRUE(first.insert(old).second) << old;
  }
  for (const std::string& name : first) EXPECT_FALSE(current.contains(name)) << name;
}

TEST(ResponseAliases, OtherNamesStay) {
  for (const char* name :
       {"", " ", "[", "max ", "0.5", "angle_of_repose", "wall_rise_x", "my_wall_rise",
        "_fifo_index", "duration_waiting_times", "peak_stress_on_the_largest_drive",
        "wear_depth_on_the_fifo_index", "contacts_on_a_waiting_times"}) {
    EXPECT_EQ(current_response_name(name), name);
    EXPECT_EQ(first_response_name(name), name);
  }
}

// The page of responses has each current name and no earlier one.
TEST(ResponseAliases, AreInThePage) {
  const std::string page = test::read_text(FIRN_SOURCE_DIR "/docs/responses.md");
  for (const RenamedResponse& r : renamed_responses()) {
    EXPECT_THAT(page, testing::Not(HasSubstr(std::string(r.old_name))));
    if (r.name.ends_with("_right")) continue;  // "`NAME_left`, `_right`"
    EXPECT_THAT(page, HasSubstr(std::string(r.name) + "`"));
  }
}

TEST(ResponseAliases, MeasurementsOfCasesTakeCurrentNames) {
  const auto read = [](const std::string& name, const std::string& operand) {
    return read_measurement_text(
        fmt::format("name = \"m\"\nresponse = \"{}\"\nstatus = \"qualitative\"\nstatement = \"s\"\n"
                    "source = \"here\"\n[[criteria]]\nstatement = \"s\"\nlhs = \"{}\"\n"
                    "rhs = \"0.5\"\nrationale = \"r\"\n",
                    name, operand),
        "old_responses.toml");
  };
  Measurement m = read("wall_rise", "max low_waiting_times");
  EXPECT_EQ(m.response, "wall_rise");  // perhaps of a program of the user
  testing::internal::CaptureStderr();
  use_current_responses(m);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "firn: warning: old_responses.toml:2: response: \"wall_rise\" is now "
            "\"wall_height_excess\"; the old name is read by this version only\n"
            "firn: warning: old_responses.toml:8: criteria.0.lhs: \"max low_waiting_times\" is now "
            "\"max low_censored_times\"; the old name is read by this version only\n");
  EXPECT_EQ(m.response, "wall_height_excess");
  EXPECT_EQ(m.criteria.at(0).lhs, "max low_censored_times");
  EXPECT_EQ(m.criteria.at(0).rhs, "0.5");
}

TEST(ResponseAliases, StudiesKeepTheirIdentity) {
  const auto study = [](const char* target, const char* observed) {
    return fmt::format(
        "[study]\nname = \"s\"\n[[targets]]\nresponse = \"{}\"\nvalue = 1\n"
        "[[observe]]\nresponse = \"{}\"\n",
        target, observed);
  };
  const std::string old = study("wall_rise", "low_fifo_index");
  const std::string now = study("wall_height_excess", "low_order_index");
  TomlDocument as_it_was(old, "s.toml");
  EXPECT_EQ(study_identity(now, "s.toml"), as_it_was.text());
  EXPECT_EQ(study_identity(old, "s.toml"), as_it_was.text());
}

}  // namespace
}  // namespace firn
