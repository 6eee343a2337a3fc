#include "experiments/case_reader/process/sintering.h"

#include <cmath>

#include "experiments/text/units.h"

namespace firn {
namespace {

constexpr double kBoltzmann = 1.380649e-23;         // J/K, exact
constexpr double kSurfaceEnergy = 0.109;            // J/m^2, ice against its vapor
constexpr double kMoleculeVolume = 3.262e-29;       // m^3, of 917 kg/m^3
constexpr double kDiffusivityAtIcePoint = 2.11e-5;  // m^2/s, of water vapor in air at 1 atm

double saturation_pressure(double temperature) {  // Pa, over ice
  return std::exp(9.550426 - 5723.265 / temperature + 3.53068 * std::log(temperature) -
                  0.00728332 * temperature);
}

double vapor_diffusivity(double temperature) {  // m^2/s
  return kDiffusivityAtIcePoint * std::pow(temperature / kIcePoint, 1.94);
}

}  // namespace

double sintered_neck_radius(const StorageConditions& s) {
  const double volume_per_energy = kMoleculeVolume / (kBoltzmann * s.temperature);  // m^3/J
  const double rate = 20 * kSurfaceEnergy * volume_per_energy * volume_per_energy *
                      saturation_pressure(s.temperature) *
                      vapor_diffusivity(s.temperature);  // m^3/s
  return std::pow(rate * s.curvature_radius * s.curvature_radius * s.time, 0.2);
}

}  // namespace firn
