#include "app/output/contact_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/text/number_text.h"
#include "experiments/text/vector_json.h"
namespace firn {
namespace {

std::string vector_text(const Vec3& v) {
  // Components at the rounding error of the largest one print as zero.
  const double least = 1e-12 * v.cwiseAbs().maxCoeff();
  const auto text = [&](double x) { return std::abs(x) <= least ? 0.0 : x; };
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", text(v.x()), text(v.y()), text(v.z()));
}

std::string place_text(const Vec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f}) mm", 1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z());
}

std::string percent(double part) { return fmt::format("{:.1f} %", 100 * part); }

// A difference and the scale that it is compared with.
std::string error_text(double error, double scale, const char* unit) {
  return fmt::format(
      "{:.1e} {}{}", error, unit,
      scale > 0 ? fmt::format(" ({:.0e} of all sizes together)", error / scale) : "");
}

std::string state_text(const Contact& c) {
  if (!(c.normal_force > 0)) return "near";
  return c.sliding ? "slides" : "sticks";
}

// Where a point is on its hysteresis: loading goes along K s, unloading far below it.
std::string branch_text(const Contact& c, const ContactPointInfo& p) {
  if (!(p.force > 0)) return "";
  const double part = p.force / (c.stiffness * p.stiffness_fraction * -p.gap);
  return part > 1 - 1e-9 ? ", loading" : fmt::format(", {} of loading", percent(part));
}

std::string contact_text(const Model& model, const ContactView& view) {
  const Contact& c = view.contact;
  std::string text = fmt::format("{}, patch {}: ", body_name(model, view.neighbor()), c.patch);
  if (!view.is_active()) return text + fmt::format("near, gap {:.3g} um\n", 1e6 * c.gap);
  text += fmt::format("{:.4g} N along normal {}, at {}\n", c.normal_force, vector_text(c.normal),
                      place_text(c.position));
  text += fmt::format(
      "  {}: friction {:.4g} N, {} of its limit {:.4g} N; torsion {:.3g} of {:.3g} "
      "N mm\n",
      state_text(c), c.friction.norm(), percent(view.friction_mobilization()), c.friction_limit,
      1e3 * c.torsion, 1e3 * c.torsion_limit);
  if (c.rolling.norm() > 0)
    text += fmt::format("  rolling moment {} N mm\n", vector_text(1e3 * c.rolling));
  text += fmt::format(
      "  force on it {} N; overlap {:.4g} um, {} % of the thickness; K {:.4g} "
      "N/m, {} points\n",
      vector_text(c.force), 1e6 * c.overlap,
      number_text(100 * c.overlap / smallest_extent(model, c), 3), c.stiffness, c.points.size());
  for (std::size_t k = 0; k < c.points.size(); ++k) {
    const ContactPointInfo& p = c.points[k];
    text += fmt::format("    {:>2}  {}  {} {:8.3f} um  fraction {:.4f}  {:.4g} N{}\n", k,
                        place_text(p.position), p.gap > 0 ? "gap    " : "overlap",
                        1e6 * std::abs(p.gap), p.stiffness_fraction, p.force, branch_text(c, p));
  }
  return text;
}

std::string head_text(const Case& c, const ContactSnapshot& now) {
  return fmt::format("{}, t = {:.9g} s, step {}\n", c.name, now.time, now.step);
}

// One line for a list of contacts, seen from a to b.
std::string line_text(const Model& model, const Contact& c) {
  return fmt::format("  {:<14} {:<18} {:>10.4g} N  {:>7}  {} of limit    {:>9.3f} um {:>7.3f} %\n",
                     body_name(model, c.a), body_name(model, c.b), c.normal_force, state_text(c),
                     percent(c.friction_limit > 0 ? c.friction.norm() / c.friction_limit : 0),
                     1e6 * c.overlap, 100 * c.overlap / smallest_extent(model, c));
}

Json body_json(const Model& model, int body) {
  if (is_particle(model, body)) return body;
  return body_name(model, body);
}

Json contact_json(const Model& model, const Contact& c) {
  Json points = Json::array();
  for (const ContactPointInfo& p : c.points) {
    points.push_back({{"position", vector_json(p.position)},
                      {"gap", p.gap},
                      {"stiffness_fraction", p.stiffness_fraction},
                      {"force", p.force},
                      {"area", p.area}});
  }
  return {
      {"body", body_json(model, c.a)},
      {"neighbor", body_json(model, c.b)},
      {"patch", c.patch},
      {"state", state_text(c)},
      {"position", vector_json(c.position)},
      {"normal", vector_json(c.normal)},
      {"normal_force", c.normal_force},
      {"friction", vector_json(c.friction)},
      {"friction_limit", c.friction_limit},
      {"friction_mobilization", c.friction_limit > 0 ? c.friction.norm() / c.friction_limit : 0},
      {"torsion", c.torsion},
      {"torsion_limit", c.torsion_limit},
      {"rolling", vector_json(c.rolling)},
      {"force", vector_json(c.force)},
      {"moment", vector_json(c.moment_a)},
      {"gap", c.gap},
      {"overlap", c.overlap},
      {"overlap_relative", c.overlap / smallest_extent(model, c)},
      {"stiffness", c.stiffness},
      {"points", points}};
}

}  // namespace

std::string audit_text(const Case& c, const ContactSelection& choice, const ContactSnapshot& now) {
  const Model& model = c.model;
  std::string text = head_text(c, now);
  text += body_name(model, choice.body);
  if (is_particle(model, choice.body)) {
    const std::size_t i = index(choice.body);
    const Particle& particle = model.particles[i];
    text += fmt::format(" ({}, tag {}) at {}, {:.4g} m/s, {:.4g} rad/s",
                        model.shapes[index(particle.shape)].name, particle.tag,
                        place_text(now.particles.position[i]), now.particles.velocity[i].norm(),
                        now.particles.angular_velocity[i].norm());
  }
  if (choice.other >= 0) text += " and " + body_name(model, choice.other);
  text += "\n";
  if (now.contacts.empty()) text += "nothing is near\n";
  for (const ContactView& view : now.contacts) text += contact_text(model, view);
  if (!now.balance) return text;
  const ForceBalance& b = *now.balance;
  text += fmt::format("{} contact{} forces {} N + weight {} N = {} N\n",
                      choice.other < 0 ? "all" : "with all neighbors,",
                      model.bonds.empty() ? "" : " and bond", vector_text(b.contacts),
                      vector_text(b.weight), vector_text(b.contacts + b.weight));
  text += fmt::format("mass x acceleration over the next step: {} N\n",
                      vector_text(b.mass_acceleration));
  text += fmt::format("unaccounted for: {} of force, {} of moment\n",
                      error_text(std::max(b.force_error, b.sum_mismatch), b.scale, "N"),
                      error_text(b.moment_error, b.moment_scale, "N m"));
  return text;
}

std::string summary_text(const Case& c, const ContactSnapshot& now) {
  const ContactSummary& s = now.summary;
  std::string text = head_text(c, now);
  text += fmt::format("{} particles present, {} touched by nothing; {:.2f} neighbors each\n",
                      s.present, s.unsupported, s.neighbors);
  text += fmt::format("{} pairs touch in {} patches with {} points; {} patches more are near\n",
                      s.pairs, s.patches, s.points, s.non_touching_patches);
  if (s.patches == 0) return text;
  text += fmt::format(
      "normal force of a patch: mean {:.4g} N, median {:.4g} N, 99 % below {:.4g} N, largest "
      "{:.4g} N\n",
      s.force_mean, s.force_median, s.force_p99, s.force_largest);
  text +=
      fmt::format("friction: {} patches slide; {} of the friction limit is mobilized on average\n",
                  s.sliding, percent(s.friction_mobilization));
  text += fmt::format("overlap: median {:.4g} um, 99 % below {:.4g} um, largest {:.4g} um\n",
                      1e6 * s.overlap_median, 1e6 * s.overlap_p99, 1e6 * s.overlap_largest);
  text += "most loaded:\n";
  for (const Contact& contact : s.most_loaded) text += line_text(c.model, contact);
  text += "deepest:\n";
  for (const Contact& contact : s.deepest) text += line_text(c.model, contact);
  return text;
}

std::string history_text(const std::vector<HistoryRow>& rows) {
  std::string text = fmt::format(
      "{:>12} {:>9} {:>7} {:>7} {:>10} {:>10} {:>10} {:>10} {:>7} {:>10} {:>10} {:>11} {:>11} "
      "{:>6} {:>6}\n",
      "time/s", "step", "patches", "sliding", "gap/um", "normal/N", "peak/N", "friction/N",
      "used/%", "approach", "slip", "work n/uJ", "work f/uJ", "new", "lost");
  for (const HistoryRow& r : rows) {
    text += fmt::format(
        "{:>12.9g} {:>9} {:>7} {:>7} {:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g} {:>7.1f} {:>10.3g} "
        "{:>10.3g} {:>11.4g} {:>11.4g} {:>6} {:>6}\n",
        r.time, r.step, r.patches, r.sliding, 1e6 * r.gap, r.normal_force, r.peak_normal_force,
        r.friction, 100 * r.friction_mobilization, r.approach, r.slip, 1e6 * r.work_normal,
        1e6 * r.work_friction, r.new_patches, r.lost_patches);
  }
  return text;
}

std::string events_text(const Case& c, const std::vector<PatchEvent>& events) {
  std::string text;
  for (const PatchEvent& e : events) {
    text += fmt::format("t = {:.9g} s, step {}: {} and {} bear on {} patch{}, before {}\n", e.time,
                        e.step, body_name(c.model, e.a), body_name(c.model, e.b), e.after,
                        e.after == 1 ? "" : "es", e.before);
  }
  return text;
}

Json audit_json(const Case& c, const ContactSelection& choice, const ContactSnapshot& now) {
  Json document = {{"case", c.name}, {"time", now.time}, {"step", now.step}};
  document["body"] = body_json(c.model, choice.body);
  if (choice.other >= 0) document["other"] = body_json(c.model, choice.other);
  if (is_particle(c.model, choice.body)) {
    const std::size_t i = index(choice.body);
    document["position"] = vector_json(now.particles.position[i]);
    document["velocity"] = vector_json(now.particles.velocity[i]);
    document["angular_velocity"] = vector_json(now.particles.angular_velocity[i]);
  }
  Json contacts = Json::array();
  for (const ContactView& view : now.contacts)
    contacts.push_back(contact_json(c.model, view.contact));
  document["contacts"] = contacts;
  if (now.balance) {
    const ForceBalance& b = *now.balance;
    document["balance"] = {{"contact_force", vector_json(b.contacts)},
                           {"contact_moment", vector_json(b.moment)},
                           {"weight", vector_json(b.weight)},
                           {"mass_acceleration", vector_json(b.mass_acceleration)},
                           {"force_error", std::max(b.force_error, b.sum_mismatch)},
                           {"moment_error", b.moment_error}};
  }
  return document;
}

Json summary_json(const Case& c, const ContactSnapshot& now) {
  const ContactSummary& s = now.summary;
  const auto list = [&](const std::vector<Contact>& contacts) {
    Json all = Json::array();
    for (const Contact& contact : contacts) all.push_back(contact_json(c.model, contact));
    return all;
  };
  return {{"case", c.name},
          {"time", now.time},
          {"step", now.step},
          {"present", s.present},
          {"touched_by_nothing", s.unsupported},
          {"neighbors", s.neighbors},
          {"pairs", s.pairs},
          {"patches", s.patches},
          {"non_touching_patches", s.non_touching_patches},
          {"points", s.points},
          {"sliding", s.sliding},
          {"friction_mobilization", s.friction_mobilization},
          {"normal_force",
           {{"mean", s.force_mean},
            {"median", s.force_median},
            {"p99", s.force_p99},
            {"largest", s.force_largest}}},
          {"overlap",
           {{"median", s.overlap_median}, {"p99", s.overlap_p99}, {"largest", s.overlap_largest}}},
          {"most_loaded", list(s.most_loaded)},
          {"deepest", list(s.deepest)}};
}

Json history_json(const Case& c, const std::vector<HistoryRow>& rows,
                  const std::vector<PatchEvent>& events) {
  Json table = Json::array(), list = Json::array();
  for (const HistoryRow& r : rows) {
    table.push_back({{"time", r.time},
                     {"step", r.step},
                     {"patches", r.patches},
                     {"sliding", r.sliding},
                     {"gap", number_json(r.gap)},
                     {"normal_force", r.normal_force},
                     {"peak_normal_force", r.peak_normal_force},
                     {"friction", r.friction},
                     {"friction_mobilization", r.friction_mobilization},
                     {"force", vector_json(r.force)},
                     {"approach", number_json(r.approach)},
                     {"slip", number_json(r.slip)},
                     {"work_normal", r.work_normal},
                     {"work_friction", r.work_friction},
                     {"new_patches", r.new_patches},
                     {"lost_patches", r.lost_patches}});
  }
  for (const PatchEvent& e : events) {
    list.push_back({{"time", e.time},
                    {"step", e.step},
                    {"a", body_json(c.model, e.a)},
                    {"b", body_json(c.model, e.b)},
                    {"before", e.before},
                    {"after", e.after}});
  }
  return {{"case", c.name}, {"rows", table}, {"events", list}};
}

}  // namespace firn
