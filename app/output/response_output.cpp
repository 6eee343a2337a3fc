#include "app/output/response_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "experiments/responses/response_order.h"
#include "experiments/system/terminal.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

constexpr std::size_t values_in_a_row = 6;  // longer responses print as a range

std::string value_text(const Response& r, std::size_t i) {
  const double uncertainty = i < r.uncertainty.size() ? r.uncertainty[i] : 0;
  return measured_text(resolved(r.value[i], r.unit), resolved(uncertainty, r.unit));
}

// Columns on a terminal: bytes that do not continue a character.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string value_text(const Response& r) {
  if (r.value.empty()) return "none";
  if (r.value.size() > values_in_a_row) {
    std::vector<double> defined = r.value;
    std::erase_if(defined, [](double v) { return !std::isfinite(v); });
    if (defined.empty()) return fmt::format("{} values, all undefined", r.value.size());
    const auto [low, high] = std::ranges::minmax(defined);
    const std::size_t missing = r.value.size() - defined.size();
    return fmt::format("{} values, {} to {}{}", r.value.size(), number_text(resolved(low, r.unit)),
                       number_text(resolved(high, r.unit)),
                       missing > 0 ? fmt::format(", {} undefined", missing) : "");
  }
  std::string text;
  for (std::size_t i = 0; i < r.value.size(); ++i) text += (i ? ", " : "") + value_text(r, i);
  return text;
}

Json scalar_or_array(const std::vector<double>& values) {
  if (values.size() == 1) return values[0];
  return values;
}

}  // namespace

std::string mm_text(const Vec3& size) {
  return fmt::format("{:.2f} x {:.2f} x {:.2f} mm", size.x() * 1e3, size.y() * 1e3, size.z() * 1e3);
}

std::string volume_text(double volume) {
  return fmt::format("{:.6g}{}", volume * 1e6, unit_suffix("cm^3"));
}

std::string responses_table(const std::vector<Response>& responses) {
  std::size_t name_width = 0;
  std::size_t value_width = 0;
  for (const Response& r : responses) {
    name_width = std::max(name_width, r.name.size());
    value_width = std::max(value_width, width(value_text(r)));
  }
  std::string table;
  for (const Response& r : responses) {
    table += fmt::format("{:<{}}  {:<{}}  {:<6}  {}\n", r.name, name_width, value_text(r),
                         value_width, unit_text(r.unit), r.method);
  }
  return table;
}

std::string run_responses_table(const std::vector<Response>& responses, const Case& c) {
  constexpr std::size_t kScreen = 25;  // lines
  std::string table = responses_table(in_display_order(responses, c));
  if (responses.size() <= kScreen) return table;
  const std::vector<Response> main = main_responses(responses, c);
  if (!main.empty()) table += "\nMain results:\n" + responses_table(main);
  return table;
}

Json responses_json(const std::vector<Response>& responses) {
  Json all = Json::object();
  for (const Response& r : responses) {
    all[r.name] = {{"value", scalar_or_array(r.value)},
                   {"uncertainty", r.uncertainty.empty() ? Json() : scalar_or_array(r.uncertainty)},
                   {"unit", r.unit},
                   {"method", r.method},
                   {"method_version", r.method_version}};
  }
  return all;
}

std::string verdicts_table(const std::vector<RequirementResult>& verdicts) {
  std::string table;
  for (const RequirementResult& v : verdicts) {
    table += fmt::format("require {}: {}\n", v.requirement.text, v.met ? "met" : "NOT met");
  }
  return table;
}

Json verdicts_json(const std::vector<RequirementResult>& verdicts) {
  Json all = Json::array();
  for (const RequirementResult& v : verdicts) {
    all.push_back({{"require", v.requirement.text}, {"met", v.met}});
  }
  return all;
}

std::string profile_table(const std::vector<PhaseTime>& profile) {
  double total = 0;
  for (const PhaseTime& phase : profile) total += phase.seconds;
  std::string table;
  for (const PhaseTime& phase : profile) {
    table += fmt::format("{:<32} {:>9.2f} s {:>5.1f} %\n", phase.name, phase.seconds,
                         total > 0 ? 100 * phase.seconds / total : 0);
  }
  return table;
}

Json profile_json(const std::vector<PhaseTime>& profile) {
  Json all = Json::object();
  for (const PhaseTime& phase : profile) all[phase.name] = phase.seconds;
  return all;
}

Json energy_json(const Energy& e) {
  Json all = Json::object();
  for (const EnergyTerm& term : energy_terms(e)) all[term.name] = term.value;
  for (const EnergyTerm& term : energy_terms(e.free_bodies)) all[term.name] = term.value;
  return all;
}

void print_json(const Json& document) {
  // Names of files may be no UTF-8.
  print_lines(stdout, "{}\n", document.dump(2, ' ', false, Json::error_handler_t::replace));
}

}  // namespace firn
