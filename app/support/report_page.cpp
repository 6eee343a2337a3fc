#include "app/support/report_page.h"

#include <fmt/format.h>

#include "experiments/batch/batch_folder.h"
#include "experiments/batch/batch_state.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/text/json_fields.h"
#include "firn/math.h"
#include "reports/documents/batch_page.h"
#include "reports/documents/optimization_page.h"
#include "reports/documents/run_page.h"
#include "reports/documents/study_page.h"
#include "reports/documents/sweep_page.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

bool is_run(const fs::path& path) { return path.extension() == ".h5"; }

// results.json of the folder, or the file itself.
fs::path results_json(const std::string& path) {
  std::error_code unreadable;  // as a name that is too long
  return fs::is_directory(path, unreadable) ? fs::path(path) / "results.json" : fs::path(path);
}

}  // namespace

std::string folder_name(const std::string& folder) {
  return fs::absolute(folder).lexically_normal().filename().string();
}

page::Page report_page(const std::string& path, const ValidationPageOptions& options) {
  if (is_run(path)) return run_page(path);
  const fs::path source = results_json(path);
  std::error_code unreadable;
  const bool ended = fs::exists(source, unreadable);
  if (!ended && fs::is_directory(path, unreadable)) {
    if (const auto state = read_batch_state(path)) return batch_page(*state, folder_name(path));
  }
  constexpr const char* kExpected =
      "RUN.h5, the folder of a study, validation, sweep or optimization, or its results.json";
  if (!ended)
    throw InputError(fmt::format("{}: does not exist; expected {}", source.string(), kExpected));
  if (source.extension() == ".toml")
    throw InputError(fmt::format("{}: is an input; expected what was made of it: {}",
                                 source.string(), kExpected));
  const ResultsJson results = read_results_json(source.string());
  const std::string kind = results.kind();
  if (kind == "sweep") return sweep_page(results);
  if (kind == "optimization") return optimization_page(results);
  return kind == "study" ? study_page(results) : validation_page(results, options);
}

std::string write_folder_page(const std::string& folder) {
  const std::string page = default_report_file(folder).string();
  try {
    with_kept_runs(folder, [&] { report_page(folder, {}).write(page); });
    return page;
  } catch (const OutputPathError& e) {
    throw WriteError(page, e.error);
  } catch (const InputError& e) {  // the results stand all the same
    print_lines(stderr, "firn: no page: {}\n", e.what());
    return "";
  }
}

fs::path default_report_file(const std::string& path) {
  return is_run(path) ? fs::path(path).replace_extension(".html")
                      : results_json(path).parent_path() / "report.html";
}

}  // namespace firn
