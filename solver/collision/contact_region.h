// Touching region of two features, projected along the contact normal: clipping, and weights of its
// corners. Internal to the narrow phase.
#pragma once

#include <cassert>
#include <cmath>
#include <vector>

#include "firn/convex_part.h"
#include "solver/core/simd.h"

namespace firn {

struct Manifold;

// As fractions of the characteristic length of the pair: least width of edges and corners, and the
// length below which a segment counts as a point.
inline constexpr double kEdgeWidth = 1e-4;
inline constexpr double kLeastExtent = 1e-7;

struct PlanePoint {
  double u, v;
};

// Second moments of an area, m^4: of u^2, u v and v^2.
struct PlaneMoments {
  double uu = 0, uv = 0, vv = 0;
};

// Axes u, v across the normal n; right-handed.
struct ContactBasis {
  Vec3 u, v, n;

  explicit ContactBasis(const Vec3& normal) : n(normal) {
    const TangentBasis across = tangent_basis(to_vec(n));
    u = to_eigen(across.u);
    v = to_eigen(across.v);
  }
  // The same about the same point in three dimensions, in the axes of u and v.
  Mat3 moments(const PlaneMoments& m) const {
    return m.uu * u * u.transpose() + m.uv * (u * v.transpose() + v * u.transpose()) +
           m.vv * v * v.transpose();
  }
  PlanePoint flat(const Vec3& x) const { return {u.dot(x), v.dot(x)}; }
  Vec3 point(const PlanePoint& at, double height) const { return at.u * u + at.v * v + height * n; }
};

// A part seen along the normal: positions across it and heights along it, in the pair's frame.
struct ProjectedPart {
  const ConvexPart& part;
  Vec3 u, v, n;  // the frame in part axes
  Vec3 shift;    // (u, v, height) of the part's origin

  ProjectedPart(const ConvexPart& a, const ContactBasis& frame)
      : part(a), u(frame.u), v(frame.v), n(frame.n), shift(Vec3::Zero()) {}
  ProjectedPart(const ConvexPart& b, const ContactBasis& frame, const Pose& b_in_a)
      : part(b),
        u(b_in_a.rotation.transpose() * frame.u),
        v(b_in_a.rotation.transpose() * frame.v),
        n(b_in_a.rotation.transpose() * frame.n),
        shift(frame.u.dot(b_in_a.translation), frame.v.dot(b_in_a.translation),
              frame.n.dot(b_in_a.translation)) {}

  PlanePoint flat(const Vec3& x) const { return {u.dot(x) + shift.x(), v.dot(x) + shift.y()}; }
  PlanePoint flat(int i) const { return flat(part.vertex(i)); }
  double height(const Vec3& x) const { return n.dot(x) + shift.z(); }
  double height(int i) const { return height(part.vertex(i)); }
  // A point of the frame in part axes.
  Vec3 body_point(const PlanePoint& at, double height) const {
    return (at.u - shift.x()) * u + (at.v - shift.y()) * v + (height - shift.z()) * n;
  }
};

// Room for `count` items: on the stack up to a size that ordinary parts never exceed.
template <class T>
class Scratch {
 public:
  explicit Scratch(int count) {
    if (count > kInline) heap_.resize(count);
  }
  T* data() { return heap_.empty() ? inline_ : heap_.data(); }

 private:
  static constexpr int kInline = 64;
  T inline_[kInline];
  std::vector<T> heap_;
};

// One corner of the touching region and the heights of the two cores over it.
struct ClippedPoint {
  PlanePoint at;
  double height_a, height_b;  // m
  double weight;              // m^2
};

// The touching region seen along the normal: a convex polygon, a segment or a point.
struct ContactRegion {
  ContactRegion(int room, double characteristic_length)
      : storage(room), points(storage.data()), capacity(room), size(characteristic_length) {}
  ContactRegion(const ContactRegion&) = delete;

  void add(const PlanePoint& at, double height_a, double height_b) {
    assert(count < capacity);
    points[count++] = {at, height_a, height_b, 0};
  }

  Scratch<ClippedPoint> storage;
  ClippedPoint* points;
  int capacity;
  double size;  // m, of the pair
  int count = 0;
  double area = 0;       // m^2, sum of the weights
  PlaneMoments moments;  // about the centroid
};

// Upper bound of the corners of the common polygon: one more for each cut, and a reserve for
// outlines that are slightly concave due to rounding.
inline int region_capacity(int corners_a, int corners_b) { return 2 * (corners_a + corners_b); }

// Weights that integrate linear functions over the polygon exactly, and its moments.
void compute_polygon_weights(ContactRegion& r);
// Edges and corners are swept: a rounding of `radius` (m) that overlaps by d touches over a width
// of 2 sqrt(2 radius d). With a fixed width, an edge that overlaps deeper than an adjacent face
// would carry almost no part of the force on the patch. `radii`: sum of both sweep radii, m.
void compute_segment_weights(ContactRegion& r, double radius, double radii);
void compute_point_weights(ContactRegion& r, double radius, double radii);
// The same width for one overlap (m), and the radius of two edges against each other. `size`: of
// the pair, m.
double swept_width(double radius, double overlap, double size);
double edge_radius(double radius_a, double radius_b);

// A face as height over (u, v).
struct HeightGradient {
  double at_origin, du, dv;

  HeightGradient(const ProjectedPart& view, const ConvexPart::Face& face);
  explicit HeightGradient(double level) : at_origin(level), du(0), dv(0) {}
  double height(const PlanePoint& p) const { return at_origin + du * p.u + dv * p.v; }
};

// True when a face is seen at `at`. `reversed`: its outline is seen clockwise, as that of B is.
bool is_over_face(const ProjectedPart& view, const ConvexPart::Face& face, bool reversed,
                  const PlanePoint& at);
// Cuts a convex polygon by the left side of p -> q. Returns the new number of corners.
int cut(const PlanePoint* in, int count, const PlanePoint& p, const PlanePoint& q, PlanePoint* out);
// The part of p -> q within a convex polygon, counter-clockwise, as fractions. False without any.
bool clip_segment(const PlanePoint* polygon, int count, const PlanePoint& p, const PlanePoint& q,
                  double& from, double& to);
// Indices of the corners of the convex hull, counter-clockwise. Points on its sides are none.
// `extent`: m, its greatest width from the first corner. Fewer than three: it has no area.
std::vector<int> hull_corners(const std::vector<PlanePoint>& points, double& extent);

// Contact points and moments of a weighed region; with `flat`, its outline too.
void emit_region(const ContactRegion& r, const ContactBasis& frame, double radius_a,
                 double radius_b, double contact_margin, bool flat, Manifold& out);

// The region over which two features face each other, weighed. False when it is empty or too small.
bool clip_face_face(const ProjectedPart& a, const ConvexPart::Face& face_a, const ProjectedPart& b,
                    const ConvexPart::Face& face_b, ContactRegion& r);
// An edge of one part on a face of the other. `edge_is_a`: the edge belongs to A, the face to B.
bool clip_edge_face(const ProjectedPart& edge_view, const std::uint16_t (&ends)[2],
                    const ProjectedPart& face_view, const ConvexPart::Face& face, bool edge_is_a,
                    ContactRegion& r);
// Two edges that run side by side: the stretch over which they are less than `aside` (m) apart
// across the normal. Shrinks to the crossing point as they turn against each other.
bool clip_edge_edge(const ProjectedPart& a, const std::uint16_t (&ends_a)[2],
                    const ProjectedPart& b, const std::uint16_t (&ends_b)[2], double aside,
                    ContactRegion& r);

}  // namespace firn
