// C++ sources as text, for tests that read them.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace firn::cli {

// The text without comments and directives; literals are empty.
inline std::string code_of(const std::string& text) {
  std::string code;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto skip_to = [&](const std::string& end) {
      const std::size_t at = text.find(end, i);
      i = at == text.npos ? text.size() : at + end.size() - 1;
    };
    const bool line_begins =
        code.find_last_not_of(" \t") == code.npos || code[code.find_last_not_of(" \t")] == '\n';
    if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (text.compare(i, 2, "/*") == 0) {
      i += 2;
      skip_to("*/");
    } else if (text[i] == '#' && line_begins) {
      do i = std::min(text.find('\n', i + 1), text.size());
      while (i < text.size() && text[i - 1] == '\\');
      code += '\n';
    } else if (text.compare(i, 2, "R\"") == 0) {
      const std::size_t open = text.find('(', i);
      const std::string end = ")" + text.substr(i + 2, open - i - 2) + "\"";
      skip_to(end);
      code += "\"\"";
    } else if (text[i] == '"' || (text[i] == '\'' && !(i > 0 && std::isalnum(text[i - 1])))) {
      const char quote = text[i++];
      while (i < text.size() && text[i] != quote) i += text[i] == '\\' ? 2 : 1;
      code += "\"\"";
    } else {
      code += text[i];
    }
  }
  return code;
}

}  // namespace firn::cli
