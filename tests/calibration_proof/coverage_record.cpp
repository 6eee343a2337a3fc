#include "tests/calibration_proof/coverage_record.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <set>
#include <sstream>
#include <system_error>
#include <utility>

#include "experiments/storage/sha256.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv/csv_reader.h"
#include "firn/math.h"
#include "tests/calibration_proof/coverage_engine.h"

namespace firn::proof {
namespace {

namespace fs = std::filesystem;

constexpr std::array columns = {
    "engine",           "problem",      "truth",   "definition",  "study",
    "verdict",          "cautions",     "level",   "ideal_level", "width",
    "intervals",        "parameters",   "far_off", "determined",  "ideal_infeasible",
    "confirmed_errors", "model_errors", "cost"};

// The fields of one line in their order.
class RecordFields {
 public:
  RecordFields(const std::string& file, const CsvRow& row) : file_(file), row_(row) {
    if (row.fields.size() != columns.size())
      fail(fmt::format("has {} fields; expected {}", row.fields.size(), columns.size()));
  }

  const std::string& text() { return row_.fields[next_++]; }
  double number() { return number_of(text()); }
  int whole() {
    const double value = number();
    if (value != std::floor(value) || std::abs(value) > 1e9)
      fail(fmt::format("{} is {}; expected a whole number", columns[next_ - 1], value));
    return static_cast<int>(value);
  }
  std::optional<double> optional_number() {
    const std::string& field = text();
    if (field.empty()) return std::nullopt;
    return number_of(field);
  }
  std::vector<double> numbers() {
    std::vector<double> values;
    std::istringstream words(text());
    for (std::string word; words >> word;) values.push_back(number_of(word));
    return values;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_, row_.line, what));
  }
  double number_of(const std::string& word) const {
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc() || stop != end)
      fail(fmt::format("{} is \"{}\"; expected a number", columns[next_ - 1], word));
    return value;
  }

  const std::string& file_;
  const CsvRow& row_;
  std::size_t next_ = 0;
};

RecordedStudy study_of_line(const std::string& file, const CsvRow& row) {
  RecordFields fields(file, row);
  RecordedStudy s;
  s.key.engine = fields.text();
  s.key.problem = fields.text();
  s.key.truth = fields.text();
  s.key.definition = fields.text();
  s.key.index = fields.whole();
  CoverageOutcome& o = s.outcome;
  o.verdict = fields.text();
  o.cautions = fields.whole();
  o.level = fields.optional_number();
  o.ideal_level = fields.number();
  o.width = fields.number();
  o.intervals = fields.whole();
  o.parameters = fields.whole();
  o.far_off = fields.whole();
  o.determined = fields.whole();
  o.ideal_infeasible = fields.whole() != 0;
  o.confirmed_z = fields.numbers();
  o.model_z = fields.numbers();
  o.cost = fields.number();
  return s;
}

std::string line_of_study(const RecordedStudy& s) {
  const StudyKey& k = s.key;
  const CoverageOutcome& o = s.outcome;
  return fmt::format(
      "{},{},{},{},{:04},{},{},{},{:.5f},{:.4g},{},{},{},{},{},{:.3g},{:.3g},{:.4g}\n", k.engine,
      encode::csv_field(k.problem), k.truth, k.definition, k.index, o.verdict, o.cautions,
      o.level ? fmt::format("{:.5f}", *o.level) : "", o.ideal_level, o.width, o.intervals,
      o.parameters, o.far_off, o.determined, static_cast<int>(o.ideal_infeasible),
      fmt::join(o.confirmed_z, " "), fmt::join(o.model_z, " "), o.cost);
}

// SIGINT and SIGTERM wait until the destructor, so that no temporary file is left.
class SignalDelay {
 public:
  SignalDelay() {
    sigset_t delayed;
    sigemptyset(&delayed);
    sigaddset(&delayed, SIGINT);
    sigaddset(&delayed, SIGTERM);
    sigprocmask(SIG_BLOCK, &delayed, &before_);
  }
  SignalDelay(const SignalDelay&) = delete;
  SignalDelay& operator=(const SignalDelay&) = delete;
  ~SignalDelay() { sigprocmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

// Waits until no other process adds to a record in the folder of the file.
Descriptor lock_folder_of(const std::string& file) {
  const std::string folder = fs::absolute(file).parent_path().string();
  Descriptor lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.number() < 0) refuse_output(file, errno);
  while (::flock(lock.number(), LOCK_EX) != 0)
    if (errno != EINTR) throw WriteError(file, errno);
  return lock;
}

}  // namespace

StudyKey study_key(const CoveredProblem& p, const std::string& truth, int index) {
  return {coverage_engine(), p.name, truth, sha256(p.definition).substr(0, 8), index};
}

std::vector<RecordedStudy> read_coverage_record(const std::string& file) {
  if (!fs::exists(file)) return {};
  std::vector<RecordedStudy> studies;
  std::set<StudyKey> known;
  for (const CsvRow& row : read_csv_rows(file)) {
    RecordedStudy study = study_of_line(file, row);
    if (known.insert(study.key).second) studies.push_back(std::move(study));
  }
  return studies;
}

std::string coverage_record_text(const std::vector<RecordedStudy>& studies) {
  std::vector<std::string> lines;
  lines.reserve(studies.size());
  for (const RecordedStudy& study : studies) lines.push_back(line_of_study(study));
  std::sort(lines.begin(), lines.end());
  return fmt::format(
      "# Finished studies of firn_coverage_proof: docs/calibration-proof.md.\n# {}\n{}",
      fmt::join(columns, ","), fmt::join(lines, ""));
}

void add_to_coverage_record(const std::string& file, const std::vector<RecordedStudy>& studies) {
  const SignalDelay delay;
  const Descriptor lock = lock_folder_of(file);
  std::vector<RecordedStudy> all = read_coverage_record(file);
  std::set<StudyKey> known;
  for (const RecordedStudy& study : all) known.insert(study.key);
  for (const RecordedStudy& study : studies)
    if (known.insert(study.key).second) all.push_back(study);
  write_file(file, coverage_record_text(all));
}

}  // namespace firn::proof
