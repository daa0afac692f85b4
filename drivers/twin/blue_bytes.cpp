#include "drivers/twin/blue_bytes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/blue_bytes.cpp"
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

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(BlueBytes);

void blue_bytes(const std::uint32_t* pixels, int count, std::uint8_t* blue) {
  HWY_DYNAMIC_DISPATCH(BlueBytes)(pixels, count, blue);
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
