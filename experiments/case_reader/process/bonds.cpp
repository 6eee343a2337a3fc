#include "experiments/case_reader/process/bonds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <unordered_map>
#include <utility>

#include "experiments/analysis/random_stream.h"
#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/case_reader/process/insertion.h"
#include "experiments/case_reader/process/sintering.h"
#include "experiments/text/units.h"
#include "firn/distance.h"
#include "firn/solver.h"

namespace firn {
namespace {

// A body as it stands when its bridge freezes.
struct Standing {
  int body = 0;  // particle, or number of particles + boundary
  BodyInMotion at;
};
using Couple = std::array<Standing, 2>;

Standing supported_particle(const Model& model, int particle, const Vec3& position,
                            const Quat& orientation) {
  const Quat body = (orientation * shape_of(model, particle).shape_from_body).normalized();
  return {particle, {position, Vec3::Zero(), Vec3::Zero(), body}};
}

// The bodies of an inlet, batch by batch in the order of its places.
struct InletBodies {
  std::size_t joined = 0;  // bodies in a row: the pieces of a place, else the places of a batch
  std::vector<Standing> bodies;
};
InletBodies read_inlet_bodies(const TomlTable& t, const Case& c) {
  const std::string name = t.string("inlet");
  const auto source = std::ranges::find(c.inlets, name, &Inlet::name);
  if (source == c.inlets.end())
    t.fail("inlet", fmt::format("\"{}\" is not an inlet of the case; expected the name of one of "
                                "[[inlets]]",
                                name));
  const std::size_t pieces = source->pieces.size();
  InletBodies inlet{pieces > 1 ? pieces : source->positions.size(), {}};
  int particle = first_inlet_particles(c)[static_cast<std::size_t>(source - c.inlets.begin())];
  for (int batch = 0; batch < source->batches; ++batch) {
    for (std::size_t i = 0; i < source->batch_size(); ++i, ++particle) {
      const InletPose pose = inlet_pose(*source, i, particle, c.seed);
      inlet.bodies.push_back(
          supported_particle(c.model, particle, pose.position, pose.orientation));
    }
  }
  return inlet;
}

std::vector<Couple> neighbors_in_inlet(const TomlTable& t, const Case& c) {
  const InletBodies inlet = read_inlet_bodies(t, c);
  if (inlet.joined < 2)
    t.fail("inlet", "places one body at a time; expected several, to be joined");
  std::vector<Couple> couples;
  for (std::size_t k = 1; k < inlet.bodies.size(); ++k)
    if (k % inlet.joined != 0) couples.push_back({inlet.bodies[k - 1], inlet.bodies[k]});
  return couples;
}

// The bodies of [[particles]] that a key of the table selects by their numbers, or with the key
// "tags" by tags that one of them carries each.
class PlacedBodies {
 public:
  PlacedBodies(const TomlTable& t, const Case& c, std::string_view key)
      : table_(t), model_(c.model), key_(key) {
    for (const Case::InitialParticle& p : c.placed)
      bodies_.emplace(by_tag() ? model_.particles[index(p.particle)].tag : p.particle, &p);
  }

  Standing find(int number) const {
    const std::size_t count = bodies_.count(number);
    if (count != 1) {
      const std::string holders = count == 0 ? "no body" : fmt::format("{} bodies", count);
      table_.fail(key_,
                  fmt::format("{} of [[particles]] {} the {} {}; expected exactly one", holders,
                              count == 0 ? "has" : "have", by_tag() ? "tag" : "number", number));
    }
    const Case::InitialParticle& p = *bodies_.find(number)->second;
    return supported_particle(model_, p.particle, p.position, p.orientation);
  }

 private:
  bool by_tag() const { return key_ == "tags"; }

  const TomlTable& table_;
  const Model& model_;
  std::string_view key_;
  std::unordered_multimap<int, const Case::InitialParticle*> bodies_;
};

std::vector<Couple> couples_of_pairs(const TomlTable& t, const Case& c, std::string_view key) {
  const PlacedBodies bodies(t, c, key);
  std::vector<Couple> couples;
  std::set<std::pair<int, int>> joined;
  for (const auto& [a, b] : t.integer_pairs(key)) {
    if (a == b) t.fail(key, fmt::format("joins {} with itself; expected two bodies", a));
    if (!joined.insert(std::minmax(a, b)).second)
      t.fail(key, fmt::format("joins {} and {} twice; expected each pair once", a, b));
    couples.push_back({bodies.find(a), bodies.find(b)});
  }
  return couples;
}

std::vector<Couple> read_couples(const TomlTable& t, const Case& c) {
  if (t.has("inlet")) return neighbors_in_inlet(t, c);
  return couples_of_pairs(t, c, t.has("pairs") ? "pairs" : "tags");
}

// The bodies that are joined to a boundary.
std::vector<Standing> read_single_bodies(const TomlTable& t, const Case& c) {
  if (t.has("inlet")) return read_inlet_bodies(t, c).bodies;
  const PlacedBodies bodies(t, c, "particles");
  std::vector<Standing> out;
  std::set<int> joined;
  for (const int number : t.integers("particles")) {
    if (!joined.insert(number).second)
      t.fail("particles", fmt::format("joins {} twice; expected each body once", number));
    out.push_back(bodies.find(number));
  }
  if (out.empty()) t.fail("particles", "is empty; expected numbers of bodies of [[particles]]");
  return out;
}

// A bond before it is made: about a place, along an axis from the first body to the second.
struct PlannedBond {
  Couple bodies;
  Vec3 middle = Vec3::Zero(), axis = Vec3::Zero(),
       up = Vec3::Zero();  // m, world; directions of any length
};

// m, from a point in body axes to the surface; 0 within.
double distance_to(const std::vector<ConvexPart>& parts, const Vec3& point) {
  double least = std::numeric_limits<double>::infinity();
  const ConvexPart there = sphere_part(point, 0);
  for (const ConvexPart& part : parts)
    least = std::min(least, core_distance(part, there, Pose{}) - part.radius);
  return std::max(0.0, least);
}
double distance_to(const Model& model, int body, const Vec3& point) {
  if (is_particle(model, body)) return distance_to(shape_of(model, body).parts, point);
  const Boundary& boundary = boundary_of(model, body);
  return boundary.kind == Boundary::Kind::plane ? std::max(0.0, point.z())
                                                : distance_to(boundary.parts, point);
}

// The middle of the contact; if it lies in the air, such as between the two rims of a dish, the
// deepest point. m, world.
Vec3 neck_position(const Model& model, const Contact& contact, const Couple& bodies) {
  constexpr double kRoundingError = 1e-9;  // m
  const bool in_the_air = std::ranges::any_of(bodies, [&](const Standing& body) {
    const Vec3 point = body.at.orientation.conjugate() * (contact.position - body.at.position);
    return distance_to(model, body.body, point) > kRoundingError;
  });
  if (!in_the_air) return contact.position;
  return std::ranges::min_element(contact.points, {}, &ContactPointInfo::gap)->position;
}

// The contacts of the bodies that are there at the start, as they stand. The solver that finds them
// has no boundaries, and its one step is too short to move a body.
std::vector<PlannedBond> bonds_at_contacts(const TomlTable& t, const Case& c) {
  constexpr double kStep = 1e-12;  // s
  Model bodies;
  bodies.gravity = Vec3::Zero();
  bodies.timestep = kStep;
  bodies.materials = c.model.materials;
  bodies.interactions = c.model.interactions;
  bodies.shapes = c.model.shapes;
  bodies.particles = c.model.particles;
  bodies.numerics = c.model.numerics;
  bodies.numerics.overlap_limit = std::numeric_limits<double>::max();  // checked by the run
  Solver solver(std::move(bodies));
  std::unordered_map<int, Standing> at;
  for (const Case::InitialParticle& p : c.placed) {
    solver.insert(p.particle, p.position, p.orientation, Vec3::Zero(), Vec3::Zero());
    at.emplace(p.particle, supported_particle(c.model, p.particle, p.position, p.orientation));
  }
  solver.step();
  std::vector<PlannedBond> planned;
  for (const Contact& contact : solver.contacts()) {
    if (!(contact.overlap > 0)) continue;
    const Couple bodies = {at.at(contact.a), at.at(contact.b)};
    planned.push_back({bodies, neck_position(c.model, contact, bodies), contact.normal,
                       contact.normal.unitOrthogonal()});
  }
  if (planned.empty())
    t.fail("contacts",
           "no two bodies touch at the start; expected bodies of [initial_state] or "
           "[[particles]] that do");
  return planned;
}

// Exactly one key selects the bodies.
void check_selection(const TomlTable& t) {
  std::vector<std::string_view> ways = {"inlet", "pairs", "tags", "contacts", "initial_state"};
  if (t.has("boundary")) {
    ways = {"inlet", "particles"};
    for (const char* key : {"pairs", "tags", "contacts", "initial_state"})
      if (t.has(key))
        t.fail(key, "is not a key of bonds to a boundary; expected inlet or particles");
    if (t.has("mold"))
      t.fail("mold", "is not a key of bonds to a boundary; expected a radius, or width and height");
  } else {
    for (const char* key : {"particles", "direction"})
      if (t.has(key)) t.fail(key, "is a key of bonds to a boundary; expected boundary with it");
  }
  const auto given = std::ranges::count_if(ways, [&](std::string_view key) { return t.has(key); });
  if (given != 1)
    t.fail("", fmt::format("has {} keys that select the bodies; expected exactly one of {}", given,
                           comma_list(ways)));
}

bool at_contacts(const TomlTable& t) {
  if (!t.has("contacts")) return false;
  if (!t.boolean("contacts", true)) t.fail("contacts", "is false; expected true, or no such key");
  for (const char* key : {"position", "height_direction", "mold", "width", "height"})
    if (t.has(key))
      t.fail(key,
             "is not a key of bonds at contacts, which are round; expected a radius or a storage "
             "time");
  return true;
}

// The bonds of the earlier run with the name of the table.
std::vector<Case::InitialBond> read_taken_bonds(const TomlTable& t, const Case& c) {
  if (!t.boolean("initial_state", true))
    t.fail("initial_state", "is false; expected true, or no such key");
  for (const char* key : {"position", "height_direction"})
    if (t.has(key))
      t.fail(key, "is not a key of bonds of [initial_state], which stay where they are");
  if (t.has("weibull_modulus"))
    t.fail("weibull_modulus",
           "is not a key of bonds of [initial_state], which keep their scatter; expected no such "
           "key");
  std::vector<Case::InitialBond> bonds;
  std::ranges::copy_if(c.initial_bonds, std::back_inserter(bonds),
                       [&](const Case::InitialBond& one) { return one.name == t.string("name"); });
  if (bonds.empty())
    t.fail("initial_state", fmt::format("no bond \"{}\" of [initial_state] holds; expected the "
                                        "name of bonds that do",
                                        t.string("name")));
  if (!t.has("length") && !t.has("mold"))
    t.set("length", si_text(bonds.front().length, dimension::length));
  return bonds;
}

// With another length the bond would be strained in the pose in which it was made.
void check_same_length(const TomlTable& t, const BeamLaw& law, const Case::InitialBond& bond) {
  constexpr double kSame = 1e-9;  // relative
  if (std::abs(law.length - bond.length) <= kSame * bond.length) return;
  t.fail(t.has("length") ? "length" : "",
         fmt::format("is {:.6g} mm long, and the bonds of [initial_state] are {:.6g} mm long; "
                     "expected the same",
                     1e3 * law.length, 1e3 * bond.length));
}

// The ice in the channel through a mold's webs: section and length.
struct Channel {
  double width = 0, height = 0, length = 0;  // m
};
Channel channel_of(const TomlTable& root, const TomlTable& t) {
  const std::string name = t.string("mold");
  for (const TomlTable& b : root.tables("boundaries")) {
    if (b.string("name") != name || b.string("kind") != "mold") continue;
    Channel channel;
    channel.width = b.quantity("notch_width", dimension::length, Sign::non_negative);
    channel.height = b.quantity("notch_depth", dimension::length, Sign::non_negative);
    if (!(channel.width > 0 && channel.height > 0))
      t.fail("mold", fmt::format("\"{}\" has no channel between its cavities; expected one with a "
                                 "notch",
                                 name));
    // The web at the water line.
    channel.length = b.quantity("pitch", dimension::length, Sign::positive) -
                     read_crescent(b).parameters.width -
                     2 * b.quantity("clearance", dimension::length, Sign::non_negative);
    return channel;
  }
  t.fail("mold",
         fmt::format("\"{}\" is not a mold; expected the name of a boundary of that kind", name));
}

// Given, or grown in store.
double read_neck_radius(const TomlTable& t) {
  if (t.has("radius") == t.has("storage_time"))
    t.fail("radius",
           "expected either a radius, or a storage_time, temperature and "
           "curvature_radius");
  if (t.has("radius")) {
    for (const char* key : {"temperature", "curvature_radius"})
      if (t.has(key)) t.fail(key, "is given together with a radius; expected one of the two");
    return t.quantity("radius", dimension::length, Sign::positive);
  }
  constexpr double kColdest = kIcePoint - 100;  // K
  const StorageConditions storage{
      t.quantity("storage_time", dimension::time, Sign::positive),
      t.quantity("temperature", dimension::temperature, Sign::positive),
      t.quantity("curvature_radius", dimension::length, Sign::positive)};
  if (!(storage.temperature >= kColdest && storage.temperature < kIcePoint))
    t.fail("temperature", fmt::format("is {:.4g} degC; expected one from -100 degC to below 0 degC",
                                      storage.temperature - kIcePoint));
  const double radius = sintered_neck_radius(storage);
  if (radius > 0.5 * storage.curvature_radius)
    t.fail("storage_time",
           fmt::format("necks grow to {:.4g} mm, beyond half of the curvature_radius, where their "
                       "law does not hold; expected a shorter time, a lower temperature, a larger "
                       "curvature_radius, or a radius in place of the three",
                       1e3 * radius));
  return radius;
}

// As long as to give way by a normal force as the circle of this radius between two half-spaces
// does: E a / (1 - nu^2) = E pi a^2 / L (Johnson, Contact Mechanics (1985), equation (3.32)).
void read_neck(const TomlTable& t, double poisson_ratio, BeamLaw& law) {
  const double radius = read_neck_radius(t);
  law.section = round_section(radius, poisson_ratio);
  law.length = t.has("length") ? t.quantity("length", dimension::length, Sign::positive)
                               : std::numbers::pi * radius * (1 - poisson_ratio * poisson_ratio);
}

void read_geometry(const TomlTable& root, const TomlTable& t, double poisson_ratio, BeamLaw& law) {
  if (t.has("contacts")) return read_neck(t, poisson_ratio, law);
  for (const char* key : {"storage_time", "temperature", "curvature_radius"})
    if (t.has(key)) t.fail(key, "is a key of bonds at contacts; expected contacts = true with it");
  const auto length = [&](std::string_view key) {
    return t.quantity(key, dimension::length, Sign::positive);
  };
  Channel channel;
  if (t.has("mold")) {
    for (const char* key : {"radius", "width", "height"})
      if (t.has(key))
        t.fail(key, "is given together with a mold, which has it; expected one of the two");
    channel = channel_of(root, t);
    law.length = t.has("length") ? length("length") : channel.length;
  } else {
    if (t.has("radius") == t.has("width"))
      t.fail("width", "expected either width and height, or a radius, or a mold");
    if (!t.has("radius")) channel = {length("width"), length("height"), 0};
    law.length = length("length");
  }
  law.section = t.has("radius") ? round_section(length("radius"), poisson_ratio)
                                : rectangular_section(channel.width, channel.height, poisson_ratio);
}

// Material constants that are left out are those of the bodies.
BeamLaw read_law(const TomlTable& root, const TomlTable& t, const Material& material) {
  BeamLaw law;
  law.name = t.string("name");
  law.young_modulus = t.has("young_modulus")
                          ? t.quantity("young_modulus", dimension::pressure, Sign::positive)
                          : material.young_modulus;
  if (!(law.young_modulus > 0))
    t.fail("young_modulus", fmt::format("missing, and material \"{}\" has none; expected a "
                                        "pressure, such as \"9 GPa\"",
                                        material.name));
  const double poisson_ratio =
      t.has("poisson_ratio") ? t.number("poisson_ratio") : material.poisson_ratio;
  if (!(poisson_ratio > -1 && poisson_ratio <= 0.5))
    t.fail("poisson_ratio",
           fmt::format("is {}; expected a number above -1 and up to 0.5", poisson_ratio));
  law.shear_modulus = t.has("shear_modulus")
                          ? t.quantity("shear_modulus", dimension::pressure, Sign::positive)
                          : law.young_modulus / (2 * (1 + poisson_ratio));
  read_geometry(root, t, poisson_ratio, law);
  law.lifetime = t.optional_quantity("lifetime", dimension::time, Sign::positive)
                     .value_or(std::numeric_limits<double>::infinity());
  law.tensile_strength = t.quantity("tensile_strength", dimension::pressure, Sign::positive);
  law.shear_strength = t.quantity("shear_strength", dimension::pressure, Sign::positive);
  law.damping_ratio = t.number("damping_ratio", 0.05);
  if (!(law.damping_ratio >= 0 && law.damping_ratio <= 1))
    t.fail("damping_ratio", fmt::format("is {}; expected a number from 0 to 1", law.damping_ratio));
  return law;
}

std::string body_text(const Model& model, int body) {
  return is_particle(model, body) ? fmt::format("particle {}", body)
                                  : fmt::format("boundary \"{}\"", boundary_of(model, body).name);
}
// "the bridge from particle 0 to 1", "the bridge from particle 0 to boundary "mold"".
std::string bridge_text(const Model& model, int a, int b) {
  return fmt::format("the bridge from particle {} to {}", a,
                     is_particle(model, b) ? fmt::format("{}", b) : body_text(model, b));
}

// Refuses a bond whose section does not reach both bodies.
void check_reach(const TomlTable& t, const Model& model, const Bond& bond, const BeamLaw& law) {
  const double reach = 2 * std::max(law.section.half_width, law.section.half_height);
  const auto check = [&](int body, const Vec3& end) {
    const double off = distance_to(model, body, end);
    if (off <= reach) return;
    t.fail("length", fmt::format("{} ends {:.4g} mm off {}; expected neighbors, a bridge that "
                                 "comes to within {:.4g} mm of both",
                                 bridge_text(model, bond.a, bond.b), 1e3 * off,
                                 body_text(model, body), 1e3 * reach));
  };
  check(bond.a, bond.end_a);
  check(bond.b, bond.end_b);
}

// `middle` and `axis`: world; `position` (m, from `middle`) and `height`: shape axes of the first
// body.
PlannedBond bond_between(const TomlTable& t, const Model& model, const Couple& couple,
                         const Vec3& middle, const Vec3& axis, const Vec3& position,
                         const Vec3& height) {
  const Standing& a = couple[0];
  const Quat shape_a = a.at.orientation * shape_of(model, a.body).shape_from_body.conjugate();
  const Vec3 up = shape_a * height;
  if (!(axis.norm() > 0))
    t.fail("",
           fmt::format("{} has no direction: both have the same center of mass; expected bodies "
                       "at different places",
                       bridge_text(model, a.body, couple[1].body)));
  if (!(axis.cross(up).norm() > 0.1 * axis.norm()))
    t.fail("height_direction", fmt::format("runs along {}; expected a direction across it, in "
                                           "shape axes of the first",
                                           bridge_text(model, a.body, couple[1].body)));
  return {couple, middle + shape_a * position, axis, up};
}

// The number in the model of a boundary that nothing moves or removes.
int read_fixed_boundary(const TomlTable& t, const Case& c) {
  const int number = boundary_index(t, "boundary", t.string("boundary"), c.model.boundaries);
  const Boundary& boundary = c.model.boundaries[index(number)];
  const auto refuse = [&](const std::string& why) {
    t.fail("boundary",
           fmt::format("\"{}\" {}; expected one without motion frame and motions, which no stage "
                       "moves or removes",
                       boundary.name, why));
  };
  if (boundary.frame >= 0)
    refuse(
        fmt::format("is on the motion frame \"{}\"", c.model.frames[index(boundary.frame)].name));
  if (!boundary.motions.empty()) refuse("has motions");
  for (const Stage& stage : c.stages) {
    if (std::ranges::find(stage.motions, number, &Stage::StartedMotion::boundary) !=
        stage.motions.end())
      refuse(fmt::format("is moved by the stage \"{}\"", stage.name));
    if (std::ranges::find(stage.remove, boundary.name) != stage.remove.end())
      refuse(fmt::format("is removed by the stage \"{}\"", stage.name));
  }
  return number;
}

std::vector<PlannedBond> bonds_to_boundary(const TomlTable& t, const Case& c) {
  const Model& model = c.model;
  const int number = read_fixed_boundary(t, c);
  const Boundary& boundary = model.boundaries[index(number)];
  const Standing wall = {static_cast<int>(model.particles.size()) + number,
                         {boundary.origin, Vec3::Zero(), Vec3::Zero(), boundary.orientation}};
  const Vec3 position = t.vector("position", dimension::length, "0 0 0 m");
  if (!t.has("direction")) {
    if (!(model.gravity.norm() > 0))
      t.fail("direction",
             "missing in a case without gravity; expected the direction from a body to the "
             "boundary, [x, y, z]");
    const Vec3 down = model.gravity.normalized();
    t.set("direction", toml::array{down.x(), down.y(), down.z()});
  }
  const Vec3 direction = t.direction("direction");
  if (!t.has("height_direction")) t.set("height_direction", toml::array{0, 1, 0});
  const Vec3 height = t.direction("height_direction");
  std::vector<PlannedBond> planned;
  for (const Standing& body : read_single_bodies(t, c))
    planned.push_back(
        bond_between(t, model, {body, wall}, body.at.position, direction, position, height));
  return planned;
}

std::vector<PlannedBond> read_planned_bonds(const TomlTable& t, const Case& c) {
  if (t.has("boundary")) return bonds_to_boundary(t, c);
  if (at_contacts(t)) return bonds_at_contacts(t, c);
  const std::vector<Couple> couples = read_couples(t, c);
  if (couples.empty()) t.fail("pairs", "is empty; expected pairs of bodies");
  const Vec3 position = t.vector("position", dimension::length, "0 0 0 m");
  if (!t.has("height_direction")) t.set("height_direction", toml::array{0, 0, 1});
  const Vec3 height = t.direction("height_direction");
  std::vector<PlannedBond> planned;
  planned.reserve(couples.size());
  for (const Couple& couple : couples) {
    const Vec3 &a = couple[0].at.position, &b = couple[1].at.position;
    planned.push_back(bond_between(t, c.model, couple, 0.5 * (a + b), b - a, position, height));
  }
  return planned;
}

// Strengths over their mean, by Weibull's distribution (J. Appl. Mech. 18 (1951) 293). Each bond
// has a separate random stream.
class StrengthScatter {
 public:
  StrengthScatter(const TomlTable& t, std::uint64_t seed) : seed_(seed) {
    if (!t.has("weibull_modulus")) return;
    constexpr double kLeast = 0.5, kMost = 1000;  // standard deviations of 2.2 and 0.0013
    modulus_ = t.number("weibull_modulus");
    if (!(modulus_ >= kLeast && modulus_ <= kMost))
      t.fail("weibull_modulus",
             fmt::format("is {}; expected a number from {} to {}", modulus_, kLeast, kMost));
  }
  double of(std::size_t bond) const {
    constexpr std::uint64_t kStream = ~std::uint64_t{1};
    if (modulus_ == 0) return 1;
    RandomStream random(seed_, kStream, bond);
    return std::pow(-std::log1p(-random.uniform()), 1 / modulus_) / std::tgamma(1 + 1 / modulus_);
  }

 private:
  std::uint64_t seed_;
  double modulus_ = 0;  // 0: no scatter
};

}  // namespace

void read_bonds(const TomlTable& root, Case& c) {
  Model& model = c.model;
  std::size_t left = c.initial_bonds.size();
  for (const TomlTable& t : root.tables("bonds")) {
    t.allow({"name",
             "enabled",
             "inlet",
             "pairs",
             "tags",
             "contacts",
             "initial_state",
             "boundary",
             "particles",
             "direction",
             "mold",
             "width",
             "height",
             "radius",
             "length",
             "position",
             "height_direction",
             "storage_time",
             "temperature",
             "curvature_radius",
             "young_modulus",
             "poisson_ratio",
             "shear_modulus",
             "tensile_strength",
             "shear_strength",
             "weibull_modulus",
             "damping_ratio",
             "lifetime"});
    check_selection(t);
    std::vector<PlannedBond> planned;
    std::vector<Case::InitialBond> taken;
    if (t.has("initial_state"))
      taken = read_taken_bonds(t, c);
    else
      planned = read_planned_bonds(t, c);
    const int first = taken.empty() ? planned.front().bodies.front().body : taken.front().bond.a;
    const int material = shape_of(model, first).material;
    const BeamLaw law = read_law(root, t, model.materials[index(material)]);
    const StrengthScatter scatter(t, c.seed);
    const bool enabled = t.boolean("enabled", true);
    if (std::ranges::find(model.beams, law.name, &BeamLaw::name) != model.beams.end())
      t.fail("name", fmt::format("\"{}\" is taken already; expected another name", law.name));
    if (!enabled) continue;
    model.beams.push_back(law);
    const int number = static_cast<int>(model.beams.size()) - 1;
    for (const auto& [bodies, middle, axis, up] : planned) {
      const auto& [a, b] = bodies;
      model.bonds.push_back(
          make_bond(a.body, b.body, number, law.length, a.at, b.at, middle, axis, up));
      model.bonds.back().strength = scatter.of(model.bonds.size() - 1);
      // Bodies in contact need no bridge that reaches them.
      if (!t.has("contacts")) check_reach(t, model, model.bonds.back(), law);
    }
    left -= taken.size();
    for (const Case::InitialBond& one : taken) {
      check_same_length(t, law, one);
      model.bonds.push_back(one.bond);
      model.bonds.back().law = number;
    }
  }
  if (left > 0) c.start += fmt::format("; {} bonds that held there are left behind", left);
}

}  // namespace firn
