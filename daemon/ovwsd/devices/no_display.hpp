/// The display of a sensor without an SLM: accepts every image at once, and shows nothing.
#pragma once

#include "core/port/clock.hpp"
#include "core/port/display.hpp"

namespace ovws {

class NoDisplay final : public Display {
 public:
  NoDisplay(int width, int height) { info_ = {"none", width, height, 0.0, "none"}; }

  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& /*grey*/) override {
    return monotonic_ns();
  }
  Result<Image<std::uint32_t>> read_back() override {
    return fail(Errc::unavailable, "slm", "the sensor has no display");
  }
  Result<void> check() override { return {}; }

 private:
  DisplayInfo info_;
};

}  // namespace ovws
