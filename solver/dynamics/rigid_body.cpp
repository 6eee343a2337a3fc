#include "solver/dynamics/rigid_body.h"

namespace firn {

namespace {

constexpr double kSmallAngle = 2e-2;  // rad, below which the polynomials are exact to rounding

[[gnu::always_inline]] inline bool small(double h) { return h * h < kSmallAngle * kSmallAngle; }
[[gnu::always_inline]] inline bool small(const Simd8d& h) {
  const Simd4d l = h.low * h.low, u = h.high * h.high, most = l > u ? l : u;
  const double a = most[0] > most[1] ? most[0] : most[1], b = most[2] > most[3] ? most[2] : most[3];
  return (a > b ? a : b) < kSmallAngle * kSmallAngle;
}

template <class Real>
[[gnu::always_inline]] inline void small_sin_cos(const Real& h, Real& s, Real& c) {
  const Real h2 = h * h;
  s = h * (1.0 - (1.0 / 6) * h2 * (1.0 - (1.0 / 20) * h2 * (1.0 - (1.0 / 42) * h2)));
  c = 1.0 - 0.5 * h2 * (1.0 - (1.0 / 12) * h2 * (1.0 - (1.0 / 30) * h2));
}

[[gnu::always_inline]] inline void sin_cos(double h, double& s, double& c) {
  if (small(h)) {
    small_sin_cos(h, s, c);
  } else {
    s = std::sin(h);
    c = std::cos(h);
  }
}

[[gnu::always_inline]] inline void sin_cos(const Simd8d& h, Simd8d& s, Simd8d& c) {
  if (small(h)) {
    small_sin_cos(h, s, c);
  } else {
    for (int k = 0; k < Simd8d::size; ++k) {
      double sine, cosine;
      sin_cos(h[k], sine, cosine);
      s.set(k, sine);
      c.set(k, cosine);
    }
  }
}

// Turn about principal axis K at the rate m_K / I_K for a time t: the momentum turns backwards in
// body axes, the orientation forwards.
template <int K, class Real>
[[gnu::always_inline]] inline void turn(const Real& inverse_inertia, double t, Real* q, Real* m) {
  constexpr int I = (K + 1) % 3, J = (K + 2) % 3;
  Real s, c;
  sin_cos(Real(0.5 * t * m[K] * inverse_inertia), s, c);
  const Real c2 = c * c - s * s, s2 = 2.0 * c * s;
  const Real mi = m[I], mj = m[J];
  m[I] = c2 * mi + s2 * mj;
  m[J] = c2 * mj - s2 * mi;
  // q * (c, s e_K); q in the order x y z w.
  const Real w = q[3], qk = q[K], qi = q[I], qj = q[J];
  q[3] = c * w - s * qk;
  q[K] = c * qk + s * w;
  q[I] = c * qi + s * qj;
  q[J] = c * qj - s * qi;
}

template <class Real>
[[gnu::always_inline]] inline void rotate(const Real* inverse, double dt, Real* q, Real* m) {
  turn<0>(inverse[0], 0.5 * dt, q, m);
  turn<1>(inverse[1], 0.5 * dt, q, m);
  turn<2>(inverse[2], dt, q, m);
  turn<1>(inverse[1], 0.5 * dt, q, m);
  turn<0>(inverse[0], 0.5 * dt, q, m);
  // One Newton step keeps the quaternion unit to rounding.
  const Real scale = 1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int k = 0; k < 4; ++k) q[k] = scale * q[k];
}

}  // namespace

void rotate_torque_free(const Vec3& inverse_inertia, double dt, Quat& orientation, Vec3& m) {
  rotate(inverse_inertia.data(), dt, orientation.coeffs().data(), m.data());
}

void rotate_torque_free(FreeRotations& b, double dt) {
  rotate(b.inverse_inertia, dt, b.q, b.momentum);
}

void half_kick(const RigidBody& body, const Vec3& force, const Vec3& torque, const Vec3& gravity,
               double dt, const Mat3& rotation, Vec3& velocity, Vec3& angular_momentum) {
  const double h = 0.5 * dt;
  velocity += h * (body.inverse_mass * force + gravity);
  angular_momentum += h * (rotation.transpose() * torque);
}

}  // namespace firn
