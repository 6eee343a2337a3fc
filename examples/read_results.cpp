// Prints what a results file holds: read_results RESULTS.h5
#include <firn/experiments/results.h>

#include <cmath>
#include <cstdio>
#include <exception>

using namespace firn::experiments;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: read_results RESULTS.h5\n");
    return 2;
  }
  const Results results(argv[1]);
  const std::vector<double> times = results.times();
  std::printf("%s, %zu particles, %zu frames\n", results.status().c_str(), results.particle_count(),
              times.size());
  for (const Stage& stage : results.stages())
    std::printf("stage %s: %.2f s to %.2f s, end: %s\n", stage.name.c_str(), stage.start, stage.end,
                stage.end_reason.c_str());

  const Particles particles = results.particles();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Frame frame = results.frame(i);
    double mass = 0, moment = 0;  // of those present
    for (std::size_t k = 0; k < frame.position.size(); ++k) {
      if (std::isnan(frame.position[k][2])) continue;
      mass += particles.mass[k];
      moment += particles.mass[k] * frame.position[k][2];
    }
    if (mass > 0)
      std::printf("t = %.2f s  %.1f g, mean height %.1f mm\n", frame.time, 1e3 * mass,
                  1e3 * moment / mass);
  }
  if (particles.mass.size() > 0 && !times.empty()) {
    const std::array<double, 4> q = results.frame(times.size() - 1).orientation[0];
    std::printf("particle 0, last orientation (w x y z): %g %g %g %g\n", q[0], q[1], q[2], q[3]);
  }
  for (const Series& s : results.series())
    std::printf("series %s [%zu x %zu] %s\n", s.path.c_str(), times.size(), s.width,
                s.unit.c_str());
  for (const Response& r : results.responses())
    std::printf("response %s: %zu value(s), first %g %s\n", r.name.c_str(), r.value.size(),
                r.value.empty() ? NAN : r.value[0], r.unit.c_str());
} catch (const std::exception& e) {
  std::fprintf(stderr, "read_results: %s\n", e.what());
  return 2;
}
