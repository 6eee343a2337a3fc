#include "photo/photograph.h"

#include <fmt/core.h>
#include <png.h>
#include <turbojpeg.h>

#include <cstring>
#include <memory>
#include <optional>

#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "firn/math.h"

namespace firn {
namespace {

constexpr std::string_view kWanted = "a photograph in PNG or JPEG";
constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::uint64_t kLeastEdge = 32;  // pixels

[[noreturn]] void refuse(const std::string& source, std::string_view what) {
  throw InputError(fmt::format("{}: {}; expected {}", source, what, kWanted));
}

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

// Throws unless a picture of this size may be decoded.
void check_size(const std::string& source, std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t most = input_limits::photo_pixels;
  if (width < kLeastEdge || height < kLeastEdge) {
    throw InputError(fmt::format("{}: has {} x {} pixels; expected at least {} each way", source,
                                 width, height, kLeastEdge));
  }
  if (width > most || height > most || width * height > most) {
    throw InputError(fmt::format("{}: has {} x {} pixels; expected at most {} million in all",
                                 source, width, height, most / 1'000'000));
  }
}

Photograph empty_photograph(std::uint64_t width, std::uint64_t height) {
  Photograph photo;
  photo.width = static_cast<int>(width);
  photo.height = static_cast<int>(height);
  photo.rgb.resize(3 * width * height);
  return photo;
}

// The header of a PNG is the first chunk: length, IHDR, width, height.
Photograph decode_png(std::string_view bytes, const std::string& source) {
  if (bytes.size() < 33 || bytes.substr(12, 4) != "IHDR") refuse(source, "is a damaged PNG file");
  const std::uint64_t width = big_endian(bytes.substr(16, 4));
  const std::uint64_t height = big_endian(bytes.substr(20, 4));
  check_size(source, width, height);
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  const auto release = [](png_image* p) { png_image_free(p); };
  const std::unique_ptr<png_image, decltype(release)> guard(&image, release);
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0)
    refuse(source, fmt::format("is a damaged PNG file ({})", image.message));
  if (image.width != width || image.height != height) refuse(source, "is a damaged PNG file");
  image.format = PNG_FORMAT_RGB;
  Photograph photo = empty_photograph(width, height);
  const png_color white{255, 255, 255};  // behind what is transparent
  if (png_image_finish_read(&image, &white, photo.rgb.data(), 0, nullptr) == 0)
    refuse(source, fmt::format("is a damaged PNG file ({})", image.message));
  return photo;
}

// The orientation in a TIFF block of Exif, 1 to 8; 1 when there is none.
int orientation_in(std::string_view tiff) {
  if (tiff.size() < 8) return 1;
  const bool little = tiff.substr(0, 2) == "II";
  if (!little && tiff.substr(0, 2) != "MM") return 1;
  const auto number = [&](std::size_t at, std::size_t bytes) -> std::uint64_t {
    if (at + bytes > tiff.size()) return 0;
    if (!little) return big_endian(tiff.substr(at, bytes));
    std::uint64_t value = 0;
    for (std::size_t k = bytes; k > 0; --k)
      value = value << 8 | static_cast<unsigned char>(tiff[at + k - 1]);
    return value;
  };
  const std::size_t directory = number(4, 4);
  const std::uint64_t entries = number(directory, 2);
  for (std::uint64_t k = 0; k < entries; ++k) {
    const std::size_t entry = directory + 2 + 12 * k;
    if (entry + 12 > tiff.size()) return 1;
    constexpr std::uint64_t kOrientation = 0x0112;
    if (number(entry, 2) != kOrientation) continue;
    const std::uint64_t value = number(entry + 8, 2);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

// Segments of a JPEG file up to the first scan: 0xff, marker, length of two bytes.
int jpeg_orientation(std::string_view bytes) {
  for (std::size_t at = 2; at + 4 <= bytes.size();) {
    if (static_cast<unsigned char>(bytes[at]) != 0xff) return 1;
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    const std::size_t length = big_endian(bytes.substr(at + 2, 2));
    constexpr unsigned char kScan = 0xda, kApplication1 = 0xe1;
    if (marker == kScan || length < 2) return 1;
    const std::string_view segment =
        bytes.substr(at + 4, std::min(length - 2, bytes.size() - at - 4));
    constexpr std::string_view kExif("Exif\0\0", 6);
    if (marker == kApplication1 && segment.substr(0, 6) == kExif)
      return orientation_in(segment.substr(6));
    at += 2 + length;
  }
  return 1;
}

// Turned and mirrored as an orientation of Exif says.
Photograph upright(const Photograph& stored, int orientation) {
  if (orientation == 1) return stored;
  const bool across = orientation >= 5;  // rows become columns
  Photograph photo =
      empty_photograph(static_cast<std::uint64_t>(across ? stored.height : stored.width),
                       static_cast<std::uint64_t>(across ? stored.width : stored.height));
  const int right = stored.width - 1, low = stored.height - 1;
  for (int row = 0; row < photo.height; ++row) {
    for (int column = 0; column < photo.width; ++column) {
      const std::array<std::array<int, 2>, 9> from{{{column, row},
                                                    {column, row},
                                                    {right - column, row},
                                                    {right - column, low - row},
                                                    {column, low - row},
                                                    {row, column},
                                                    {row, low - column},
                                                    {right - row, low - column},
                                                    {right - row, column}}};
      const auto [i, j] = from[static_cast<std::size_t>(orientation)];
      const auto pixel = stored.at(i, j);
      std::copy(pixel.begin(), pixel.end(),
                photo.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(row) * photo.width + column));
    }
  }
  return photo;
}

Photograph decode_jpeg(std::string_view bytes, const std::string& source) {
  const auto release = [](void* p) { tjDestroy(p); };
  const std::unique_ptr<void, decltype(release)> decoder(tjInitDecompress(), release);
  if (!decoder) throw std::bad_alloc();
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, sampling = 0, colors = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &sampling, &colors) !=
          0 ||
      width <= 0 || height <= 0)
    refuse(source, fmt::format("is a damaged JPEG file ({})", tjGetErrorStr2(decoder.get())));
  check_size(source, static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
  if (colors == TJCS_CMYK || colors == TJCS_YCCK) refuse(source, "has the colors of print (CMYK)");
  Photograph photo =
      empty_photograph(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
  // A progressive picture of very many scans costs time out of proportion to its size.
  if (tjDecompress2(decoder.get(), data, bytes.size(), photo.rgb.data(), width, 0, height, TJPF_RGB,
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0)
    refuse(source, fmt::format("is a damaged JPEG file ({})", tjGetErrorStr2(decoder.get())));
  return upright(photo, jpeg_orientation(bytes));
}

}  // namespace

Photograph decode_photograph(std::string_view bytes, const std::string& source) {
  Photograph photo;
  if (bytes.starts_with(kPngSignature))
    photo = decode_png(bytes, source);
  else if (bytes.starts_with("\xff\xd8\xff"))
    photo = decode_jpeg(bytes, source);
  else
    refuse(source, "is neither PNG nor JPEG");
  photo.file = source;
  photo.hash = sha256(bytes);
  return photo;
}

Photograph read_photograph(const std::string& file) {
  return decode_photograph(read_input_file(file, kWanted, input_limits::photo_bytes), file);
}

}  // namespace firn
