// Wavefront OBJ files.
#include "experiments/meshes/obj_file.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  fuzz::accepts([&] {
    const TriangleMesh mesh = read_obj("mesh.obj", std::string(fuzz::text_of(data, size)));
    for (const Vec3& v : mesh.vertices) fuzz::require(v.allFinite(), "coordinates are finite");
    for (const auto& t : mesh.triangles) {
      for (const int i : t)
        fuzz::require(i >= 0 && i < static_cast<int>(mesh.vertices.size()), "corners exist");
    }
  });
  return 0;
}
