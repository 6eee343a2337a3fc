// A step that keeps the neighbor list allocates no memory once its buffers have grown.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "validation/verification/fixtures/mechanisms.h"

namespace {

thread_local std::size_t allocation_count = 0;

void* counted(std::size_t size) {
  ++allocation_count;
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void* counted(std::size_t size, std::align_val_t alignment) {
  ++allocation_count;
  const auto a = std::max(static_cast<std::size_t>(alignment), sizeof(void*));
  void* const memory = std::aligned_alloc(a, (size + a - 1) / a * a);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

template <class... Request>
void* counted_or_null(Request... request) noexcept {
  try {
    return counted(request...);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

// GCC takes the memory for that of another operator new where the thread sanitizer is in the build.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
#endif

// All forms: a sanitizer has its own of those that are left out, which free() does not fit.
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, alignment);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return counted_or_null(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return counted_or_null(size);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return counted_or_null(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return counted_or_null(size, alignment);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  std::free(memory);
}

namespace firn {
namespace {

using namespace scenes;

// How many steps allocated memory, of those that kept the neighbor list.
int allocating_steps(Solver& solver, int steps) {
  int sum = 0;
  for (int k = 0; k < steps; ++k) {
    const std::size_t before = allocation_count;
    const std::uint64_t rebuilds = solver.diagnostics().rebuilds;
    solver.step();
    sum += solver.diagnostics().rebuilds == rebuilds && allocation_count > before ? 1 : 0;
  }
  return sum;
}

Shape random_shape(Random& random) {
  const double size = random.uniform(0.008, 0.012);
  const ShapeOptions options = ice_options(1e-3, 1e4, 1e-3);
  switch (static_cast<int>(random.uniform(0, 3))) {
    case 0:
      return make_sphere(size / 2, options);
    case 1:
      return make_box(Vec3::Constant(size), options);
    default:
      return crescent();
  }
}

// A settled bed of bodies of two random shapes in a box.
Solver settled_bed(Random& random) {
  Model model = empty(law(random.uniform(0.1, 0.5), 0.3), law(random.uniform(0.1, 0.5), 0.3));
  const int count = 20 + static_cast<int>(random.uniform(0, 10));
  for (int k = 0; k < 2; ++k) add_particles(model, add_shape(model, random_shape(random)), count);
  add_box_of_planes(model, {-0.06, -0.06, 0}, {0.12, 0.12, 0.4});
  model.timestep = advise_timestep(model, 10).timestep;
  Solver solver(model);
  scatter(solver, 0, 2 * count, {-0.05, -0.05, 0.02}, {0.05, 0.05, 0.38},
          static_cast<std::uint64_t>(random.uniform(0, 1e9)));
  run(solver, 1.5);
  return solver;
}

TEST(StepAllocations, CountingSeesAnAllocation) {
  const std::size_t before = allocation_count;
  const std::vector<double> some(1000);
  EXPECT_EQ(some.size(), 1000u);
  EXPECT_GT(allocation_count, before);
}

TEST(StepAllocations, AreNoneInASettledBed) {
  Random random(11);
  for (int member = 0; member < 3; ++member) {
    Solver solver = settled_bed(random);
    ASSERT_GT(solver.diagnostics().patches, 40u);
    // A few: a body that creeps may need more contact points than ever before.
    EXPECT_LE(allocating_steps(solver, 1000), 20) << "member " << member;
  }
}

// Blocks that are pushed over a floor against each other: searches, patches that come and go.
Model pushed_blocks(Random& random, int blocks) {
  Model model = mechanism();
  const int floor = add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  int before = -1;
  for (int k = 0; k < blocks; ++k) {
    const double x = 0.06 * k, size = random.uniform(0.04, 0.05);
    Joint along = slider(Vec3::UnitX());
    if (k == 0) {
      along.motors.push_back({});
      along.motors[0].speed = random.uniform(0.05, 0.2);
      along.motors[0].max_load = 20;
      along.motors[0].no_load_speed = 1;
    }
    const std::string name = "block " + std::to_string(k);
    const int frame =
        add_mover(model, name, 0.3, {x, 0, size / 2}, Vec3::Constant(1e-4),
                  {along, slider(Vec3::UnitZ()), hinge(Vec3::UnitY())}, {x, 0, size / 2});
    const int block =
        add_panel(model, name, {x - size / 2, -0.02, 0.0005}, {x + size / 2, 0.02, size});
    model.boundaries[static_cast<std::size_t>(block)].frame = frame;
    add_contact(model, block, floor, random.uniform(0.1, 0.4), 0.3, 2e5);
    if (before >= 0) add_contact(model, before, block, 0.2, 0.3, 2e5);
    before = block;
  }
  model.timestep = 2e-5;
  return model;
}

TEST(StepAllocations, AreNoneWithContactsOfBoundaries) {
  Random random(12);
  for (int member = 0; member < 3; ++member) {
    Solver solver(pushed_blocks(random, 2 + member));
    run(solver, 0.5);
    std::size_t touching = 0;
    for (const BoundaryContactState& c : solver.boundary_contacts())
      touching += c.normal_force > 0 ? 1 : 0;
    ASSERT_GE(touching, 2u);
    EXPECT_EQ(allocating_steps(solver, 2000), 0) << "member " << member;
  }
}

}  // namespace
}  // namespace firn
