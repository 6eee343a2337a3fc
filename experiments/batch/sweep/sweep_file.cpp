// Reading of sweep files, and the combinations that they define.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "experiments/batch/sweep/sweep.h"
#include "experiments/responses/response_expression.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

constexpr std::size_t most_runs = input_limits::batch_runs;
constexpr int default_trajectories = 6;

// Empty when they are missing.
std::vector<std::string> read_labels(const TomlTable& t, std::size_t values) {
  std::vector<std::string> labels = t.strings("labels");
  if (t.has("labels") && labels.size() != values)
    t.fail("labels", fmt::format("has {} texts; expected {}, one a value", labels.size(), values));
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i].empty() || !encode::first_unprintable(labels[i]).empty())
      t.fail_element("labels", i, "cannot be shown on one line; expected a printable text");
    if (std::ranges::count(labels, labels[i]) > 1)
      t.fail_element("labels", i,
                     fmt::format("\"{}\" is there twice; expected different texts", labels[i]));
  }
  return labels;
}

SweptKey read_key(const TomlTable& t, const Sweep& sweep) {
  t.allow({"name", "keys", "values", "labels", "materials"});
  SweptKey k;
  k.name = unique_table_name(t, sweep.vary);
  if (t.has("materials")) {
    for (const char* other : {"keys", "values", "labels"})
      if (t.has(other))
        t.fail(other, "is given with `materials`; expected either keys and values, or materials");
    k.values = t.strings("materials");
    k.value_places = t.element_places("materials");
    if (k.values.empty()) t.fail("materials", "is empty; expected names of material records");
    return k;
  }
  for (const std::string& key : t.strings("keys"))
    k.keys.push_back(current_case_key(t, "keys", key));
  k.key_places = t.element_places("keys");
  if (k.keys.empty()) t.fail("keys", "is missing; expected keys of the case");
  if (const auto seed = std::ranges::find(k.keys, "case.seed"); seed != k.keys.end())
    t.fail_element("keys", static_cast<std::size_t>(seed - k.keys.begin()),
                   "\"case.seed\" is the sweep's own; expected another key, or more `seeds`");
  k.values = t.value_texts("values");
  k.value_places = t.element_places("values");
  if (k.values.empty()) t.fail("values", "is missing; expected a list of values");
  k.labels = read_labels(t, k.values.size());
  return k;
}

// Trajectories of a screening.
void read_screening(const TomlTable& head, Sweep& s) {
  if (s.design != SweepDesign::morris) {
    for (const char* key : {"trajectories", "design_seed"})
      if (head.has(key))
        head.fail(key, "needs `design = \"morris\"`; expected that, or no such key");
    return;
  }
  if (s.vary.empty()) head.fail("design", "\"morris\" has nothing to vary; expected [[vary]]");
  const int trajectories = head.integer("trajectories", 2, default_trajectories);
  const std::size_t points = static_cast<std::size_t>(trajectories) * (s.vary.size() + 1);
  if (points * s.seeds.size() > most_runs)
    head.fail("trajectories", fmt::format("make more than {} runs; expected fewer", most_runs));
  std::vector<std::size_t> levels;
  for (const SweptKey& k : s.vary) levels.push_back(k.values.size());
  s.screening = screening_design(levels, trajectories,
                                 static_cast<std::uint64_t>(head.integer("design_seed", 0, 1)));
}

// Without line breaks and the indentation after them.
std::string on_one_line(const std::string& toml) {
  std::string line;
  for (std::size_t at = 0; at < toml.size(); ++at) {
    line += toml[at] == '\n' ? ' ' : toml[at];
    if (toml[at] == '\n') at = std::min(toml.find_first_not_of(" \n", at), toml.size()) - 1;
  }
  return line;
}

}  // namespace

std::string plain_value(const std::string& value) {
  const bool string = value.size() > 1 && (value.front() == '"' || value.front() == '\'');
  if (string) return value.substr(1, value.size() - 2);
  double number = 0;  // 0.2 is written with all its digits: the shortest that reads the same
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = error == std::errc() && end == value.data() + value.size();
  return whole ? fmt::format("{}", number) : on_one_line(value);
}

std::string Sweep::label(std::size_t combination) const {
  const std::vector<std::string> chosen = value_labels(combination);
  std::string text;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    text += fmt::format("{}{}={}", i > 0 ? " " : "", vary[i].name, chosen[i]);
  return text;
}

std::size_t Sweep::combinations() const {
  if (vary.empty()) return 1;
  if (design == SweepDesign::morris) return screening.points.size();
  if (design == SweepDesign::list) return vary.front().values.size();
  std::size_t n = 1;
  for (const SweptKey& k : vary) n *= k.values.size();
  return n;
}

std::vector<std::size_t> Sweep::levels(std::size_t combination) const {
  std::vector<std::size_t> chosen(vary.size());
  for (std::size_t i = vary.size(); i-- > 0;) {
    const std::size_t n = vary[i].values.size();
    std::size_t value = combination;
    if (design == SweepDesign::morris) value = screening.points[combination][i];
    if (design == SweepDesign::grid) {
      value = combination % n;
      combination /= n;
    }
    chosen[i] = value;
  }
  return chosen;
}

std::vector<std::string> Sweep::values(std::size_t combination) const {
  const std::vector<std::size_t> chosen = levels(combination);
  std::vector<std::string> all;
  for (std::size_t i = 0; i < vary.size(); ++i) all.push_back(vary[i].values[chosen[i]]);
  return all;
}

std::vector<std::string> Sweep::value_labels(std::size_t combination) const {
  const std::vector<std::size_t> chosen = levels(combination);
  std::vector<std::string> all;
  for (std::size_t i = 0; i < vary.size(); ++i)
    all.push_back(vary[i].labels.empty() ? plain_value(vary[i].values[chosen[i]])
                                         : vary[i].labels[chosen[i]]);
  return all;
}

Sweep read_sweep(const std::string& file) {
  Sweep s;
  s.source = file;
  s.text = read_input_file(file, "a sweep file", input_limits::toml_bytes);
  TomlDocument document(s.text, file);
  require_kind(document, "sweep");
  const TomlTable root = TomlTable::root(document);
  root.allow({"sweep", "vary", "execution"});
  const TomlTable head = root.required_table("sweep");
  head.allow({"name", "case", "set", "materials", "responses", "seeds", "first_seed", "design",
              "threads", "trajectories", "design_seed"});
  s.name = valid_name(head);
  s.case_file = case_path(head, file, "sweep");
  s.set = read_case_overrides(head, &s.set_places);
  s.materials = head.strings("materials");
  s.material_places = head.element_places("materials");
  s.responses = current_responses(head, "responses");
  s.response_places = head.element_places("responses");
  for (std::size_t i = 0; i < s.responses.size(); ++i)
    head.at_element("responses", i, [&] { parse_response_expression(s.responses[i]); });
  const int seeds = head.integer("seeds", 1, 1), first = head.integer("first_seed", 1, 1);
  if (seeds > static_cast<int>(most_runs))
    head.fail("seeds", fmt::format("are more than {}; expected fewer", most_runs));
  s.seeds = seed_list(first, seeds);
  const std::string design = head.choice("design", {"grid", "list", "morris"}, "grid");
  s.design = design == "grid"   ? SweepDesign::grid
             : design == "list" ? SweepDesign::list
                                : SweepDesign::morris;
  s.threads = head.integer("threads", 1, 1);
  std::size_t runs = s.seeds.size();
  for (const TomlTable& t : root.tables("vary")) {
    s.vary.push_back(read_key(t, s));
    const char* key = s.vary.back().is_material() ? "materials" : "values";
    const std::size_t n = s.vary.back().values.size();
    if (s.design == SweepDesign::list && n != s.vary.front().values.size())
      t.fail(key, fmt::format("has {} values; expected {}, as the first of the list", n,
                              s.vary.front().values.size()));
    if (s.design == SweepDesign::morris && n % 2 != 0)
      t.fail(key, fmt::format("has {} values; expected an even number of levels", n));
    if (s.design == SweepDesign::grid) runs *= n;
    if (runs > most_runs)
      t.fail(key, fmt::format("make more than {} runs; expected fewer", most_runs));
  }
  read_screening(head, s);
  s.execution = read_execution(root);
  return s;
}

}  // namespace firn
