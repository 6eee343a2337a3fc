#include "tests/calibration_proof/coverage_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/system/text_encoding.h"

namespace firn::proof {
namespace {

constexpr double widest = 1.15;  // over the ideal
constexpr double check_confidence = 0.99;

std::string percentage(int part, int of) {
  return of == 0 ? "-" : fmt::format("{:.1f}", 100.0 * part / of);
}

std::string root_mean_square_text(double squares, int count) {
  return count == 0 ? "-" : fmt::format("{:.2f}", std::sqrt(squares / count));
}

std::string notices_text(const CoverageCounts& t, const std::string& older) {
  std::vector<std::string> notices;
  if (!older.empty()) notices.push_back(older);
  if (t.infeasible > 0 || t.ideal_infeasible > 0)
    notices.push_back(fmt::format("{} infeasible (ideal {})", t.infeasible, t.ideal_infeasible));
  if (t.unconfirmed > 0) notices.push_back(fmt::format("{} unconfirmed", t.unconfirmed));
  if (t.cautioned > 0) notices.push_back(fmt::format("{} with cautions", t.cautioned));
  return fmt::format("{}", fmt::join(notices, ", "));
}

std::string table_line(const std::string& name, const CoverageCounts& t, const std::string& older) {
  const Interval held = binomial_interval(t.region_95, t.studies);
  return fmt::format(
      "| {} | {} | {} ({:.1f} to {:.1f}) | {} | {} | {} | {} | {} | {} of {} | {} | {} | {:.0f} | "
      "{} |\n",
      name, t.studies, percentage(t.region_95, t.studies), 100 * held.low, 100 * held.high,
      percentage(t.ideal_95, t.studies), percentage(t.region_68, t.studies),
      percentage(t.ideal_68, t.studies), percentage(t.intervals, t.parameters),
      t.parameters == 0 ? "-" : fmt::format("{:.2f}", t.width()), t.far_off, t.determined,
      root_mean_square_text(t.confirmed_z2, t.confirmed),
      root_mean_square_text(t.model_z2, t.modeled), t.cost / std::max(1, t.studies),
      notices_text(t, older));
}

// Rows of one problem and kind of truth.
void add_rows(const std::vector<RecordedStudy>& record, const StudyKey& present,
              std::vector<CoverageRow>& rows) {
  std::map<std::pair<std::string, std::string>, CoverageCounts> versions;
  for (const RecordedStudy& s : record)
    if (s.key.problem == present.problem && s.key.truth == present.truth)
      versions[{s.key.engine, s.key.definition}].add(s.outcome);
  const std::pair now(present.engine, present.definition);
  int studies = 0;
  if (const auto found = versions.find(now); found != versions.end()) {
    rows.push_back({present.problem, present.truth, "", found->second});
    studies = found->second.studies;
    versions.erase(found);
  }
  const auto most = std::max_element(
      versions.begin(), versions.end(),
      [](const auto& a, const auto& b) { return a.second.studies < b.second.studies; });
  if (most == versions.end() || most->second.studies <= studies) return;
  const std::string& engine = most->first.first;
  rows.push_back({present.problem, present.truth,
                  engine == present.engine ? "older text" : "older engine " + engine,
                  most->second});
}

struct ShareLimit {
  const char* region;
  double nominal, tolerance;
};

// A clause if the share of truths that a region holds is outside of its limits; else empty.
std::string exceeded_share(const ShareLimit& limit, int held, int ideal, const CoverageRow& row) {
  const int studies = row.counts.studies;
  const double exact = row.truth == "prior" ? limit.nominal : static_cast<double>(ideal) / studies;
  const double low = std::min(limit.nominal, exact) - limit.tolerance;
  const double high = std::max(limit.nominal, exact) + limit.tolerance;
  const Interval share = binomial_interval(held, studies, check_confidence);
  if (share.high >= low && share.low <= high) return "";
  return fmt::format(
      "the {} region holds {} of {} truths (99 % interval {:.1f} to {:.1f} %), expected {:.1f} to "
      "{:.1f} %",
      limit.region, held, studies, 100 * share.low, 100 * share.high, 100 * low,
      std::min(100.0, 100 * high));
}

}  // namespace

void CoverageCounts::add(const CoverageOutcome& o) {
  ++studies;
  infeasible += o.verdict == "infeasible";
  unconfirmed += o.verdict == "unconfirmed";
  cautioned += o.cautions > 0;
  cost += o.cost;
  if (!o.level) return;
  region_95 += *o.level <= 0.95;
  region_68 += *o.level <= 0.68;
  ideal_95 += o.ideal_level <= 0.95;
  ideal_68 += o.ideal_level <= 0.68;
  ideal_infeasible += o.ideal_infeasible;
  parameters += o.parameters;
  intervals += o.intervals;
  log_width += o.parameters * std::log(o.width);
  determined += o.determined;
  far_off += o.far_off;
  confirmed += static_cast<int>(o.confirmed_z.size());
  for (const double z : o.confirmed_z) confirmed_z2 += z * z;
  modeled += static_cast<int>(o.model_z.size());
  for (const double z : o.model_z) model_z2 += z * z;
}

void CoverageCounts::add(const CoverageCounts& other) {
  for (int CoverageCounts::*n :
       {&CoverageCounts::studies, &CoverageCounts::region_95, &CoverageCounts::region_68,
        &CoverageCounts::ideal_95, &CoverageCounts::ideal_68, &CoverageCounts::parameters,
        &CoverageCounts::intervals, &CoverageCounts::determined, &CoverageCounts::far_off,
        &CoverageCounts::infeasible, &CoverageCounts::ideal_infeasible,
        &CoverageCounts::unconfirmed, &CoverageCounts::cautioned, &CoverageCounts::confirmed,
        &CoverageCounts::modeled})
    this->*n += other.*n;
  for (double CoverageCounts::*x : {&CoverageCounts::confirmed_z2, &CoverageCounts::model_z2,
                                    &CoverageCounts::log_width, &CoverageCounts::cost})
    this->*x += other.*x;
}

double CoverageCounts::width() const { return std::exp(log_width / std::max(1, parameters)); }

std::vector<CoverageRow> coverage_rows(const std::vector<RecordedStudy>& record,
                                       const std::vector<CoveredProblem>& problems) {
  std::vector<CoverageRow> rows;
  for (const CoveredProblem& p : problems)
    for (const std::string& truth : p.truths) add_rows(record, study_key(p, truth, 0), rows);
  std::sort(rows.begin(), rows.end(), [](const CoverageRow& a, const CoverageRow& b) {
    return std::tie(a.problem, a.truth, a.older) < std::tie(b.problem, b.truth, b.older);
  });
  return rows;
}

std::string coverage_table(const std::vector<CoverageRow>& rows) {
  if (rows.empty()) return "No study is recorded.\n";
  std::string text =
      "| problem, truth | studies | 95 % region | ideal | 68 % region | ideal | intervals | width "
      "| "
      "off | error | model | cost | notices |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  CoverageCounts present, older;
  for (const CoverageRow& row : rows) {
    text += table_line(encode::markdown(row.problem + ", " + row.truth), row.counts, row.older);
    (row.older.empty() ? present : older).add(row.counts);
  }
  if (present.studies > 0) text += table_line("all", present, "");
  if (older.studies > 0) text += table_line("all of older engines", older, "");
  return text;
}

std::vector<std::string> exceeded_limits(const CoverageRow& row) {
  const CoverageCounts& t = row.counts;
  std::vector<std::string> exceeded;
  if (!row.older.empty() || t.studies < coverage_least_studies) return exceeded;
  const std::string of_95 = exceeded_share({"95 %", 0.95, 0.02}, t.region_95, t.ideal_95, row);
  const std::string of_68 = exceeded_share({"68 %", 0.68, 0.04}, t.region_68, t.ideal_68, row);
  for (const std::string& one : {of_95, of_68})
    if (!one.empty()) exceeded.push_back(one);
  if (t.width() > widest)
    exceeded.push_back(
        fmt::format("the width is {:.2f} of the ideal, expected up to {}", t.width(), widest));
  return exceeded;
}

}  // namespace firn::proof
