#include "experiments/batch/batch_state.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "experiments/system/output_file.h"
#include "experiments/text/json_reader.h"
#include "firn/math.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kMostRuns = 1'000'000'000;

void read_progress(const std::string& text, const std::string& source, BatchState& state) {
  const nlohmann::json json = parse_json(text, source);
  const JsonReader progress(json, source, "progress");
  progress.allow({"command", "most_runs", "jobs", "knowledge"});
  state.command = progress.string("command");
  state.most_runs = static_cast<int>(progress.integer("most_runs", 0, kMostRuns));
  state.jobs = static_cast<int>(progress.integer("jobs", 0, kMostRuns));
  if (!progress.has("knowledge")) return;
  const JsonReader knowledge = progress.at("knowledge");
  knowledge.allow({"best", "determined", "targets"});
  if (!json["knowledge"].contains("best") || !json["knowledge"]["best"].is_object())
    knowledge.fail("has no object \"best\"; expected the parameters");
  const JsonReader best = knowledge.at("best");
  for (const auto& [name, value] : json["knowledge"]["best"].items()) {
    const JsonReader p = best.at(name);
    state.best.push_back(
        {name, p.string_or_empty("unit"), p.number("value"), p.number("low"), p.number("high")});
  }
  for (const JsonReader& t : knowledge.items("targets"))
    state.targets.push_back({t.string("response"), t.number("value")});
  for (const JsonReader& d : knowledge.items("determined"))
    state.determined.push_back(fmt::format("{} = {:.3g} ± {:.2g}", d.string("combination"),
                                           d.number("value"), d.number("uncertainty")));
}

}  // namespace

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
  const int left = std::max(most_runs, static_cast<int>(runs.size())) - ended();
  const int side_by_side = std::max(jobs, count("running"));
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
  if (!content.progress.empty()) read_progress(content.progress, file, state);
  return state;
}

std::string progress_text(const std::string& command, int most_runs, int jobs,
                          const std::string& knowledge) {
  nlohmann::ordered_json json = {{"command", command}, {"most_runs", most_runs}, {"jobs", jobs}};
  if (!knowledge.empty()) json["knowledge"] = nlohmann::ordered_json::parse(knowledge);
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace firn
