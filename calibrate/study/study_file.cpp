#include "calibrate/study/study_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "calibrate/study/budget.h"
#include "calibrate/study/read_parameters.h"
#include "calibrate/study/read_priors.h"
#include "calibrate/study/read_responses.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

// Of a program, whose inputs have the user's names.
std::vector<Override> read_program_inputs(const TomlTable& t, std::vector<ValuePlace>& places) {
  std::vector<Override> set;
  const TomlTable values = t.required_table("set");
  for (const std::string& key : values.keys()) {
    set.emplace_back(key, values.value_text(key));
    places.push_back(values.value_place(key));
  }
  return set;
}

// Which of the parameters an experiment's case is given: those named, or all.
void read_takes(const TomlTable& t, const Study& study, Experiment& e) {
  std::vector<bool> takes(study.parameters.size(), !t.has("parameters"));
  e.takes_choice = study.choice && !t.has("parameters");
  for (const std::string& name : t.strings("parameters")) {
    if (study.choice && study.choice->name == name) {
      e.takes_choice = true;
      continue;
    }
    const auto found = std::find_if(study.parameters.begin(), study.parameters.end(),
                                    [&](const Parameter& p) { return p.name == name; });
    if (found == study.parameters.end())
      t.fail("parameters",
             fmt::format("\"{}\" is not a parameter of this study; expected the names "
                         "of some",
                         name));
    takes[static_cast<std::size_t>(found - study.parameters.begin())] = true;
  }
  e.takes = std::move(takes);
}

// A parameter needs keys where a case takes it; a program takes it by its name.
void require_keys(const TomlTable& root, const Study& study) {
  std::size_t i = 0;  // of the parameters with a range
  for (const TomlTable& t : root.tables("parameters")) {
    const bool choice = t.has("choices");
    const auto& keys = choice ? study.choice->keys : study.parameters[i].keys;
    for (const Experiment& e : study.experiments)
      if ((choice ? e.takes_choice : e.takes[i]) && !e.program && keys.empty())
        t.fail("keys",
               "is missing; expected a list such as "
               "[\"interactions.ice-ice.static_friction\"]");
    i += choice ? 0 : 1;
  }
}

Experiment read_experiment(const TomlTable& t, const Study& study, Programs programs) {
  Experiment e;
  e.name = valid_name(t);
  if (t.has("program")) {
    t.allow({"name", "program", "template", "inputs", "responses", "set", "parameters"});
    e.program = read_user_program(t, study.source, programs);
  } else {
    t.allow({"name", "case", "set", "parameters"});
    e.case_file = case_path(t, study.source, "study");
  }
  if (t.has("set"))
    e.set =
        e.program ? read_program_inputs(t, e.set_places) : read_case_overrides(t, &e.set_places);
  read_takes(t, study, e);
  if (!e.program) return e;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < e.takes.size(); ++i)
    if (e.takes[i]) names.push_back(study.parameters[i].name);
  if (e.takes_choice) names.push_back(study.choice->name);
  for (const auto& [key, value] : e.set) names.push_back(key);
  require_placeholders(t, *e.program, names);
  return e;
}

// What simulates: the solver with case files and programs, or a function of the caller.
enum class Simulates { cases, function };

void read_experiments(const TomlTable& root, const TomlTable& head, Study& study,
                      Simulates simulates, Programs programs) {
  if (simulates == Simulates::function) {
    study.experiments.push_back({"", "", {}, std::vector<bool>(study.parameters.size(), true)});
    return;
  }
  const std::vector<TomlTable> tables = root.tables("experiments");
  if (tables.empty()) {
    study.experiments.push_back({"",
                                 case_path(head, study.source, "study"),
                                 {},
                                 std::vector<bool>(study.parameters.size(), true)});
    return;
  }
  if (head.has("case"))
    head.fail("case", "is given together with [[experiments]]; expected one or the other");
  std::set<std::string> names;
  for (const TomlTable& t : tables) {
    study.experiments.push_back(read_experiment(t, study, programs));
    if (!names.insert(study.experiments.back().name).second)
      t.fail("name", "is used twice; expected a unique name");
  }
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    if (std::none_of(study.experiments.begin(), study.experiments.end(),
                     [&](const Experiment& e) { return e.takes[i]; }))
      root.fail("experiments", fmt::format("no experiment takes the parameter \"{}\"; expected at "
                                           "least one",
                                           study.parameters[i].name));
  if (study.choice && std::none_of(study.experiments.begin(), study.experiments.end(),
                                   [](const Experiment& e) { return e.takes_choice; }))
    root.fail("experiments", fmt::format("no experiment takes the parameter \"{}\"; expected at "
                                         "least one",
                                         study.choice->name));
}

// `changes.set`: what a table sets in the experiments, or in the one that it names. A program takes
// only what its experiment sets as well.
template <class Changes>
void read_changes(const TomlTable& t, const Study& study, Changes& changes) {
  if (t.has("experiment")) changes.only = named_experiment(t, study);
  std::vector<const Experiment*> programs;
  for (std::size_t e = 0; e < study.experiments.size(); ++e)
    if (study.experiments[e].program && changes.only.value_or(e) == e)
      programs.push_back(&study.experiments[e]);
  t.required_table("set");
  changes.set = programs.empty() ? read_case_overrides(t, &changes.set_places)
                                 : read_program_inputs(t, changes.set_places);
  for (const Experiment* program : programs)
    for (const Override& change : changes.set)
      if (std::none_of(program->set.begin(), program->set.end(),
                       [&](const Override& o) { return o.first == change.first; }))
        t.fail("set", fmt::format("\"{}\" is not a key of `set` of the experiment \"{}\"; expected "
                                  "one, or another `experiment`",
                                  change.first, program->name));
}

void read_numerics(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("numerics")) {
    t.allow({"name", "set", "experiment"});
    NumericsCheck check{t.string("name"), {}, {}};
    read_changes(t, study, check);
    study.numerics.push_back(std::move(check));
  }
}

void read_low_fidelity(const TomlTable& root, Study& study) {
  const TomlTable t = root.required_table("low_fidelity");
  t.allow({"set", "experiment", "pairs"});
  LowFidelity low;
  read_changes(t, study, low);
  if (low.set.empty())
    t.fail("set",
           "is empty; expected the keys that make the case cheaper, such as "
           "{ \"materials.ice.young_modulus\" = \"1 MPa\" }");
  constexpr int usual_pairs = 2;
  low.pairs = checked_count(t, "pairs", t.integer("pairs", 1, usual_pairs));
  study.low_fidelity = std::move(low);
}

void read_direct(const TomlTable& root, Study& study) {
  const TomlTable t = root.required_table("direct");
  t.allow({"search", "evaluations"});
  const std::string word = t.choice("search", {"bobyqa", "cobyla", "nelder-mead", "crs"});
  for (const DirectSearch s :
       {DirectSearch::bobyqa, DirectSearch::cobyla, DirectSearch::nelder_mead, DirectSearch::crs})
    if (word == to_string(s)) study.direct = s;
  study.direct_evaluations = t.integer("evaluations", 1);
  if (study.choice)
    t.fail("search", "takes no parameter with choices; expected a study without one");
  if (!study.curves.empty())
    t.fail("search", "takes no curves as targets; expected targets with a value");
  if (study.low_fidelity) t.fail("search", "takes no [low_fidelity]; expected a study without it");
  if (!study.constraints.all.empty() || !study.priors.empty())
    t.fail("search", "takes neither [[priors]] nor [[constraints]]; expected a study without them");
}

Study read_text(const std::string& text, const std::string& source, Simulates simulates,
                Programs programs) {
  Study study;
  study.source = source;
  study.text = text;
  TomlDocument document(study.text, source, TomlFormat::study);
  require_kind(document, "study");
  const TomlTable root = TomlTable::root(document);
  root.allow({"study", "experiments", "budget", "parameters", "priors", "constraints", "targets",
              "observe", "compare", "numerics", "low_fidelity", "direct", "execution"});
  const TomlTable head = root.required_table("study");
  head.allow({"name", "case", "bench_tests", "seed", "threads"});
  study.name = valid_name(head);
  study.seed = static_cast<std::uint64_t>(head.integer("seed", 0, 1));
  study.threads = head.integer("threads", 1, 1);
  read_parameters(root, study);
  read_priors(root, study);
  read_constraints(root, study);
  read_experiments(root, head, study, simulates, programs);
  require_keys(root, study);
  read_responses(root, head, study);
  read_compare(root, study);
  read_numerics(root, study);
  if (root.has("low_fidelity")) read_low_fidelity(root, study);
  if (root.has("direct")) read_direct(root, study);
  study.execution = read_execution(root);
  study.budget = read_budget(root, study);
  if (study.largest_total() > input_limits::batch_runs)
    root.fail("budget",
              fmt::format("makes more than {} runs; expected fewer", input_limits::batch_runs));
  return study;
}

}  // namespace

const char* to_string(DirectSearch search) {
  switch (search) {
    case DirectSearch::none:
      return "none";
    case DirectSearch::bobyqa:
      return "bobyqa";
    case DirectSearch::cobyla:
      return "cobyla";
    case DirectSearch::nelder_mead:
      return "nelder-mead";
    case DirectSearch::crs:
      return "crs";
  }
  return "";
}

Study read_study(const std::string& file, Programs programs) {
  return read_text(read_input_file(file, "a study file (TOML)", input_limits::toml_bytes), file,
                   Simulates::cases, programs);
}

Study read_function_study(const std::string& text, const std::string& source) {
  return read_text(text, source, Simulates::function, Programs::refused);
}

}  // namespace firn
