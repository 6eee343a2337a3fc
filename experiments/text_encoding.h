// Text of the user inside another language: one function for each. A result has no effect in its
// language other than to stand for the text. Every function accepts any bytes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace firn::encode {

// One line for people: control characters, characters that change the direction of writing, and
// bytes that are no UTF-8 become \n, \t, \x1b, \u202e or \xff. Idempotent; never longer than six
// times the text.
std::string terminal(std::string_view text);
// The same, except that line feeds and tabs stay: for tables of several lines.
std::string terminal_lines(std::string_view text);
// Whether terminal() would return the text unchanged.
bool is_printable(std::string_view text);

// Between tags and inside a quoted attribute of HTML, SVG and XML. Characters that XML forbids and
// bytes that are no UTF-8 become U+FFFD.
std::string markup(std::string_view text);
// Inside one line of a Markdown document, table cells included.
std::string markdown(std::string_view text);
// JSON text that may stand in a <script> element.
std::string script_json(const nlohmann::ordered_json& json);

// One field of a CSV file (RFC 4180). Text that a spreadsheet would read as a formula gets a
// leading apostrophe; numbers stay as they are.
std::string csv_field(std::string_view text);

// A string of gnuplot's language with its quotes: one line, at most 200 characters of the text.
// The script must draw text with `noenhanced`.
std::string gnuplot(std::string_view text);
// The same for the label of a tic, which gnuplot reads as a format.
std::string gnuplot_tic(std::string_view text);

// One component of a path. Letters, digits, spaces, `.`, `_`, `-` and characters above U+00A0 stay;
// other bytes become %XX, and so do a leading `-` and a leading `.`. Different texts give different
// names, up to 200 bytes; a longer name ends in a hash of the text.
std::string file_name(std::string_view text);

// One word of the language of a POSIX shell.
std::string shell_word(std::string_view text);

}  // namespace firn::encode
