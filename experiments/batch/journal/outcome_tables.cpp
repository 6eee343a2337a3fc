#include "experiments/batch/journal/outcome_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace firn {

std::optional<JobResult> read_outcome(Database& db, const std::string& key) {
  Statement run(db,
                "SELECT status, reason, wall, simulated, cut_at, results FROM runs WHERE key = ?");
  run.bind(key);
  if (!run.next()) return std::nullopt;
  const auto status = outcome_status(run.text(0));
  if (!status) return std::nullopt;  // planned or running
  JobResult result{*status, run.text(1), {}, run.real(2), run.real(3), run.real(4), run.text(5)};
  Statement row(db,
                "SELECT name, value, uncertainty, unit, method, method_version FROM responses "
                "WHERE run = ? ORDER BY name, part");
  row.bind(key);
  while (row.next()) {
    if (result.responses.empty() || result.responses.back().name != row.text(0))
      result.responses.push_back(
          {row.text(0), {}, {}, row.text(3), row.text(4), static_cast<int>(row.integer(5))});
    Response& r = result.responses.back();
    r.value.push_back(row.real(1));
    if (!row.null(2)) r.uncertainty.push_back(row.real(2));
  }
  return plausible(std::move(result));
}

JobResult stored_form(JobResult result) {
  std::erase_if(result.responses, [](const Response& r) { return r.value.empty(); });
  std::ranges::stable_sort(result.responses, {}, &Response::name);
  for (Response& r : result.responses) {
    r.uncertainty.resize(std::min(r.uncertainty.size(), r.value.size()));
    std::erase_if(r.uncertainty, [](double u) { return std::isnan(u); });
  }
  return plausible(std::move(result));
}

void write_outcome(Database& db, const std::string& key, const JobResult& result) {
  Statement(db, "DELETE FROM responses WHERE run = ?").bind(key).next();
  for (const Response& r : result.responses)
    for (std::size_t i = 0; i < r.value.size(); ++i) {
      const double uncertainty =
          i < r.uncertainty.size() ? r.uncertainty[i] : std::numeric_limits<double>::quiet_NaN();
      Statement(db, "INSERT INTO responses VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
          .bind(key)
          .bind(r.name)
          .bind(static_cast<std::int64_t>(i))
          .bind(r.value[i])
          .bind(uncertainty)
          .bind(r.unit)
          .bind(r.method)
          .bind(std::int64_t{r.method_version})
          .next();
    }
  Statement(db,
            "UPDATE runs SET status = ?, reason = ?, wall = ?, simulated = ?, cut_at = ?, "
            "results = ? WHERE key = ?")
      .bind(std::string(to_string(result.status)))
      .bind(result.reason)
      .bind(result.wall)
      .bind(result.simulated)
      .bind(result.limit)
      .bind(result.results_file)
      .bind(key)
      .next();
}

}  // namespace firn
