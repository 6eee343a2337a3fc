// Strict reading of TOML: unknown keys are errors, values are checked for type and range, and error
// messages state file, line and key. Defaults are written into the document, which becomes
// complete.
#pragma once

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/system/value_place.h"
#include "experiments/text/toml_aliases.h"
#include "experiments/text/units.h"

namespace firn {

// An error in what an override sets: `LABEL: PROBLEM`, behind it `; ADVICE`.
struct OverrideError : InputError {
  OverrideError(std::string by, std::string what_is_wrong, std::string what_to_write = "");

  std::string label;       // of the override: override_label(), or the name of another source
  std::string problem;     // "PATH: MESSAGE"
  std::string advice;      // for a key that the file lacks: which ones there are; else empty
  bool of_value = false;   // true: the value is wrong; false: the path
  std::string value_part;  // path of the wrong part in the value; empty: the whole value
};

// "--set PATH=VALUE"
std::string override_label(const std::string& path, const std::string& value);

// A parsed file. It must outlive the TomlTable objects of its tables.
class TomlDocument {
 public:
  // Old names of the format are replaced by current ones (toml_aliases.h). Throws InputError
  // `SOURCE:LINE: TOML: ...` for text that is not TOML, and for a key given by both names.
  TomlDocument(std::string_view text, std::string source, TomlFormat format = TomlFormat::other,
               OldNames old_names = OldNames::warn);

  // Merges the files that the key `include` lists, relative to `directory`, and the files that
  // those include. Values of this document take precedence. Tables are merged. Arrays of tables are
  // concatenated, included ones first, but tables of the same `name` are merged. `file` keys of
  // included files become relative to `directory`. To be called before any other function.
  void include(const std::string& directory);

  // Sets values before anything is read. Each override is a TOML path (elements of arrays by index
  // or by `name`) and a TOML value. Text that is not a TOML value is taken as a string.
  // `path_in_file`: path in the document of the path that an override states. Throws OverrideError
  // `--set PATH=VALUE: ...` for a path that does not exist.
  void apply(const std::vector<std::pair<std::string, std::string>>& overrides,
             const std::function<std::string(const std::string&)>& path_in_file = std::identity());
  // Sets one value from another source, whose name in messages is `label`.
  void set(const std::string& path, const std::string& value, const std::string& label);
  bool has(const std::string& path) const;  // through tables alone
  // Set by apply() or set(), itself or an enclosing table.
  bool overridden(const std::string& path) const;

  // Base of relative paths, as given to include().
  const std::string& directory() const { return directory_; }

  toml::table& root() { return root_; }
  const std::string& source() const { return source_; }
  std::string text() const;  // the current content as TOML
  // text() with the first name of each renamed key, so that a rename does not change it. Hashes and
  // keys of stored runs are computed from it.
  std::string first_names_text() const;

  // A path for messages: elements of arrays by `name` if that is unique, else by index. apply()
  // accepts both.
  std::string named(const std::string& path) const;

  // The file that contains the key at `path`: this document or an included one.
  std::string source_of(const std::string& path) const;

  // Throws InputError `SOURCE:LINE: PATH: MESSAGE`, or OverrideError for a value of an override.
  // The message is one line. `line` 0: unknown. `advice`: for a key that the file lacks, which ones
  // there are; it follows the message.
  [[noreturn]] void fail(const std::string& path, unsigned line, const std::string& message,
                         const std::string& advice = "") const;

 private:
  // Replaces old names in a root table of the format that was read from `file`; empty: from an
  // override, which messages name.
  void use_current(toml::table& root, const std::string& file) const;

  std::string source_, directory_;
  TomlFormat format_;
  OldNames old_names_;
  toml::table root_;
  std::map<std::string, std::string> set_by_;  // path -> override that set it
};

enum class Sign { any, non_negative, positive };

// One table of the document. For a missing key, getters with a fallback write the fallback into the
// document and return it; getters without one throw. Errors are InputError with file, line and key.
class TomlTable {
 public:
  TomlTable(TomlDocument& document, toml::table& table, std::string path, unsigned line);
  static TomlTable root(TomlDocument& document);

  // Throws if the table `key` exists and has more than `most` keys.
  void require_at_most(std::string_view key, std::size_t most) const;

  // Throws for a key that is not in `keys`, with a suggestion(). To be called before any getter.
  void allow(std::span<const std::string_view> keys) const;
  void allow(std::initializer_list<std::string_view> keys) const;

  bool has(std::string_view key) const;
  bool is_list(std::string_view key) const;
  bool is_table(std::string_view key) const;
  // A table with a header or of dotted keys, in contrast to an inline table.
  bool is_block_table(std::string_view key) const;
  std::vector<std::string> keys() const;  // sorted
  const std::string& path() const { return path_; }
  TomlDocument& document() const { return *document_; }

  // A required string. `wanted` describes it in messages: "a number and its unit".
  const std::string& text(std::string_view key, const std::string& wanted) const;
  std::string string(std::string_view key) const;
  std::string string(std::string_view key, const std::string& fallback) const;
  bool boolean(std::string_view key, bool fallback) const;
  std::int64_t integer64(std::string_view key, std::int64_t least,
                         std::int64_t most = std::numeric_limits<std::int64_t>::max()) const;
  int integer(std::string_view key, int least) const;
  int integer(std::string_view key, int least, int fallback) const;
  double number(std::string_view key) const;
  double number(std::string_view key, double fallback) const;
  // One of `words`.
  std::string choice(std::string_view key, std::span<const std::string_view> words,
                     std::string_view fallback = {}) const;
  std::string choice(std::string_view key, std::initializer_list<std::string_view> words,
                     std::string_view fallback = {}) const;

  // Quantities: strings with a unit, also the fallback. Results are in SI units.
  double quantity(std::string_view key, const Dimension& dimension, Sign sign,
                  std::string_view fallback = {}) const;
  std::optional<double> optional_quantity(std::string_view key, const Dimension& dimension,
                                          Sign sign) const;
  std::vector<double> quantities(std::string_view key, const Dimension& dimension) const;  // a list
  Vec3 vector(std::string_view key, const Dimension& dimension,
              std::string_view fallback = {}) const;
  Vec3 sizes(std::string_view key) const;  // three lengths above zero

  std::array<double, 2> pair(std::string_view key) const;  // [a, b]
  std::vector<int> integers(std::string_view key) const;   // a list; empty when missing
  std::array<int, 3> counts(std::string_view key) const;   // [nx, ny, nz], whole, at least 1
  // [[i, j], ...], whole, at least 0.
  std::vector<std::array<int, 2>> integer_pairs(std::string_view key) const;
  Vec3 direction(std::string_view key) const;    // [x, y, z], scaled to unit length
  Quat orientation(std::string_view key) const;  // [w, x, y, z], unit; identity when missing
  // Empty when missing. `wanted` describes the list in messages.
  std::vector<std::string> strings(std::string_view key,
                                   const std::string& wanted = "an array of strings") const;
  // Any value as TOML text in the form that TomlDocument::apply() accepts.
  std::string value_text(std::string_view key) const;
  std::vector<std::string> value_texts(
      std::string_view key) const;  // elements of a list; empty when missing

  TomlTable table(std::string_view key) const;  // created when missing
  TomlTable required_table(std::string_view key) const;
  std::vector<TomlTable> tables(std::string_view key) const;  // array of tables; empty when missing

  // "FILE:LINE: KEY" of this key, or of the table without one: prefix of messages.
  std::string place(std::string_view key = {}) const;
  // Where the file states the value of `key` and its parts. Messages name it `name`; empty: by its
  // path.
  ValuePlace value_place(std::string_view key, std::string name = {}) const;
  // The same for each element of a list; for a value that is no list, its own. Empty when missing.
  // Messages name the key.
  std::vector<ValuePlace> element_places(std::string_view key) const;
  // Throws InputError for this key; empty: for the table.
  [[noreturn]] void fail(std::string_view key, const std::string& message,
                         const std::string& advice = "") const;
  // The same with the line of an element of the list `key`.
  [[noreturn]] void fail_element(std::string_view key, std::size_t element,
                                 const std::string& message) const;
  // Returns make(). Adds file, line and key to an InputError that it throws.
  template <class F>
  auto at(std::string_view key, F make) const {
    try {
      return make();
    } catch (const InputError& error) {
      fail(key, error.what());
    }
  }
  // The same with the line of an element of the list `key`.
  template <class F>
  auto at_element(std::string_view key, std::size_t element, F make) const {
    try {
      return make();
    } catch (const InputError& error) {
      fail_element(key, element, error.what());
    }
  }

  template <class T>
  void set(std::string_view key, T&& value) const {
    table_->insert_or_assign(key, std::forward<T>(value));
  }

 private:
  std::string path_of(std::string_view key) const;
  unsigned line_of_key(std::string_view key) const;  // that of the table where the key is missing
  const toml::node& require(std::string_view key) const;
  std::vector<double> numbers(std::string_view key, std::size_t count, const char* wanted) const;
  void check_sign(std::string_view key, double value, const Dimension& dimension, Sign sign) const;

  TomlDocument* document_;
  toml::table* table_;
  std::string path_;
  unsigned line_;
};

}  // namespace firn
