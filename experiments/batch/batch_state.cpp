#include "experiments/batch/batch_state.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "experiments/system/output_file.h"
#include "experiments/text/json_parser.h"
#include "firn/math.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kMostRuns = 1'000'000'000;

BatchProgressRecord read_progress(const std::string& text, const std::string& file) {
  const nlohmann::ordered_json json = parse_json(text, file);
  BatchProgressRecord progress;
  JsonFieldReader::read(json, {file, JsonReading::tolerant, nullptr, "progress"}, progress);
  for (const int count : {progress.most_runs, progress.jobs})
    if (count < 0)  // the reader refuses larger ones than kMostRuns
      throw InputError(fmt::format("{}: progress: {} runs; expected a number from 0 to {}", file,
                                   count, kMostRuns));
  return progress;
}

}  // namespace

std::string BatchKnowledge::Determined::text() const {
  return fmt::format("{} = {:.3g} ± {:.2g}", combination, value, uncertainty);
}

double time_left(double mean_wall, int left, int side_by_side) {
  if (left <= 0 || side_by_side == 0) return std::numeric_limits<double>::quiet_NaN();
  return mean_wall * left / std::min(side_by_side, left);
}

int BatchState::count(const std::string& status) const {
  return static_cast<int>(std::ranges::count(runs, status, &JournalRun::status));
}

int BatchState::ended() const {
  return static_cast<int>(runs.size()) - count("planned") - count("running");
}

double BatchState::mean_wall() const {
  double sum = 0;
  int number = 0;
  for (const JournalRun& run : runs) {
    if (!(run.result.wall > 0)) continue;
    sum += run.result.wall;
    ++number;
  }
  return number > 0 ? sum / number : std::numeric_limits<double>::quiet_NaN();
}

double BatchState::time_left() const {
  const int left = std::max(progress.most_runs, static_cast<int>(runs.size())) - ended();
  const int side_by_side = std::max(progress.jobs, count("running"));
  return firn::time_left(mean_wall(), left, side_by_side);
}

bool is_at_work(const std::string& folder) {
  const Descriptor lock(
      ::open((fs::path(folder) / "lock").c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (lock.number() < 0) return false;
  return ::flock(lock.number(), LOCK_SH | LOCK_NB) != 0;
}

std::optional<BatchState> read_batch_state(const std::string& folder) {
  const std::string file = (fs::path(folder) / "study.db").string();
  std::error_code unreadable;
  if (!fs::exists(file, unreadable)) return std::nullopt;
  BatchState state;
  state.at_work = is_at_work(folder);
  JournalContent content = read_journal(file);
  state.runs = std::move(content.runs);
  if (!content.progress.empty()) state.progress = read_progress(content.progress, file);
  return state;
}

}  // namespace firn
