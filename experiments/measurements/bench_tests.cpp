#include "experiments/measurements/bench_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/measurements/measurement.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::string words(const TomlTable& t, std::string_view key) {
  std::string text = t.string(key);
  if (text.empty()) t.fail(key, "is empty; expected a sentence");
  return text;
}

std::string existing_file(const TomlTable& t, std::string_view key, const fs::path& folder) {
  const fs::path path = (folder / t.string(key)).lexically_normal();
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    t.fail(key, fmt::format("\"{}\" is not a file; expected a path relative to this file",
                            path.string()));
  }
  return path.string();
}

UnitValue above_zero(const TomlTable& t, std::string_view key) {
  const std::string text = t.string(key);
  UnitValue q = t.at(key, [&] { return parse_unit_value(text); });
  if (!(q.value > 0)) t.fail(key, fmt::format("is \"{}\"; expected more than zero", text));
  return q;
}

BenchResponse read_response(const TomlTable& t, const fs::path& folder) {
  t.allow({"name", "measurement", "standard_deviation", "systematic_uncertainty", "rationale"});
  BenchResponse r;
  r.name = current_response(t, "name", words(t, "name"));
  r.measurement = existing_file(t, "measurement", folder);
  const UnitValue scatter = above_zero(t, "standard_deviation");
  r.standard_deviation = scatter.value;
  r.unit = scatter.unit;
  if (t.has("systematic_uncertainty")) {
    const UnitValue reading = above_zero(t, "systematic_uncertainty");
    if (reading.unit != r.unit) {
      t.fail("systematic_uncertainty",
             fmt::format("has the unit \"{}\"; expected \"{}\", as standard_deviation",
                         reading.unit, r.unit));
    }
    r.systematic_uncertainty = reading.value;
  }
  r.rationale = words(t, "rationale");
  return r;
}

BenchTest read_test(const TomlTable& t, const fs::path& folder) {
  t.allow({"name", "title", "case", "informs", "extends_test", "setup", "time_per_repeat",
           "repeats", "rationale", "responses"});
  BenchTest test;
  test.name = words(t, "name");
  test.title = words(t, "title");
  test.case_file = existing_file(t, "case", folder);
  test.informs = words(t, "informs");
  test.with = t.string("extends_test", "");
  test.setup = t.quantity("setup", dimension::time, Sign::non_negative);
  test.per_repeat = t.quantity("time_per_repeat", dimension::time, Sign::non_negative);
  test.repeats = t.integer("repeats", 1);
  test.rationale = words(t, "rationale");
  for (const TomlTable& response : t.tables("responses")) {
    test.responses.push_back(read_response(response, folder));
  }
  if (test.responses.empty()) {
    t.fail("responses", "is missing; expected at least one [[tests.responses]] table");
  }
  return test;
}

}  // namespace

double BenchResponse::standard_uncertainty(int repeats) const {
  return std::hypot(standard_deviation / std::sqrt(repeats), systematic_uncertainty);
}

std::vector<BenchTest> read_bench_tests(const std::string& file) {
  TomlDocument document(read_input_file(file, "a file of bench tests", input_limits::toml_bytes),
                        file, TomlFormat::bench_tests);
  const TomlTable root = TomlTable::root(document);
  root.allow({"tests"});
  std::vector<BenchTest> tests;
  const std::vector<TomlTable> tables = root.tables("tests");
  if (tables.empty()) root.fail("tests", "is missing; expected at least one [[tests]] table");
  for (const TomlTable& t : tables) {
    BenchTest test = read_test(t, fs::path(file).parent_path());
    if (std::ranges::count(tests, test.name, &BenchTest::name) > 0) {
      t.fail("name", fmt::format("\"{}\" is taken already; expected another name", test.name));
    }
    tests.push_back(std::move(test));
  }
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const std::string& with = tests[i].with;
    if (with.empty()) continue;
    if (with == tests[i].name || std::ranges::count(tests, with, &BenchTest::name) == 0) {
      tables[i].fail("extends_test",
                     fmt::format("\"{}\" is not another test; expected one of this file's", with));
    }
  }
  return tests;
}

}  // namespace firn
