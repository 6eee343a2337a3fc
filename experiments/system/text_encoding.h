// Encoding of arbitrary text for other languages, one function each. The result represents the text
// and has no other effect in the language. Every function accepts any bytes. Names of folders are
// not encoded: valid_name() of toml_names.h rejects invalid ones.
#pragma once

#include <string>
#include <string_view>

namespace firn::encode {

// One line for a terminal. Control characters, characters that change the writing direction, and
// bytes that are not UTF-8 become escapes: \n, \t, \x1b, \u202e, \xff. Idempotent. JSON text stays
// equivalent.
std::string terminal(std::string_view text);
// The same with line feeds and tabs unchanged, for texts of several lines.
std::string terminal_lines(std::string_view text);
// The escape of the first character that terminal() would change. Empty: none. The second function
// is for prose of several lines: terminal_lines(), and invisible characters are accepted.
std::string first_unprintable(std::string_view text);
std::string first_control(std::string_view prose);

// The text itself, or terminal_lines() of it if it has control characters or is not UTF-8. For text
// of a file that other programs can have changed.
std::string cleaned(std::string text);

// Text between tags and in quoted attributes of HTML, SVG and XML. Characters that XML forbids and
// bytes that are not UTF-8 become U+FFFD.
std::string markup(std::string_view text);
// Text in one line of a Markdown document, also in a table cell.
std::string markdown(std::string_view text);
// Lines as a code block of a Markdown document. No line can end the block.
std::string markdown_block(std::string_view lines);

// One field of a CSV file (RFC 4180). Text that a spreadsheet would read as a formula gets a
// leading apostrophe; numbers stay as they are.
std::string csv_field(std::string_view text);

// A string of the gnuplot language with its quotes: one line, at most 200 characters of the text,
// with a space inserted into `]]>`. The script must draw text with `noenhanced`.
std::string gnuplot(std::string_view text);
// The same for the label of a tic, which gnuplot interprets as a format.
std::string gnuplot_tic(std::string_view text);

// Part of a file name: ASCII letters and digits and `_`; one `-` replaces each sequence of other
// characters. At most 100 characters, may be empty. Different texts can give the same name.
std::string file_name(std::string_view text);

// One word of the POSIX shell language.
std::string shell_word(std::string_view text);

}  // namespace firn::encode
