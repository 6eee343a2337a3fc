#include "app/support/known_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>

#include "experiments/text/suggestions.h"

namespace firn {
namespace {

std::string with_underscores(std::string_view word) {
  std::string text(word);
  std::ranges::replace(text, '-', '_');
  return text;
}

// The known word that is most likely meant; nothing without a similar one.
std::optional<std::string> likely_word(std::string_view word,
                                       const std::vector<std::string>& known) {
  std::map<std::string, std::string, std::less<>> by_spelling;
  std::vector<std::string_view> candidates;
  for (const std::string& one : known)
    candidates.push_back(by_spelling.emplace(with_underscores(one), one).first->first);
  const auto found = nearest(with_underscores(word), candidates);
  return found ? std::optional(by_spelling.find(*found)->second) : std::nullopt;
}

// Those that the help text lists.
std::vector<std::string> subcommand_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands({}))
    if (!sub->get_group().empty()) names.push_back(sub->get_name());
  return names;
}

// Without the leading hyphens.
std::vector<std::string> long_option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_group().empty())
      names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  return names;
}

// "firn", "firn materials list"
std::string path_of(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? "firn" : path_of(*parent) + " " + command.get_name();
}

std::string unknown_subcommand(const CLI::App& command, const std::string& argument) {
  return fmt::format("{}: no such sub-command{}; {}", argument,
                     command.get_parent() == nullptr ? "" : " of " + path_of(command),
                     expected_word(argument, subcommand_names(command)));
}

std::string unknown_option(const CLI::App& command, const std::string& name) {
  const auto likely = likely_word(name.substr(2), long_option_names(command));
  return fmt::format(
      "{}: unknown option of {}; {}", name, path_of(command),
      likely ? did_you_mean("--" + *likely) : fmt::format("see `{} --help`", path_of(command)));
}

}  // namespace

std::string expected_word(std::string_view word, const std::vector<std::string>& known) {
  if (const auto likely = likely_word(word, known)) return did_you_mean(*likely);
  return fmt::format("expected one of {}", fmt::join(known, ", "));
}

CLI::Validator one_of(std::vector<std::string> values) {
  const std::string help = fmt::format("{{{}}}", fmt::join(values, ","));
  return {[values = std::move(values)](std::string& word) {
            if (std::ranges::find(values, word) != values.end()) return std::string();
            return fmt::format("unknown value \"{}\"; {}", word, expected_word(word, values));
          },
          help};
}

std::string unknown_argument(const CLI::App& command) {
  for (const std::string& argument : command.remaining()) {
    if (argument == "--") break;
    if (argument.starts_with("--"))
      return unknown_option(command, argument.substr(0, argument.find('=')));
    if (!argument.starts_with('-') && !command.get_subcommands({}).empty())
      return unknown_subcommand(command, argument);
  }
  for (const CLI::App* chosen : command.get_subcommands())
    if (const std::string unknown = unknown_argument(*chosen); !unknown.empty()) return unknown;
  return {};
}

}  // namespace firn
