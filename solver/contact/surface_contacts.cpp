#include "solver/contact/surface_contacts.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "solver/collision/contact_region.h"

namespace firn {
namespace {

constexpr double kNoRegion = std::numeric_limits<double>::infinity();
// Fraction of the contact margin. A contact that is deeper than a region by less is part of it.
constexpr double kCovered = 1e-3;

// Surfaces of the features of a contact; -1: none.
struct Surfaces {
  int a, b;
};

Surfaces surfaces_of(const SurfacePair& pair, const PartContact& c) {
  const Manifold& m = c.manifold;
  Surfaces s{pair.surfaces_a.find(pair.parts_a[static_cast<std::size_t>(c.a)], c.a, m.feature_a),
             -1};
  if (!pair.parts_b.empty())
    s.b = pair.surfaces_b.find(pair.parts_b[static_cast<std::size_t>(c.b)], c.b, m.feature_b);
  return s;
}

bool is_same_place(const PartContact& c, const Surfaces& of_c, const PartContact& d,
                   const Surfaces& of_d) {
  return (c.a == d.a || (of_c.a >= 0 && of_c.a == of_d.a)) &&
         (c.b == d.b || (of_c.b >= 0 && of_c.b == of_d.b));
}

// A contact of parts, and its surfaces.
struct SurfaceContact {
  const Manifold& manifold;
  Surfaces surfaces;
};

// Cosines of the angles between the normal and those of the faces that meet; -1: no face.
struct FaceCosines {
  double a = -1, b = -1;
};

FaceCosines face_cosines(const SurfacePair& pair, const Manifold& m) {
  FaceCosines out;
  if (m.feature_a.face) out.a = m.feature_a.face->normal.dot(m.normal);
  if (m.feature_b.face) out.b = -(pair.b_in_a.rotation * m.feature_b.face->normal).dot(m.normal);
  return out;
}

// True when c represents the contact of the surfaces better than d. A normal that points out
// through an internal face is that of a part, not of the surface, so a normal along that of the
// surface is preferred. The next criteria are the flatter features and the normal closer to the
// face normals.
bool is_better(const SurfacePair& pair, const SurfaceContact& c, const SurfaceContact& d) {
  constexpr double kAlongFace = 1 - 1e-12;
  const FaceCosines at_c = face_cosines(pair, c.manifold), at_d = face_cosines(pair, d.manifold);
  const auto is_along = [](const SurfaceContact& contact, const FaceCosines& cosines) {
    return (contact.surfaces.a >= 0 && cosines.a > kAlongFace) ||
           (contact.surfaces.b >= 0 && cosines.b > kAlongFace);
  };
  if (is_along(c, at_c) != is_along(d, at_d)) return is_along(c, at_c);
  const auto rank = [](const Manifold& m) {
    return static_cast<int>(m.feature_a.kind) + static_cast<int>(m.feature_b.kind);
  };
  if (rank(c.manifold) != rank(d.manifold)) return rank(c.manifold) > rank(d.manifold);
  return at_c.a + at_c.b > at_d.a + at_d.b;
}

}  // namespace

std::size_t join_surface_contacts(const SurfacePair& pair, std::vector<PartContact>& contacts,
                                  std::size_t count) {
  // Contacts of one place: the best one is moved to the front, its number is the set of the others.
  Scratch<std::size_t> storage(static_cast<int>(count));
  std::size_t* const set = storage.data();
  std::size_t best = 0;  // contacts at the front
  for (std::size_t i = 0; i < count; ++i) {
    const Surfaces own = surfaces_of(pair, contacts[i]);
    bool joined = false;
    for (std::size_t k = 0; k < best && !joined; ++k) {
      PartContact& other = contacts[k];
      if (!is_same_place(contacts[i], own, other, surfaces_of(pair, other))) continue;
      joined = true;
      set[i] = k;
      if (is_better(pair, {contacts[i].manifold, own}, {other.manifold, surfaces_of(pair, other)}))
        std::swap(contacts[i], other);
      other.other_a |= contacts[i].other_a | part_bit(contacts[i].a);
      other.other_b |= contacts[i].other_b | part_bit(contacts[i].b);
    }
    if (joined) continue;
    if (best != i) {
      std::swap(contacts[best], contacts[i]);
      set[i] = set[best];
    }
    ++best;
  }
  const auto extend = [&](PartContact& c) {
    const Surfaces own = surfaces_of(pair, c);
    if (own.a < 0 && own.b < 0) return kNoRegion;
    const auto surface = [](const FlatSurfaces& all, int number) {
      return number < 0 ? nullptr : &all.surfaces[static_cast<std::size_t>(number)];
    };
    return extend_to_surfaces(
        pair.parts_a[static_cast<std::size_t>(c.a)],
        pair.parts_b.empty() ? nullptr : &pair.parts_b[static_cast<std::size_t>(c.b)], pair.b_in_a,
        pair.plane_offset, pair.contact_margin, surface(pair.surfaces_a, own.a),
        surface(pair.surfaces_b, own.b), c.manifold);
  };
  Scratch<double> gaps(static_cast<int>(best));  // m, least one of the region of the surfaces
  double* const region_gap = gaps.data();
  for (std::size_t k = 0; k < best; ++k) region_gap[k] = extend(contacts[k]);
  // A contact that is deeper than the region of its surfaces is outside the region, at a border of
  // the surface. It is kept as a separate contact. If the surfaces have no region yet, the region
  // of this contact is tried.
  std::size_t kept = best;
  for (std::size_t i = best; i < count; ++i) {
    double& gap = region_gap[set[i]];
    const bool is_covered = contacts[i].manifold.gap >= gap - kCovered * pair.contact_margin;
    if (is_covered) continue;
    if (gap == kNoRegion) gap = extend(contacts[i]);
    if (kept != i) std::swap(contacts[kept], contacts[i]);
    ++kept;
  }
  return kept;
}

}  // namespace firn
