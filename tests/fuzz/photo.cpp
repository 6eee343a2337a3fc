// Photographs. What is accepted has all of its pixels, and no more than the limit.
#include "experiments/system/input_limits.h"
#include "photo/photograph.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  fuzz::accepts([&] {
    const Photograph photo = decode_photograph(fuzz::text_of(data, size), "photo.png");
    fuzz::require(photo.width > 0 && photo.height > 0, "a photograph has pixels");
    const auto pixels =
        static_cast<std::uint64_t>(photo.width) * static_cast<std::uint64_t>(photo.height);
    fuzz::require(pixels <= input_limits::photo_pixels, "the limit of pixels is kept");
    fuzz::require(photo.rgb.size() == 3 * pixels, "every pixel has three channels");
    fuzz::require(photo.hash.size() == 64, "the file has a hash");
  });
  return 0;
}
