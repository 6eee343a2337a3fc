#include "reports/plots/plot_text.h"

#include <algorithm>

#include "experiments/system/text_encoding.h"

namespace firn::plots {
namespace {

using Characters = std::vector<std::string>;

Characters characters_of(const std::string& text) {
  Characters all;
  for (const char c : encode::terminal(text)) {
    const bool continues = (static_cast<unsigned char>(c) & 0xC0) == 0x80;
    if (continues && !all.empty())
      all.back() += c;
    else
      all.emplace_back(1, c);
  }
  return all;
}

std::string joined_characters(const Characters& all, std::size_t begin, std::size_t end) {
  std::string text;
  for (std::size_t i = begin; i < end; ++i) text += all[i];
  return text;
}

Characters without_middle(const Characters& all, std::size_t most) {
  if (all.size() <= most) return all;
  const std::size_t kept = std::max<std::size_t>(most, 2) - 1, tail = kept / 3;
  Characters result(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept - tail));
  result.emplace_back("…");
  result.insert(result.end(), all.end() - static_cast<std::ptrdiff_t>(tail), all.end());
  return result;
}

std::vector<std::string> broken_at_spaces(const Characters& all, std::size_t width) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < all.size()) {
    std::size_t end = std::min(begin + width, all.size());
    if (end < all.size()) {
      for (std::size_t i = end; i > begin; --i) {
        if (all[i] != " ") continue;
        end = i;
        break;
      }
    }
    lines.push_back(joined_characters(all, begin, end));
    begin = end;
    if (begin < all.size() && all[begin] == " ") ++begin;
  }
  if (lines.empty()) lines.emplace_back();
  return lines;
}

// Strings of gnuplot as one, with line feeds between them.
std::string joined_strings(const std::vector<std::string>& quoted) {
  std::string result = "\"";
  for (std::size_t i = 0; i < quoted.size(); ++i)
    result += (i > 0 ? "\\n" : "") + quoted[i].substr(1, quoted[i].size() - 2);
  return result + "\"";
}

}  // namespace

std::size_t text_length(const std::string& text) { return characters_of(text).size(); }

std::string shorten_text(const std::string& text, std::size_t width) {
  const Characters kept = without_middle(characters_of(text), width);
  return joined_characters(kept, 0, kept.size());
}

std::vector<std::string> wrap_text(const std::string& text, std::size_t width, std::size_t lines) {
  const Characters all = characters_of(text);
  // Lines that end at spaces are not full: less text may fit.
  for (std::size_t most = width * lines;; --most) {
    std::vector<std::string> result = broken_at_spaces(without_middle(all, most), width);
    if (result.size() <= lines || most <= 2) return result;
  }
}

std::string gnuplot_lines(const std::vector<std::string>& lines) {
  std::vector<std::string> quoted;
  for (const std::string& line : lines) quoted.push_back(encode::gnuplot(line));
  return joined_strings(quoted);
}

std::string gnuplot_tic_lines(const std::vector<std::string>& lines) {
  std::vector<std::string> quoted;
  for (const std::string& line : lines) quoted.push_back(encode::gnuplot_tic(line));
  return joined_strings(quoted);
}

}  // namespace firn::plots
