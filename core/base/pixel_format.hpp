/// The pixel formats of cameras: how numbers lie in memory, and which pixels see the laser.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/vec2.hpp"

namespace ovws {

/// GenICam's names (PFNC, the "Pixel Format Naming Convention", 2.4). Words are little-endian.
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

/// How the numbers of a row follow one another.
enum class PixelLayout : std::uint8_t {
  bytes,     ///< one each
  words,     ///< two bytes each, the number in the low bits
  p10,       ///< 10 bits each, from the lowest bit of the first byte on
  p12,       ///< 12 bits each, the same way
  packed10,  ///< GigE Vision 1: two in three bytes, the middle one with the low bits of both
  packed12,  ///< the same, of 12 bits
};

/// Colours of the square of two by two filters that repeats over the sensor, first row first.
enum class ColourFilter : std::uint8_t { none, rg, gr, gb, bg };

struct PixelFormatTraits {
  PixelFormat format;
  std::string_view name;  ///< "Mono8", …
  std::uint32_t code;     ///< PFNC's number
  int bits;               ///< that count: 8, 10, 12, 14 or 16
  PixelLayout layout;
  ColourFilter filter;
};

std::span<const PixelFormatTraits> all_pixel_formats();
const PixelFormatTraits& traits_of(PixelFormat format);
int significant_bits(PixelFormat format);
double full_scale_dn(PixelFormat format);  ///< of significant_bits
std::string_view pixel_format_name(PixelFormat format);
std::optional<PixelFormat> pixel_format_from_name(std::string_view name);
std::optional<PixelFormat> pixel_format_from_code(std::uint32_t code);

/// Bytes that `width` pixels of one row take; rows begin at whole bytes.
std::size_t row_bytes(PixelFormat format, int width);
/// The least number of pixels that fill whole bytes (and pairs): a row's length is a multiple of
/// it. 1, 2 or 4.
int pixels_per_group(PixelFormat format);

/// Every `step`-th pixel of a camera's image, along both axes, from (x, y) on.
struct PixelLattice {
  int step = 1;
  int x = 0, y = 0;

  bool everything() const { return step == 1; }
  /// How many of `size` pixels along an axis, from `first` on.
  int count(int size, int first) const { return (size - first + step - 1) / step; }
  /// Of a position among the lattice's pixels in the camera's pixels, and back.
  Vec2 to_image(Vec2 at) const { return {x + step * at.x, y + step * at.y}; }
  Vec2 from_image(Vec2 px) const { return {(px.x - x) / step, (px.y - y) / step}; }

  friend bool operator==(const PixelLattice&, const PixelLattice&) = default;
};

/// The pixels that see the laser: all of them, or those under the filters of its colour.
struct LitPixels {
  PixelLattice lattice{};
  bool diagonal = false;  ///< green: those at the other diagonal corner, other(), see it too

  PixelLattice other() const { return {lattice.step, lattice.x ^ 1, lattice.y ^ 1}; }

  friend bool operator==(const LitPixels&, const LitPixels&) = default;
};

/// By the filter that passes most: blue below 490 nm, red from 580 nm on, green between (where the
/// curves of the usual filters cross). The pattern counts from the image's first pixel.
LitPixels lit_pixels(PixelFormat format, double wavelength_nm);

/// Whether a picture in this format shows light where `lit` says: pictures without filters always
/// do.
bool shows(PixelFormat format, const LitPixels& lit);

}  // namespace ovws
