#include "solver/model/bond_checks.h"

#include <fmt/format.h>

#include <vector>

namespace firn {

void check_bonds(const Model& model) {
  for (const BeamLaw& law : model.beams) {
    const auto require = [&](double value, const char* what) {
      if (!(value > 0))
        throw InputError(
            fmt::format("bonds.{}: {} is {}; expected more than zero", law.name, what, value));
    };
    require(law.length, "length");
    require(law.young_modulus, "Young's modulus");
    require(law.shear_modulus, "shear modulus");
    require(law.tensile_strength, "tensile strength");
    require(law.shear_strength, "shear strength");
    require(law.section.area, "cross-section");
    require(law.lifetime, "lifetime");
    if (!(law.damping_ratio >= 0))
      throw InputError(fmt::format("bonds.{}: damping ratio is negative", law.name));
  }
  const int particles = static_cast<int>(model.particles.size()),
            bodies = particles + static_cast<int>(model.boundaries.size()),
            laws = static_cast<int>(model.beams.size());
  for (const Bond& b : model.bonds) {
    const bool fits = b.a >= 0 && b.a < particles && b.b >= 0 && b.b < bodies && b.a != b.b &&
                      b.law >= 0 && b.law < laws;
    if (!fits)
      throw InputError(fmt::format(
          "bonds: {} and {} are not a particle and another body of the case", b.a, b.b));
    if (!(b.strength > 0))
      throw InputError(fmt::format("bonds.{}: strength factor is {}; expected more than zero",
                                   model.beams[b.law].name, b.strength));
    if (is_particle(model, b.b)) continue;
    const Boundary& boundary = boundary_of(model, b.b);
    if (boundary.frame >= 0 || !boundary.motions.empty())
      throw InputError(
          fmt::format("bonds.{}: boundary \"{}\" moves; expected one without motion frame and "
                      "motions",
                      model.beams[b.law].name, boundary.name));
  }
}

std::string ends_text(const Model& model, const Bond& bond) {
  if (is_particle(model, bond.b)) return fmt::format("particles {} and {}", bond.a, bond.b);
  return fmt::format("particle {} and boundary \"{}\"", bond.a, boundary_of(model, bond.b).name);
}

FastestBond fastest_bond(const Model& model) {
  std::vector<int> bonds(model.particles.size() + model.boundaries.size(), 0);
  for (const Bond& b : model.bonds) {
    ++bonds[b.a];
    ++bonds[b.b];
  }
  FastestBond fastest;
  for (std::size_t k = 0; k < model.bonds.size(); ++k) {
    const Bond& b = model.bonds[k];
    const double frequency =
        highest_frequency(model.beams[b.law], b, shape_of(model, b.a), 1.0 / bonds[b.a],
                          bonded_shape(model, b.b), 1.0 / bonds[b.b]);
    if (frequency > fastest.frequency) fastest = {static_cast<int>(k), frequency};
  }
  return fastest;
}

}  // namespace firn
