#include "drivers/twin/pixel_bytes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/pixel_bytes.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

void BlueBytes(const std::uint32_t* pixels, int count, std::uint8_t* blue) {
  const hn::ScalableTag<std::uint32_t> words;
  const hn::Rebind<std::uint8_t, decltype(words)> bytes;
  const int lanes = int(hn::Lanes(words));
  int k = 0;
  for (; k + lanes <= count; k += lanes) {
    hn::StoreU(hn::TruncateTo(bytes, hn::LoadU(words, pixels + k)), bytes, blue + k);
  }
  for (; k < count; ++k) blue[k] = std::uint8_t(pixels[k]);
}

void BitBytes(const std::uint32_t* pixels, int count, int bit, std::uint8_t* out) {
  const hn::ScalableTag<std::uint32_t> words;
  const hn::Rebind<std::uint8_t, decltype(words)> bytes;
  const auto mask = hn::Set(words, 1U << bit);
  const int lanes = int(hn::Lanes(words));
  int k = 0;
  for (; k + lanes <= count; k += lanes) {
    const auto set = hn::Ne(hn::And(hn::LoadU(words, pixels + k), mask), hn::Zero(words));
    hn::StoreU(hn::TruncateTo(bytes, hn::VecFromMask(words, set)), bytes, out + k);
  }
  for (; k < count; ++k) out[k] = (pixels[k] >> bit & 1U) != 0 ? 255 : 0;
}

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(BlueBytes);
HWY_EXPORT(BitBytes);

void blue_bytes(const std::uint32_t* pixels, int count, std::uint8_t* blue) {
  HWY_DYNAMIC_DISPATCH(BlueBytes)(pixels, count, blue);
}

void bit_bytes(const std::uint32_t* pixels, int count, int bit, std::uint8_t* bytes) {
  HWY_DYNAMIC_DISPATCH(BitBytes)(pixels, count, bit, bytes);
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
