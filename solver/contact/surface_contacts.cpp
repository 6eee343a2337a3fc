#include "solver/contact/surface_contacts.h"

#include <algorithm>
#include <utility>

namespace firn {
namespace {

using Kind = ContactFeature::Kind;

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

// A normal that leans out over a seam is that of a piece, not of the surface: one along the normal
// of the surface counts more. Then the flatter features count, and of like ones the normal nearest
// to the faces.
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
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Surfaces own = surfaces_of(pair, contacts[i]);
    bool joined = false;
    for (std::size_t k = 0; k < kept && !joined; ++k) {
      PartContact& other = contacts[k];
      if (!is_same_place(contacts[i], own, other, surfaces_of(pair, other))) continue;
      joined = true;
      if (is_better(pair, {contacts[i].manifold, own}, {other.manifold, surfaces_of(pair, other)}))
        std::swap(contacts[i], other);
      other.other_a |= contacts[i].other_a | part_bit(contacts[i].a);
      other.other_b |= contacts[i].other_b | part_bit(contacts[i].b);
    }
    if (joined) continue;
    if (kept != i) std::swap(contacts[kept], contacts[i]);
    ++kept;
  }
  for (std::size_t k = 0; k < kept; ++k) {
    PartContact& c = contacts[k];
    const Surfaces own = surfaces_of(pair, c);
    if (own.a < 0 && own.b < 0) continue;
    const auto surface = [](const FlatSurfaces& all, int number) {
      return number < 0 ? nullptr : &all.surfaces[static_cast<std::size_t>(number)];
    };
    extend_to_surfaces(
        pair.parts_a[static_cast<std::size_t>(c.a)],
        pair.parts_b.empty() ? nullptr : &pair.parts_b[static_cast<std::size_t>(c.b)], pair.b_in_a,
        pair.plane_offset, pair.shell, surface(pair.surfaces_a, own.a),
        surface(pair.surfaces_b, own.b), c.manifold);
  }
  return kept;
}

}  // namespace firn
