#include "solver/state/bond_workspace.h"

namespace firn {

namespace {

BeamDampers dampers_of(const Model& model, const Bond& bond) {
  const BeamLaw& law = model.beams[bond.law];
  const Shape &a = shape_of(model, bond.a), &b = bonded_shape(model, bond.b);
  const BeamSprings c = damping_of(law, bond, a, b);
  BeamDampers out;
  out.constants << c.linear, c.angular;
  const Mat6 half =
      0.5 * model.timestep * mobility_of(law, bond, a, b) * out.constants.asDiagonal();
  out.implicit = (Mat6::Identity() + half).inverse();
  return out;
}

}  // namespace

BondWorkspace::BondWorkspace(const Model& model)
    : first(model.particles.size() + model.boundaries.size() + 1, 0),
      ends(2 * model.bonds.size()),
      lost(model.bonds.size(), 0) {
  for (const Bond& b : model.bonds) {
    const BeamLaw& law = model.beams[b.law];
    stiffness.push_back(stiffness_of(law));
    dampers.push_back(dampers_of(model, b));
    ++first[b.a + 1];
    ++first[b.b + 1];
  }
  for (std::size_t i = 0; i + 1 < first.size(); ++i) first[i + 1] += first[i];
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::size_t k = 0; k < model.bonds.size(); ++k) {
    const auto number = static_cast<std::uint32_t>(k);
    ends[next[model.bonds[k].a]++] = 2 * number;
    ends[next[model.bonds[k].b]++] = 2 * number + 1;
  }
}

}  // namespace firn
