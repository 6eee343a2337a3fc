#include "experiments/inspection/contact_inspection.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

// The smallest of the sorted values that `share` of them do not exceed; 0 of none.
Contact turned(Contact c) {
  std::swap(c.a, c.b);
  std::swap(c.moment_a, c.moment_b);
  c.normal = -c.normal;
  c.friction = -c.friction;
  c.rolling = -c.rolling;
  c.force = -c.force;
  return c;  // torsion: on the other body about the other normal, the same number
}

// Sums of force and moment on one particle.
Solver::Load sum_on(const std::vector<Contact>& contacts, int particle) {
  Solver::Load sum{Vec3::Zero(), Vec3::Zero()};
  for (const Contact& c : contacts) {
    if (c.a == particle) {
      sum.force += c.force;
      sum.moment += c.moment_a;
    } else if (c.b == particle) {
      sum.force -= c.force;
      sum.moment += c.moment_b;
    }
  }
  return sum;
}

// Angular momentum about the center of mass in world axes, kg m^2/s.
Vec3 angular_momentum(const Solver& solver, int particle) {
  const ParticleState& state = solver.particles();
  const Quat& q = state.orientation[index(particle)];
  const Vec3 w = q.conjugate() * state.angular_velocity[index(particle)];
  return q * Vec3(shape_of(solver.model(), particle).inertia.cwiseProduct(w));
}

}  // namespace

std::string body_name(const Model& model, int body) {
  if (is_particle(model, body)) return fmt::format("particle {}", body);
  return boundary_of(model, body).name;
}

int find_body(const Model& model, const std::string& text, const std::string& option) {
  for (std::size_t b = 0; b < model.boundaries.size(); ++b)
    if (model.boundaries[b].name == text) return static_cast<int>(model.particles.size() + b);
  int id = -1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, id);
  const int count = static_cast<int>(model.particles.size());
  if (error == std::errc() && stop == end && id >= 0 && id < count) return id;
  std::string names;
  for (const Boundary& b : model.boundaries) names += fmt::format(", \"{}\"", b.name);
  throw InputError(fmt::format("{} {}: no such body; expected a particle 0 ... {}{}", option, text,
                               count - 1, names.empty() ? "" : " or a boundary" + names));
}

double smallest_extent(const Model& model, const Contact& contact) {
  double least = std::numeric_limits<double>::infinity();
  for (const int body : {contact.a, contact.b})
    if (is_particle(model, body)) least = std::min(least, shape_of(model, body).box.minCoeff());
  return least;
}

bool ContactSelection::includes(const Contact& c) const {
  if (body < 0) return true;
  if (other < 0) return c.a == body || c.b == body;
  return (c.a == body && c.b == other) || (c.a == other && c.b == body);
}

double ContactView::friction_mobilization() const {
  return contact.friction_limit > 0 ? contact.friction.norm() / contact.friction_limit : 0;
}

std::vector<ContactView> select_contacts(const Solver& solver, const ContactSelection& choice) {
  std::vector<ContactView> out;
  for (Contact& c : solver.contacts()) {
    if (!choice.includes(c)) continue;
    const bool turn = choice.body >= 0 && c.a != choice.body;
    out.push_back({turn ? turned(std::move(c)) : std::move(c)});
  }
  std::stable_sort(out.begin(), out.end(), [](const ContactView& x, const ContactView& y) {
    return std::pair(x.contact.a, x.contact.b) < std::pair(y.contact.a, y.contact.b);
  });
  return out;
}

namespace {

// Of contacts and bonds.
Solver::Load all_on(const Solver& solver, const std::vector<Contact>& contacts, int particle) {
  Solver::Load sum = sum_on(contacts, particle);
  const std::vector<Bond>& bonds = solver.model().bonds;
  for (std::size_t k = 0; k < bonds.size(); ++k) {
    if (bonds[k].a != particle && bonds[k].b != particle) continue;
    const BeamLoad load = solver.bond(static_cast<int>(k)).load;
    const bool is_a = bonds[k].a == particle;
    sum.force += is_a ? load.force : Vec3(-load.force);
    sum.moment += is_a ? load.moment_a : load.moment_b;
  }
  return sum;
}

}  // namespace

ForceBalance force_balance(const Solver& solver, int particle) {
  const Model& model = solver.model();
  const double mass = shape_of(model, particle).mass, dt = model.timestep;
  Solver next(unowned(model), 0);
  next.restore(solver.save());
  next.step();
  const std::vector<Contact> contacts = solver.contacts();
  const Solver::Load now = all_on(solver, contacts, particle);
  const Solver::Load then = all_on(next, next.contacts(), particle);
  ForceBalance b;
  b.contacts = now.force;
  b.moment = now.moment;
  b.weight = mass * model.gravity;
  b.sum_mismatch = (now.force - solver.load(particle).force).norm();
  const Vec3 faster =
      next.particles().velocity[index(particle)] - solver.particles().velocity[index(particle)];
  b.mass_acceleration = mass / dt * faster;
  b.force_error = (b.mass_acceleration - 0.5 * (now.force + then.force) - b.weight).norm();
  const Vec3 turning = angular_momentum(next, particle) - angular_momentum(solver, particle);
  b.moment_error = (turning / dt - 0.5 * (now.moment + then.moment)).norm();
  b.scale = b.weight.norm();
  for (const Contact& c : contacts) {
    if (c.a != particle && c.b != particle) continue;
    b.scale += c.force.norm();
    b.moment_scale += (c.a == particle ? c.moment_a : c.moment_b).norm();
  }
  return b;
}

ContactSummary summarize_contacts(const Solver& solver, std::size_t listed) {
  const Model& model = solver.model();
  ContactSummary s;
  std::vector<std::size_t> neighbors(model.particles.size(), 0);
  std::vector<double> forces, overlaps;
  std::pair<int, int> last(-1, -1);
  std::vector<Contact> bearing;
  std::size_t with_friction = 0;
  for (Contact& c : solver.contacts()) {
    if (!(c.normal_force > 0)) {
      ++s.non_touching_patches;
      continue;
    }
    ++s.patches;
    s.sliding += c.sliding;
    for (const ContactPointInfo& spot : c.points) s.points += spot.force > 0;
    forces.push_back(c.normal_force);
    overlaps.push_back(c.overlap);
    if (c.friction_limit > 0) {
      s.friction_mobilization += c.friction.norm() / c.friction_limit;
      ++with_friction;
    }
    if (std::pair(c.a, c.b) != last) {
      last = {c.a, c.b};
      ++s.pairs;
      ++neighbors[index(c.a)];
      if (is_particle(model, c.b)) ++neighbors[index(c.b)];
    }
    bearing.push_back(std::move(c));
  }
  const std::vector<Presence>& presence = solver.particles().presence;
  for (std::size_t i = 0; i < presence.size(); ++i) {
    if (presence[i] != Presence::present) continue;
    ++s.present;
    s.unsupported += neighbors[i] == 0;
    s.neighbors += static_cast<double>(neighbors[i]);
  }
  if (s.present > 0) s.neighbors /= static_cast<double>(s.present);
  if (with_friction > 0) s.friction_mobilization /= static_cast<double>(with_friction);
  std::sort(forces.begin(), forces.end());
  std::sort(overlaps.begin(), overlaps.end());
  for (double f : forces) s.force_mean += f / static_cast<double>(forces.size());
  s.force_median = quantile(forces, 0.5, 0);
  s.force_p99 = quantile(forces, 0.99, 0);
  s.force_largest = quantile(forces, 1, 0);
  s.overlap_median = quantile(overlaps, 0.5, 0);
  s.overlap_p99 = quantile(overlaps, 0.99, 0);
  s.overlap_largest = quantile(overlaps, 1, 0);
  const auto top = [&](auto value) {
    std::stable_sort(bearing.begin(), bearing.end(),
                     [&](const Contact& x, const Contact& y) { return value(x) > value(y); });
    const std::size_t n = std::min(listed, bearing.size());
    return std::vector<Contact>(bearing.begin(), bearing.begin() + static_cast<std::ptrdiff_t>(n));
  };
  s.most_loaded = top([](const Contact& c) { return c.normal_force; });
  s.deepest = top([](const Contact& c) { return c.overlap; });
  return s;
}

ContactSnapshot take_snapshot(const Solver& solver, const ContactSelection& choice,
                              std::size_t listed, const std::string& option) {
  const Model& model = solver.model();
  ContactSnapshot now;
  now.time = solver.time();
  now.step = solver.steps();
  now.particles = solver.particles();
  now.boundaries = solver.boundaries();
  for (const int body : {choice.body, choice.other}) {
    if (body < 0 || !is_particle(model, body)) continue;
    const Presence presence = now.particles.presence[index(body)];
    if (presence != Presence::present)
      throw InputError(fmt::format(
          "{} {}: is not there at {:.6g} s, it {}; expected a particle that is present", option,
          body, now.time, presence == Presence::removed ? "has left" : "is still to come"));
  }
  for (std::size_t i = 0; i < model.particles.size(); ++i)
    now.shape_orientation.push_back(solver.shape_orientation(static_cast<int>(i)));
  now.contacts = select_contacts(solver, choice);
  if (choice.body >= 0 && is_particle(model, choice.body))
    now.balance = force_balance(solver, choice.body);
  now.summary = summarize_contacts(solver, listed);
  return now;
}

void write_contacts_csv(const Model& model, const std::vector<ContactView>& contacts,
                        const std::string& file) {
  OutputFile out(file);
  out << "body,neighbor,patch,normal_x,normal_y,normal_z,normal_force_N,friction_N,"
         "friction_limit_N,sliding,point,x_m,y_m,z_m,gap_m,stiffness_fraction,force_N,area_m2\n";
  for (const ContactView& view : contacts) {
    const Contact& c = view.contact;
    for (std::size_t k = 0; k < c.points.size(); ++k) {
      const ContactPointInfo& p = c.points[k];
      out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                         encode::csv_field(body_name(model, c.a)),
                         encode::csv_field(body_name(model, c.b)), c.patch, c.normal.x(),
                         c.normal.y(), c.normal.z(), c.normal_force, c.friction.norm(),
                         c.friction_limit, c.sliding ? 1 : 0, k, p.position.x(), p.position.y(),
                         p.position.z(), p.gap, p.stiffness_fraction, p.force, p.area);
    }
  }
  out.commit();
}

}  // namespace firn
