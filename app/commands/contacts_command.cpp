// firn contacts: simulates again up to an instant and prints the contact forces.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "app/commands/commands.h"
#include "app/output/contact_output.h"
#include "app/output/progress_bar.h"
#include "app/support/case_file.h"
#include "app/support/count_range.h"
#include "app/support/default_threads.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_file.h"
#include "experiments/run/replay.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "reports/rendering/contact_picture.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct ContactsArguments {
  std::string file;
  std::string time;
  std::optional<std::uint64_t> step;
  std::string particle;
  std::vector<std::string> pair;
  std::vector<std::string> history;
  std::uint64_t every = 0;  // steps; 0: about 200 rows
  std::vector<std::string> settings;
  std::size_t listed = 10;
  int threads = 0;
  std::string output;
  bool json = false, quiet = false;
};

constexpr std::uint64_t kEnd = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kRows = 200;  // of a history, by default

// What is simulated again, and how far it goes.
struct ReplaySource {
  Case c;
  bool recorded = false;            // a results file
  std::string latest;               // words for the message: "the run's last frame, 0.6 s"
  std::uint64_t last_frame = kEnd;  // step
  std::uint64_t last_step = 0;      // that can be asked for
};

ReplaySource open_source(const ContactsArguments& a) {
  ReplaySource s;
  s.recorded = !is_case_file(a.file);
  if (!s.recorded) {
    std::vector<Override> overrides;
    for (const std::string& text : a.settings) overrides.push_back(parse_override(text));
    s.c = read_case(a.file, overrides);
    s.last_step = to_steps(s.c, s.c.duration);
    s.latest = fmt::format("the case's latest end, {:.6g} s", s.c.duration);
    return s;
  }
  if (!a.settings.empty())
    throw InputError("--set: changes a case file; expected none together with a results file");
  const Recording recording(a.file);
  s.c = read_case(recording);
  const std::vector<double> times = recording.frame_times();
  if (times.empty()) throw InputError(a.file + ": holds no frame; expected a run that has begun");
  s.last_frame = s.last_step = to_steps(s.c, times.back());
  s.latest = fmt::format("the end of the run, {:.6g} s", times.back());
  if (recording.status() != "finished") {
    // How far the run came beyond its last frame is unknown.
    s.last_step = to_steps(s.c, s.c.duration);
    s.latest = fmt::format("the case's latest end, {:.6g} s", s.c.duration);
    spdlog::info("{}: status of the run: {}", a.file, recording.status());
  }
  return s;
}

std::uint64_t asked_step(const ReplaySource& source, const std::string& option,
                         const std::string& text) {
  double time = 0;
  try {
    time = parse_quantity(text, dimension::time);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{} {}: {}", option, text, e.what()));
  }
  const double last = static_cast<double>(source.last_step) * source.c.model.timestep;
  if (time < 0 || time > last * (1 + 1e-9) + 0.5 * source.c.model.timestep)
    throw InputError(
        fmt::format("{} {}: is outside the run; expected 0 s ... {}", option, text, source.latest));
  return std::min(to_steps(source.c, time), source.last_step);
}

std::uint64_t instant_step(const ContactsArguments& a, const ReplaySource& source) {
  if (!a.time.empty()) return asked_step(source, "--time", a.time);
  if (!a.step) return source.last_frame;
  if (*a.step > source.last_step)
    throw InputError(
        fmt::format("--step {}: is outside the run; expected 0 ... {}", *a.step, source.last_step));
  return *a.step;
}

ContactSelection choice_of(const ContactsArguments& a, const Model& model) {
  ContactSelection choice;
  if (!a.particle.empty()) {
    choice.body = find_body(model, a.particle, "--particle");
    if (!is_particle(model, choice.body))
      throw InputError(
          fmt::format("--particle {}: is a boundary; expected a particle's id", a.particle));
  }
  if (a.pair.empty()) return choice;
  choice.body = find_body(model, a.pair[0], "--pair");
  choice.other = find_body(model, a.pair[1], "--pair");
  if (choice.body == choice.other ||
      (!is_particle(model, choice.body) && !is_particle(model, choice.other)))
    throw InputError(
        fmt::format("--pair {} {}: cannot touch each other; expected two bodies, one "
                    "of them a particle at least",
                    a.pair[0], a.pair[1]));
  return choice;
}

void check_contact_options(const ContactsArguments& a) {
  if (!a.particle.empty() && !a.pair.empty())
    throw InputError("--particle: and --pair were both given; expected one of them");
  if (!a.history.empty() && a.particle.empty() && a.pair.empty())
    throw InputError("--history: needs a body; expected --particle or --pair with it");
  if (a.every > 0 && a.history.empty())
    throw InputError("--every: thins a history; expected --history with it");
  if (!a.history.empty() && (!a.time.empty() || a.step))
    throw InputError("--history: has its own times; expected no --time or --step with it");
  if (!a.time.empty() && a.step)
    throw InputError("--time: and --step were both given; expected one of them");
}

// Refuses particles that are absent at that step by the results file, before minutes of replay. One
// that comes or leaves within a step of the instant is left to the replay.
void check_presence(const ContactsArguments& a, const ReplaySource& source,
                    const ContactSelection& choice, std::uint64_t step) {
  if (!source.recorded || step == kEnd) return;
  const Recording recording(a.file);
  const std::vector<double> came = recording.insert_time(), left = recording.exit_time();
  const double dt = source.c.model.timestep, time = static_cast<double>(step) * dt;
  for (const int body : {choice.body, choice.other}) {
    if (body < 0 || !is_particle(source.c.model, body)) continue;
    const auto i = static_cast<std::size_t>(body);
    const bool gone = left.at(i)<time - dt, to_come = came.at(i)> time + dt;
    if (gone || to_come)
      throw InputError(fmt::format(
          "{} {}: is not there at {} s, it {} at {} s; expected a particle that is present, or "
          "another --time",
          a.pair.empty() ? "--particle" : "--pair", body, number_text(time, 6),
          gone ? "has left" : "comes", number_text(gone ? left[i] : came[i], 6)));
  }
}

// Runs the replay and prints how it was checked. Returns `done`; false: interrupted.
bool simulate(const ContactsArguments& a, const ReplaySource& source, ReplayOptions options,
              const bool& done) {
  const double dt = source.c.model.timestep;
  ProgressMeter meter(dt);
  options.threads = a.threads > 0 ? a.threads : default_threads();
  options.interrupt = &interruption::requested();
  if (!a.quiet) options.progress = [&](const Progress& p) { meter.show(p); };
  const Replay replayed = source.recorded ? replay(a.file, options) : replay(source.c, options);
  meter.finish();
  // A replay that was stopped before the frame after the instant is not proved.
  if (replayed.interrupted) {
    print_lines(stderr, "firn: interrupted at t = {:.4g} s\n", replayed.simulated);
    return false;
  }
  if (!done) {
    throw InputError(fmt::format("{}: ended at {:.6g} s, before the instant asked for ({})", a.file,
                                 replayed.simulated, replayed.reason));
  }
  if (source.recorded) {
    spdlog::info(
        "replayed from {:.6g} s; {} recorded frames up to {:.6g} s came out the same, bit "
        "for bit",
        static_cast<double>(replayed.began_at) * dt, replayed.frames_equal,
        replayed.verified_until);
  }
  return true;
}

// What --output names: a picture, a table, points for ParaView, or a folder for all.
struct Outputs {
  std::string picture, table, points;
};
// `whole`: all bodies of an instant, which are not drawn; `points`: the output lists points.
Outputs outputs_of(const std::string& output, bool whole, bool points) {
  if (output.empty()) return {};
  const std::string extension = fs::path(output).extension().string();
  const bool picture = extension == ".png" || extension == ".svg";
  if (picture && whole)
    throw InputError(
        "--output: a picture shows one body or pair; expected --particle or --pair with it");
  if (picture) return {output, "", ""};
  if (extension == ".csv") return {"", output, ""};
  if (extension == ".vtp" && points) return {"", "", output};
  if (!extension.empty())
    throw InputError(
        fmt::format("--output {}: no format that is known here; expected FILE.png, FILE.svg, "
                    "FILE.csv{} or a folder",
                    output, points ? ", FILE.vtp" : ""));
  make_output_folder(output);
  const fs::path folder(output);
  return {whole ? "" : (folder / "contacts.png").string(), (folder / "contacts.csv").string(),
          points ? (folder / "contacts.vtp").string() : ""};
}

void log_outputs(const Outputs& out) {
  if (!out.picture.empty()) print_lines(stderr, "drawn in {}\n", out.picture);
  if (!out.table.empty()) print_lines(stderr, "tabled in {}\n", out.table);
  if (!out.points.empty()) print_lines(stderr, "points for ParaView in {}\n", out.points);
}

int audit_instant(const ContactsArguments& a, const ReplaySource& source) {
  const ContactSelection choice = choice_of(a, source.c.model);
  const std::uint64_t step = instant_step(a, source);
  const Outputs out = outputs_of(a.output, choice.body < 0, true);
  check_presence(a, source, choice, step);
  std::optional<ContactSnapshot> now;
  bool done = false;
  ReplayOptions options;
  if (step != kEnd) {
    options.from_step = step;
    options.end_time_limit = static_cast<double>(step) * source.c.model.timestep;
  }
  options.observe = [&](const Solver& solver, bool last) {
    if (solver.steps() != step && !(last && step == kEnd)) return true;
    now = take_snapshot(solver, choice, a.listed, a.pair.empty() ? "--particle" : "--pair");
    done = true;
    return false;
  };
  if (!simulate(a, source, options, done)) return ExitStatus::interrupted;
  if (a.json)
    print_json(choice.body < 0 ? summary_json(source.c, *now) : audit_json(source.c, choice, *now));
  else
    print_lines(
        stdout, "{}",
        choice.body < 0 ? summary_text(source.c, *now) : audit_text(source.c, choice, *now));
  if (!out.picture.empty()) draw_contacts(source.c, choice, *now, out.picture);
  if (!out.table.empty()) write_contacts_csv(source.c.model, now->contacts, out.table);
  if (!out.points.empty()) write_contacts_vtk(now->contacts, out.points);
  log_outputs(out);
  return ExitStatus::done;
}

int audit_history(const ContactsArguments& a, const ReplaySource& source) {
  const ContactSelection choice = choice_of(a, source.c.model);
  const std::uint64_t from = asked_step(source, "--history", a.history[0]);
  const std::uint64_t to = asked_step(source, "--history", a.history[1]);
  if (to <= from)
    throw InputError(fmt::format("--history {} {}: ends before it begins; expected FROM before TO",
                                 a.history[0], a.history[1]));
  const Outputs out = outputs_of(a.output, false, false);
  const std::uint64_t every =
      a.every > 0 ? a.every : std::max<std::uint64_t>(1, (to - from) / kRows);
  ContactHistory history(choice, every);
  bool done = false;
  ReplayOptions options;
  options.from_step = from;
  options.end_time_limit = static_cast<double>(to) * source.c.model.timestep;
  options.observe = [&](const Solver& solver, bool last) {
    done = solver.steps() == to;
    history.add_step(solver, last || done);
    return !done;
  };
  if (!simulate(a, source, options, done)) return ExitStatus::interrupted;
  if (a.json)
    print_json(history_json(source.c, history.rows(), history.events()));
  else
    print_lines(stdout, "{}{}", history_text(history.rows()),
                events_text(source.c, history.events()));
  if (!out.picture.empty()) draw_history(source.c, choice, history.rows(), out.picture);
  if (!out.table.empty()) write_history_csv(history.rows(), out.table);
  log_outputs(out);
  return ExitStatus::done;
}

int audit(const ContactsArguments& a) {
  check_contact_options(a);
  if (a.quiet) spdlog::set_level(spdlog::level::warn);
  const ReplaySource source = open_source(a);
  return a.history.empty() ? audit_instant(a, source) : audit_history(a, source);
}

// Which instants and which contacts.
void add_selection_options(CLI::App& command, ContactsArguments& a) {
  command
      .add_option(
          "--time", a.time,
          "Instant, e.g. \"0.5 s\"; by default the last frame of a run, or\nthe end of a case")
      ->type_name("TIME");
  command.add_option("--step", a.step, "Instant as a number of time steps, in place of --time")
      ->check(CLI::Range(std::int64_t{0}, kLargestCount))
      ->type_name("N");
  command
      .add_option("--particle", a.particle, "All contacts of the particle with this number, from 0")
      ->type_name("ID");
  command
      .add_option("--pair", a.pair,
                  "Contacts of two bodies: numbers of particles or names of\nboundaries")
      ->expected(2)
      ->type_name("A B");
  command
      .add_option("--history", a.history,
                  "The contacts over time, loading and unloading, between two\ninstants, e.g. "
                  "\"0.1 s\" \"0.2 s\"")
      ->expected(2)
      ->type_name("FROM TO");
  command
      .add_option("--every", a.every,
                  "With --history: a row every N time steps; about 200 rows by\ndefault")
      ->check(CLI::Range(1, 1000000000))
      ->type_name("N");
  command
      .add_option("--limit", a.listed,
                  "Without --particle and --pair: list at most so many contacts")
      ->check(CLI::Range(1, 1000000000))
      ->type_name("N")
      ->capture_default_str();
}

}  // namespace

void add_contacts_command(CLI::App& app, int& status) {
  auto a = std::make_shared<ContactsArguments>();
  CLI::App* command = app.add_subcommand(
      "contacts", "Simulate again up to an instant and print the contact forces");
  command
      ->add_option("FILE", a->file,
                   "Results file of `firn run`, whose run is simulated again and\n"
                   "compared with it; or a case file (*.toml)")
      ->required()
      ->type_name("RUN.h5|CASE.toml");
  add_selection_options(*command, *a);
  add_settings_option(*command, a->settings);
  add_threads_option(*command, a->threads);
  command
      ->add_option("-o,--output", a->output,
                   "FILE.png or FILE.svg: a picture; FILE.csv: a table; FILE.vtp: the\n"
                   "points for ParaView; else a folder for all")
      ->type_name("PATH");
  command->add_flag("--json", a->json, json_help);
  command->add_flag("-q,--quiet", a->quiet, quiet_help);
  command->callback([a, &status] { status = audit(*a); });
}

}  // namespace firn
