// Bullet's side of `agree`: convex bodies above a floor, with or without four walls. `agree` builds
// it with Debian's libbullet-dev. Reads the case from standard input, numbers with blanks between
// them, in units of length in which a body is about as large as one, as Bullet wants it:
//
//   rounding mass Ixx Iyy Izz gravity friction restitution timestep steps every length width
//   corners x y z ...   bodies  x y z  w qx qy qz  vx vy vz ...
//
// length 0: no walls. Writes a line for each frame: time, then x y z w qx qy qz vx vy vz and the
// spin of every body.
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <vector>

namespace {

double next() {
  double number = 0;
  if (!(std::cin >> number)) {
    std::fprintf(stderr, "hulls: the case ends too soon\n");
    std::exit(2);
  }
  return number;
}
btScalar scalar() { return static_cast<btScalar>(next()); }
btVector3 vector() {
  const btScalar x = scalar(), y = scalar(), z = scalar();
  return {x, y, z};
}
btQuaternion quaternion() {
  const btScalar w = scalar(), x = scalar(), y = scalar(), z = scalar();
  return {x, y, z, w};
}

struct Law {
  btScalar friction, restitution;
};

// Bodies are handed over with all that they stand on.
struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;

  ~World() {
    for (const auto& body : bodies) dynamics.removeRigidBody(body.get());
  }

  btRigidBody& add(btScalar mass, const btVector3& inertia, btCollisionShape* shape,
                   const Law& law) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_friction = std::sqrt(law.friction);  // a pair has the product of both
    info.m_restitution = std::sqrt(law.restitution);
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    dynamics.addRigidBody(bodies.back().get());
    return *bodies.back();
  }

  void add_plane(const btVector3& normal, btScalar distance, const Law& law) {
    shapes.push_back(std::make_unique<btStaticPlaneShape>(normal, distance));
    shapes.back()->setMargin(0);
    add(0, {0, 0, 0}, shapes.back().get(), law);
  }
};

void print(const btRigidBody& body) {
  const btVector3& x = body.getWorldTransform().getOrigin();
  const btQuaternion q = body.getWorldTransform().getRotation();
  const btVector3 &v = body.getLinearVelocity(), &w = body.getAngularVelocity();
  std::printf(" %.9g %.9g %.9g %.9g %.9g %.9g %.9g", x.x(), x.y(), x.z(), q.w(), q.x(), q.y(),
              q.z());
  std::printf(" %.9g %.9g %.9g %.9g %.9g %.9g", v.x(), v.y(), v.z(), w.x(), w.y(), w.z());
}

}  // namespace

int main() {
  World world;
  const btScalar rounding = scalar(), mass = scalar();
  const btVector3 inertia = vector();
  world.dynamics.setGravity({0, 0, -scalar()});
  Law law{};
  law.friction = scalar();
  law.restitution = scalar();
  const btScalar timestep = scalar();
  const int steps = static_cast<int>(next()), every = static_cast<int>(next());
  const btScalar length = scalar(), width = scalar();
  auto hull = std::make_unique<btConvexHullShape>();
  for (int corners = static_cast<int>(next()); corners > 0; --corners)
    hull->addPoint(vector(), corners == 1);
  hull->setMargin(rounding);  // the corners are those of the core
  btCollisionShape* const shape = hull.get();
  world.shapes.push_back(std::move(hull));

  btContactSolverInfo& info = world.dynamics.getSolverInfo();
  info.m_numIterations = 100;
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  info.m_splitImpulse = 1;  // overlaps are undone without giving speed
  info.m_restitutionVelocityThreshold = 0;

  world.add_plane({0, 0, 1}, 0, law);
  if (length > 0) {
    world.add_plane({1, 0, 0}, 0, law);
    world.add_plane({-1, 0, 0}, -length, law);
    world.add_plane({0, 1, 0}, 0, law);
    world.add_plane({0, -1, 0}, -width, law);
  }
  std::vector<btRigidBody*> bodies;
  for (int count = static_cast<int>(next()); count > 0; --count) {
    btRigidBody& body = world.add(mass, inertia, shape, law);
    const btVector3 place = vector();
    const btQuaternion turned = quaternion();
    body.setCenterOfMassTransform(btTransform(turned, place));  // and inertia
    body.setLinearVelocity(vector());
    bodies.push_back(&body);
  }
  for (int step = 1; step <= steps; ++step) {
    world.dynamics.stepSimulation(timestep, 0, timestep);
    if (step % every != 0) continue;
    std::printf("%.9g", static_cast<double>(timestep) * step);
    for (const btRigidBody* const body : bodies) print(*body);
    std::printf("\n");
  }
}
