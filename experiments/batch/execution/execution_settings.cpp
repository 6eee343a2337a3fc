#include "experiments/batch/execution/execution_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/text/toml_document.h"

namespace firn {
namespace {

struct MemoryUnit {
  const char* name;
  double bytes;
};
constexpr MemoryUnit memory_units[] = {{"kB", 1e3},     {"MB", 1e6},     {"GB", 1e9},
                                       {"TB", 1e12},    {"KiB", 0x1p10}, {"MiB", 0x1p20},
                                       {"GiB", 0x1p30}, {"TiB", 0x1p40}};

// Options of sbatch that say where and when a job runs. Others can choose what runs (--wrap, a
// script, --export, --container) or where it writes: a study file may not.
constexpr std::string_view slurm_options[] = {
    "begin",      "clusters",  "comment",          "constraint", "contiguous",  "core-spec",
    "cpu-freq",   "deadline",  "exclude",          "exclusive",  "gres",        "hint",
    "licenses",   "mail-type", "mail-user",        "mem-bind",   "mem-per-cpu", "nice",
    "nodelist",   "nodes",     "prefer",           "priority",   "qos",         "reservation",
    "spread-job", "switches",  "threads-per-core", "time-min",   "tmp",         "wckey"};

bool is_slurm_option(std::string_view option) {
  if (!option.starts_with("--")) return false;
  return std::ranges::find(slurm_options, option.substr(2, option.find('=') - 2)) !=
         std::end(slurm_options);
}

SlurmSettings read_slurm(const TomlTable& t) {
  t.allow({"partition", "account", "options", "poll"});
  SlurmSettings s;
  s.partition = t.string("partition", "");
  s.account = t.string("account", "");
  s.options = t.strings("options");
  for (const std::string& option : s.options)
    if (!is_slurm_option(option))
      t.fail("options",
             fmt::format("\"{}\" is not an option of sbatch that a file may set; expected "
                         "such as \"--qos=low\": one of {}",
                         option, comma_list(slurm_options)));
  s.poll = t.quantity("poll", dimension::time, Sign::positive, "10 s");
  return s;
}

}  // namespace

Execution read_execution(const TomlTable& study) {
  Execution e;
  if (!study.has("execution")) return e;
  const TomlTable t = study.required_table("execution");
  t.allow({"time_limit", "memory_limit", "slurm"});
  e.limits.time = t.optional_quantity("time_limit", dimension::time, Sign::positive).value_or(0);
  if (t.has("memory_limit"))
    e.limits.memory = t.at("memory_limit", [&] { return parse_memory(t.string("memory_limit")); });
  if (t.has("slurm")) e.slurm = read_slurm(t.required_table("slurm"));
  return e;
}

std::vector<std::uint64_t> seed_list(std::uint64_t first, int count) {
  std::vector<std::uint64_t> seeds;
  seeds.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) seeds.push_back(first + static_cast<std::uint64_t>(i));
  return seeds;
}

double parse_memory(const std::string& text) {
  std::size_t used = 0;
  double value = std::numeric_limits<double>::quiet_NaN();
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  const std::size_t unit = text.find_first_not_of(' ', used);
  for (const MemoryUnit& u : memory_units)
    if (std::isfinite(value) && value > 0 && unit != std::string::npos &&
        text.substr(unit) == u.name)
      return value * u.bytes;
  throw InputError(
      fmt::format("\"{}\" is not an amount of memory; expected a number above 0 and its unit, such "
                  "as \"2 GiB\"",
                  text));
}

std::string memory_text(double bytes) {
  return bytes >= 0x1p30 ? fmt::format("{:.3g} GiB", bytes / 0x1p30)
                         : fmt::format("{:.3g} MiB", bytes / 0x1p20);
}

std::string time_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  if (seconds < 7200) return fmt::format("{:.3g} min", seconds / 60);
  return fmt::format("{:.3g} h", seconds / 3600);
}

std::string study_identity(const std::string& text, const std::string& source) {
  TomlDocument document(text, source, TomlFormat::study, OldNames::accept);
  document.root().erase("execution");
  return document.first_names_text();
}

}  // namespace firn
