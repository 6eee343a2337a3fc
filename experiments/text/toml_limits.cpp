#include "experiments/text/toml_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/system/input_limits.h"
#include "firn/math.h"

namespace firn {
namespace {

// Walks over text outside of strings and comments.
class Scan {
 public:
  Scan(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  void run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'')
        skip_string(c);
      else if (c == '#')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else
        take(c);
    }
  }

 private:
  void take(char c) {
    ++at_;
    switch (c) {
      case '\n':
        ++line_;
        parts_ = 1;
        begins_ = true;
        return;
      case ' ':
      case '\t':
      case '\r':
        return;
      case '.':
        if (++parts_ > input_limits::toml_key_parts)
          fail(fmt::format("a key has more than {} parts", input_limits::toml_key_parts));
        break;
      case '[':
      case '{':
        if (++depth_ > input_limits::toml_depth)
          fail(fmt::format("arrays and tables are nested more than {} deep",
                           input_limits::toml_depth));
        // A header counts, and an inline table.
        if ((c == '{' || (begins_ && depth_ == 1)) && ++tables_ > input_limits::toml_tables)
          fail(fmt::format("has more than {} tables", input_limits::toml_tables));
        parts_ = 1;
        break;
      case ']':
      case '}':
        depth_ = std::max(0, depth_ - 1);
        parts_ = 1;
        break;
      case '=':
      case ',':
        parts_ = 1;
        break;
      default:
        break;
    }
    begins_ = false;
  }

  // Basic strings have escapes, literal ones do not; three quotes begin one of several lines.
  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool several_lines = text_.substr(at_, 3) == three;
    at_ += several_lines ? 3 : 1;
    begins_ = false;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        if (!several_lines) return;  // no TOML
        ++line_;
      }
      if (c == '\\' && quote == '"' && at_ + 1 < text_.size()) {
        line_ += text_[at_ + 1] == '\n';
        at_ += 2;
        continue;
      }
      if (c == quote && (!several_lines || text_.substr(at_, 3) == three)) {
        at_ += several_lines ? 3 : 1;
        // Two more quotes at most are the string's last characters.
        for (int k = 0; several_lines && k < 2 && text_.substr(at_, 1) == three.substr(0, 1); ++k)
          ++at_;
        return;
      }
      ++at_;
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: TOML: {}; expected fewer", source_, line_, what));
  }

  std::string_view text_;
  const std::string& source_;
  std::size_t at_ = 0, line_ = 1, tables_ = 0;
  int depth_ = 0, parts_ = 1;
  bool begins_ = true;  // nothing but blanks since the line began
};

}  // namespace

void check_toml_limits(std::string_view text, const std::string& source) {
  Scan(text, source).run();
}

}  // namespace firn
