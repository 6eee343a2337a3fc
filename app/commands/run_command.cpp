// firn run: simulates one case or resumes one.
#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string_view>

#include "app/commands/commands.h"
#include "app/output/progress_bar.h"
#include "app/output/response_output.h"
#include "app/output/shape_output.h"
#include "app/support/count_range.h"
#include "app/support/default_threads.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/inspection/run_diagnostics.h"
#include "experiments/inspection/state_trace.h"
#include "experiments/material_records/material_record.h"
#include "experiments/meshes/length_unit.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "experiments/storage/version.h"
#include "experiments/system/interruption.h"
#include "experiments/system/terminal.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  std::string case_file;
  std::string output;
  std::optional<std::uint64_t> seed;
  int threads = 0;  // 0: not given
  std::vector<std::string> settings;
  MaterialRequest materials;
  std::string resume_file;
  TraceOptions trace;
  std::string trace_numbers;
  std::vector<std::string> requirements;
  bool json = false;
  bool verbose = false;
  bool quiet = false;
};

// The kind of a shape as the case states it: "crescent (mass-matched)".
std::string kind_text(const toml::table& resolved, const std::string& shape) {
  const auto table = resolved["shapes"][shape];
  const std::string kind = table["kind"].value_or("shape");
  const std::string variant = table["variant"].value_or("");
  return variant.empty() ? kind : fmt::format("{} ({})", kind, variant);
}

// runs/<case name>-seed<N>.h5
std::string default_output(const Case& c) {
  const std::string name = encode::file_name(c.name);
  return fmt::format("runs/{}-seed{}.h5", name.empty() ? "case" : name, c.seed);
}

// Logs the values that each material record sets, and those of its values that are not used.
void log_materials(const Case& c, const toml::table& resolved) {
  for (const AppliedMaterial& m : c.material_records) {
    std::vector<std::string> sets;
    for (const std::string& key : m.applied_keys) {
      const toml::node_view value = resolved.at_path(key);
      sets.push_back(value.is_string() ? fmt::format("{} = {}", key, value.value_or(""))
                                       : fmt::format("{} = {}", key, value.value_or(0.0)));
    }
    spdlog::info("material {}{}{} sets {}", m.record, m.selection.empty() ? "" : ", ", m.selection,
                 sets.empty() ? "nothing" : comma_list(sets));
    if (!m.overridden_keys.empty())
      spdlog::info("  the case takes precedence for {}", comma_list(m.overridden_keys));
    if (!m.unmatched_keys.empty())
      spdlog::info("  the case has no place for {}", comma_list(m.unmatched_keys));
    if (!m.contact_model) continue;
    const std::string warning = contact_model_warning(m.record, *m.contact_model);
    if (!warning.empty()) spdlog::warn("{}", warning);
  }
}

void log_case(const Case& c, const std::string& results_file) {
  spdlog::info("case {} ({}), seed {}", c.name, c.source, c.seed);
  if (!c.start.empty()) spdlog::info("starts from {}", c.start);
  const toml::table resolved = toml::parse(c.resolved);
  log_materials(c, resolved);
  const std::set<std::string> rounded = shapes_with_stated_rounding(c);
  for (std::size_t i = 0; i < c.model.shapes.size(); ++i) {
    const Shape& shape = c.model.shapes[i];
    const auto count = std::count_if(
        c.model.particles.begin(), c.model.particles.end(),
        [&](const Particle& particle) { return particle.shape == static_cast<int>(i); });
    spdlog::info("{} x {}: {}, {}", count, shape.name, kind_text(resolved, shape.name),
                 shape_line(shape));
    const std::string warning = deviation_warning(shape, rounded.contains(shape.name));
    if (!warning.empty()) spdlog::warn("{}", warning);
    const auto table = resolved["shapes"][shape.name];
    if (table["kind"].value_or("") != std::string_view("mesh")) continue;
    const std::string advice = length_unit_warning(
        shape.box.maxCoeff(), parse_length_unit(table["length_unit"].value_or("m")),
        MeshUse::particle);
    if (!advice.empty()) spdlog::warn("shape {}: length_unit: {}", shape.name, advice);
  }
  for (std::size_t i = 0; i < c.model.beams.size(); ++i) {
    const BeamLaw& beam = c.model.beams[i];
    const auto count = std::ranges::count(c.model.bonds, static_cast<int>(i), &Bond::law);
    spdlog::info("{} x bond {}: {:.4g} mm wide, {:.4g} mm long, {:.4g} MPa in tension", count,
                 beam.name, 2e3 * beam.section.half_width, 1e3 * beam.length,
                 1e-6 * beam.tensile_strength);
  }
  spdlog::info("time step {:.4g} s: {}", c.model.timestep, c.timestep_reason);
  if (c.steps_taken > 0 && c.steps_taken < kAccurateSteps) {
    spdlog::warn(
        "time step: {:.3g} steps in the shortest quarter period are {}; expected at most {:.4g} s",
        c.steps_taken,
        c.steps_taken < kStableSteps ? "not stable"
                                     : "stable, but restitution is off by more than 1 %",
        c.model.timestep * c.steps_taken / kAccurateSteps);
  }
  spdlog::info("results in {}", results_file);
}

// Largest overlap as a fraction of the smallest edge of that particle's bounding box.
double relative_overlap(const Case& c, const Diagnostics& diagnostics) {
  if (diagnostics.largest_overlap_particle < 0) return 0;
  const Particle& particle =
      c.model.particles.at(static_cast<std::size_t>(diagnostics.largest_overlap_particle));
  const Shape& shape = c.model.shapes.at(static_cast<std::size_t>(particle.shape));
  return diagnostics.largest_overlap / shape.box.minCoeff();
}

// Warnings on the results of a run in one sentence; empty: none.
std::string warning_of_run(const Case& c, const std::string& results_file,
                           const RunSummary& summary) {
  if (summary.steps == 0) return {};
  try {
    const Recording recording(results_file);
    std::string all;
    for (const RunWarning& warning : run_warnings(recording, c))
      all += (all.empty() ? "" : "; ") + warning.text;
    return all;
  } catch (const InputError&) {
    return {};  // a file that a full disk cut short; the summary reports it
  }
}

Json summary_json(const Case& c, const std::string& file, const RunSummary& s,
                  const std::vector<RequirementResult>& verdicts, const std::string& warning) {
  Json document = {{"case", c.name},
                   {"results_file", file},
                   {"status", to_string(s.status)},
                   {"reason", s.reason},
                   {"seed", c.seed},
                   {"timestep", c.model.timestep},
                   {"particles", c.model.particles.size()},
                   {"simulated", s.simulated},
                   {"wall", s.wall},
                   {"steps", s.steps},
                   {"responses", responses_json(s.responses)}};
  if (!verdicts.empty()) document["requirements"] = verdicts_json(verdicts);
  if (!c.material_records.empty()) {
    Json& records = document["material_records"] = Json::array();
    for (const AppliedMaterial& m : c.material_records)
      records.push_back({{"record", m.record},
                         {"selection", m.selection},
                         {"sha256", m.sha256},
                         {"sets", m.applied_keys}});
  }
  document["energy"] = energy_json(s.energy);
  document["diagnostics"] = {{"largest_overlap", s.diagnostics.largest_overlap},
                             {"largest_overlap_relative", relative_overlap(c, s.diagnostics)},
                             {"largest_overlap_particle", s.diagnostics.largest_overlap_particle},
                             {"late_contacts", s.diagnostics.late_contacts},
                             {"unconverged_steps", s.diagnostics.unconverged_steps},
                             {"energy_error", s.diagnostics.energy_error},
                             {"warning", warning}};
  document["profile"] = profile_json(s.profile);
  document["firn_version"] = firn_version();
  document["git_commit"] = firn_git_commit();
  document["contact_model"] = kContactModel;
  return document;
}

void log_summary(const Case& c, const RunSummary& s) {
  if (!s.write_failed) spdlog::info("{} at t = {:.4g} s", s.reason, s.simulated);
  if (s.steps == 0) return;  // nothing was simulated: it was finished already
  spdlog::info("{} steps in all; {} of wall time in this session", s.steps, duration_text(s.wall));
  spdlog::info(
      "diagnostics: largest overlap {} mm ({} % of the thickness), {} late contact{}, "
      "energy error {} J",
      number_text(s.diagnostics.largest_overlap * 1e3, 3),
      number_text(100 * relative_overlap(c, s.diagnostics), 2), s.diagnostics.late_contacts,
      s.diagnostics.late_contacts == 1 ? "" : "s", number_text(s.diagnostics.energy_error, 3));
  const auto joules = [](double energy) { return number_text(resolved(energy, "J")); };
  spdlog::info(
      "energy: {} J kinetic, {} J elastic, {} J dissipated by restitution, {} J by friction{}",
      joules(s.energy.kinetic), joules(s.energy.elastic), joules(s.energy.dissipated_normal),
      joules(s.energy.dissipated_friction),
      c.model.bonds.empty() ? ""
                            : fmt::format(", {} J by bonds", joules(s.energy.dissipated_bonds)));
  spdlog::debug("instructions: {}; time by phase of the step:\n{}", instruction_set(),
                profile_table(s.profile));
}

int exit_status(const RunSummary& summary, const std::string& file,
                const std::vector<RequirementResult>& verdicts) {
  switch (summary.status) {
    case RunStatus::finished:
      return all_met(verdicts) ? ExitStatus::done : ExitStatus::requirement_missed;
    case RunStatus::interrupted:
      print_lines(stderr, "firn: interrupted at t = {:.4g} s; resume with: firn run --resume {}\n",
                  summary.simulated, file);
      return ExitStatus::interrupted;
    case RunStatus::failed:
      print_lines(stderr, "firn: {}{}\n",
                  summary.write_failed ? "" : "the run failed: ", summary.reason);
      return ExitStatus::failed;
  }
  return ExitStatus::failed;
}

void check_run_options(const RunArguments& a) {
  if (a.case_file.empty() && a.resume_file.empty()) {
    throw InputError("run: no case; expected CASE.toml or --resume RUN.h5");
  }
  const bool changed = !a.case_file.empty() || !a.output.empty() || a.seed || !a.settings.empty() ||
                       !a.materials.records.empty();
  if (!a.resume_file.empty() && changed) {
    throw InputError(
        "--resume: takes the case from the results file; expected no CASE.toml, --output, "
        "--seed, --set or --material with it");
  }
}

// "1200" or "1200:1210"
TraceOptions trace_options(const RunArguments& a) {
  TraceOptions trace = a.trace;
  if (a.trace_numbers.empty()) return trace;
  const char* text = a.trace_numbers.c_str();
  const char* end = text + a.trace_numbers.size();
  auto [stop, error] = std::from_chars(text, end, trace.numbers_from);
  trace.numbers_to = trace.numbers_from;
  if (error == std::errc() && stop != end && *stop == ':') {
    const auto second = std::from_chars(stop + 1, end, trace.numbers_to);
    stop = second.ptr;
    error = second.ec;
  }
  if (error != std::errc() || stop != end || trace.numbers_to < trace.numbers_from)
    throw InputError(fmt::format(
        "--trace-numbers {}: is not a range of steps; expected STEP or FROM:TO", a.trace_numbers));
  return trace;
}

Case read_case_to_run(const RunArguments& a) {
  if (!a.resume_file.empty()) return read_case(Recording(a.resume_file));
  std::vector<Override> overrides;
  for (const std::string& text : a.settings) overrides.push_back(parse_override(text));
  if (a.seed) overrides.emplace_back("case.seed", std::to_string(*a.seed));
  return read_case(a.case_file, overrides, a.materials);
}

int run_case(const RunArguments& a) {
  check_run_options(a);
  if (a.verbose) spdlog::set_level(spdlog::level::debug);
  if (a.quiet) spdlog::set_level(spdlog::level::warn);
  std::vector<Requirement> requirements;
  for (const std::string& text : a.requirements) requirements.push_back(parse_requirement(text));
  const TraceOptions traced = trace_options(a);
  const Case c = read_case_to_run(a);

  RunOptions options;
  options.threads = a.threads > 0 ? a.threads : default_threads();
  options.interrupt = &interruption::requested();
  ProgressMeter meter(c.model.timestep);
  if (!a.quiet) options.progress = [&](const Progress& progress) { meter.show(progress); };
  const bool resuming = !a.resume_file.empty();
  options.results_file = resuming ? a.resume_file : a.output.empty() ? default_output(c) : a.output;
  make_output_folder(fs::path(options.results_file).parent_path().string());
  options.started = [&] { log_case(c, options.results_file); };
  std::optional<TraceWriter> trace;
  if (!a.trace.file.empty()) {
    trace.emplace(c, traced);
    options.each_step = [&](const Solver& solver, bool last) { trace->add_step(solver, last); };
  }
  const RunSummary summary = resuming ? resume(a.resume_file, options, &c) : run(c, options);
  meter.finish();
  if (trace) trace->close();
  if (!summary.renamed_earlier_file.empty()) {
    spdlog::info("earlier results of that name are now in {}", summary.renamed_earlier_file);
  }
  log_summary(c, summary);
  const std::string warning = warning_of_run(c, options.results_file, summary);
  if (!warning.empty()) spdlog::warn("{}", warning);

  std::vector<RequirementResult> verdicts;
  if (summary.status == RunStatus::finished)
    verdicts = check_requirements(requirements, summary.responses);
  if (a.json) {
    print_json(summary_json(c, options.results_file, summary, verdicts, warning));
  } else {
    print_lines(stdout, "{}{}", run_responses_table(summary.responses, c),
                verdicts_table(verdicts));
  }
  return exit_status(summary, options.results_file, verdicts);
}

// What is simulated: a case with changes, or the rest of a run.
void add_input_options(CLI::App& command, RunArguments& a) {
  command.add_option("CASE.toml", a.case_file, "Case file; docs/case-files.md lists its keys")
      ->type_name("");
  command
      .add_option("--seed", a.seed,
                  "Seed of all random choices, a whole number; by default that of\nthe case "
                  "(case.seed)")
      ->check(CLI::Range(std::int64_t{0}, kLargestCount))
      ->type_name("N");
  add_settings_option(command, a.settings,
                      "Override a value of the case by its TOML path, e.g.\n"
                      "interactions.ice-ice.static_friction=0.2 (may be repeated)");
  command
      .add_option("--material", a.materials.records,
                  "Values of a material record over those of the case; NAME#3 takes a\n"
                  "sample of its posterior ensemble (may be repeated; --set takes precedence)")
      ->type_name("NAME[@VERSION]")
      ->allow_extra_args(false);
  command.add_option("--database", a.materials.database, database_help)->type_name("FILE");
  command
      .add_option("--resume", a.resume_file,
                  "Resume from the last checkpoint in a results file,\nwith the bits of an "
                  "uninterrupted run")
      ->type_name("RUN.h5");
}

void add_trace_options(CLI::App& command, RunArguments& a) {
  CLI::Option* trace =
      command
          .add_option("--trace-hashes", a.trace.file,
                      "Write a line of hashes of the state each step, for `firn compare-traces`")
          ->type_name("FILE");
  command
      .add_option("--trace-every", a.trace.every,
                  "Write hashes only every N time steps; 1 by default")
      ->check(CLI::Range(1, 1000000000))
      ->needs(trace)
      ->type_name("N");
  command
      .add_option("--trace-numbers", a.trace_numbers,
                  "Also write the state itself (bodies, patches, points) at one\ntime step or over "
                  "a range, e.g. 1200 or 1200:1210")
      ->needs(trace)
      ->type_name("STEP|FROM:TO");
}

}  // namespace

void add_run_command(CLI::App& app, int& status) {
  auto a = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Simulate one case and measure its responses");
  add_input_options(*command, *a);
  command
      ->add_option("-o,--output", a->output,
                   "Results file; runs/<case name>-seed<N>.h5 by default.\n"
                   "Earlier results of that name become RUN.1.h5, RUN.2.h5, ...")
      ->type_name("RUN.h5");
  add_threads_option(*command, a->threads);
  add_trace_options(*command, *a);
  command->add_option("--require", a->requirements, requirement_help)
      ->type_name("\"RESPONSE<=VALUE\"")
      ->allow_extra_args(false);
  command->add_flag("--json", a->json, json_help);
  command->add_flag("-v,--verbose", a->verbose,
                    "Also print the wall time of each phase of the step and the\ninstruction "
                    "set in use");
  command->add_flag("-q,--quiet", a->quiet, quiet_help);
  command->footer("Ctrl-C saves the state and leaves with status 130; --resume continues from it.");
  command->callback([a, &status] { status = run_case(*a); });
}

}  // namespace firn
