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
    if (!(law.damping_ratio >= 0))
      throw InputError(fmt::format("bonds.{}: damping ratio is negative", law.name));
  }
  const int particles = static_cast<int>(model.particles.size()),
            laws = static_cast<int>(model.beams.size());
  for (const Bond& b : model.bonds) {
    const bool fits = b.a >= 0 && b.a < particles && b.b >= 0 && b.b < particles && b.a != b.b &&
                      b.law >= 0 && b.law < laws;
    if (!fits)
      throw InputError(fmt::format("bonds: {} and {} are not two particles of the case", b.a, b.b));
  }
}

FastestBond fastest_bond(const Model& model) {
  std::vector<int> bonds(model.particles.size(), 0);
  for (const Bond& b : model.bonds) {
    ++bonds[b.a];
    ++bonds[b.b];
  }
  FastestBond fastest;
  for (std::size_t k = 0; k < model.bonds.size(); ++k) {
    const Bond& b = model.bonds[k];
    const double frequency = highest_frequency(
        model.beams[b.law], b, model.shapes[model.particles[b.a].shape], 1.0 / bonds[b.a],
        model.shapes[model.particles[b.b].shape], 1.0 / bonds[b.b]);
    if (frequency > fastest.frequency) fastest = {static_cast<int>(k), frequency};
  }
  return fastest;
}

}  // namespace firn
