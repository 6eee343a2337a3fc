#include "reports/documents/validation_replays.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <set>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/system/text_encoding.h"
#include "reports/replay/replay_view.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Where a run's file is now: folders are moved with their runs. Empty: nowhere.
fs::path found(const std::string& results_file, const fs::path& folder) {
  if (results_file.empty()) return {};
  std::error_code unreadable;  // as a name that is too long
  for (const fs::path& file :
       {folder / "runs" / fs::path(results_file).filename(), fs::path(results_file)})
    if (fs::is_regular_file(file, unreadable)) return file;
  return {};
}

}  // namespace

ValidationReplays::ValidationReplays(const ValidationDocument& results, const std::string& folder,
                                     std::size_t budget)
    : budget_(budget) {
  std::set<std::string> compared;
  for (const ValidationDocument::ComparisonRow& c : results.comparisons)
    compared.insert(c.experiment);
  for (const ValidationDocument::ExperimentRow& e : results.experiments) {
    if (!compared.contains(e.name)) continue;
    for (const ValidationDocument::RunRow& r : e.runs) {
      if (r.purpose != "base") continue;
      const fs::path file = found(r.results_file, folder);
      if (!file.empty())
        runs_[e.name] = {file.string(), file.filename().string(), r.parameter_set, r.seed, ""};
      break;
    }
  }
  waiting_ = runs_.size();
}

void ValidationReplays::add(const std::string& experiment, const std::string& anchor,
                            page::Page& page, page::Content& content) {
  const auto known = runs_.find(experiment);
  if (known == runs_.end()) return;
  FirstRun& run = known->second;
  if (!run.drawn_at.empty()) {
    content.html(fmt::format(
        "<p class=\"screen-only\">The replay of this experiment stands <a href=\"#{}\">above</a>."
        "</p>\n",
        encode::markup(run.drawn_at)));
    return;
  }
  page::Content watch;
  const std::string said =
      fmt::format("results file {}, parameter set {}, seed {}", run.shown_as, run.parameter_set,
                  page::number_text(static_cast<double>(run.seed), 9));
  try {
    const Recording recording(run.file);
    ReplayViewOptions options;
    options.budget = budget_ / waiting_;
    const ReplaySize size =
        add_replay_view(page, watch, {page::slugify(experiment), fmt::format("\"{}\"", experiment)},
                        recording, read_case(recording), options);
    budget_ -= std::min(budget_, size.characters);
    if (size.frames > 0) {
      run.drawn_at = anchor;
      watch.paragraph(fmt::format("The first run of this experiment: {}.", said));
    }
  } catch (const std::exception& e) {  // the verdicts stand all the same
    watch = {};
    watch.note({page::Mark::caution, "no replay"}, fmt::format("{}: {}", said, e.what()));
  }
  --waiting_;
  if (watch.empty()) return;
  content.html("<div class=\"replay-watch\">\n");
  content.heading("Watch it");
  content.html(watch.html() + "</div>\n");
}

}  // namespace firn
