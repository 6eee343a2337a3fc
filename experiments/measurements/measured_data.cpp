#include "experiments/measurements/measured_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "experiments/analysis/channel_filter.h"
#include "experiments/text/csv/csv_reader.h"

namespace firn {
namespace {

// A number of a column in the unit of the data.
double number_in_unit(const std::string& file, const CsvRow& row, const CsvColumn& column,
                      double factor) {
  const double value = csv_number(file, row, column) / factor;
  if (!std::isfinite(value))
    throw InputError(
        fmt::format("{}:{}: {}: is \"{}\"; expected a number that is finite in the "
                    "unit of the measurement",
                    file, row.line, column.name, row.fields[column.index]));
  return value;
}

void read_values(const TomlTable& t, MeasuredData& d) {
  const std::string column = t.string("column"), censored = t.string("right_censored", "");
  const Unit unit = t.at("unit", [&] { return parse_unit(d.unit); });
  if (!d.present) return;
  const std::vector<CsvRow> rows = read_csv_table(d.file);
  const CsvColumn values = find_csv_column(d.file, rows.front(), column, unit.dimension);
  std::optional<CsvColumn> marks;
  if (!censored.empty()) marks = find_csv_column(d.file, rows.front(), censored, std::nullopt);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const bool open = marks && csv_number(d.file, rows[i], *marks) != 0;
    (open ? d.right_censored : d.values)
        .push_back(number_in_unit(d.file, rows[i], values, unit.factor));
  }
}

void read_classes(const TomlTable& t, MeasuredData& d) {
  const std::string classes = t.string("classes", "class"), counts = t.string("counts", "count");
  if (!d.present) return;
  const std::vector<CsvRow> rows = read_csv_table(d.file);
  const CsvColumn name = find_csv_column(d.file, rows.front(), classes, std::nullopt);
  const CsvColumn count = find_csv_column(d.file, rows.front(), counts, std::nullopt);
  double sum = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    d.classes.push_back(rows[i].fields[name.index]);
    d.counts.push_back(csv_number(d.file, rows[i], count));
    if (d.counts.back() < 0 || d.counts.back() != std::floor(d.counts.back()) ||
        d.counts.back() > 1e6)
      throw InputError(fmt::format("{}:{}: {}: is {}; expected a whole number of things", d.file,
                                   rows[i].line, counts, d.counts.back()));
    sum += d.counts.back();
  }
  if (!(sum > 0))
    throw InputError(fmt::format("{}:{}: {}: counts nothing; expected one thing at least", d.file,
                                 rows.front().line, counts));
}

// The recorder's zero and sign.
struct RecorderZero {
  double tare = 0;       // what it shows without a load, in the unit of the data
  double tare_over = 0;  // above 0: the tare is the mean over this stretch of x, from its least on
  bool inverted = false;
};
RecorderZero read_zero(const TomlTable& t, const Unit& x_unit, const Unit& unit) {
  RecorderZero zero;
  zero.tare = t.optional_quantity("tare", unit.dimension, Sign::any).value_or(0) / unit.factor;
  zero.tare_over = t.optional_quantity("tare_over", x_unit.dimension, Sign::positive).value_or(0) /
                   x_unit.factor;
  zero.inverted = t.boolean("invert", false);
  if (t.has("tare") && t.has("tare_over"))
    t.fail("tare_over", "does not go with tare; expected one of them");
  return zero;
}
// x and samples in the units of `zero`.
void apply_zero(const RecorderZero& zero, const TomlTable& t, const std::vector<double>& x,
                std::vector<double>& samples) {
  double tare = zero.tare;
  if (zero.tare_over > 0) {
    const auto [least, greatest] = std::ranges::minmax(x);
    if (zero.tare_over >= greatest - least)
      t.fail("tare_over",
             fmt::format("is as long as the data; expected a stretch without load, shorter than "
                         "{:.4g}",
                         greatest - least));
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (x[i] > least + zero.tare_over) continue;
      sum += samples[i];
      ++count;
    }
    tare = sum / count;
  }
  for (double& sample : samples) sample = (zero.inverted ? -1 : 1) * (sample - tare);
}

// Resamples by linear interpolation at steps of `interval`: filters need equal steps.
void resample(std::vector<double>& time, std::vector<double>& samples, double interval) {
  std::vector<double> even_time, even;
  const auto steps =
      static_cast<std::size_t>(std::floor((time.back() - time.front()) / interval * (1 + 1e-12)));
  std::size_t at = 0;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double t = time.front() + static_cast<double>(k) * interval;
    while (at + 2 < time.size() && time[at + 1] < t) ++at;
    const double share = std::clamp((t - time[at]) / (time[at + 1] - time[at]), 0.0, 1.0);
    even_time.push_back(t);
    even.push_back(samples[at] + share * (samples[at + 1] - samples[at]));
  }
  time = std::move(even_time);
  samples = std::move(even);
}

void read_trace(const TomlTable& t, MeasuredData& d) {
  const std::string column = t.string("column"), time_column = t.string("time", "time");
  const Unit unit = t.at("unit", [&] { return parse_unit(d.unit); });
  const double cfc = t.optional_quantity("cfc", dimension::frequency, Sign::positive).value_or(0);
  const double threshold = t.quantity("threshold", unit.dimension, Sign::positive) / unit.factor;
  const double dead_time = t.quantity("dead_time", dimension::time, Sign::non_negative, "0 s");
  const RecorderZero zero = read_zero(t, parse_unit("s"), unit);
  if (!d.present) return;
  const std::vector<CsvRow> rows = read_csv_table(d.file);
  const CsvColumn time = find_csv_column(d.file, rows.front(), time_column, dimension::time);
  const CsvColumn signal = find_csv_column(d.file, rows.front(), column, unit.dimension);
  double interval = 0;
  std::size_t closest = 0;  // row behind it
  for (std::size_t i = 1; i < rows.size(); ++i) {
    d.time.push_back(csv_number(d.file, rows[i], time));
    d.samples.push_back(number_in_unit(d.file, rows[i], signal, unit.factor));
    if (i == 1) continue;
    const double step = d.time[i - 1] - d.time[i - 2];
    if (!(step > 0))
      throw InputError(fmt::format("{}:{}: {}: does not grow; expected times in order", d.file,
                                   rows[i].line, time_column));
    if (interval == 0 || step < interval) {
      interval = step;
      closest = i;
    }
  }
  if (d.time.size() < 3)
    throw InputError(fmt::format("{}:{}: CSV: holds {} samples; expected three at least", d.file,
                                 rows.back().line, d.time.size()));
  if ((d.time.back() - d.time.front()) / interval > 1e8)
    throw InputError(
        fmt::format("{}:{}: {}: two times are only {} s apart; expected samples about "
                    "evenly spaced",
                    d.file, rows[closest].line, time_column, interval));
  apply_zero(zero, t, d.time, d.samples);
  resample(d.time, d.samples, interval);  // the smallest step of the file
  if (cfc > 0) {
    if (interval * cfc * kSamplesPerClass > 1)
      t.fail("cfc",
             fmt::format("is {} Hz, of samples {} s apart; expected at most a tenth of their "
                         "rate",
                         cfc, interval));
    d.samples = channel_filter(d.samples, interval, cfc);
  }
  d.values = peaks(d.time, d.samples, threshold, dead_time);
}

void read_curve(const TomlTable& t, MeasuredData& d) {
  const std::string x = t.string("x"), y = t.string("y"), repeat = t.string("repeat", "");
  d.x_unit = plain_unit(t.string("x_unit"));
  d.x_name = x;
  d.y_name = y;
  const Unit x_unit = t.at("x_unit", [&] { return parse_unit(d.x_unit); });
  const Unit unit = t.at("unit", [&] { return parse_unit(d.unit); });
  const double cfc = t.optional_quantity("cfc", dimension::frequency, Sign::positive).value_or(0);
  const std::string align = t.choice("align", {"none", "onset", "best"}, "none");
  d.align = align == "none"    ? MeasuredData::Alignment::none
            : align == "onset" ? MeasuredData::Alignment::onset
                               : MeasuredData::Alignment::best;
  const RecorderZero zero = read_zero(t, x_unit, unit);
  if (!d.present) return;
  const std::vector<CsvRow> rows = read_csv_table(d.file);
  const CsvColumn xs = find_csv_column(d.file, rows.front(), x, x_unit.dimension);
  const CsvColumn ys = find_csv_column(d.file, rows.front(), y, unit.dimension);
  std::optional<CsvColumn> marks;
  if (!repeat.empty()) marks = find_csv_column(d.file, rows.front(), repeat, std::nullopt);
  std::string before;
  std::vector<unsigned> first_lines;  // [repeats]
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::string mark = marks ? rows[i].fields[marks->index] : "";
    if (d.repeats.empty() || mark != before) {
      d.repeats.emplace_back();
      first_lines.push_back(rows[i].line);
    }
    before = mark;
    d.repeats.back().x.push_back(number_in_unit(d.file, rows[i], xs, x_unit.factor));
    d.repeats.back().y.push_back(number_in_unit(d.file, rows[i], ys, unit.factor));
  }
  for (std::size_t i = 0; i < d.repeats.size(); ++i) {
    MeasuredData::Repeat& r = d.repeats[i];
    if (r.x.size() < 3)
      throw InputError(fmt::format("{}:{}: CSV: a repeat holds {} samples; expected three at least",
                                   d.file, first_lines[i], r.x.size()));
    apply_zero(zero, t, r.x, r.y);
    if (cfc == 0) continue;
    // The filter needs equal steps of x, which must be a time.
    const double interval = (r.x.back() - r.x.front()) / static_cast<double>(r.x.size() - 1);
    if (x_unit.dimension != dimension::time || !(interval > 0) ||
        interval * x_unit.factor * cfc * kSamplesPerClass > 1)
      t.fail("cfc",
             fmt::format("is {} Hz; expected curves over a time that grows, with ten samples "
                         "in a period",
                         cfc));
    resample(r.x, r.y, interval);
    r.y = channel_filter(r.y, interval * x_unit.factor, cfc);
  }
}

}  // namespace

std::vector<double> read_csv_values(const std::string& file, const std::string& column,
                                    const Unit& unit) {
  const std::vector<CsvRow> rows = read_csv_table(file);
  const CsvColumn values = find_csv_column(file, rows.front(), column, unit.dimension);
  std::vector<double> numbers;
  for (std::size_t i = 1; i < rows.size(); ++i)
    numbers.push_back(number_in_unit(file, rows[i], values, unit.factor));
  return numbers;
}

std::vector<double> peaks(const std::vector<double>& time, const std::vector<double>& samples,
                          double threshold, double dead_time) {
  std::vector<double> found;
  double last_above = 0;
  bool any = false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::abs(samples[i]) < threshold) continue;
    if (!any || time[i] - last_above > dead_time + 1e-12) {
      // Neighboring samples belong together however short the dead time is.
      const bool goes_on = any && i > 0 && std::abs(samples[i - 1]) >= threshold;
      if (!goes_on) found.push_back(samples[i]);
    }
    if (std::abs(samples[i]) > std::abs(found.back())) found.back() = samples[i];
    last_above = time[i];
    any = true;
  }
  return found;
}

MeasuredData read_measured_data(const TomlTable& t, const std::string& directory) {
  t.allow({"kind",   "file",   "response", "unit",      "source",    "column",         "classes",
           "counts", "time",   "cfc",      "threshold", "dead_time", "right_censored", "x",
           "y",      "x_unit", "repeat",   "align",     "tare",      "tare_over",      "invert"});
  MeasuredData d;
  const std::string kind = t.choice("kind", {"values", "classes", "trace", "curve"});
  d.kind = kind == "values"    ? MeasuredData::Kind::values
           : kind == "classes" ? MeasuredData::Kind::classes
           : kind == "trace"   ? MeasuredData::Kind::trace
                               : MeasuredData::Kind::curve;
  d.file = (std::filesystem::path(directory) / t.string("file")).lexically_normal().string();
  std::error_code unreadable;  // as a name that is too long
  d.present = std::filesystem::exists(d.file, unreadable);
  d.response = t.string("response");
  d.response_place = t.place("response");
  d.source = t.string("source", "");
  const auto belongs = [&](std::initializer_list<const char*> keys, bool here) {
    for (const char* key : keys)
      if (t.has(key) && !here)
        t.fail(key, fmt::format("does not go with the kind \"{}\"; expected it left out", kind));
  };
  belongs({"classes", "counts"}, kind == "classes");
  belongs({"unit"}, kind != "classes");
  belongs({"column"}, kind == "values" || kind == "trace");
  belongs({"right_censored"}, kind == "values");
  belongs({"time", "threshold", "dead_time"}, kind == "trace");
  belongs({"cfc", "tare", "tare_over", "invert"}, kind == "trace" || kind == "curve");
  belongs({"x", "y", "x_unit", "repeat", "align"}, kind == "curve");
  if (d.kind != MeasuredData::Kind::classes) d.unit = plain_unit(t.string("unit"));
  if (d.kind == MeasuredData::Kind::values) read_values(t, d);
  if (d.kind == MeasuredData::Kind::classes) read_classes(t, d);
  if (d.kind == MeasuredData::Kind::trace) read_trace(t, d);
  if (d.kind == MeasuredData::Kind::curve) read_curve(t, d);
  const bool empty = d.kind == MeasuredData::Kind::curve ? d.repeats.empty() : d.values.empty();
  if (d.present && d.kind != MeasuredData::Kind::classes && empty)
    throw InputError(
        fmt::format("{}:1: CSV: holds no value; expected one at least{}", d.file,
                    d.kind == MeasuredData::Kind::trace ? " above the threshold" : ""));
  // A tare and a filter add samples.
  const auto are_finite = [](const std::vector<double>& numbers) {
    return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
  };
  if (!are_finite(d.values) || !are_finite(d.samples) ||
      !std::ranges::all_of(d.repeats, [&](const auto& repeat) { return are_finite(repeat.y); }))
    throw InputError(
        fmt::format("{}: its values are too large to be filtered; expected smaller ones", d.file));
  return d;
}

}  // namespace firn
