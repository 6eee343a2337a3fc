// Texts of plots that fit their places.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace firn::plots {

// Nominal pixels of a character, about the mean of the fonts of browsers, and of a line.
inline constexpr double kCharacterWidth = 10, kLineHeight = 21;

std::size_t text_length(const std::string& text);  // characters of UTF-8

// One line of at most `width` characters. What exceeds them is left out before the last third,
// marked by "…": names often differ at their ends.
std::string shorten_text(const std::string& text, std::size_t width);

// The same in at most `lines` lines of `width` characters each (at least 2), broken at spaces where
// there are some. At least one line.
std::vector<std::string> wrap_text(const std::string& text, std::size_t width, std::size_t lines);

// The lines as one string of gnuplot with its quotes.
std::string gnuplot_lines(const std::vector<std::string>& lines);
// The same for the label of a tic.
std::string gnuplot_tic_lines(const std::vector<std::string>& lines);

}  // namespace firn::plots
