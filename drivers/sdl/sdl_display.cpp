#include "drivers/sdl/sdl_display.hpp"

#include "core/port/clock.hpp"
#include "drivers/sdl/slm_window.hpp"

namespace ovws {

namespace {

constexpr std::int64_t kVerifyEveryNs = 1'000'000'000;

bool exact(const SDL_Surface& surface, const DisplayInfo& info) {
  const SDL_PixelFormat& format = *surface.format;
  return surface.w == info.width && surface.h == info.height && format.BytesPerPixel == 4 &&
         format.Rmask == 0xff0000 && format.Gmask == 0xff00 && format.Bmask == 0xff;
}

void expand(const Image<std::uint8_t>& levels, SDL_Surface& surface) {
  auto* row = static_cast<std::uint8_t*>(surface.pixels);
  for (int y = 0; y < levels.height; ++y, row += surface.pitch) {
    const std::uint8_t* from = levels.row(y);
    auto* to = reinterpret_cast<std::uint32_t*>(row);
    if (levels.width == surface.w) {
      for (int x = 0; x < surface.w; ++x) to[x] = 0xff000000u | from[x] * 0x010101u;
    } else {
      for (int x = 0; x < surface.w; ++x, from += 3) {
        to[x] = 0xff000000u | from[0] * 0x010000u | from[1] * 0x0100u | from[2];
      }
    }
  }
}

}  // namespace

Result<std::int64_t> sdl::SlmWindow::present(const Image<std::uint8_t>& levels) {
  if ((levels.width != info_.width && levels.width != 3 * info_.width) ||
      levels.height != info_.height ||
      levels.pixels.size() != std::size_t(levels.width) * levels.height) {
    return fail(Errc::invalid, "slm", "the image does not have the size of the display");
  }
  if (const auto alive = connection(); !alive) return fail(alive.error());
  SDL_Surface* surface = SDL_GetWindowSurface(canvas_.get());
  if (surface == nullptr || !exact(*surface, info_)) {
    return fail(
        Errc::device, "slm.display",
        "SDL provides no 32-bit surface of the display's size (" + std::string(SDL_GetError()) +
            "): check the output's mode and 24-bit colour, then restart the display system");
  }
  expand(levels, *surface);
  if (const auto shown = flush(); !shown) return fail(shown.error());
  return monotonic_ns();
}

Result<void> sdl::SlmWindow::check() {
  const auto events = take_events();
  if (auto alive = connection(); !alive) return alive;
  if (events.redraw) {
    if (auto shown = flush(); !shown) return shown;
  }
  const std::int64_t now = monotonic_ns();
  if (!events.verify_needed && now < verify_at_ns_) return {};
  verify_at_ns_ = now + kVerifyEveryNs;
  return verify();
}

Result<void> sdl::SlmWindow::flush() {
  if (SDL_UpdateWindowSurface(canvas_.get()) != 0) {
    return fail(Errc::device, "slm.display", std::string("SDL: ") + SDL_GetError());
  }
  return connection();
}

Result<std::unique_ptr<Display>> open_sdl_display(const SdlConfig& config) {
  if (sdl::Video::is_open()) {
    return fail(Errc::refused, "slm.display",
                "program error: the display was opened twice; restart ovwsd");
  }
  const auto driver = sdl::choose_driver();
  if (!driver) return fail(driver.error());
  auto display =
      *driver == "x11" ? sdl::open_x_window(config) : sdl::open_named_window(*driver, config);
  if (!display) return display;
  const Image<std::uint8_t> black((*display)->info().width, (*display)->info().height);
  if (const auto shown = (*display)->present(black); !shown) return fail(shown.error());
  return display;
}

}  // namespace ovws
