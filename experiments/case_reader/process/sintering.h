// Growth of the necks between pieces of ice that touch in store.
#pragma once

namespace firn {

// Conditions of the storage.
struct Storage {
  double time = 0;              // s
  double temperature = 0;       // K, below the ice point
  double curvature_radius = 0;  // m, of both surfaces where they touch
};

// Radius x, m, of the neck between two spheres of ice of radius R that touch in air of 1 atm:
//   x^5 = 20 (gamma Omega^2 p / (k T)^2) D R^2 t
// with the surface energy gamma, the volume Omega of a molecule, the saturation pressure p over ice
// and the diffusivity D of water vapor. Ice sublimes from the spheres and condenses at the neck,
// over whose concave surface the vapor pressure is lower; the diffusion of vapor bounds the rate.
// Source: Hobbs and Mason, Philosophical Magazine 9 (1964) 181. It holds while x is well below R.
// p: Murphy and Koop, Q. J. R. Meteorol. Soc. 131 (2005) 1539, equation (7). D: Pruppacher and
// Klett, Microphysics of Clouds and Precipitation (1997), equation (13-3). gamma: Ketcham and
// Hobbs, Philosophical Magazine 19 (1969) 1161.
double sintered_neck_radius(const Storage& storage);

}  // namespace firn
