// Text of the user inside another language: one function for each. A result has no effect in its
// language other than to stand for the text. Every function accepts any bytes. Names of folders
// are not encoded: path_name() of toml_names.h refuses those that are none.
#pragma once

#include <string>
#include <string_view>

namespace firn::encode {

// One line for people: control characters, characters that change the direction of writing, and
// bytes that are no UTF-8 become \n, \t, \x1b, \u202e or \xff. Idempotent. JSON stays the same
// JSON.
std::string terminal(std::string_view text);
// The same, except that line feeds and tabs stay: for tables of several lines.
std::string terminal_lines(std::string_view text);
// The first character that terminal() (or, for several lines of prose, terminal_lines(); there
// characters without a shape are fine) would change, as it would show it. Empty: none.
std::string first_unprintable(std::string_view text);
std::string first_control(std::string_view prose);

// The text itself, or as terminal_lines() shows it when it has control characters or is no UTF-8:
// for text of a file that other programs may have changed.
std::string cleaned(std::string text);

// Between tags and inside a quoted attribute of HTML, SVG and XML. Characters that XML forbids and
// bytes that are no UTF-8 become U+FFFD.
std::string markup(std::string_view text);
// Inside one line of a Markdown document, table cells included.
std::string markdown(std::string_view text);
// Lines as a block of code of a Markdown document, which no line of it can end.
std::string markdown_block(std::string_view lines);

// One field of a CSV file (RFC 4180). Text that a spreadsheet would read as a formula gets a
// leading apostrophe; numbers stay as they are.
std::string csv_field(std::string_view text);

// A string of gnuplot's language with its quotes: one line, at most 200 characters of the text, a
// space in `]]>`.
// The script must draw text with `noenhanced`.
std::string gnuplot(std::string_view text);
// The same for the label of a tic, which gnuplot reads as a format.
std::string gnuplot_tic(std::string_view text);

// Part of the name of a file: letters and digits of ASCII, `_`, and one `-` for whatever stands
// between them; at most 100 characters, may be empty. Different texts can give the same name.
std::string file_name(std::string_view text);

// One word of the language of a POSIX shell.
std::string shell_word(std::string_view text);

}  // namespace firn::encode
