#include "experiments/batch/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "experiments/batch/batch_folder.h"
#include "experiments/batch/sweep/sweep_document.h"
#include "experiments/responses/response_expression.h"
#include "experiments/results/response.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/interruption.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv_writer.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t most_runs = input_limits::batch_runs;

SweptKey read_key(const TomlTable& t, const Sweep& sweep) {
  t.allow({"name", "keys", "values"});
  SweptKey k;
  k.name = fresh_name(t, sweep.vary);
  for (const std::string& key : t.strings("keys"))
    k.keys.push_back(current_case_key(t, "keys", key));
  if (k.keys.empty()) t.fail("keys", "is missing; expected keys of the case");
  for (const std::string& key : k.keys)
    if (key == "case.seed")
      t.fail("keys", "\"case.seed\" is the sweep's own; expected another key, or more `seeds`");
  k.values = t.value_texts("values");
  if (k.values.empty()) t.fail("values", "is missing; expected a list of values");
  return k;
}

// A TOML value as people write it: strings without their quotes.
std::string plain(const std::string& value) {
  const bool string = value.size() > 1 && (value.front() == '"' || value.front() == '\'');
  if (string) return value.substr(1, value.size() - 2);
  double number = 0;  // 0.2 is written with all its digits: the shortest that reads the same
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = error == std::errc() && end == value.data() + value.size();
  return whole ? fmt::format("{}", number) : value;
}

std::string label(const Sweep& sweep, const std::vector<std::string>& values) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i)
    text += fmt::format("{}{}={}", i > 0 ? " " : "", sweep.vary[i].name, plain(values[i]));
  return text;
}

std::vector<Override> overrides(const Sweep& sweep, std::size_t combination, std::uint64_t seed) {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  all.insert(all.end(), sweep.set.begin(), sweep.set.end());
  const std::vector<std::string> values = sweep.values(combination);
  for (std::size_t i = 0; i < values.size(); ++i)
    for (const std::string& key : sweep.vary[i].keys) all.emplace_back(key, values[i]);
  return all;
}

// What is tabled: as asked for, or every single-valued response of the first run that finished.
void choose_responses(SweepResult& r) {
  const auto finished = std::ranges::find_if(
      r.runs, [](const SweepRun& run) { return run.result.status == JobStatus::finished; });
  r.responses = r.sweep.responses;
  if (finished == r.runs.end()) return;
  if (r.responses.empty())
    for (const Response& response : finished->result.responses)
      if (response.value.size() == 1) r.responses.push_back(response.name);
  for (const std::string& name : r.responses)
    r.units.push_back(unit_of(parse_response_expression(name), finished->result.responses));
}

void read_values(SweepResult& r) {
  for (SweepRun& run : r.runs)
    for (const std::string& name : r.responses) try {
        run.values.push_back(run.result.status == JobStatus::finished
                                 ? evaluate(parse_response_expression(name), run.result.responses)
                                 : kUndefined);
      } catch (const InputError& e) {
        // One that a run has only when something came to pass is undefined where it did not.
        if (!r.sweep.responses.empty())
          throw InputError(r.sweep.source + ": responses: " + e.what());
        run.values.push_back(kUndefined);
      }
}

void write_csv(const SweepResult& r) {
  CsvFile file(r.directory, "runs.csv");
  std::string head;
  for (const SweptKey& k : r.sweep.vary) head += encode::csv_field(k.name) + ",";
  head += "seed,status,wall [s],key";
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    const std::string unit = i < r.units.size() ? r.units[i] : "";
    head +=
        "," + encode::csv_field(unit.empty() || unit == "1" ? r.responses[i]
                                                            : r.responses[i] + " [" + unit + "]");
  }
  file.line(head);
  for (const SweepRun& run : r.runs) {
    std::string line;
    for (const std::string& v : r.sweep.values(run.combination))
      line += encode::csv_field(plain(v)) + ",";
    line += fmt::format("{},{},{},{}", run.seed, to_string(run.result.status), run.result.wall,
                        run.key);
    for (const double v : run.values) line += std::isfinite(v) ? fmt::format(",{}", v) : ",";
    file.line(line);
  }
  file.close();
}

SweepDocument::Scatter scatter(const SweepResult& r, std::size_t combination,
                               std::size_t response) {
  std::vector<double> values;
  for (const SweepRun& run : r.runs)
    if (run.combination == combination && std::isfinite(run.values[response]))
      values.push_back(run.values[response]);
  SweepDocument::Scatter s;
  s.runs = static_cast<int>(values.size());
  if (values.empty()) return s;
  s.mean = 0;
  for (const double v : values) s.mean += v / s.runs;
  double squares = 0;
  for (const double v : values) squares += (v - s.mean) * (v - s.mean);
  if (s.runs > 1) s.standard_deviation = std::sqrt(squares / (s.runs - 1));
  return s;
}

// A value that is a number, with a unit or without, in SI.
std::optional<double> number(const std::string& value) {
  const std::string text = plain(value);
  double n = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (error != std::errc()) return std::nullopt;
  const std::string unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (unit.empty()) return n;
  try {
    return n * parse_unit(unit).factor;
  } catch (const InputError&) {
    return std::nullopt;  // a vector, a file
  }
}

}  // namespace

std::size_t Sweep::combinations() const {
  if (vary.empty()) return 1;
  if (!grid) return vary.front().values.size();
  std::size_t n = 1;
  for (const SweptKey& k : vary) n *= k.values.size();
  return n;
}

std::vector<std::string> Sweep::values(std::size_t combination) const {
  std::vector<std::string> chosen(vary.size());
  for (std::size_t i = vary.size(); i-- > 0;) {
    const std::size_t n = vary[i].values.size();
    chosen[i] = vary[i].values[grid ? combination % n : combination];
    if (grid) combination /= n;
  }
  return chosen;
}

Sweep read_sweep(const std::string& file) {
  Sweep s;
  s.source = file;
  s.text = read_input_file(file, "a sweep file", input_limits::toml_bytes);
  TomlDocument document(s.text, file);
  const TomlTable root = TomlTable::root(document);
  root.allow({"sweep", "vary", "execution"});
  const TomlTable head = root.required_table("sweep");
  head.allow({"name", "case", "set", "materials", "responses", "seeds", "first_seed", "design",
              "threads"});
  s.name = path_name(head);
  s.case_file = (fs::path(file).parent_path() / head.string("case")).lexically_normal().string();
  std::error_code unreadable;  // as a name that is too long
  if (!fs::exists(s.case_file, unreadable))
    head.fail("case", fmt::format("{} does not exist; expected a case file, relative to the sweep",
                                  s.case_file));
  s.set = read_case_overrides(head);
  s.materials = head.strings("materials");
  s.responses = current_responses(head, "responses");
  for (const std::string& name : s.responses)
    head.at("responses", [&] { parse_response_expression(name); });
  const int seeds = head.integer("seeds", 1, 1), first = head.integer("first_seed", 1, 1);
  if (seeds > static_cast<int>(most_runs))
    head.fail("seeds", fmt::format("are more than {}; expected fewer", most_runs));
  s.seeds = seed_list(first, seeds);
  s.grid = head.choice("design", {"grid", "list"}, "grid") == "grid";
  s.threads = head.integer("threads", 1, 1);
  std::size_t runs = s.seeds.size();
  for (const TomlTable& t : root.tables("vary")) {
    s.vary.push_back(read_key(t, s));
    const std::size_t n = s.vary.back().values.size();
    if (!s.grid && n != s.vary.front().values.size())
      t.fail("values", fmt::format("has {} values; expected {}, as the first of the list", n,
                                   s.vary.front().values.size()));
    if (s.grid) runs *= n;
    if (runs > most_runs)
      t.fail("values", fmt::format("make more than {} runs; expected fewer", most_runs));
  }
  s.execution = read_execution(root);
  return s;
}

namespace {

void carry_out(SweepResult& r, const SweepOptions& options) {
  BatchFolder folder(folder_options(options, "sweep", "sweep " + r.sweep.name, r.directory,
                                    static_cast<int>(r.sweep.combinations() * r.sweep.seeds.size()),
                                    r.sweep.execution.slurm));
  const interruption::Advice advice(
      fmt::format("everything finished is kept in {}: the same command resumes", r.directory));
  Batch batch(folder.executor(), folder.journal(), folder.store(), folder.progress(),
              options.interrupt);
  std::vector<BatchRun> runs;
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c)
    for (const std::uint64_t seed : r.sweep.seeds) {
      BatchRun next =
          batch.make(r.sweep.case_file, overrides(r.sweep, c, seed), folder.runs(),
                     {"", "sweep", static_cast<int>(c), label(r.sweep, r.sweep.values(c)), seed},
                     {r.sweep.materials, ""});
      next.job.threads = r.sweep.threads;
      next.job.limits = r.sweep.execution.limits;
      r.runs.push_back({c, seed, next.job.key, {}, {}});
      runs.push_back(std::move(next));
    }
  folder.progress().phase(r.sweep.name);
  try {
    batch.run(runs);
  } catch (const BatchInterrupted&) {
    r.interrupted = true;
    return;
  }
  folder.progress().done();
  for (SweepRun& run : r.runs) run.result = batch.outcome(run.key);
  choose_responses(r);
  read_values(r);
  folder.journal().require_in_place();
  write_csv(r);
  write_own_file((fs::path(r.directory) / "results.json").string(), render_json(r) + "\n");
  folder.journal().require_in_place();
}

}  // namespace

namespace {

// runs/<name>, without blanks; one of an earlier version with blanks is gone on with.
std::string default_folder(const std::string& name) {
  const fs::path runs = "runs", as_it_is = runs / name;
  std::error_code unreadable;  // as a name that is too long
  if (fs::is_directory(as_it_is, unreadable)) return as_it_is.string();
  const std::string plain_name = encode::file_name(name);
  return (runs / (plain_name.empty() ? "sweep" : plain_name)).string();
}

}  // namespace

SweepResult sweep(const SweepOptions& options) {
  SweepResult r;
  r.sweep = read_sweep(options.sweep_file);
  r.directory = options.directory.empty() ? default_folder(r.sweep.name) : options.directory;
  with_kept_runs(r.directory, [&] { carry_out(r, options); });
  return r;
}

std::vector<SweptPower> powers(const SweepResult& r) {
  if (r.sweep.vary.size() != 1) return {};
  std::vector<double> x;
  for (const std::string& value : r.sweep.vary.front().values)
    x.push_back(number(value).value_or(kUndefined));
  std::vector<SweptPower> all;
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    std::vector<double> mean, error;
    std::vector<int> runs;
    for (std::size_t c = 0; c < x.size(); ++c) {
      const SweepDocument::Scatter s = scatter(r, c, i);
      mean.push_back(s.mean);
      error.push_back(s.standard_deviation / std::sqrt(s.runs));
      runs.push_back(s.runs);
    }
    if (has_power_law(x, mean))
      all.push_back({r.responses[i], fit_power_law(x, mean, error, runs)});
  }
  return all;
}

std::string render_table(const SweepResult& r) {
  std::string text;
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    const auto finished = std::ranges::count_if(r.runs, [&](const SweepRun& run) {
      return run.combination == c && run.result.status == JobStatus::finished;
    });
    text += fmt::format("{}: {} of {} runs finished\n",
                        r.sweep.vary.empty() ? r.sweep.name : label(r.sweep, r.sweep.values(c)),
                        finished, r.sweep.seeds.size());
    for (std::size_t i = 0; i < r.responses.size(); ++i) {
      const SweepDocument::Scatter s = scatter(r, c, i);
      const std::string unit = i < r.units.size() && r.units[i] != "1" ? r.units[i] : "";
      text += fmt::format(
          "    {:<36} {:>12} {:<7} {}\n", r.responses[i],
          s.runs > 0 ? fmt::format("{:.4g}", s.mean) : "undefined", unit,
          s.runs > 1 ? fmt::format("sd {:.2g} over {} runs", s.standard_deviation, s.runs) : "");
    }
    for (const SweepRun& run : r.runs)
      if (run.combination == c && run.result.status != JobStatus::finished)
        text += fmt::format("    seed {} {}: {}\n", run.seed, to_string(run.result.status),
                            run.result.reason);
  }
  const std::vector<SweptPower> laws = powers(r);
  if (!laws.empty()) text += fmt::format("as a power of {}:\n", r.sweep.vary.front().name);
  for (const auto& [response, law] : laws)
    text += fmt::format("    {:<36} {:>12.2f} {}\n", response, law.exponent,
                        std::isfinite(law.exponent_error)
                            ? fmt::format("± {:.2g}, one standard error", law.exponent_error)
                            : "(two values: how straight it is, is not known)");
  return text;
}

namespace {

SweepDocument document_of(const SweepResult& r) {
  SweepDocument d;
  d.name = r.sweep.name;
  d.case_file = r.sweep.case_file;
  for (std::size_t i = 0; i < r.responses.size(); ++i)
    d.responses.push_back({r.responses[i], i < r.units.size() ? r.units[i] : ""});
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    SweepDocument::Combination& row = d.combinations.emplace_back();
    const std::vector<std::string> values = r.sweep.values(c);
    for (std::size_t i = 0; i < values.size(); ++i)
      row.values.emplace_back(r.sweep.vary[i].name, plain(values[i]));
    for (std::size_t i = 0; i < r.responses.size(); ++i)
      row.responses.emplace_back(r.responses[i], scatter(r, c, i));
  }
  for (const auto& [response, law] : powers(r))
    d.powers.push_back({response, {law.exponent, law.exponent_error}});
  for (const SweepRun& run : r.runs)
    d.runs.push_back({run.combination, run.seed, run.key, to_string(run.result.status),
                      run.result.reason, run.result.wall, run.values, run.result.results_file});
  return d;
}

}  // namespace

std::string render_json(const SweepResult& r) { return json_text(document_of(r), 1); }

SweepDocument read_sweep_document(const std::string& results_file) {
  return document_from_json<SweepDocument>(
      read_results_json(results_file, "the results of a sweep", "sweep", "firn sweep"),
      results_file);
}

}  // namespace firn
