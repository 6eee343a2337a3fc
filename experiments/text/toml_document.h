// Strict reading of TOML: every key is known, typed and checked, every complaint has a place, and
// what was left out is filled in, so that the document ends up complete.
#pragma once

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/text/toml_aliases.h"
#include "experiments/text/units.h"

namespace firn {

// A parsed file. It must outlive the readers of its tables.
class TomlDocument {
 public:
  // Old names of the format are replaced by current ones (toml_aliases.h). Throws InputError
  // `SOURCE:LINE: TOML: ...` for text that is not TOML, and for a key that is given by both names.
  TomlDocument(std::string_view text, std::string source, TomlFormat format = TomlFormat::other,
               OldNames old_names = OldNames::warn);

  // Takes in the files that the key `include` names, relative to `directory`, and files that those
  // include. What stands in this document goes before what it includes; tables are joined, and so
  // are arrays of tables: those included come first, one of the same `name` is changed instead.
  // `file` keys of included files are made to lead on from `directory`. Before anything else.
  void include(const std::string& directory);

  // Sets values before anything is read. Each is a TOML path (elements of arrays by index or by
  // their `name`) and a TOML value; a text that is no TOML value stands for itself as a string.
  // Throws InputError `--set PATH=VALUE: ...` for a path that leads nowhere.
  void apply(const std::vector<std::pair<std::string, std::string>>& overrides);
  // One value from elsewhere, which messages call LABEL.
  void set(const std::string& path, const std::string& value, const std::string& label);
  bool has(const std::string& path) const;         // through tables alone
  bool overridden(const std::string& path) const;  // by apply() or set(), itself or a table around

  // Where relative paths begin: as given to include().
  const std::string& directory() const { return directory_; }

  toml::table& root() { return root_; }
  const std::string& source() const { return source_; }
  std::string text() const;  // the tree as it stands now
  // text() with the first name of each renamed key: the same before and after a rename. Hashes and
  // keys of stored runs are formed from it.
  std::string first_names_text() const;

  // A path for messages: elements of arrays by their `name` where it is the only one, else by their
  // index. apply() takes both.
  std::string named(const std::string& path) const;

  // The file that a key came from, as far as it is known.
  std::string source_of(const std::string& path) const;

  // Throws InputError `SOURCE:LINE: PATH: MESSAGE`, or `--set PATH=VALUE: PATH: MESSAGE` for what
  // an override brought in. One line always. A line of 0 means unknown.
  [[noreturn]] void fail(const std::string& path, unsigned line, const std::string& message) const;

 private:
  // Replaces old names of a table of the format's root, read from `file` (an override's label for
  // an empty one).
  void use_current(toml::table& root, const std::string& file) const;

  std::string source_, directory_;
  TomlFormat format_;
  OldNames old_names_;
  toml::table root_;
  std::map<std::string, std::string> set_by_;  // path -> override that set it
};

enum class Sign { any, non_negative, positive };

// One table of the document. Getters with a fallback write it into the document when the key is
// missing; those without throw. All throw InputError with file, line and key.
class TomlTable {
 public:
  TomlTable(TomlDocument& document, toml::table& table, std::string path, unsigned line);
  static TomlTable root(TomlDocument& document);

  // Throws when the table of that name has more keys; nothing when it is missing.
  void require_at_most(std::string_view key, std::size_t most) const;

  // Throws for a key that is none of these, naming the nearest one. Call it before any getter.
  void allow(std::span<const std::string_view> keys) const;
  void allow(std::initializer_list<std::string_view> keys) const;

  bool has(std::string_view key) const;
  bool is_list(std::string_view key) const;
  std::vector<std::string> keys() const;  // sorted
  const std::string& path() const { return path_; }
  TomlDocument& document() const { return *document_; }

  std::string string(std::string_view key) const;
  std::string string(std::string_view key, const std::string& fallback) const;
  bool boolean(std::string_view key, bool fallback) const;
  std::int64_t integer64(std::string_view key, std::int64_t least,
                         std::int64_t most = std::numeric_limits<std::int64_t>::max()) const;
  int integer(std::string_view key, int least) const;
  int integer(std::string_view key, int least, int fallback) const;
  double number(std::string_view key) const;
  double number(std::string_view key, double fallback) const;
  // One of a few words.
  std::string choice(std::string_view key, std::span<const std::string_view> words,
                     std::string_view fallback = {}) const;
  std::string choice(std::string_view key, std::initializer_list<std::string_view> words,
                     std::string_view fallback = {}) const;

  // Dimensional: strings with a unit. Fallbacks are written the same way.
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
  std::vector<std::string> strings(std::string_view key) const;  // empty when missing
  // Any value as TOML text, as TomlDocument::apply takes it.
  std::string value_text(std::string_view key) const;
  std::vector<std::string> value_texts(
      std::string_view key) const;  // of a list; empty when missing

  TomlTable table(std::string_view key) const;  // made when missing
  TomlTable required_table(std::string_view key) const;
  std::vector<TomlTable> tables(std::string_view key) const;  // array of tables; empty when missing

  std::string place() const;  // "FILE:LINE: KEY" of the table, as messages begin
  // The user's mistake at this key (or in the table as a whole, for an empty key).
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  // Runs `make`, giving its InputErrors the place of this key.
  template <class F>
  auto at(std::string_view key, F make) const {
    try {
      return make();
    } catch (const InputError& error) {
      fail(key, error.what());
    }
  }

  template <class T>
  void set(std::string_view key, T&& value) const {
    table_->insert_or_assign(key, std::forward<T>(value));
  }

 private:
  std::string path_of(std::string_view key) const;
  const toml::node& require(std::string_view key) const;
  std::vector<double> numbers(std::string_view key, std::size_t count, const char* wanted) const;
  const std::string& text(std::string_view key, const std::string& wanted) const;
  void check_sign(std::string_view key, double value, const Dimension& dimension, Sign sign) const;

  TomlDocument* document_;
  toml::table* table_;
  std::string path_;
  unsigned line_;
};

// The likely candidate: one with a few other letters, else one that shares a part between
// underscores ("friction": "static_friction"), else the nearest by edit distance. The first of
// equals.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace firn
