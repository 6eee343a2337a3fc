#include "solver/dynamics/multibody_tree.h"

#include <Simbody.h>

#include <utility>

#include "solver/dynamics/rotation_vector.h"

namespace firn {
namespace {

using Vec3 = Eigen::Vector3d;

SimTK::Vec3 simbody(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 plain_vector(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
SimTK::Vector simbody(const Eigen::VectorXd& v) {
  SimTK::Vector out(static_cast<int>(v.size()));
  for (int i = 0; i < out.size(); ++i) out[i] = v[i];
  return out;
}
Eigen::VectorXd plain_vector(const SimTK::Vector& v) {
  Eigen::VectorXd out(v.size());
  for (int i = 0; i < v.size(); ++i) out[i] = v[i];
  return out;
}
Eigen::MatrixXd plain_matrix(const SimTK::Matrix& m) {
  Eigen::MatrixXd out(m.nrow(), m.ncol());
  for (int i = 0; i < m.nrow(); ++i)
    for (int j = 0; j < m.ncol(); ++j) out(i, j) = m(i, j);
  return out;
}

// Axes one of which, the x or z axis, is along a direction.
SimTK::Rotation along(const Vec3& direction, SimTK::CoordinateAxis axis) {
  return SimTK::Rotation(SimTK::UnitVec3(simbody(direction)), axis);
}

SimTK::MassProperties properties_of(const TreeBody& body) {
  const Eigen::Matrix3d& i = body.inertia;
  const SimTK::Vec3 arm = simbody(Vec3(body.center - body.origin));
  const SimTK::Inertia central(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
  return {body.mass, arm, central.shiftFromMassCenter(arm, body.mass)};
}

}  // namespace

struct MultibodyTree::Impl {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  std::vector<SimTK::MobilizedBody> bodies;               // [bodies] what carries the mass
  std::vector<std::vector<SimTK::MobilizedBody>> joints;  // [bodies][joints], free rotation last
  std::vector<std::vector<SimTK::Constraint>> loops;      // a loop is one or two
  std::vector<std::vector<int>> coordinate;               // [bodies][joints and free rotation]
  std::vector<Vec3> origin;                               // [bodies] m, as drawn
  std::vector<Eigen::Quaterniond> orientation;  // [bodies] as of MultibodyTree::set_orientations()
  SimTK::State state;

  // Massless links carry the slides. The turn about the moved origin, or the free rotation, is the
  // last joint.
  void add_body(const TreeBody& body) {
    const auto parent_number = static_cast<std::size_t>(body.parent);
    SimTK::MobilizedBody parent = matter.Ground();
    Vec3 place = body.origin;
    if (body.parent >= 0) {
      parent = bodies[parent_number];
      place -= origin[parent_number];
    }
    const std::vector<TreeJoint>& given = body.joints;
    std::vector<std::size_t> order;
    for (const bool turns : {false, true})
      for (std::size_t k = 0; k < given.size(); ++k)
        if (given[k].turns == turns) order.push_back(k);
    const SimTK::Body::Rigid full(properties_of(body));
    std::vector<SimTK::MobilizedBody> chain(given.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
      const TreeJoint& joint = given[order[n]];
      const bool is_last = n + 1 == order.size() && !body.free_rotation;
      const SimTK::Body link = is_last ? SimTK::Body(full) : SimTK::Body(SimTK::Body::Massless());
      const SimTK::Rotation axes =
          along(joint.direction, joint.turns ? SimTK::CoordinateAxis(SimTK::ZAxis)
                                             : SimTK::CoordinateAxis(SimTK::XAxis));
      const SimTK::Transform from(axes, simbody(place)), to(axes);
      if (joint.turns) {
        parent = SimTK::MobilizedBody::Pin(parent, from, link, to);
      } else {
        parent = SimTK::MobilizedBody::Slider(parent, from, link, to);
      }
      chain[order[n]] = parent;
      place.setZero();
    }
    if (body.free_rotation) {
      parent = SimTK::MobilizedBody::Ball(parent, SimTK::Transform(simbody(place)), full,
                                          SimTK::Transform());
      chain.push_back(parent);
    }
    bodies.push_back(parent);
    joints.push_back(std::move(chain));
    origin.push_back(body.origin);
  }

  // Simbody's coordinates for those of MultibodyTree::place(). They are equal for joints. A free
  // rotation has a quaternion.
  SimTK::Vector simbody_coordinates(const Eigen::VectorXd& coordinates) const {
    SimTK::Vector q(state.getNQ());
    for (std::size_t b = 0; b < joints.size(); ++b) {
      for (const SimTK::MobilizedBody& joint : joints[b]) {
        const int from = joint.getFirstUIndex(state), to = joint.getFirstQIndex(state);
        if (joint.getNumU(state) == 1) {
          q[to] = coordinates[from];
          continue;
        }
        const Eigen::Quaterniond turned =
            rotation_by(coordinates.segment<3>(from)) * orientation[b];
        q[to] = turned.w();
        for (int k = 0; k < 3; ++k) q[to + 1 + k] = turned.vec()[k];
      }
    }
    return q;
  }

  void add_loop(const TreeLoop& loop) {
    const auto body_of = [&](int b) {
      return b < 0 ? SimTK::MobilizedBody(matter.Ground()) : bodies[static_cast<std::size_t>(b)];
    };
    const auto station = [&](int b, const Vec3& at) {
      return simbody(b < 0 ? at : Vec3(at - origin[static_cast<std::size_t>(b)]));
    };
    SimTK::MobilizedBody a = body_of(loop.a), b = body_of(loop.b);
    const Vec3& at = loop.position;
    std::vector<SimTK::Constraint> parts;
    switch (loop.kind) {
      case TreeLoop::Kind::hinge: {
        // Another point of the axis; the row along the axis is there twice.
        const Vec3 other = at + 0.1 * loop.direction;
        parts.push_back(
            SimTK::Constraint::Ball(a, station(loop.a, other), b, station(loop.b, other)));
        [[fallthrough]];
      }
      case TreeLoop::Kind::ball:
        parts.push_back(SimTK::Constraint::Ball(a, station(loop.a, at), b, station(loop.b, at)));
        break;
      case TreeLoop::Kind::weld:
        parts.push_back(SimTK::Constraint::Weld(a, SimTK::Transform(station(loop.a, at)), b,
                                                SimTK::Transform(station(loop.b, at))));
        break;
      case TreeLoop::Kind::slot:
        parts.push_back(SimTK::Constraint::PointOnLine(a, SimTK::UnitVec3(simbody(loop.direction)),
                                                       station(loop.a, at), b,
                                                       station(loop.b, at)));
        break;
    }
    loops.push_back(std::move(parts));
  }

  SimTK::Vector_<SimTK::SpatialVec> spatial(const std::vector<TreeLoad>& loads) const {
    SimTK::Vector_<SimTK::SpatialVec> out(matter.getNumBodies(),
                                          SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0)));
    for (std::size_t b = 0; b < loads.size(); ++b)
      out[bodies[b].getMobilizedBodyIndex()] =
          SimTK::SpatialVec(simbody(loads[b].torque), simbody(loads[b].force));
    return out;
  }
};

MultibodyTree::MultibodyTree(const std::vector<TreeBody>& bodies,
                             const std::vector<TreeLoop>& loops)
    : impl_(std::make_unique<Impl>()) {
  Impl& i = *impl_;
  for (const TreeBody& body : bodies) i.add_body(body);
  for (const TreeLoop& loop : loops) i.add_loop(loop);
  i.state = i.system.realizeTopology();
  i.system.realizeModel(i.state);
  for (const auto& chain : i.joints) {
    std::vector<int>& places = i.coordinate.emplace_back();
    for (const SimTK::MobilizedBody& joint : chain)
      for (int k = 0; k < joint.getNumU(i.state); ++k)
        places.push_back(static_cast<int>(joint.getFirstUIndex(i.state)) + k);
  }
  i.orientation.assign(bodies.size(), Eigen::Quaterniond::Identity());
}
MultibodyTree::~MultibodyTree() = default;
MultibodyTree::MultibodyTree(MultibodyTree&&) noexcept = default;
MultibodyTree& MultibodyTree::operator=(MultibodyTree&&) noexcept = default;

int MultibodyTree::coordinates() const { return impl_->state.getNU(); }

int MultibodyTree::coordinate(int body, int joint) const {
  return impl_->coordinate[static_cast<std::size_t>(body)][static_cast<std::size_t>(joint)];
}

void MultibodyTree::set_orientations(const std::vector<Eigen::Quaterniond>& orientations) {
  impl_->orientation = orientations;
}

void MultibodyTree::place(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& rates) {
  impl_->state.updQ() = impl_->simbody_coordinates(coordinates);
  impl_->state.updU() = simbody(rates);
  impl_->system.realize(impl_->state, SimTK::Stage::Velocity);
}

Eigen::MatrixXd MultibodyTree::mass_matrix() const {
  SimTK::Matrix m;
  impl_->matter.calcM(impl_->state, m);
  return plain_matrix(m);
}

Eigen::MatrixXd MultibodyTree::constraint_matrix() const {
  SimTK::Matrix g;
  impl_->matter.calcG(impl_->state, g);
  return plain_matrix(g);
}

Eigen::VectorXd MultibodyTree::constraint_errors() const {
  // The errors of the norms of quaternions are last and belong to no loop.
  const int rows = impl_->state.getNQErr() - impl_->matter.getNumQuaternionsInUse(impl_->state);
  return plain_vector(SimTK::Vector(impl_->state.getQErr())).head(rows);
}

TreePose MultibodyTree::pose(int body) const {
  const SimTK::MobilizedBody& b = impl_->bodies[static_cast<std::size_t>(body)];
  const SimTK::Transform& at = b.getBodyTransform(impl_->state);
  TreePose pose;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) pose.rotation(i, j) = at.R()[i][j];
  pose.origin = plain_vector(at.p());
  const SimTK::SpatialVec& moves = b.getBodyVelocity(impl_->state);
  pose.angular_velocity = plain_vector(moves[0]);
  pose.velocity = plain_vector(moves[1]);
  return pose;
}

Eigen::VectorXd MultibodyTree::generalized_forces(const std::vector<TreeLoad>& loads) const {
  const SimTK::Vector none(coordinates(), 0.0);
  SimTK::Vector missing;
  impl_->matter.calcResidualForceIgnoringConstraints(impl_->state, none, impl_->spatial(loads),
                                                     none, missing);
  return -plain_vector(missing);
}

Eigen::VectorXd MultibodyTree::generalized_impulses(const std::vector<TreeLoad>& impulses) const {
  SimTK::Vector out;
  impl_->matter.multiplyBySystemJacobianTranspose(impl_->state, impl_->spatial(impulses), out);
  return plain_vector(out);
}

std::vector<TreeLoad> MultibodyTree::loop_loads(int loop,
                                                const Eigen::VectorXd& multipliers) const {
  const Impl& i = *impl_;
  std::vector<TreeLoad> loads(i.bodies.size());
  SimTK::Vector chosen(static_cast<int>(multipliers.size()), 0.0);
  int row = 0;
  for (int c = 0; c < i.matter.getNumConstraints(); ++c) {
    const SimTK::Constraint& constraint = i.matter.getConstraint(SimTK::ConstraintIndex(c));
    int holonomic = 0, nonholonomic = 0, accelerations = 0;
    constraint.getNumConstraintEquationsInUse(i.state, holonomic, nonholonomic, accelerations);
    bool wanted = false;
    for (const SimTK::Constraint& part : i.loops[static_cast<std::size_t>(loop)])
      wanted = wanted || part.getConstraintIndex() == constraint.getConstraintIndex();
    for (int k = 0; k < holonomic; ++k, ++row)
      if (wanted) chosen[row] = multipliers[row];
  }
  SimTK::Vector_<SimTK::SpatialVec> forces;
  SimTK::Vector along_coordinates;
  i.matter.calcConstraintForcesFromMultipliers(i.state, chosen, forces, along_coordinates);
  for (std::size_t b = 0; b < loads.size(); ++b) {
    const SimTK::SpatialVec& load = forces[i.bodies[b].getMobilizedBodyIndex()];
    loads[b] = {plain_vector(load[1]), plain_vector(load[0])};
  }
  return loads;
}

}  // namespace firn
