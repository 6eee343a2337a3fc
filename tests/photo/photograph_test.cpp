// Reading photographs: pixels, orientation, and what is refused before it is decoded.
#include "photo/photograph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "experiments/storage/sha256.h"
#include "experiments/system/input_limits.h"
#include "firn/math.h"
#include "tests/photo/picture_files.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

using testing::HasSubstr;

// Smooth, so that a JPEG is close to it, and without any symmetry.
Photograph smooth_picture(int width, int height) {
  Photograph photo;
  photo.width = width;
  photo.height = height;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const double u = static_cast<double>(i) / width, v = static_cast<double>(j) / height;
      for (const double c : {40 + 180 * u, 30 + 90 * v + 60 * u * u, 200 - 120 * u * v})
        photo.rgb.push_back(static_cast<std::uint8_t>(c));
    }
  }
  return photo;
}

std::string photograph_refusal(const std::string& bytes) {
  return test::error_if_any([&] { decode_photograph(bytes, "p.jpg"); });
}

double largest_difference(const Photograph& a, const Photograph& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.rgb.size(); ++k)
    most = std::max(most, std::abs(static_cast<double>(a.rgb[k]) - b.rgb[k]));
  return most;
}

TEST(Photograph, PngKeepsEveryPixel) {
  const Photograph photo = smooth_picture(97, 61);
  const std::string bytes = test::png_bytes(photo);
  const Photograph read = decode_photograph(bytes, "p.png");
  EXPECT_EQ(read.width, 97);
  EXPECT_EQ(read.height, 61);
  EXPECT_EQ(read.rgb, photo.rgb);
  EXPECT_EQ(read.file, "p.png");
  EXPECT_EQ(read.hash, sha256(bytes));
}

TEST(Photograph, JpegIsClose) {
  const Photograph photo = smooth_picture(97, 61);
  const Photograph read = decode_photograph(test::jpeg_bytes(photo, 95), "p.jpg");
  ASSERT_EQ(read.rgb.size(), photo.rgb.size());
  EXPECT_LT(largest_difference(read, photo), 12);
}

// Where the pixel (i, j) of the upright picture is stored, as the Exif standard describes the
// eight values: what the first row and the first column of the stored picture are.
TEST(Photograph, EveryOrientationOfExifIsApplied) {
  const int width = 96, height = 64;
  const Photograph stored = smooth_picture(width, height);
  const std::string jpeg = test::jpeg_bytes(stored, 95);
  const Photograph plain = decode_photograph(jpeg, "p.jpg");
  for (const bool little : {false, true}) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
      SCOPED_TRACE(orientation);
      const Photograph read =
          decode_photograph(test::with_orientation(jpeg, orientation, little), "p.jpg");
      ASSERT_EQ(read.width, orientation >= 5 ? height : width);
      ASSERT_EQ(read.height, orientation >= 5 ? width : height);
      const int right = read.width - 1, low = read.height - 1;
      for (const auto& [i, j] : {std::pair{0, 0}, {95, 0}, {0, 63}, {95, 63}, {20, 50}}) {
        // Stored row 0 is the top (1, 2), bottom (3, 4), left side (5, 8) or right side (6, 7) of
        // the scene; stored column 0 is the left (1, 4), right (2, 3), top (5, 6) or bottom (7, 8).
        const bool side_rows = orientation >= 5;
        int x = side_rows ? j : i, y = side_rows ? i : j;
        if (orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7)
          x = right - x;
        if (orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8)
          y = low - y;
        EXPECT_EQ(read.at(x, y), plain.at(i, j)) << i << ' ' << j;
      }
    }
  }
}

// Headers that promise more than the limit, with hardly any data behind them.
TEST(Photograph, ASizeBeyondTheLimitIsRefusedBeforeDecoding) {
  const auto big_endian = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int k = bytes - 1; k >= 0; --k) text += static_cast<char>(value >> 8 * k);
    return text;
  };
  for (const std::uint32_t edge : {8001U, 60000U, 2147483647U, 4294967295U}) {
    std::string png = test::png_bytes(smooth_picture(40, 40));
    png.replace(16, 8, big_endian(edge, 4) + big_endian(edge, 4));
    EXPECT_THAT(photograph_refusal(png), HasSubstr("expected at most 64 million")) << edge;
  }
  std::string jpeg = test::jpeg_bytes(smooth_picture(40, 40));
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, big_endian(65000, 2) + big_endian(65000, 2));
  EXPECT_THAT(photograph_refusal(jpeg),
              HasSubstr("has 65000 x 65000 pixels; expected at most 64 million"));
  EXPECT_THAT(photograph_refusal(test::png_bytes(smooth_picture(31, 40))),
              HasSubstr("at least 32"));
}

TEST(Photograph, OtherFilesAreRefused) {
  for (const std::string& bytes :
       {std::string(), std::string("name = 1"), std::string("\x89PNG\r\n\x1a\n"),
        std::string("\xff\xd8\xff"), std::string("GIF89a\1\0\1\0", 10)}) {
    EXPECT_THAT(photograph_refusal(bytes), HasSubstr("expected a photograph in PNG or JPEG"));
  }
}

// A part of a file, or one with bytes that changed: an error of one line or a picture, and of a
// part always an error.
TEST(Photograph, DamagedFilesAreRefusedOrRead) {
  std::mt19937_64 random(4);
  const Photograph photo = smooth_picture(120, 80);
  for (const std::string& whole : {test::png_bytes(photo), test::jpeg_bytes(photo),
                                   test::with_orientation(test::jpeg_bytes(photo), 6, true)}) {
    for (int k = 0; k < 60; ++k) {
      const std::string part = whole.substr(0, random() % (whole.size() - 12));
      EXPECT_THAT(photograph_refusal(part), HasSubstr("p.jpg: "))
          << part.size() << " of " << whole.size();
      std::string changed = whole;
      for (int n = 0; n < 4; ++n) changed[random() % changed.size()] = static_cast<char>(random());
      const std::string message = photograph_refusal(changed);
      EXPECT_EQ(message.find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace firn
