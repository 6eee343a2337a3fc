// Lumps of a user's shape run out of a slot: hopper CASE.toml RESULTS.h5 [COUNT]
#include <firn/experiments/run.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

using namespace firn;

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::fprintf(stderr, "usage: hopper CASE.toml RESULTS.h5 [COUNT]\n");
    return 2;
  }
  experiments::Case hopper = experiments::Case::load(argv[1]);
  if (argc > 3) hopper = hopper.with({{"fills.0.count", argv[3]}});
  const Shape& lump = hopper.model().shapes.at(0);
  std::printf("%zu x %s, %.2f g each, time step %.1f us\n", hopper.model().particles.size(),
              lump.name.c_str(), 1e3 * lump.mass, 1e6 * hopper.timestep());

  experiments::RunOptions options;
  options.results_file = argv[2];
  options.on_frame = [](const Solver& solver) {
    const ParticleState& state = solver.particles();
    std::printf("t = %.2f s  %td lumps inside\n", solver.time(),
                std::ranges::count(state.presence, Presence::present));
    return true;  // false would stop the run
  };
  const experiments::RunResult result = experiments::run(hopper, options);
  for (const experiments::Response& r : result.responses)
    if (r.value.size() == 1)
      std::printf("%s = %g %s\n", r.name.c_str(), r.value[0], r.unit == "1" ? "" : r.unit.c_str());
  std::printf("%s\n", result.reason.c_str());
  return result.status == experiments::RunResult::Status::finished ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "hopper: %s\n", e.what());
  return 2;
}
