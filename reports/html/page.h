// Report pages: each is one self-contained HTML file for screens, phones and paper, without network
// access.
//
//   page::Page page("Auger, half full", "seed 1");
//   page.top().key_figures({{"delivered", "75 of 80", "cubes", {page::Mark::good, "within"}}});
//   page::Content& loads = page.section("Loads");
//   loads.figure({plots::draw(plot), "Force on the auger.", "Force against time, at most 12 N"});
//   page.write("auger.html");
//
// All texts are plain: their characters are shown literally.
#pragma once

#include <limits>
#include <list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/number_text.h"

namespace firn::page {

// A text as an anchor: letters and digits in lower case, hyphens between them.
std::string slugify(const std::string& text);

using firn::measured_text;
using firn::number_text;
using firn::resolved;
using firn::words;

// A verdict, shown by shape and word, not by color alone.
enum class Mark { none, good, caution, bad, neutral };
struct Badge {
  Mark mark = Mark::none;
  std::string word;
};

// One number of a summary.
struct KeyFigure {
  std::string label, value, note;  // "angle of repose", "11.4 ± 1.2 deg", "measured: 10 ± 0.7 deg"
  Badge badge;
};

struct Property {
  std::string name, value;
};

// One cell of a table. Columns sort by the values where there are some, else by the texts; copies
// hold values with all digits, and uncertainties in a separate column.
struct Cell {
  std::string text;
  double value = std::numeric_limits<double>::quiet_NaN();
  double uncertainty = std::numeric_limits<double>::quiet_NaN();  // one standard deviation
  Badge badge;
  std::string anchor;  // of the section that the text leads to; empty: none

  Cell(std::string plain) : text(std::move(plain)) {}
  Cell(const char* plain) : text(plain) {}
  Cell(double number, int digits = 4) : text(number_text(number, digits)), value(number) {}
  Cell(Badge verdict) : badge(std::move(verdict)) {}
  static Cell measured(double value, double uncertainty);
  // Its text has resolved() numbers, without the unit.
  static Cell measured(double value, double uncertainty, const std::string& unit);
  static Cell link(std::string text, std::string anchor);
};

struct Column {
  std::string title;
  std::string unit;  // empty or "1": none
};

struct Table {
  std::string caption;  // what the rows are
  std::vector<Column> columns;
  std::vector<std::vector<Cell>> rows;  // each as long as `columns`
};

struct Figure {
  std::string svg;        // of plots.h, inline
  std::string caption;    // caption below the figure
  std::string alt;        // text alternative for screen readers, numbers included
  bool on_paper = false;  // has fixed colors for a white background
};

// Content of a section or of a collapsible block, in order.
class Content {
 public:
  Content& heading(const std::string& title);
  Content& paragraph(const std::string& text);
  Content& note(const Badge& badge, const std::string& text);  // set off, with its verdict
  Content& list(const std::vector<std::string>& items);
  Content& key_figures(const std::vector<KeyFigure>& figures);
  Content& properties(const std::vector<Property>& properties);
  // Throws std::logic_error for a row that is not as long as the columns.
  Content& table(const Table& table);
  Content& figure(const Figure& figure);
  Content& figures(const std::vector<Figure>& figures);  // side by side where there is room
  // Commands, one a line, with a button that copies them.
  Content& code(const std::string& text, const std::string& caption = "");
  // A collapsible block, always open on paper.
  Content& collapsible(const std::string& summary, const Content& content, bool open = false);
  Content& html(const std::string& trusted);  // inserted unchanged

  const std::string& html() const { return html_; }
  bool empty() const { return html_.empty(); }
  const std::vector<std::string>& drawings() const { return drawings_; }  // the figures' <svg>

 private:
  std::string html_;
  std::vector<std::string> drawings_;
};

class Page {
 public:
  Page(std::string title, std::string subtitle);

  Content& top() { return top_; }  // above the table of contents
  // Above everything else, or to its left on wide screens, and always in sight; announced by screen
  // readers.
  Content& alert() { return alert_; }
  // What is below the alert is of an earlier version: its views are dimmed.
  void mark_outdated() { outdated_ = true; }
  // A new section, listed in the table of contents. The anchor is made of the title unless given;
  // a second one of a name gets a number. The reference holds as long as the page.
  Content& section(const std::string& title, const std::string& anchor = "");
  // At the end of the document: data (base64) under an id, and behind all of them scripts, each
  // text once, however often it is added.
  void add_script(std::string_view script);
  void add_data(const std::string& id, std::string_view base64);
  void add_style(std::string_view css);  // after the page's own; each text once
  // Scripts of the page may send requests to the server of the page only.
  void allow_requests_to_its_server() { asks_server_ = true; }
  void set_footer(std::string text) { footer_ = std::move(text); }

  std::string html() const;
  // Replaces an older file atomically. Throws InputError unless FILE.html can be written.
  void write(const std::string& file) const;
  // Writes every figure as a separate SVG file, in the light colors on white: <section>.svg,
  // <section>-2.svg, ... Makes the folder; throws InputError where it cannot. The files' names.
  std::vector<std::string> write_figures(const std::string& folder) const;

 private:
  struct Section {
    std::string title, anchor;
    Content content;
  };
  bool added_before(std::string_view text);

  std::string title_, subtitle_, footer_, styles_, data_;
  std::vector<std::string> scripts_;
  std::set<std::size_t> added_;  // hashes of scripts and styles
  Content top_, alert_;
  bool asks_server_ = false, outdated_ = false;
  std::list<Section> sections_;
};

}  // namespace firn::page
