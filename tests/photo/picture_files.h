// Photographs as files.
#pragma once

#include <png.h>
#include <turbojpeg.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "photo/photograph.h"

namespace firn::test {

inline std::string png_bytes(const Photograph& photo) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(photo.width);
  image.height = static_cast<png_uint_32>(photo.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, photo.rgb.data(), 0, nullptr) == 0)
    throw std::runtime_error(image.message);
  bytes.resize(size);
  return bytes;
}

inline std::string jpeg_bytes(const Photograph& photo, int quality = 90) {
  const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  if (tjCompress2(encoder.get(), photo.rgb.data(), photo.width, 0, photo.height, TJPF_RGB, &buffer,
                  &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT) != 0)
    throw std::runtime_error(tjGetErrorStr2(encoder.get()));
  std::string bytes(reinterpret_cast<const char*>(buffer), size);
  tjFree(buffer);
  return bytes;
}

// A JPEG with a segment of Exif that says how the camera was held, 1 to 8.
inline std::string with_orientation(const std::string& jpeg, int orientation, bool little) {
  const auto number = [&](unsigned value, int bytes) {
    std::string text;
    for (int k = 0; k < bytes; ++k)
      text += static_cast<char>(value >> 8 * (little ? k : bytes - 1 - k));
    return text;
  };
  const std::string tiff =
      std::string(little ? "II" : "MM") + number(42, 2) + number(8, 4) + number(2, 2) +  // entries
      number(0x0100, 2) + number(4, 2) + number(1, 4) + number(77, 4) + number(0x0112, 2) +
      number(3, 2) + number(1, 4) + number(static_cast<unsigned>(orientation), 2) + number(0, 2) +
      number(0, 4);
  const std::string segment = std::string("Exif\0\0", 6) + tiff;
  const auto length = static_cast<unsigned>(segment.size() + 2);
  return jpeg.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) +
         static_cast<char>(length) + segment + jpeg.substr(2);
}

}  // namespace firn::test
