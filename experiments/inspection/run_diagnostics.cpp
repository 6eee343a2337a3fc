#include "experiments/inspection/run_diagnostics.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/text/number_text.h"
#include "firn/diagnostics.h"

namespace firn {
namespace {

constexpr double kDeep = 0.1;  // of the smallest edge

bool too_deep(const ContactDiagnostics& h) {
  return h.stopped || h.largest_overlap > kDeep * h.edge;
}

bool too_late(const ContactDiagnostics& h) {
  return h.late_contacts > std::max(10.0, 0.1 * h.particles);
}

// Smallest and largest of some values.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double width() const { return high - low; }
};

double largest_speed(const Recording& recording) {
  constexpr std::size_t kFrames = 200;
  const std::size_t count = recording.frame_count();
  const std::size_t stride = 1 + count / kFrames;
  double squared = 0;
  for (std::size_t i = 0; i < count; i += stride) {
    for (const auto& v : recording.frame(i).velocity) {
      const double s = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      if (s > squared) squared = s;  // not for a particle that is absent
    }
  }
  return std::sqrt(squared);
}

}  // namespace

ContactCause likely_cause(const ContactDiagnostics& h) {
  constexpr double kFewSteps = 4;      // in a quarter period
  constexpr double kSharp = 0.005;     // rounding over the smallest edge
  constexpr double kExplained = 0.25;  // of the overlap, by speed and load
  if (!too_deep(h) && !too_late(h)) return ContactCause::none;
  if (h.steps_per_quarter < kFewSteps) return ContactCause::timestep;
  const double overlap = std::max(h.largest_overlap, h.stopped ? kDeep * h.edge : 0.0);
  if (too_deep(h) && h.expected_overlap >= kExplained * overlap) return ContactCause::stiffness;
  if (h.rounding < kSharp * h.rounding_edge) return ContactCause::rounding;
  return too_deep(h) ? ContactCause::stiffness : ContactCause::timestep;
}

ContactDiagnostics contact_diagnostics(const Recording& recording, const Case& c) {
  ContactDiagnostics h;
  h.largest_overlap = last_finite(recording.series("/diagnostics/largest_overlap"));
  h.late_contacts = last_finite(recording.series("/diagnostics/late_contacts"));
  const std::string status = recording.status();
  h.stopped = status.starts_with("failed") && status.find("overlaps") != std::string::npos;
  h.particles = static_cast<double>(recording.particle_count());
  const std::vector<double> times = recording.frame_times();
  const double interval = times.size() > 1 ? times[1] - times[0] : 0;
  const double gravity = c.model.gravity.norm();
  h.speed = largest_speed(recording) + gravity * interval;
  h.edge = std::numeric_limits<double>::infinity();
  double sharpest = h.edge, softest = -1;
  const std::vector<int> shapes = recording.shape();
  for (const int i : std::set<int>(shapes.begin(), shapes.end())) {
    const Shape& shape = c.model.shapes.at(static_cast<std::size_t>(i));
    const double edge = shape.box.minCoeff();
    h.edge = std::min(h.edge, edge);
    if (shape.rounding < sharpest * edge) {
      sharpest = shape.rounding / edge;
      h.rounding = shape.rounding;
      h.rounding_edge = edge;
    }
    // In a bed, a column of bodies rests on the lowest one.
    const double impact = h.speed * std::sqrt(shape.mass / shape.stiffness);
    const double load = std::cbrt(h.particles) * shape.mass * gravity / shape.stiffness;
    if ((impact + load) / edge > softest) {
      softest = (impact + load) / edge;
      h.expected_overlap = impact + load;
    }
  }
  h.automatic_timestep = c.automatic_timestep;
  h.steps_per_quarter = advise_timestep(c.model, 1).timestep / recording.timestep();
  return h;
}

std::string contact_warning(const ContactDiagnostics& h) {
  const ContactCause cause = likely_cause(h);
  if (cause == ContactCause::none) return {};
  std::string what;
  if (too_deep(h)) {
    what = h.stopped ? "the overlap of two bodies passed its limit"
                     : fmt::format("bodies overlapped by up to {} mm, {} % of the smallest edge",
                                   number_text(1e3 * h.largest_overlap, 3),
                                   number_text(100 * h.largest_overlap / h.edge, 3));
  }
  if (too_late(h)) {
    what += fmt::format("{}{:.0f} contacts were first seen when already deep",
                        what.empty() ? "" : ", and ", h.late_contacts);
  }
  switch (cause) {
    case ContactCause::rounding:
      return fmt::format(
          "{}; likely cause: the rounding, {} mm or {} % of the smallest edge, as sharp "
          "edges and corners bear on next to no area; give shapes 1 to 3 %, or leave rounding out",
          what, number_text(1e3 * h.rounding, 3),
          number_text(100 * h.rounding / h.rounding_edge, 2));
    case ContactCause::stiffness:
      return fmt::format(
          "{}; likely cause: the stiffness, as speeds up to {:.3g} m/s and the load explain {} "
          "mm; raise young_modulus or stiffness",
          what, h.speed, number_text(1e3 * h.expected_overlap, 3));
    case ContactCause::timestep:
      return fmt::format(
          "{}; likely cause: the time step, {:.3g} steps in the quarter period of the stiffest "
          "contact; {}",
          what, h.steps_per_quarter,
          h.automatic_timestep ? "raise case.steps_per_loading"
                               : "lower case.timestep, or leave it out");
    case ContactCause::none:
      break;
  }
  return {};
}

std::optional<EnergyAccount> energy_account(const Recording& recording) {
  const auto series = [&](const char* name) {
    return recording.series(std::string("/energy/") + name);
  };
  const std::vector<double> kinetic = series("kinetic"), gravitational = series("gravitational"),
                            elastic = series("elastic"), dissipated = series("dissipated"),
                            work = series("boundary_work"), removed = series("removed");
  for (const auto* one : {&gravitational, &elastic, &dissipated, &work, &removed})
    if (one->size() != kinetic.size() || kinetic.empty()) return std::nullopt;
  EnergyAccount a;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kinetic.size(); ++i) {
    const double account =
        kinetic[i] + gravitational[i] + elastic[i] + dissipated[i] - work[i] + removed[i];
    lowest = std::min(lowest, account);
    a.gained = std::max(a.gained, account - lowest);
    a.turned_over = std::max({a.turned_over, std::abs(dissipated[i]), std::abs(work[i])});
  }
  return a;
}

std::string energy_warning(const EnergyAccount& a) {
  constexpr double kGain = 0.002, kNothing = 1e-9;  // of what was turned over; J
  if (!(a.gained > kGain * a.turned_over) || a.gained < kNothing) return {};
  return fmt::format(
      "the energy account gains {:.3g} J, {:.2g} % of the {:.4g} J that were turned over; a "
      "smaller time step (case.steps_per_loading, case.timestep) shows whether it matters",
      a.gained, 100 * a.gained / a.turned_over, a.turned_over);
}

std::optional<FreeBodyBalance> free_body_balance(const Recording& recording) {
  if (!recording.contains("/energy/free_bodies_kinetic")) return std::nullopt;
  const auto series = [&](const char* name) {
    return recording.series(std::string("/energy/") + name);
  };
  const std::vector<double> kinetic = series("free_bodies_kinetic"),
                            gravitational = series("free_bodies_gravitational"),
                            springs = series("free_bodies_elastic"),
                            contacts = series("boundary_contacts_elastic"),
                            friction = series("dissipated_joint_friction"),
                            damping = series("dissipated_joint_damping"),
                            impacts = series("dissipated_boundary_contacts"),
                            work = series("free_bodies_work");
  if (kinetic.empty()) return std::nullopt;
  Range balance, moving, elastic, dissipated, given;
  for (std::size_t i = 0; i < kinetic.size(); ++i) {
    const FreeBodyEnergy e{kinetic[i],  gravitational[i], springs[i], contacts[i],
                           friction[i], damping[i],       impacts[i], work[i]};
    balance.add(e.balance());
    moving.add(e.kinetic);
    elastic.add(e.elastic + e.contacts_elastic);
    dissipated.add(e.dissipated_friction + e.dissipated_damping + e.dissipated_contacts);
    given.add(e.work);
  }
  return FreeBodyBalance{balance.width(), std::max({moving.width(), elastic.width(),
                                                    dissipated.width(), given.width()})};
}

std::string free_body_warning(const FreeBodyBalance& b) {
  constexpr double kChange = 0.02, kNothing = 1e-9;  // of what was turned over; J
  if (!(b.change > kChange * b.turned_over) || b.change < kNothing) return {};
  return fmt::format(
      "the energy balance of free bodies changes by {:.3g} J, {:.2g} % of the {:.4g} J that were "
      "turned over; a smaller time step (case.steps_per_loading, case.timestep) shows whether it "
      "matters",
      b.change, 100 * b.change / b.turned_over, b.turned_over);
}

JointConvergence joint_convergence(const Recording& recording) {
  constexpr const char* kUnconverged = "/diagnostics/unconverged_steps";
  const std::vector<double> times = recording.frame_times();
  if (times.empty() || !recording.contains(kUnconverged)) return {};
  return {last_finite(recording.series(kUnconverged)),
          std::round(times.back() / recording.timestep())};
}

std::string convergence_warning(const JointConvergence& j) {
  if (!(j.unconverged > 0)) return {};
  return fmt::format(
      "friction, motors and limits of mechanisms did not converge in {:.0f} of {:.0f} steps, and "
      "their loads are inexact there; likely cause: a motor without max_load, or with a large one, "
      "works against a limit or friction of another joint or coupling; lower its max_load, or "
      "shorten the time step (case.steps_per_loading, case.timestep)",
      j.unconverged, j.steps);
}

std::vector<RunWarning> run_warnings(const Recording& recording, const Case& c) {
  std::vector<RunWarning> all;
  const auto add = [&](const char* subject, std::string text) {
    if (!text.empty()) all.push_back({subject, std::move(text)});
  };
  add("contacts", contact_warning(contact_diagnostics(recording, c)));
  if (const auto account = energy_account(recording))
    add("energy account", energy_warning(*account));
  if (const auto balance = free_body_balance(recording))
    add("energy of free bodies", free_body_warning(*balance));
  add("joints", convergence_warning(joint_convergence(recording)));
  return all;
}

std::set<std::string> shapes_with_stated_rounding(const Case& c) {
  const toml::table resolved = toml::parse(c.resolved);  // holds no rounding that was chosen
  std::set<std::string> names;
  for (const Shape& shape : c.model.shapes)
    if (resolved["shapes"][shape.name]["rounding"]) names.insert(shape.name);
  return names;
}

std::string deviation_warning(const Shape& shape, bool rounding_is_stated) {
  constexpr double kAllowed = 0.02, kStated = 0.05;  // of the smallest edge
  const bool by_rounding = shape.deviation_reason.starts_with("edges rounded");
  const double most = rounding_is_stated && by_rounding ? kStated : kAllowed;
  const double relative = shape.surface_deviation / shape.box.minCoeff();
  const bool needs_parts = shape.deviation_reason.starts_with("max_parts");
  if (relative <= most && !needs_parts) return {};
  return fmt::format(
      "shape {}: the contact parts deviate by {} mm from the mesh ({} % of the smallest "
      "edge; {}); {}",
      shape.name, number_text(shape.surface_deviation * 1e3, 3), number_text(100 * relative, 3),
      shape.deviation_reason,
      by_rounding ? "a smaller rounding reduces it" : "check with firn shape");
}

}  // namespace firn
