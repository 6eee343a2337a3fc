#include "reports/documents/verification_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "firn/math.h"

namespace firn {

using namespace verification;

namespace {

const std::map<std::string, std::string>& group_titles() {
  static const std::map<std::string, std::string> titles = {
      {"impact", "One contact"},          {"body", "One rigid body"},
      {"structure", "Stacks and arches"}, {"bulk", "Packings, silos, heaps"},
      {"machine", "Parts of machines"},   {"invariance", "Invariance under equivalent setups"},
      {"robustness", "The hard places"}};
  return titles;
}

std::string title_of(const std::string& group) {
  const auto found = group_titles().find(group);
  return found == group_titles().end() ? group : found->second;
}

std::string value_text(double value, const std::string& unit) {
  return number_text(value, 6) + unit_suffix(unit);
}

// A tolerance in words for all checks of a case, when they share one.
std::string common_tolerance(const CaseResult& result) {
  if (result.checks.empty()) return "";
  const std::string first = tolerance_text(result.checks.front());
  const bool same = std::all_of(result.checks.begin(), result.checks.end(),
                                [&](const Check& c) { return tolerance_text(c) == first; });
  return same ? first : "several";
}

std::string verdict_text(const CaseResult& r) {
  if (!r.ran) return "not run";
  if (!r.error.empty()) return "error";
  return passed(r) ? "holds" : "fails";
}

struct CheckCounts {
  int cases = 0, held = 0, checks = 0, checks_held = 0, not_run = 0;
};

CheckCounts count_checks(const std::vector<CaseResult>& results) {
  CheckCounts t;
  for (const CaseResult& r : results) {
    ++t.cases;
    if (!r.ran) ++t.not_run;
    if (passed(r)) ++t.held;
    for (const Check& c : r.checks) {
      ++t.checks;
      if (passed(c)) ++t.checks_held;
    }
  }
  return t;
}

std::string summary_text(const std::vector<CaseResult>& results) {
  const CheckCounts t = count_checks(results);
  std::string text = fmt::format("{} of {} cases hold, with {} of {} checks", t.held, t.cases,
                                 t.checks_held, t.checks);
  if (t.not_run > 0) text += fmt::format("; {} have not run", t.not_run);
  return text + ".";
}

constexpr const char* kIntroduction =
    "Each case sets up a small scene, runs it with the solver as shipped, and compares what comes "
    "out with a closed form, a published value, a second method, or an equivalent setup. "
    "Each case lists the fraction of the tolerance that its worst check uses: 100 % is the bound.";

// ---- Markdown

std::string markdown_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\\|");
  return text;
}

void markdown_case(fmt::memory_buffer& out, const VerificationCase& c, const CaseResult& r) {
  auto to = std::back_inserter(out);
  fmt::format_to(to, "### {}\n\n`{}`, {}. Against: {}{}\n\n", c.title, c.name, verdict_text(r),
                 c.reference, c.reference.ends_with('.') ? "" : ".");
  if (!c.remark.empty()) fmt::format_to(to, "{}\n\n", c.remark);
  if (!r.error.empty()) fmt::format_to(to, "It ended with: {}\n\n", r.error);
  if (r.checks.empty()) return;
  fmt::format_to(to, "| check | measured | expected | tolerance | used |\n|---|---|---|---|---|\n");
  for (const Check& k : r.checks) {
    fmt::format_to(to, "| {} | {} | {} | {} | {}{} |\n", markdown_cell(k.what),
                   measured_value_text(k), value_text(k.expected, k.unit), tolerance_text(k),
                   used_text(tolerance_fraction(k)), passed(k) ? "" : " **fails**");
  }
  fmt::format_to(to, "\n");
}

std::string markdown(const std::vector<VerificationCase>& cases,
                     const std::vector<CaseResult>& results, const std::string& program) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# Verification\n\n{}\n\n{} Written by `firn verify` of {}.\n\n",
                 kIntroduction, summary_text(results), program);
  fmt::format_to(to,
                 "| case | compared with | checks | tolerance | most used | |\n"
                 "|---|---|---|---|---|---|\n");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const CaseResult& r = results[i];
    fmt::format_to(to, "| {} `{}` | {} | {} | {} | {} | {} |\n", markdown_cell(cases[i].title),
                   cases[i].name, markdown_cell(cases[i].reference), r.checks.size(),
                   common_tolerance(r), used_text(max_tolerance_fraction(r)), verdict_text(r));
  }
  std::string last;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string g = group(cases[i]);
    if (g != last) fmt::format_to(to, "\n## {}\n\n", title_of(g));
    last = g;
    markdown_case(out, cases[i], results[i]);
  }
  while (out.size() > 1 && out[out.size() - 1] == '\n' && out[out.size() - 2] == '\n')
    out.resize(out.size() - 1);
  return fmt::to_string(out);
}

// ---- HTML

constexpr const char* kStyle = R"css(
:root { --ink: #1b2733; --faint: #6b7785; --line: #d7dde4; --ground: #fff; --band: #f4f7fa;
        --good: #1d6f5c; --bad: #b3261e; --bar: #8fb8cf; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6ebf0; --faint: #9aa7b4; --line: #38424d; --ground: #14191f; --band: #1c232b;
          --good: #5cc8ab; --bad: #ff8a80; --bar: #3f6f8a; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--ground);
       margin: 0 auto; max-width: 62rem; padding: 1.5rem; }
h1 { margin: 0 0 .3rem; } h2 { margin: 2.5rem 0 .5rem; border-bottom: 2px solid var(--line); }
h3 { margin: 0; font-size: 1.05rem; } p { margin: .4rem 0; } code { color: var(--faint); }
.verdict { font-weight: 600; } .holds { color: var(--good); } .fails { color: var(--bad); }
.summary { font-size: 1.25rem; }
details { border: 1px solid var(--line); border-radius: 6px; margin: .6rem 0; padding: .5rem .9rem; }
details[open] { background: var(--band); } summary { cursor: pointer; display: flex; gap: .8rem;
  align-items: baseline; flex-wrap: wrap; } summary h3 { flex: 1 1 18rem; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; margin: .5rem 0; }
th, td { text-align: left; padding: .2rem .6rem .2rem 0; border-bottom: 1px solid var(--line);
         vertical-align: top; } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums;
         white-space: nowrap; }
.scroll { overflow-x: auto; } .scroll td:first-child { min-width: 14rem; }
.count { min-width: 6rem; text-align: right; }
.bar { display: inline-block; width: 6rem; height: .55rem; border: 1px solid var(--line);
       border-radius: 3px; overflow: hidden; } .bar i { display: block; height: 100%;
       background: var(--bar); } .bar i.over { background: var(--bad); }
.faint { color: var(--faint); }
@media print { details { break-inside: avoid; } details > * { display: block; } }
)css";

std::string bar(double used, bool held) {
  const double share = std::isfinite(used) ? std::clamp(used, 0.0, 1.0) : 1;
  return fmt::format(
      R"(<span class="bar" title="{} of the tolerance"><i{} style="width:{:.0f}%"></i></span>)",
      used_text(used), held ? "" : " class=\"over\"", 100 * share);
}

void html_checks(fmt::memory_buffer& out, const CaseResult& r) {
  auto to = std::back_inserter(out);
  fmt::format_to(to,
                 "<div class=\"scroll\"><table><tr><th>check<th class=\"n\">measured<th "
                 "class=\"n\">expected<th class=\"n\">tolerance<th>used<th></tr>\n");
  for (const Check& k : r.checks) {
    fmt::format_to(to,
                   "<tr><td>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td>{}<td "
                   "class=\"{}\">{}</tr>\n",
                   encode::markup(k.what), encode::markup(measured_value_text(k)),
                   encode::markup(value_text(k.expected, k.unit)),
                   encode::markup(tolerance_text(k)), bar(tolerance_fraction(k), passed(k)),
                   passed(k) ? "holds" : "fails", passed(k) ? "" : "fails");
  }
  fmt::format_to(to, "</table></div>");
}

void html_case(fmt::memory_buffer& out, const VerificationCase& c, const CaseResult& r) {
  auto to = std::back_inserter(out);
  const bool good = passed(r);
  fmt::format_to(to, "<details{} id=\"{}\"><summary><h3>{}</h3>", r.ran && !good ? " open" : "",
                 encode::markup(c.name), encode::markup(c.title));
  if (r.ran && r.error.empty()) {
    fmt::format_to(to, "{}<span class=\"faint count\">{} check{}</span>",
                   bar(max_tolerance_fraction(r), good), r.checks.size(),
                   r.checks.size() == 1 ? "" : "s");
  }
  fmt::format_to(to, "<span class=\"verdict {}\">{}</span></summary>\n", good ? "holds" : "fails",
                 verdict_text(r));
  fmt::format_to(to, "<p><b>Against</b> {}</p>", encode::markup(c.reference));
  if (!c.remark.empty()) fmt::format_to(to, "<p>{}</p>", encode::markup(c.remark));
  if (!r.error.empty()) fmt::format_to(to, "<p class=\"fails\">{}</p>", encode::markup(r.error));
  if (!r.checks.empty()) html_checks(out, r);
  fmt::format_to(to, "<p class=\"faint\"><code>firn verify {}</code>, {:.1f} s</p></details>\n",
                 encode::markup(c.name), r.seconds);
}

std::string html(const std::vector<VerificationCase>& cases, const std::vector<CaseResult>& results,
                 const std::string& program) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  const CheckCounts t = count_checks(results);
  fmt::format_to(to,
                 "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n<meta "
                 "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                 "<title>Firn: verification</title>\n<style>{}</style>\n",
                 kStyle);
  fmt::format_to(to,
                 "<h1>Verification</h1>\n<p class=\"summary verdict {}\">{}</p>\n<p>{}</p>\n<p "
                 "class=\"faint\">{}</p>\n",
                 t.held == t.cases ? "holds" : "fails", summary_text(results), kIntroduction,
                 encode::markup(program));
  std::string last;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string g = group(cases[i]);
    if (g != last) fmt::format_to(to, "<h2>{}</h2>\n", encode::markup(title_of(g)));
    last = g;
    html_case(out, cases[i], results[i]);
  }
  // A closed fold prints as a title only: on paper everything is shown.
  fmt::format_to(to,
                 "<script>addEventListener('beforeprint',()=>document.querySelectorAll('details')."
                 "forEach(d=>d.open=true))</script>\n</html>\n");
  return fmt::to_string(out);
}

}  // namespace

std::string measured_value_text(const Check& c) {
  const double scale = c.bound == Bound::absolute ? c.tolerance : c.expected;
  return value_text(without_rounding_error(c.measured, scale), c.unit);
}

std::string used_text(double fraction) {
  return number_text(100 * without_rounding_error(fraction, 1), 2) + " %";
}

std::string tolerance_text(const Check& c) {
  switch (c.bound) {
    case Bound::relative:
      return number_text(100 * c.tolerance, 3) + " %";
    case Bound::absolute:
      return "± " + number_text(c.tolerance, 3) + unit_suffix(c.unit);
    case Bound::at_most:
      return "at most";
    case Bound::at_least:
      return "at least";
  }
  return "";
}

void write_verification_page(const std::vector<VerificationCase>& cases,
                             const std::vector<CaseResult>& results, const std::string& program,
                             const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension != ".html" && extension != ".md") {
    throw InputError(fmt::format("{}: a page is FILE.html or FILE.md", file));
  }
  write_file(
      file, extension == ".md" ? markdown(cases, results, program) : html(cases, results, program));
}

}  // namespace firn
