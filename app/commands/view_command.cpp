// firn view: a page in the browser that follows a case, a run, a study, validation, sweep or
// optimization.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "app/commands/commands.h"
#include "app/support/case_file.h"
#include "app/support/exit_status.h"
#include "app/support/page_server.h"
#include "app/support/report_page.h"
#include "experiments/batch/batch_state.h"
#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_lock.h"
#include "experiments/storage/hdf5_file.h"
#include "experiments/system/input_file.h"
#include "experiments/system/interruption.h"
#include "experiments/system/terminal.h"
#include "experiments/system/text_encoding.h"
#include "reports/documents/batch_page.h"
#include "reports/documents/case_page.h"

extern char** environ;

namespace firn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct ViewArguments {
  std::string path;
  std::vector<std::string> settings;
  std::vector<std::string> materials;
  int port = 0;
  bool open = false, no_open = false;
};

// What a page was made of, and the page. A page that could not be made has an error instead.
struct Built {
  std::map<std::string, FileStamp> files;
  std::optional<page::Page> page;
  std::string error;  // one line, as firn prints it
};

bool has_changed(const std::map<std::string, FileStamp>& files) {
  for (const auto& [file, stamp] : files) {
    if (stamp_of(file) != stamp) return true;
  }
  return false;
}

// Runs `make` and records the files that it opens. Errors of the input become text.
Built build(const std::function<page::Page()>& make, const std::vector<std::string>& also) {
  Built built;
  for (const std::string& file : also) built.files[file] = stamp_of(file);
  const InputFileRecord record;
  try {
    const interruption::NotPolled building;
    built.page = make();
  } catch (const InputError& e) {
    built.error = e.what();
  } catch (const RunError& e) {
    built.error = e.what();
  } catch (const hdf5::Error& e) {
    built.error = e.what();
  }
  built.files.insert(record.files().begin(), record.files().end());
  return built;
}

// FILE and LINE of a message `FILE:LINE: ...`.
struct Place {
  std::string file;
  std::size_t line = 0;
};
std::optional<Place> place_of(const std::string& message,
                              const std::map<std::string, FileStamp>& files) {
  for (const auto& [file, stamp] : files) {
    if (!message.starts_with(file + ":")) continue;
    const std::size_t line = std::strtoul(message.c_str() + file.size() + 1, nullptr, 10);
    if (line > 0) return Place{file, line};
  }
  return std::nullopt;
}

// The lines about a place, the line itself marked, as HTML.
std::string excerpt(const Place& place) {
  constexpr std::size_t kAround = 4, kMost = 1 << 24;
  std::string text;
  try {
    text = read_input_file(place.file, "a text file", kMost);
  } catch (const InputError&) {
    return "";
  }
  std::string html =
      fmt::format("<pre tabindex=\"0\" role=\"region\" aria-label=\"{} about line {}\">",
                  encode::markup(encode::terminal(place.file)), place.line);
  std::size_t line = 1;
  for (std::size_t at = 0; at <= text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (line + kAround >= place.line && line <= place.line + kAround) {
      const std::string shown =
          fmt::format("{:>5} {} {}", line, line == place.line ? "&gt;" : " ",
                      encode::markup(encode::terminal(text.substr(at, end - at))));
      html += line == place.line ? "<mark>" + shown + "</mark>\n" : shown + "\n";
    }
    at = end + 1;
  }
  return html + "</pre>\n";
}

// The last good page under the error; without one, a page with the error alone.
page::Page with_error(const std::optional<page::Page>& last, const std::string& title,
                      const Built& built) {
  page::Page page = last ? *last : page::Page(title, "");
  page.alert() = page::Content();  // that of the last version
  page.alert().note({page::Mark::bad, "error"}, built.error);
  if (const auto place = place_of(built.error, built.files)) page.alert().html(excerpt(*place));
  if (last) {
    page.alert().paragraph("The page is that of the last version without an error.");
    page.mark_outdated();
  }
  return page;
}

// Does nothing where there is no opener.
void open_browser(const std::string& address) {
  const std::string program = "xdg-open";
  char* arguments[] = {const_cast<char*>(program.c_str()), const_cast<char*>(address.c_str()),
                       nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int stream : {1, 2})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  ::posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
}

bool has_screen() {
  return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
}

// What makes the page, the files that are watched from the start, and what else it depends on.
struct PageSource {
  std::function<page::Page()> make;
  std::vector<std::string> files;
  std::function<bool()> at_work = [] { return false; };
  Clock::duration pause = {};  // between two pages, at least
};
// A study, validation, sweep or optimization: in progress, or its results.
PageSource folder_source(const std::string& folder) {
  constexpr auto kPause = std::chrono::seconds(2);
  const fs::path path(folder);
  return {[folder] {
            if (is_at_work(folder)) {
              if (const auto state = read_batch_state(folder))
                return batch_page(*state, folder_name(folder));
            }
            return report_page(folder, {});
          },
          {(path / "results.json").string(), (path / "study.db").string(),
           (path / "study.db-wal").string()},
          [folder] { return is_at_work(folder); },
          kPause};
}

PageSource source_of(const ViewArguments& a) {
  const fs::path path = a.path;
  if (is_case_file(a.path)) {
    require_regular_file(a.path, "a case file");  // its errors are shown on the page, but not this
    std::vector<Override> overrides;
    for (const std::string& text : a.settings) overrides.push_back(parse_override(text));
    MaterialRequest materials;
    materials.records = a.materials;
    return {[file = a.path, overrides, materials] {
              return case_page(read_case(file, overrides, materials));
            },
            {a.path}};
  }
  if (!a.settings.empty()) throw InputError("--set: changes a case; expected CASE.toml");
  if (!a.materials.empty()) throw InputError("--material: is for a case; expected CASE.toml");
  std::error_code unreadable;
  if (!fs::exists(path, unreadable))
    throw InputError(a.path +
                     ": does not exist; expected CASE.toml, RUN.h5, or the folder of a study, "
                     "validation, sweep or optimization");
  std::vector<std::string> files = {a.path};
  if (path.extension() == ".h5") {
    files.push_back(saved_copy(a.path));
  } else if (fs::is_directory(path, unreadable)) {
    return folder_source(a.path);
  }
  return {[file = a.path] { return report_page(file, {}); }, files};
}

int view(const ViewArguments& a) {
  const PageSource source = source_of(a);
  const interruption::Polled polled;
  PageServer server(a.port);
  const std::string title = fs::path(a.path).filename().string();
  server.publish(page::Page(title, "is being read"));
  print_lines(stdout, "{}\n", server.address());
  finish_standard_output();
  print_lines(stderr, "firn: showing {}; Ctrl-C ends\n", a.path);
  if (a.open || (!a.no_open && has_screen())) open_browser(server.address());

  constexpr auto kPause = std::chrono::milliseconds(100);
  std::optional<page::Page> last;
  std::string last_error;
  Built built;
  Clock::time_point due{};
  bool first = true, at_work = false;
  while (!interruption::requested()) {
    const bool changed = first || has_changed(built.files) || source.at_work() != at_work;
    if (!changed || Clock::now() < due) {
      std::this_thread::sleep_for(kPause);
      continue;
    }
    first = false;
    server.set_busy(true);
    at_work = source.at_work();
    const Clock::time_point started = Clock::now();
    built = build(source.make, source.files);
    // A run writes more often than its page can be made.
    due = Clock::now() + std::max(Clock::now() - started, source.pause);
    if (built.page) {
      last = built.page;
      server.publish(*last);
    } else {
      server.publish(with_error(last, title, built));
      if (built.error != last_error) print_lines(stderr, "firn: {}\n", built.error);
    }
    last_error = built.error;
    server.set_busy(false);
  }
  return ExitStatus::done;
}

}  // namespace

void add_view_command(CLI::App& app, int& status) {
  auto a = std::make_shared<ViewArguments>();
  CLI::App* command =
      app.add_subcommand("view",
                         "Show a case, a run, a study, validation, sweep or optimization in "
                         "the browser, and follow its changes");
  command
      ->add_option("PATH", a->path,
                   "CASE.toml, RUN.h5 (also while it is written), or the folder of a study, "
                   "validation, sweep or optimization")
      ->required()
      ->type_name("");
  add_settings_option(*command, a->settings);
  command
      ->add_option("--material", a->materials,
                   "Values of a material record over those of the case, as for\n`firn run` (may be "
                   "repeated)")
      ->type_name("NAME[@VERSION]")
      ->allow_extra_args(false);
  command
      ->add_option("--port", a->port,
                   "Port of the server on this machine, 1 to 65535; by default 0:\nany free one")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT");
  command->add_flag("--open", a->open, "Open the browser (the default where there is a screen)");
  command->add_flag("--no-open", a->no_open, "Print the address without opening the browser");
  command->footer(
      "Prints the address on standard output and serves it on this machine alone until Ctrl-C.\n"
      "On another machine: ssh -L PORT:localhost:PORT HOST, with --port PORT.");
  command->callback([a, &status] { status = view(*a); });
}

}  // namespace firn
