// Growth of necks between pieces of ice in contact during storage.
#pragma once

namespace firn {

// Conditions of the storage.
struct StorageConditions {
  double time = 0;              // s
  double temperature = 0;       // K, below 273.15
  double curvature_radius = 0;  // m, of both surfaces at the contact
};

// Radius x (m) of the neck between two ice spheres of radius R in contact after the time t in air
// at 1 atm:
//   x^5 = 20 (gamma Omega^2 p / (k T)^2) D R^2 t
// with the surface energy gamma, the volume Omega of a molecule, the saturation pressure p over
// ice, the Boltzmann constant k and the diffusivity D of water vapor. Ice sublimes from the spheres
// and condenses at the neck, where the vapor pressure over the concave surface is lower; vapor
// diffusion limits the rate. Source: Hobbs and Mason, Philosophical Magazine 9 (1964) 181. Valid
// for x well below R. p: Murphy and Koop, Q. J. R. Meteorol. Soc. 131 (2005) 1539, equation (7). D:
// Pruppacher and Klett, Microphysics of Clouds and Precipitation (1997), equation (13-3). gamma:
// Ketcham and Hobbs, Philosophical Magazine 19 (1969) 1161.
double sintered_neck_radius(const StorageConditions& storage);

}  // namespace firn
