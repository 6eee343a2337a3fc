// firn materials: the material parameter database.
#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "app/commands/commands.h"
#include "app/output/material_output.h"
#include "app/support/default_threads.h"
#include "app/support/exit_status.h"
#include "app/support/record_verification.h"
#include "app/support/shared_options.h"
#include "experiments/material_records/material_json.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"

namespace firn {
namespace {

using Access = MaterialDatabase::Access;

struct MaterialsArguments {
  std::vector<std::string> names;
  std::string first, second;  // of diff; of others the first alone
  std::string file;           // to read or to write
  std::string database;
  bool all = false;
  bool replay = false;
  RecordReplayOptions replay_options;
  bool json = false;
  std::string database_file() const { return material_database_file(database); }
};

// A record without a sample: what these commands are about.
MaterialChoice record_choice(const std::string& text) {
  MaterialChoice choice = parse_material_choice(text);
  if (!choice.selection().empty())
    throw InputError(
        fmt::format("material {}: names a sample; expected NAME or NAME@VERSION here", text));
  return choice;
}

StoredRecord find(const MaterialDatabase& database, const std::string& text) {
  const MaterialChoice choice = record_choice(text);
  return database.find(choice.name, choice.version);
}

int list(const MaterialsArguments& a) {
  const MaterialDatabase database(a.database_file());
  std::vector<StoredRecord> newest;
  for (const std::string& name : database.names()) newest.push_back(database.find(name));
  if (a.json)
    print_json(records_json(newest));
  else
    print_lines(stdout, "{}", records_table(newest));
  return ExitStatus::done;
}

int show(const MaterialsArguments& a) {
  const StoredRecord stored = find(MaterialDatabase(a.database_file()), a.first);
  if (a.json)
    print_json(record_json(stored));
  else
    print_lines(stdout, "{}", record_text(stored));
  return ExitStatus::done;
}

int history(const MaterialsArguments& a) {
  const MaterialDatabase database(a.database_file());
  const std::vector<StoredRecord> all = database.history(record_choice(a.first).name);
  if (a.json) {
    print_json(records_json(all));
    return ExitStatus::done;
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const MaterialRecord& r = all[i].record;
    print_lines(stdout, "{}  {}  {}  {}  sha256 {}\n", r.reference(), r.provenance.date,
                r.provenance.author, r.title, all[i].sha256.substr(0, 12));
    if (i == 0) continue;
    for (const RecordChange& c : changes(all[i - 1].record, r))
      if (c.path.starts_with("parameters.")) print_lines(stdout, "    {}", changes_table({c}));
  }
  return ExitStatus::done;
}

int diff(const MaterialsArguments& a) {
  const MaterialDatabase database(a.database_file());
  const StoredRecord from = find(database, a.first), to = find(database, a.second);
  const std::vector<RecordChange> all = changes(from.record, to.record);
  if (a.json)
    print_json({{"from", from.record.reference()},
                {"to", to.record.reference()},
                {"changes", changes_json(all)}});
  else
    print_lines(stdout, "{}",
                all.empty() ? "the same but for name and version\n" : changes_table(all));
  return ExitStatus::done;
}

int print_written(const MaterialsArguments& a, const MaterialDatabase& database,
                  const std::vector<StoredRecord>& written) {
  if (a.json) {
    print_json(records_json(written));
    return ExitStatus::done;
  }
  for (const StoredRecord& s : written)
    print_lines(stdout, "{}  sha256 {}\n", s.record.reference(), s.sha256);
  print_lines(stderr, "{} new record{} in {}\n", written.size(), written.size() == 1 ? "" : "s",
              database.file());
  return ExitStatus::done;
}

int add(const MaterialsArguments& a) {
  const std::vector<ReadRecord> read = read_records_file(a.file);
  std::vector<MaterialRecord> records;
  for (const ReadRecord& r : read) {
    if (r.record.version > 0 || !r.sha256.empty() || !r.record.supersedes.empty())
      throw InputError(fmt::format(
          "{}: records: {} has a version or a hash already; expected `firn materials import` for "
          "records that were exported",
          a.file, r.record.reference()));
    records.push_back(r.record);
  }
  MaterialDatabase database(a.database_file(), Access::write);
  return print_written(a, database, database.add(records));
}

int import(const MaterialsArguments& a) {
  std::vector<StoredRecord> records;
  for (const ReadRecord& r : read_records_file(a.file))
    records.push_back({r.record, r.sha256, false});
  MaterialDatabase database(a.database_file(), Access::write);
  return print_written(a, database, database.import(records));
}

int write_export(const MaterialsArguments& a) {
  if (a.all == !a.names.empty())
    throw InputError("materials export: expected NAME[@VERSION]..., or --all");
  const MaterialDatabase database(a.database_file());
  std::vector<MaterialRecord> records;
  for (const std::string& text : a.all ? database.names() : a.names) {
    const MaterialChoice choice = record_choice(text);
    const int last = database.find(choice.name, choice.version).record.version;
    for (const StoredRecord& s : database.history(choice.name))
      if (s.record.version <= last) records.push_back(s.record);
  }
  const std::string text = export_text(records);
  if (a.file.empty()) {
    print_lines(stdout, "{}", text);
    return ExitStatus::done;
  }
  write_file(a.file, text);
  print_lines(stderr, "{} record{} in {}\n", records.size(), records.size() == 1 ? "" : "s",
              a.file);
  return ExitStatus::done;
}

const char* to_string(CheckOutcome outcome) {
  switch (outcome) {
    case CheckOutcome::passed:
      return "holds";
    case CheckOutcome::failed:
      return "fails";
    case CheckOutcome::not_checked:
      return "unknown";
  }
  return "";
}

bool failed(const RecordCheck& check) { return check.outcome == CheckOutcome::failed; }

int verify_materials(const MaterialsArguments& a) {
  const MaterialDatabase database(a.database_file());
  std::vector<RecordCheck> checks;
  for (const std::string& text : a.names.empty() ? database.names() : a.names) {
    const MaterialChoice choice = record_choice(text);
    std::vector<RecordCheck> found = verify_records(database, choice);
    if (a.replay && found[0].outcome == CheckOutcome::passed) {
      const auto replayed =
          replay_record(database.find(choice.name, choice.version), a.replay_options);
      found.insert(found.end(), replayed.begin(), replayed.end());
    }
    checks.insert(checks.end(), found.begin(), found.end());
  }
  const bool good = std::ranges::none_of(checks, failed);
  if (a.json) {
    Json all = Json::array();
    for (const RecordCheck& c : checks)
      all.push_back({{"record", c.record},
                     {"what", c.what},
                     {"finding", to_string(c.outcome)},
                     {"detail", c.detail}});
    print_json({{"holds", good}, {"checks", all}});
  } else {
    for (const RecordCheck& c : checks)
      print_lines(stdout, "{:<8} {}: {}{}\n", failed(c) ? "FAILS" : to_string(c.outcome), c.record,
                  c.what, c.detail.empty() ? "" : ": " + c.detail);
  }
  return good ? ExitStatus::done : ExitStatus::requirement_missed;
}

// Adds sub-commands of `firn materials` with the options that they share.
class MaterialsCommands {
 public:
  using Action = int (*)(const MaterialsArguments&);

  MaterialsCommands(CLI::App& command, std::shared_ptr<MaterialsArguments> arguments, int& status)
      : command_(command), a_(std::move(arguments)), status_(status) {}

  CLI::App& add(const char* name, const char* what, Action carry_out) {
    CLI::App* sub = command_.add_subcommand(name, what);
    sub->add_option("--database", a_->database, database_help)->type_name("FILE");
    sub->callback([a = a_, carry_out, &status = status_] { status = carry_out(*a); });
    return *sub;
  }
  CLI::App& add_with_json(const char* name, const char* what, Action carry_out) {
    CLI::App& sub = add(name, what, carry_out);
    sub.add_flag("--json", a_->json, json_help);
    return sub;
  }

 private:
  CLI::App& command_;
  std::shared_ptr<MaterialsArguments> a_;
  int& status_;
};

void add_required(CLI::App& command, const char* name, std::string& value, const char* what) {
  command.add_option(name, value, what)->required()->type_name("");
}

void add_reading_commands(MaterialsCommands& commands, MaterialsArguments& a) {
  commands.add_with_json("list", "The newest version of every record", list);
  add_required(commands.add_with_json("show", "All of one record", show), "NAME[@VERSION]", a.first,
               "The record; the newest version by default");
  add_required(commands.add_with_json(
                   "history", "All versions of a record, and how their values differ", history),
               "NAME", a.first, "Name of the record");
  CLI::App& both = commands.add_with_json(
      "diff", "What differs between two records, or two versions of one", diff);
  add_required(both, "FROM", a.first, "The first record, as NAME[@VERSION]");
  add_required(both, "TO", a.second, "The second record, as NAME[@VERSION]");
}

void add_writing_commands(MaterialsCommands& commands, MaterialsArguments& a) {
  add_required(commands.add_with_json(
                   "add", "Write new records; a name that exists gets its next version", add),
               "FILE.json", a.file, "Records without version and hash; docs/materials.md");
  add_required(
      commands.add_with_json("import", "Take records as another database exported them", import),
      "FILE.json", a.file, "File that `firn materials export` wrote");
  CLI::App& exporting =
      commands.add("export", "Write records, with the versions before them, as JSON", write_export);
  exporting.add_option("NAME[@VERSION]", a.names, "Records to write; none with --all")
      ->type_name("");
  exporting.add_flag("--all", a.all, "Write every record, the shipped ones too");
  exporting.add_option("-o,--output", a.file, "File to write; standard output by default")
      ->type_name("FILE.json");
}

void add_verifying_command(MaterialsCommands& commands, MaterialsArguments& a) {
  CLI::App& command = commands.add_with_json(
      "verify", "Recompute the hashes of records and of the data behind them", verify_materials);
  command.add_option("NAME[@VERSION]", a.names, "Records to check; all by default")->type_name("");
  CLI::Option* replay = command.add_flag("--replay", a.replay,
                                         "Simulate again what the records rest on, and compare");
  command
      .add_option("--runs", a.replay_options.runs,
                  "At most N runs of each reference set and experiment; all by\ndefault")
      ->needs(replay)
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  add_threads_option(command, a.replay_options.threads)->needs(replay);
}

}  // namespace

void add_materials_command(CLI::App& app, int& status) {
  auto a = std::make_shared<MaterialsArguments>();
  a->replay_options.threads = default_threads();
  CLI::App* command = app.add_subcommand("materials", "Store and show material parameters");
  command->require_subcommand(1);
  MaterialsCommands commands(*command, a, status);
  add_reading_commands(commands, *a);
  add_writing_commands(commands, *a);
  add_verifying_command(commands, *a);
  command->footer(
      "Records are never changed: `add` and `calibrate --save` write the next version.\n"
      "`verify` leaves with status 3 when something does not hold.");
}

}  // namespace firn
