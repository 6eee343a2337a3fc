#include "app/support/known_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
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
  std::vector<std::string> spelled;
  spelled.reserve(known.size());
  for (const std::string& one : known) spelled.push_back(with_underscores(one));
  const std::vector<std::string_view> candidates(spelled.begin(), spelled.end());
  const auto found = nearest(with_underscores(word), candidates);
  if (!found) return std::nullopt;
  return known[static_cast<std::size_t>(std::ranges::find(candidates, *found) -
                                        candidates.begin())];
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
  return fmt::format("{}: unknown option of {}; {}", name, path_of(command),
                     likely ? fmt::format("did you mean \"--{}\"?", *likely)
                            : fmt::format("see `{} --help`", path_of(command)));
}

// The number of arguments behind an option that are its values, whatever they look like.
int values_behind(const CLI::Option& option, bool has_value) {
  const int least = std::min(option.get_type_size_min(), option.get_items_expected_min());
  return std::max(0, least - (has_value ? 1 : 0));
}

}  // namespace

std::string expected_word(std::string_view word, const std::vector<std::string>& known) {
  if (const auto likely = likely_word(word, known))
    return fmt::format("did you mean \"{}\"?", *likely);
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

std::string unknown_argument(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* command = &app;
  for (std::size_t i = 0; i < arguments.size() && arguments[i] != "--"; ++i) {
    const std::string& argument = arguments[i];
    if (!argument.starts_with('-')) {
      const std::vector<const CLI::App*> subs = command->get_subcommands({});
      if (subs.empty()) continue;
      const auto sub = std::ranges::find(subs, argument, &CLI::App::get_name);
      if (sub == subs.end()) return unknown_subcommand(*command, argument);
      command = *sub;
      continue;
    }
    const bool is_long = argument.starts_with("--");
    const std::size_t end = std::min(argument.find('='), argument.size());
    const std::string name = argument.substr(0, is_long ? end : 2);
    const CLI::Option* option = command->get_option_no_throw(name);
    if (option == nullptr && is_long) return unknown_option(*command, name);
    if (option == nullptr) continue;
    const bool has_value = is_long ? end + 1 < argument.size() : argument.size() > 2;
    i += static_cast<std::size_t>(values_behind(*option, has_value));
  }
  return {};
}

}  // namespace firn
