// Setups of photographs. What is accepted is measured in a small picture, or refused in one line.
#include "photo/photo_setup.h"

#include <cmath>

#include "photo/heap_photo.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const Photograph photo = [] {
    Photograph p;
    p.width = 160;
    p.height = 100;
    p.file = "photo.png";
    p.hash = std::string(64, '0');
    for (int row = 0; row < p.height; ++row)  // bright below a slope
      for (int column = 0; column < p.width; ++column)
        p.rgb.insert(p.rgb.end(), 3, row > 70 - std::abs(column - 80) / 3 ? 200 : 40);
    return p;
  }();
  fuzz::accepts([&] {
    const std::string text(fuzz::text_of(data, size));
    PhotoSetup setup = read_photo_setup_text(text, "setup.toml");
    setup.background.clear();  // no file of the machine is read
    fuzz::require(setup.particle_size > 0 && setup.corners.size() >= 4, "a setup is complete");
    for (const PhotoLedge& ledge : setup.ledges)
      fuzz::require(ledge.window.from >= 0 && ledge.window.to <= ledge.length(),
                    "a window lies on its ledge");
    const HeapPhotoResult result =
        measure_heap_photos(setup, 1, [&](std::size_t) { return photo; });
    fuzz::require(std::isfinite(result.angle) && std::abs(result.angle) < 90, "an angle is finite");
    fuzz::require(std::isfinite(result.uncertainty()) && result.uncertainty() >= 0,
                  "its uncertainty is finite and not below 0");
  });
  return 0;
}
