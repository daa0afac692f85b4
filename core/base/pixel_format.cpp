#include "core/base/pixel_format.hpp"

#include <algorithm>
#include <array>

namespace ovws {
namespace {

using F = PixelFormat;
using L = PixelLayout;
using C = ColourFilter;

constexpr std::array<PixelFormatTraits, 29> kFormats{{
    {F::mono8, "Mono8", 0x01080001, 8, L::bytes, C::none},
    {F::mono10, "Mono10", 0x01100003, 10, L::words, C::none},
    {F::mono12, "Mono12", 0x01100005, 12, L::words, C::none},
    {F::mono14, "Mono14", 0x01100025, 14, L::words, C::none},
    {F::mono16, "Mono16", 0x01100007, 16, L::words, C::none},
    {F::mono10p, "Mono10p", 0x010a0046, 10, L::p10, C::none},
    {F::mono12p, "Mono12p", 0x010c0047, 12, L::p12, C::none},
    {F::mono10_packed, "Mono10Packed", 0x010c0004, 10, L::packed10, C::none},
    {F::mono12_packed, "Mono12Packed", 0x010c0006, 12, L::packed12, C::none},
    {F::bayer_rg8, "BayerRG8", 0x01080009, 8, L::bytes, C::rg},
    {F::bayer_gr8, "BayerGR8", 0x01080008, 8, L::bytes, C::gr},
    {F::bayer_gb8, "BayerGB8", 0x0108000a, 8, L::bytes, C::gb},
    {F::bayer_bg8, "BayerBG8", 0x0108000b, 8, L::bytes, C::bg},
    {F::bayer_rg10, "BayerRG10", 0x0110000d, 10, L::words, C::rg},
    {F::bayer_gr10, "BayerGR10", 0x0110000c, 10, L::words, C::gr},
    {F::bayer_gb10, "BayerGB10", 0x0110000e, 10, L::words, C::gb},
    {F::bayer_bg10, "BayerBG10", 0x0110000f, 10, L::words, C::bg},
    {F::bayer_rg12, "BayerRG12", 0x01100011, 12, L::words, C::rg},
    {F::bayer_gr12, "BayerGR12", 0x01100010, 12, L::words, C::gr},
    {F::bayer_gb12, "BayerGB12", 0x01100012, 12, L::words, C::gb},
    {F::bayer_bg12, "BayerBG12", 0x01100013, 12, L::words, C::bg},
    {F::bayer_rg10p, "BayerRG10p", 0x010a0058, 10, L::p10, C::rg},
    {F::bayer_gr10p, "BayerGR10p", 0x010a0056, 10, L::p10, C::gr},
    {F::bayer_gb10p, "BayerGB10p", 0x010a0054, 10, L::p10, C::gb},
    {F::bayer_bg10p, "BayerBG10p", 0x010a0052, 10, L::p10, C::bg},
    {F::bayer_rg12p, "BayerRG12p", 0x010c0059, 12, L::p12, C::rg},
    {F::bayer_gr12p, "BayerGR12p", 0x010c0057, 12, L::p12, C::gr},
    {F::bayer_gb12p, "BayerGB12p", 0x010c0055, 12, L::p12, C::gb},
    {F::bayer_bg12p, "BayerBG12p", 0x010c0053, 12, L::p12, C::bg},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kFormats.size(); ++i) {
    if (kFormats[i].format != F(i)) return false;
  }
  return true;
}
static_assert(in_order());  // traits_of uses the enum value as index

struct LayoutTraits {
  int bits_in_memory, pixels_per_group;
};
constexpr std::array<LayoutTraits, 6> kLayouts{
    {{8, 1}, {16, 1}, {10, 4}, {12, 2}, {12, 2}, {12, 2}}};  // in the order of PixelLayout

const LayoutTraits& layout_of(PixelFormat format) {
  return kLayouts[std::size_t(traits_of(format).layout)];
}

constexpr double kBlueToGreenNm = 490.0, kGreenToRedNm = 580.0;

}  // namespace

std::span<const PixelFormatTraits> all_pixel_formats() {
  return kFormats;
}

const PixelFormatTraits& traits_of(PixelFormat format) {
  return kFormats[std::size_t(format)];
}

int significant_bits(PixelFormat format) {
  return traits_of(format).bits;
}

double full_scale_dn(PixelFormat format) {
  return double((1 << significant_bits(format)) - 1);
}

std::string_view pixel_format_name(PixelFormat format) {
  return traits_of(format).name;
}

std::optional<PixelFormat> pixel_format_from_name(std::string_view name) {
  const auto at = std::ranges::find(kFormats, name, &PixelFormatTraits::name);
  return at == kFormats.end() ? std::nullopt : std::optional(at->format);
}

std::optional<PixelFormat> pixel_format_from_code(std::uint32_t code) {
  const auto at = std::ranges::find(kFormats, code, &PixelFormatTraits::code);
  return at == kFormats.end() ? std::nullopt : std::optional(at->format);
}

std::size_t row_bytes(PixelFormat format, int width) {
  return (std::size_t(width) * std::size_t(layout_of(format).bits_in_memory) + 7) / 8;
}

int pixels_per_group(PixelFormat format) {
  return layout_of(format).pixels_per_group;
}

LitPixels lit_pixels(PixelFormat format, double wavelength_nm) {
  const ColourFilter filter = traits_of(format).filter;
  if (filter == C::none) return {};
  // Red filter's corner of the 2 x 2 Bayer square. Blue is diagonal to red; green fills the rest.
  const int red_x = filter == C::gr || filter == C::bg ? 1 : 0;
  const int red_y = filter == C::gb || filter == C::bg ? 1 : 0;
  if (wavelength_nm >= kGreenToRedNm) return {{2, red_x, red_y}, false};
  if (wavelength_nm < kBlueToGreenNm) return {{2, red_x ^ 1, red_y ^ 1}, false};
  return {{2, red_x ^ 1, red_y}, true};
}

}  // namespace ovws
