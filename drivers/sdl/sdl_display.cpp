#include "drivers/sdl/sdl_display.hpp"

#include <SDL.h>

#include "core/port/clock.hpp"
#include "drivers/sdl/output_window.hpp"
#include "drivers/sdl/video.hpp"

namespace ovws {

namespace {

constexpr std::int64_t kVerifyEveryNs = 1'000'000'000;

bool exact(const SDL_Surface& surface, const DisplayInfo& info) {
  const SDL_PixelFormat& format = *surface.format;
  return surface.w == info.width && surface.h == info.height && format.BytesPerPixel == 4 &&
         format.Rmask == 0xff0000 && format.Gmask == 0xff00 && format.Bmask == 0xff;
}

void expand(const Image<std::uint8_t>& grey, SDL_Surface& surface) {
  auto* row = static_cast<std::uint8_t*>(surface.pixels);
  for (int y = 0; y < grey.height; ++y, row += surface.pitch) {
    const std::uint8_t* from = grey.row(y);
    auto* to = reinterpret_cast<std::uint32_t*>(row);
    for (int x = 0; x < grey.width; ++x) to[x] = 0xff000000u | from[x] * 0x010101u;
  }
}

class SdlDisplay final : public Display {
 public:
  explicit SdlDisplay(std::unique_ptr<sdl::OutputWindow> window) : window_(std::move(window)) {}

  const DisplayInfo& info() const override { return window_->info(); }

  Result<std::int64_t> present(const Image<std::uint8_t>& grey) override {
    if (grey.width != info().width || grey.height != info().height ||
        grey.pixels.size() != std::size_t(grey.width) * grey.height) {
      return fail(Errc::invalid, "slm", "the image does not have the size of the display");
    }
    if (const auto alive = window_->connection(); !alive) return fail(alive.error());
    SDL_Surface* surface = SDL_GetWindowSurface(window_->window());
    if (surface == nullptr || !exact(*surface, info())) {
      return fail(
          Errc::device, "slm.display",
          "SDL provides no 32-bit surface of the display's size: " + std::string(SDL_GetError()));
    }
    expand(grey, *surface);
    if (const auto shown = flush(); !shown) return fail(shown.error());
    return monotonic_ns();
  }

  Result<Image<std::uint32_t>> read_back() override { return window_->read_back(); }

  Result<void> check() override {
    const auto events = window_->take_events();
    if (auto alive = window_->connection(); !alive) return alive;
    if (events.redraw) {
      if (auto shown = flush(); !shown) return shown;
    }
    const std::int64_t now = monotonic_ns();
    if (!events.verify_needed && now < verify_at_ns_) return {};
    verify_at_ns_ = now + kVerifyEveryNs;
    return window_->verify();
  }

 private:
  Result<void> flush() {
    if (SDL_UpdateWindowSurface(window_->window()) != 0) {
      return fail(Errc::device, "slm.display", std::string("SDL: ") + SDL_GetError());
    }
    return window_->connection();
  }

  std::unique_ptr<sdl::OutputWindow> window_;
  std::int64_t verify_at_ns_ = 0;
};

}  // namespace

Result<std::unique_ptr<Display>> open_sdl_display(const SdlConfig& config) {
  if (sdl::Video::is_open()) {
    return fail(Errc::refused, "slm.display", "a display is open already: close it first");
  }
  const auto driver = sdl::choose_driver();
  if (!driver) return fail(driver.error());
  auto window =
      *driver == "x11" ? sdl::open_x_window(config) : sdl::open_named_window(*driver, config);
  if (!window) return fail(window.error());
  auto display = std::make_unique<SdlDisplay>(std::move(*window));
  const Image<std::uint8_t> black(display->info().width, display->info().height);
  if (const auto shown = display->present(black); !shown) return fail(shown.error());
  return display;
}

}  // namespace ovws
