#include "reports/html/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "experiments/storage/sha256.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "firn/math.h"
#include "reports/html/assets.h"
#include "reports/html/data_encoding.h"

namespace firn::page {
namespace {

const char* mark_class(Mark mark) {
  switch (mark) {
    case Mark::good:
      return "good";
    case Mark::caution:
      return "caution";
    case Mark::bad:
      return "bad";
    case Mark::neutral:
      return "neutral";
    case Mark::none:
      break;
  }
  return "";
}

// A tick, a triangle, a cross, a ring. The word next to it serves screen readers.
const char* mark_shape(Mark mark) {
  switch (mark) {
    case Mark::good:
      return "<path d='M3 9l4 4 7-9'/>";
    case Mark::caution:
      return "<path d='M8 2l6.5 12h-13zM8 6.5v3.5M8 12v.6'/>";
    case Mark::bad:
      return "<path d='M3.5 3.5l9 9M12.5 3.5l-9 9'/>";
    default:
      return "<circle cx='8' cy='8' r='5'/>";
  }
}

std::string badge_html(const Badge& badge) {
  if (badge.mark == Mark::none) return encode::markup(badge.word);
  return fmt::format(
      "<span class=\"badge {}\"><svg viewBox=\"0 0 16 16\" aria-hidden=\"true\">{}</svg>{}</span>",
      mark_class(badge.mark), mark_shape(badge.mark), encode::markup(badge.word));
}

bool numeric(const Cell& cell) { return std::isfinite(cell.value); }

// A column stands to the right when any cell of it is a number.
std::vector<bool> numeric_columns(const Table& table) {
  std::vector<bool> result(table.columns.size());
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i) result[i] = result[i] || numeric(row[i]);
  return result;
}

std::string cell_html(const Cell& cell, bool right) {
  std::string html = "<td";
  constexpr std::size_t kLong = 24, kParagraph = 120;  // characters
  if (right)
    html += " class=\"n\"";
  else if (cell.text.size() > kLong)
    html += cell.text.size() > kParagraph ? " class=\"long paragraph\"" : " class=\"long\"";
  if (numeric(cell)) html += fmt::format(" data-v=\"{}\"", cell.value);
  if (std::isfinite(cell.uncertainty)) html += fmt::format(" data-u=\"{}\"", cell.uncertainty);
  html += ">";
  if (!cell.badge.word.empty()) html += badge_html(cell.badge) + (cell.text.empty() ? "" : " ");
  html += cell.anchor.empty() ? encode::markup(cell.text)
                              : fmt::format("<a href=\"#{}\">{}</a>", encode::markup(cell.anchor),
                                            encode::markup(cell.text));
  return html + "</td>";
}

// A plot whose colors the page names gets them itself, and a white ground.
std::string standing_alone(const std::string& svg) {
  const std::string_view css = asset("page.css");
  const std::size_t from = css.find(":root"), to = css.find('}', from);
  const std::size_t tag = svg.find('>'), last = svg.rfind('>');
  return fmt::format(
      "{0}>\n<style>{1}}} svg {{ background: #fff; font-family: \"DejaVu Sans\", sans-serif; "
      "}}</style>\n{2}\n",
      svg.substr(0, tag), css.substr(from, to - from), svg.substr(tag + 1, last - tag));
}

std::string figure_html(const Figure& figure) {
  return fmt::format(
      "<figure><div class=\"plot{}\" role=\"img\" aria-label=\"{}\">{}</div><figcaption>{}"
      "</figcaption></figure>\n",
      figure.on_paper ? " paper" : "",
      encode::markup(figure.alt.empty() ? figure.caption : figure.alt), figure.svg,
      encode::markup(figure.caption));
}

// The browser refuses every request to a network, and every script but those whose hashes are here:
// `{}` is their list.
constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src {}; img-src data: blob:{}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
)";

// A script as a content security policy names it: 'sha256-BASE64'.
std::string script_source(std::string_view script) {
  const std::string hex = sha256(script);
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return "'sha256-" + base64(bytes) + "'";
}

}  // namespace

std::string slugify(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!result.empty() && result.back() != '-')
      result += '-';
  }
  while (!result.empty() && result.back() == '-') result.pop_back();
  return result.empty() ? "section" : result;
}

Cell Cell::measured(double value, double uncertainty) {
  Cell cell(measured_text(value, uncertainty));
  cell.value = value;
  cell.uncertainty = uncertainty;
  return cell;
}

Cell Cell::measured(double value, double uncertainty, const std::string& unit) {
  Cell cell = measured(resolved(value, unit), resolved(uncertainty, unit));
  cell.value = value;
  cell.uncertainty = uncertainty;
  return cell;
}

Cell Cell::link(std::string text, std::string anchor) {
  Cell cell(std::move(text));
  cell.anchor = std::move(anchor);
  return cell;
}

Content& Content::heading(const std::string& title) {
  html_ += fmt::format("<h3>{}</h3>\n", encode::markup(title));
  return *this;
}

Content& Content::paragraph(const std::string& text) {
  html_ += fmt::format("<p>{}</p>\n", encode::markup(text));
  return *this;
}

Content& Content::note(const Badge& badge, const std::string& text) {
  html_ += fmt::format("<p class=\"note {}\">{} {}</p>\n", mark_class(badge.mark),
                       badge_html(badge), encode::markup(text));
  return *this;
}

Content& Content::list(const std::vector<std::string>& items) {
  html_ += "<ul>\n";
  for (const std::string& item : items) html_ += fmt::format("<li>{}</li>\n", encode::markup(item));
  html_ += "</ul>\n";
  return *this;
}

Content& Content::key_figures(const std::vector<KeyFigure>& figures) {
  html_ += "<ul class=\"cards\">\n";
  for (const KeyFigure& figure : figures) {
    html_ += fmt::format("<li class=\"card {}\"><span class=\"label\">{}</span><b>{}</b>",
                         mark_class(figure.badge.mark), encode::markup(figure.label),
                         encode::markup(figure.value));
    if (!figure.note.empty())
      html_ += fmt::format("<span class=\"faint\">{}</span>", encode::markup(figure.note));
    if (!figure.badge.word.empty()) html_ += badge_html(figure.badge);
    html_ += "</li>\n";
  }
  html_ += "</ul>\n";
  return *this;
}

Content& Content::properties(const std::vector<Property>& properties) {
  html_ += "<dl>\n";
  for (const Property& fact : properties)
    html_ += fmt::format("<dt>{}</dt><dd>{}</dd>\n", encode::markup(fact.name),
                         encode::markup(fact.value));
  html_ += "</dl>\n";
  return *this;
}

Content& Content::table(const Table& table) {
  const std::vector<bool> right = numeric_columns(table);
  // Outside of the table, which may be wider than the page: a caption inside has the table's width.
  if (!table.caption.empty())
    html_ += fmt::format("<p class=\"tablecaption\">{}</p>\n", encode::markup(table.caption));
  html_ += fmt::format("<div class=\"table\"><table aria-label=\"{}\"><thead><tr>",
                       encode::markup(table.caption));
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string unit = unit_text(table.columns[i].unit);
    html_ += fmt::format(
        "<th scope=\"col\"{} data-unit=\"{}\">{}{}</th>", right[i] ? " class=\"n\"" : "",
        encode::markup(unit), encode::markup(table.columns[i].title),
        unit.empty() ? "" : fmt::format(" <small>{}</small>", encode::markup(unit)));
  }
  html_ += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    if (row.size() != table.columns.size())
      throw std::logic_error(fmt::format("table \"{}\": a row of {} cells under {} columns",
                                         table.caption, row.size(), table.columns.size()));
    html_ += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) html_ += cell_html(row[i], right[i]);
    html_ += "</tr>\n";
  }
  html_ += "</tbody></table></div>\n";
  return *this;
}

Content& Content::figure(const Figure& figure) {
  html_ += figure_html(figure);
  drawings_.push_back(figure.svg);
  return *this;
}

Content& Content::figures(const std::vector<Figure>& figures) {
  html_ += "<div class=\"figures\">\n";
  for (const Figure& one : figures) figure(one);
  html_ += "</div>\n";
  return *this;
}

Content& Content::code(const std::string& text, const std::string& caption) {
  if (!caption.empty())
    html_ += fmt::format("<p class=\"codecaption\">{}</p>", encode::markup(caption));
  html_ += fmt::format("<div class=\"code\"><pre tabindex=\"0\"><code>{}</code></pre></div>\n",
                       encode::markup(text));
  return *this;
}

Content& Content::collapsible(const std::string& summary, const Content& content, bool open) {
  html_ += fmt::format("<details{}><summary>{}</summary>\n{}</details>\n", open ? " open" : "",
                       encode::markup(summary), content.html_);
  drawings_.insert(drawings_.end(), content.drawings_.begin(), content.drawings_.end());
  return *this;
}

Content& Content::html(const std::string& trusted) {
  html_ += trusted;
  return *this;
}

Page::Page(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

Content& Page::section(const std::string& title, const std::string& anchor) {
  const std::string wanted = slugify(anchor.empty() ? title : anchor);
  std::string name = wanted;
  const auto taken = [&] {
    return std::ranges::any_of(sections_, [&](const Section& s) { return s.anchor == name; });
  };
  for (int i = 2; taken(); ++i) name = fmt::format("{}-{}", wanted, i);
  sections_.push_back({title, name, {}});
  return sections_.back().content;
}

bool Page::added_before(std::string_view text) {
  return !added_.insert(std::hash<std::string_view>{}(text)).second;
}

void Page::add_script(std::string_view script) {
  if (!added_before(script)) scripts_.emplace_back(script);
}

void Page::add_style(std::string_view css) {
  if (!added_before(css)) styles_ += css;
}

void Page::add_data(const std::string& id, std::string_view base64) {
  data_ += fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", encode::markup(id),
                       base64);
}

std::string Page::html() const {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  std::string sources = script_source(asset("page.js")), scripts;
  for (const std::string& script : scripts_) {
    sources += " " + script_source(script);
    scripts += fmt::format("<script>{}</script>\n", script);
  }
  const char* const body_class = outdated_        ? " class=\"alerted outdated\""
                                 : alert_.empty() ? ""
                                                  : " class=\"alerted\"";
  fmt::format_to(to, "{}<title>{}</title>\n<style>{}{}</style></head>\n<body{}>\n",
                 fmt::format(kHead, sources, asks_server_ ? "; connect-src 'self'" : ""),
                 encode::markup(title_), asset("page.css"), styles_, body_class);
  fmt::format_to(to, "<a class=\"skip\" href=\"#content\">Skip to the content</a>\n");
  if (!alert_.empty())
    fmt::format_to(to, "<div class=\"alert\" role=\"alert\" tabindex=\"0\">{}</div>\n",
                   alert_.html());
  fmt::format_to(to, "<header><h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n{}</header>\n",
                 encode::markup(title_), encode::markup(subtitle_), top_.html());
  if (sections_.size() > 1) {
    fmt::format_to(to, "<nav aria-label=\"Contents\"><ul>\n");
    for (const Section& s : sections_)
      fmt::format_to(to, "<li><a href=\"#{}\">{}</a></li>\n", s.anchor, encode::markup(s.title));
    fmt::format_to(to, "</ul></nav>\n");
  }
  fmt::format_to(to, "<main id=\"content\">\n");
  for (const Section& s : sections_)
    fmt::format_to(to,
                   "<section id=\"{0}\" aria-labelledby=\"{0}-title\"><h2 id=\"{0}-title\">{1}"
                   "</h2>\n{2}</section>\n",
                   s.anchor, encode::markup(s.title), s.content.html());
  fmt::format_to(to, "</main>\n<footer>{}</footer>\n<script>{}</script>\n{}{}</body></html>\n",
                 encode::markup(footer_), asset("page.js"), data_, scripts);
  return fmt::to_string(out);
}

std::vector<std::string> Page::write_figures(const std::string& folder) const {
  make_output_folder(folder);
  std::vector<std::string> files;
  const auto write_all = [&](const std::string& name, const std::vector<std::string>& drawings) {
    for (std::size_t k = 0; k < drawings.size(); ++k) {
      const std::string number = k == 0 ? "" : fmt::format("-{}", k + 1);
      files.push_back(
          (std::filesystem::path(folder) / (encode::file_name(name) + number + ".svg")).string());
      write_file(files.back(), standing_alone(drawings[k]));
    }
  };
  write_all("summary", top_.drawings());
  for (const Section& section : sections_) write_all(section.anchor, section.content.drawings());
  return files;
}

void Page::write(const std::string& file) const {
  if (std::filesystem::path(file).extension() != ".html")
    throw InputError(fmt::format("{}: no name of a page; expected FILE.html", file));
  write_file(file, html());
}

}  // namespace firn::page
