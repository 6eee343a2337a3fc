// firn measure --photo: the command of its page, what it writes, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "calibrate/study/study_file.h"
#include "experiments/measurements/measurement.h"
#include "tests/app/program.h"
#include "tests/support/replaced.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A folder in which the shipped cases are where the pages have them.
class PhotoCommand : public testing::Test {
 protected:
  PhotoCommand() {
    fs::create_directory_symlink(fs::path(FIRN_SOURCE_DIR) / "cases", folder_.path() / "cases");
  }
  Outcome measure(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "measure");
    return folder_.firn(arguments);
  }
  Outcome measure_example(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"--photo", "cases/photo/heap.jpg", "--setup",
                                       "cases/photo/setup.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return measure(arguments);
  }
  void expect_refused(const Outcome& o, const std::string& message) const {
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(lines(o.err), 1U) << o.err;
    EXPECT_THAT(o.err, HasSubstr(message));
  }
  Folder folder_;
};

TEST_F(PhotoCommand, TheCommandOfThePageDoesWhatThePageShows) {
  const std::string page = read_text(fs::path(FIRN_SOURCE_DIR) / "docs/photo.md");
  const std::string start = "./firn measure ";
  const auto at = page.find(start);
  ASSERT_NE(at, std::string::npos);
  std::istringstream words(page.substr(at, page.find('\n', at) - at));
  std::vector<std::string> command;
  for (std::string word; words >> word;) command.push_back(word);
  const Outcome o = folder_.firn({command.begin() + 1, command.end()});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(page, HasSubstr("```\n" + o.out + "```"));
  ASSERT_TRUE(folder_.contains("heap_angle.png"));
  EXPECT_EQ(read_text(folder_.path() / "heap_angle.png").substr(1, 3), "PNG");

  const Measurement m = read_measurement((folder_.path() / "heap_angle.toml").string());
  EXPECT_EQ(m.response, "angle_of_repose_outline");
  EXPECT_NEAR(m.value, 24, 2.5);
  EXPECT_THAT(m.source, HasSubstr("photograph heap.jpg (SHA-256 "));

  // A study takes it as a target.
  std::string study = read_text(folder_.path() / "cases/drained_repose/study.toml");
  const auto replace = [&](const std::string& from, const std::string& to) {
    study = test::replaced(study, from, to);
  };
  replace("\"../measurements/drained_angle_of_repose.toml\"", "\"heap_angle.toml\"");
  replace("response = \"angle_of_repose\"", "response = \"angle_of_repose_outline\"");
  replace("case = \"case.toml\"", "case = \"cases/drained_repose/case.toml\"");
  const Study read = read_study((folder_.path() / folder_.write("study.toml", study)).string());
  ASSERT_FALSE(read.targets.empty());
  EXPECT_EQ(read.targets[0].value, m.value);
  EXPECT_NEAR(read.targets[0].uncertainty, m.standard_uncertainty(), 1e-9);
}

TEST_F(PhotoCommand, SeveralPhotographsHaveAPictureEach) {
  const Outcome o =
      measure_example({"--photo", "cases/photo/heap.jpg", "--picture", "check.svg", "--json"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(folder_.contains("check-1.svg"));
  EXPECT_TRUE(folder_.contains("check-2.svg"));
  EXPECT_THAT(o.out, HasSubstr("\"corner_residual_pixels\""));
  EXPECT_EQ(measure_example({}).status, 0);  // no file, no picture
  EXPECT_FALSE(folder_.contains("check.svg"));
}

TEST_F(PhotoCommand, MistakesAreOneLine) {
  expect_refused(measure({}), "RUN.h5 is required");
  expect_refused(measure({"--photo", "cases/photo/heap.jpg"}), "--setup is required");
  expect_refused(measure({"--setup", "cases/photo/setup.toml"}), "--setup requires --photo");
  expect_refused(measure_example({"run.h5"}), "run.h5: ");
  expect_refused(measure_example({"--response", "x"}), "--response");
  expect_refused(measure_example({"--picture", "check.gif"}), "check.gif: no format of pictures");
  expect_refused(measure_example({"-o", "nowhere/m.toml"}), "nowhere/m.toml: cannot be written");
  expect_refused(measure({"--photo", "none.png", "--setup", "cases/photo/setup.toml"}),
                 "none.png: ");
  expect_refused(
      measure({"--photo", "cases/photo/setup.toml", "--setup", "cases/photo/setup.toml"}),
      "is neither PNG nor JPEG");
  expect_refused(measure({"--photo", "cases", "--setup", "cases/photo/setup.toml"}), "cases: ");
  fs::copy_file(folder_.path() / "cases/photo/heap.jpg", folder_.path() / "heap.png");
  fs::copy_file(folder_.path() / "cases/photo/setup.toml", folder_.path() / "setup.toml");
  const std::vector<std::string> own{"--photo", "heap.png", "--setup", "setup.toml"};
  const auto with = [&](const std::string& option, const std::string& file) {
    std::vector<std::string> arguments = own;
    arguments.insert(arguments.end(), {option, file});
    return measure(arguments);
  };
  expect_refused(with("-o", "setup.toml"), "setup.toml: is an input, too");
  expect_refused(with("--picture", "heap.png"), "heap.png: is an input, too");
  expect_refused(with("-o", "heap.toml"), "heap.png: is an input, too");
  EXPECT_EQ(read_text(folder_.path() / "heap.png"),
            read_text(folder_.path() / "cases/photo/heap.jpg"));
}

}  // namespace
}  // namespace firn::cli
