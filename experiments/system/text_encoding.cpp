#include "experiments/system/text_encoding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace firn::encode {
namespace {

constexpr char32_t kNoCharacter = 0xffffffff;

struct Character {
  char32_t code = kNoCharacter;  // kNoCharacter: a byte that begins no UTF-8 sequence
  std::size_t size = 1;          // bytes
};

// The character at the start of a text that is not empty. Refuses overlong forms, surrogates and
// codes above U+10FFFF, as Unicode demands.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < size) return {};
  char32_t code = lead & (0x7f >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kLeast[size] || surrogate || code > 0x10ffff) return {};
  return {code, size};
}

// Calls f(character, its bytes) for each character of the text.
template <class F>
void for_each_character(std::string_view text, F f) {
  while (!text.empty()) {
    const Character c = first_character(text);
    f(c.code, text.substr(0, c.size));
    text.remove_prefix(c.size);
  }
}

bool is_control(char32_t c) { return c < 0x20 || (c >= 0x7f && c < 0xa0); }

// Characters without a shape that move or hide what follows.
bool is_invisible(char32_t c) {
  return c == 0x61c || c == 0x200b || c == 0x200e || c == 0x200f || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0xfeff || (c >= 0xfff9 && c <= 0xfffb) ||
         (c >= 0xe0000 && c <= 0xe0fff);
}

bool is_plain(char32_t c) { return c != kNoCharacter && !is_control(c) && !is_invisible(c); }

void append_visible(std::string& out, char32_t c, std::string_view bytes) {
  if (is_plain(c))
    out += bytes;
  else if (c == '\n')
    out += "\\n";
  else if (c == '\r')
    out += "\\r";
  else if (c == '\t')
    out += "\\t";
  else if (c == kNoCharacter || c < ' ')
    out += fmt::format("\\x{:02x}", static_cast<unsigned char>(bytes[0]));
  else if (c > 0xffff)  // as JSON writes it, so that JSON stays JSON
    out += fmt::format("\\u{:04x}\\u{:04x}", 0xd7c0 + static_cast<std::uint32_t>(c >> 10),
                       0xdc00 + static_cast<std::uint32_t>(c & 0x3ff));
  else
    out += fmt::format("\\u{:04x}", static_cast<std::uint32_t>(c));
}

bool is_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end == text.c_str() + text.size() && end != text.c_str() && !std::isnan(value) &&
         !std::isspace(static_cast<unsigned char>(text[0]));
}

// The first `most` characters, and an ellipsis for the others.
std::string shortened(std::string_view text, std::size_t most) {
  std::string out;
  std::size_t count = 0;
  for_each_character(text, [&](char32_t, std::string_view bytes) {
    if (++count <= most) out += bytes;
  });
  return count > most ? out + "…" : out;
}

// A string of gnuplot's language: every character of ASCII that is not a letter, a digit after one
// of those, a space or harmless punctuation stands as an octal escape, so that no quote, backslash,
// backtick, brace or macro sign stands in the script.
std::string gnuplot_string(std::string_view text) {
  constexpr std::string_view kHarmless = " .,:;()/=+-";
  std::string out = "\"";
  bool escaped = false;  // a digit after an escape could extend it
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool digit = c >= '0' && c <= '9';
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool stays =
        byte >= 0x80 || letter || (digit && !escaped) || kHarmless.find(c) != kHarmless.npos;
    if (stays)
      out += c;
    else
      out += fmt::format("\\{:03o}", byte);
    escaped = !stays;
  }
  return out + "\"";
}

constexpr std::size_t kLongestLabel = 200;  // characters; more do not fit into a picture

// Text of a picture: printable, short, and without `]]>`, which gnuplot leaves as it is in SVG
// where XML forbids it.
std::string label(std::string_view text) {
  std::string shown = shortened(terminal(text), kLongestLabel);
  for (std::size_t at = 0; (at = shown.find("]]>", at)) != std::string::npos; at += 3)
    shown.insert(at + 2, 1, ' ');
  return shown;
}

}  // namespace

std::string terminal(std::string_view text) {
  std::string out;
  for_each_character(text,
                     [&](char32_t c, std::string_view bytes) { append_visible(out, c, bytes); });
  return out;
}

std::string terminal_lines(std::string_view text) {
  std::string out;
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    if (c == '\n' || c == '\t')
      out += bytes;
    else
      append_visible(out, c, bytes);
  });
  return out;
}

std::string first_unprintable(std::string_view text) {
  std::string first;
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    if (first.empty() && !is_plain(c)) append_visible(first, c, bytes);
  });
  return first;
}

std::string first_control(std::string_view prose) {
  std::string first;
  char32_t before = 0;
  for_each_character(prose, [&](char32_t c, std::string_view bytes) {
    if (before == '\r' && c != '\n' && first.empty()) first = "\\r";
    const bool fine = c == '\n' || c == '\t' || c == '\r' || (c != kNoCharacter && !is_control(c));
    if (first.empty() && !fine) append_visible(first, c, bytes);
    before = c;
  });
  return first.empty() && before == '\r' ? "\\r" : first;
}

std::string cleaned(std::string text) {
  return first_control(text).empty() ? text : terminal_lines(text);
}

std::string markup(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    const bool space = c == '\t' || c == '\n';
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else if (c == kNoCharacter || (is_control(c) && !space) || c == 0xfffe || c == 0xffff)
      out += "\xef\xbf\xbd";
    else if (is_invisible(c))  // visible, so that no line is reordered
      append_visible(out, c, bytes);
    else
      out += bytes;
  });
  return out;
}

std::string markdown(std::string_view text) {
  constexpr std::string_view kSpecial = "\\`*_{}[]()#+!|~$";
  std::string out;
  for (const char c : terminal(text)) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (kSpecial.find(c) != kSpecial.npos)
      out += {'\\', c};
    else
      out += c;
  }
  return out;
}

std::string markdown_block(std::string_view lines) {
  std::size_t longest = 2, run = 0;
  for (const char c : lines) longest = std::max(longest, run = c == '`' ? run + 1 : 0);
  const std::string code_fence(longest + 1, '`');
  std::string text = terminal_lines(lines);
  if (!text.ends_with('\n')) text += '\n';
  return code_fence + '\n' + text + code_fence + '\n';
}

std::string csv_field(std::string_view text) {
  std::string field(text);
  constexpr std::string_view kFormula = "=+-@\t\r\n";
  if (!field.empty() && kFormula.find(field[0]) != kFormula.npos && !is_number(field))
    field.insert(0, 1, '\'');
  std::erase(field, '\0');  // ends the file for some readers
  if (field.find_first_of(",;\t\"\r\n") == std::string::npos) return field;
  std::string quoted(1, '"');
  for (const char c : field) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

std::string gnuplot(std::string_view text) { return gnuplot_string(label(text)); }

std::string gnuplot_tic(std::string_view text) {
  std::string format;
  for (const char c : label(text)) format.append(c == '%' ? 2 : 1, c);
  return gnuplot_string(format);
}

std::string file_name(std::string_view text) {
  constexpr std::size_t kLongest = 100;
  std::string name;
  for (const char c : text) {
    const bool plain = c == '_' || (static_cast<unsigned char>(c) < 0x80 &&
                                    std::isalnum(static_cast<unsigned char>(c)));
    if (plain || (!name.empty() && name.back() != '-')) name += plain ? c : '-';
  }
  return name.substr(0, kLongest);
}

std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'')
      word += "'\\''";
    else if (c != '\0')
      word += c;
  }
  return word + "'";
}

}  // namespace firn::encode
