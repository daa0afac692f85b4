/// Camera pixel formats (GenICam PFNC): memory layout, bit depth and Bayer colour planes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/vec2.hpp"

namespace ovws {

/// Formats of GenICam's Pixel Format Naming Convention (PFNC) 2.4. Words are little-endian.
enum class PixelFormat : std::uint8_t {
  mono8,
  mono10,
  mono12,
  mono14,
  mono16,
  mono10p,
  mono12p,
  mono10_packed,
  mono12_packed,
  bayer_rg8,
  bayer_gr8,
  bayer_gb8,
  bayer_bg8,
  bayer_rg10,
  bayer_gr10,
  bayer_gb10,
  bayer_bg10,
  bayer_rg12,
  bayer_gr12,
  bayer_gb12,
  bayer_bg12,
  bayer_rg10p,
  bayer_gr10p,
  bayer_gb10p,
  bayer_bg10p,
  bayer_rg12p,
  bayer_gr12p,
  bayer_gb12p,
  bayer_bg12p,
};

/// Memory layout of the pixels of a row.
enum class PixelLayout : std::uint8_t {
  bytes,     ///< one byte a pixel
  words,     ///< two bytes a pixel, LSB-aligned
  p10,       ///< 10 bits a pixel without padding, from the first byte's lowest bit on
  p12,       ///< 12 bits a pixel without padding, bit order as in p10
  packed10,  ///< GigE Vision 1: 2 pixels in 3 bytes, the middle byte holds both pixels' low bits
  packed12,  ///< GigE Vision 1: 12-bit pixels, 2 in 3 bytes as in packed10
};

/// Bayer pattern: the colours in the first row of the repeating 2 x 2 square of filters.
enum class ColourFilter : std::uint8_t { none, rg, gr, gb, bg };

struct PixelFormatTraits {
  PixelFormat format;
  std::string_view name;  ///< "Mono8", …
  std::uint32_t code;     ///< PFNC code
  int bits;               ///< significant bits: 8, 10, 12, 14 or 16
  PixelLayout layout;
  ColourFilter filter;
};

std::span<const PixelFormatTraits> all_pixel_formats();
const PixelFormatTraits& traits_of(PixelFormat format);
int significant_bits(PixelFormat format);
double full_scale_dn(PixelFormat format);  ///< 2^significant_bits - 1
std::string_view pixel_format_name(PixelFormat format);
std::optional<PixelFormat> pixel_format_from_name(std::string_view name);
std::optional<PixelFormat> pixel_format_from_code(std::uint32_t code);

/// Bytes of a row of `width` pixels, rounded up, because every row begins at a byte boundary.
std::size_t row_bytes(PixelFormat format, int width);
/// Smallest number of pixels (1, 2 or 4) that fill whole bytes. Packed formats store pixels in
/// pairs, so their number is even. The width of an image must be a multiple of this number.
int pixels_per_group(PixelFormat format);

/// A Bayer colour plane: every `step`-th pixel of a camera image along both axes, from (x, y) on.
/// Step 1 selects the whole image.
struct ColourPlane {
  int step = 1;
  int x = 0, y = 0;

  bool everything() const { return step == 1; }
  bool has(int px, int py) const { return (px - x) % step == 0 && (py - y) % step == 0; }
  /// Number of the plane's pixels along an axis of `size` camera pixels, counted from `first`.
  int count(int size, int first) const { return (size - first + step - 1) / step; }
  /// Converts a position: to_image from plane pixels to camera pixels, from_image back.
  Vec2 to_image(Vec2 at) const { return {x + step * at.x, y + step * at.y}; }
  Vec2 from_image(Vec2 px) const { return {(px.x - x) / step, (px.y - y) / step}; }

  friend bool operator==(const ColourPlane&, const ColourPlane&) = default;
};

/// Camera pixels that detect the laser: all pixels of a monochrome camera, or the Bayer colour
/// plane whose filter passes the laser's wavelength.
struct LitPixels {
  ColourPlane plane{};
  bool diagonal = false;  ///< green laser: the diagonal plane, other(), detects it, too

  ColourPlane other() const { return {plane.step, plane.x ^ 1, plane.y ^ 1}; }
  /// Whether the laser reaches camera pixel (`px`, `py`).
  bool has(int px, int py) const { return plane.has(px, py) || (diagonal && other().has(px, py)); }

  /// Whether these are all pixels, or a plane of a Bayer pattern.
  bool exist() const {
    const bool bayer =
        plane.step == 2 && plane.x >= 0 && plane.x <= 1 && plane.y >= 0 && plane.y <= 1;
    return bayer || *this == LitPixels{};
  }

  friend bool operator==(const LitPixels&, const LitPixels&) = default;
};

/// Colour plane whose Bayer filter passes most of the laser: blue below 490 nm, red from 580 nm on,
/// green between. At 490 and 580 nm the transmission curves of common filters cross. The Bayer
/// pattern begins at the image's first pixel. A monochrome format gives all pixels.
LitPixels lit_pixels(PixelFormat format, double wavelength_nm);

}  // namespace ovws
