#include "reports/rendering/film.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiments/case_reader/read_case.h"
#include "experiments/run/run.h"
#include "experiments/system/process.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Film : public ResultsFolder {
 protected:
  void SetUp() override {
    ASSERT_EQ(run(read_case_text(kTray, "tray.toml", "."), options("run.h5")).status,
              RunStatus::finished);
  }
};

TEST_F(Film, LastsAsLongAsTheRunAtItsSpeed) {
  const Recording recording(path("run.h5"));
  const std::vector<double> times = recording.frame_times();
  for (const double speed : {1.0, 0.5}) {
    FilmOptions film;
    film.speed = speed;
    film.width = 640;
    std::size_t drawn = 0;
    film.progress = [&](std::size_t done, std::size_t of) {
      EXPECT_EQ(done, ++drawn);
      EXPECT_LE(done, of);
    };
    write_film(recording, path("film.mp4"), film);
    const auto pictures =
        static_cast<std::size_t>((times.back() - times.front()) / speed * 25 * (1 + 1e-9)) + 1;
    EXPECT_EQ(drawn, pictures);
    const CommandResult result = run_command({"ffprobe", "-v", "error", "-count_frames",
                                              "-show_streams", "-of", "json", path("film.mp4")});
    ASSERT_EQ(result.status, 0) << result.err;
    const json stream = json::parse(result.out)["streams"][0];
    EXPECT_EQ(stream["codec_name"], "h264");
    EXPECT_EQ(stream["width"], 640);
    EXPECT_EQ(stream["height"], 360);
    EXPECT_EQ(stream["nb_read_frames"], std::to_string(pictures));
  }
}

TEST_F(Film, WrongRequestsAreOneLine) {
  const Recording recording(path("run.h5"));
  const auto refusal = [&](const std::string& file, double speed) {
    FilmOptions film;
    film.speed = speed;
    return test::error_of([&] { write_film(recording, path(file), film); });
  };
  EXPECT_THAT(refusal("film.avi", 1), HasSubstr("expected FILE.mp4"));
  for (const double speed : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()})
    EXPECT_THAT(refusal("film.mp4", speed), HasSubstr("expected a number above 0"));
  EXPECT_THAT(refusal("film.mp4", 1e-9), HasSubstr("expected at most 100000"));
}

}  // namespace
}  // namespace firn
