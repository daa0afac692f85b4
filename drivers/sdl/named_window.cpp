/// SLM window on Wayland and KMSDRM, which have no RandR: full screen on the SDL display with the
/// configured name.
#include "drivers/sdl/output.hpp"
#include "drivers/sdl/slm_window.hpp"

namespace ovws::sdl {

namespace {

// Lists SDL's displays as outputs. SDL does not report the primary output, so none is marked.
std::vector<Output> read_displays() {
  std::vector<Output> outputs;
  for (int i = 0; i < SDL_GetNumVideoDisplays(); ++i) {
    const char* name = SDL_GetDisplayName(i);
    SDL_Rect at{};
    SDL_DisplayMode mode{};
    if (name == nullptr || SDL_GetDisplayBounds(i, &at) != 0) continue;
    if (SDL_GetDesktopDisplayMode(i, &mode) != 0) continue;
    Output& out = outputs.emplace_back();
    out.name = name;
    out.connected = true;
    out.x = at.x;
    out.y = at.y;
    out.width = at.w;
    out.height = at.h;
    out.mode_width = mode.w;
    out.mode_height = mode.h;
    out.refresh_hz = mode.refresh_rate;
  }
  return outputs;
}

int index_of(const std::string& name) {
  for (int i = 0; i < SDL_GetNumVideoDisplays(); ++i) {
    const char* its_name = SDL_GetDisplayName(i);
    if (its_name != nullptr && name == its_name) return i;
  }
  return -1;
}

class NamedWindow final : public SlmWindow {
 public:
  NamedWindow(std::unique_ptr<Video> video, const Output& output, const SdlConfig& config)
      : SlmWindow(config) {
    video_ = std::move(video);
    info_ = {output.name, output.width, output.height, output.refresh_hz,
             SDL_GetCurrentVideoDriver()};
  }

  Result<void> open() {
    const int place = SDL_WINDOWPOS_UNDEFINED_DISPLAY(index_of(info_.output));
    // ALLOW_HIGHDPI makes SDL report the size in physical pixels, so that scaling is detected.
    canvas_.reset(SDL_CreateWindow(
        "ovws SLM", place, place, info_.width, info_.height,
        SDL_WINDOW_FULLSCREEN_DESKTOP | SDL_WINDOW_BORDERLESS | SDL_WINDOW_ALLOW_HIGHDPI));
    if (canvas_ == nullptr) return fail(changed(std::string("SDL: ") + SDL_GetError()));
    SDL_ShowCursor(SDL_DISABLE);
    take_events();  // processes the compositor's first answer, which contains the real window size
    return verify();
  }

  Events take_events() override {
    Events seen;
    SDL_Event event;
    while (SDL_PollEvent(&event)) {
      lost_ |= event.type == SDL_QUIT;  // SDL reports SDL_QUIT when the compositor ends
      seen.redraw |= event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_EXPOSED;
      seen.verify_needed |= event.type == SDL_WINDOWEVENT || event.type == SDL_DISPLAYEVENT;
    }
    return seen;
  }

  Result<void> connection() override {
    if (lost_) return fail(changed("the compositor ended or closed the SLM's window"));
    return {};
  }

  Result<Image<std::uint32_t>> read_back() override {
    return fail(Errc::unavailable, "slm.display",
                std::string(info_.driver) +
                    " does not let programs read the pixels of an output: use an X11 session");
  }

  Result<void> verify() override {
    const int index = index_of(info_.output);
    if (index < 0) return fail(changed("output " + info_.output + " is gone"));
    for (const Output& now : read_displays()) {
      if (now.name != info_.output) continue;
      if (const auto mode = check_mode(now, config_); !mode) {
        return fail({Errc::device, mode.error().field, mode.error().reason});
      }
    }
    const Uint32 flags = SDL_GetWindowFlags(canvas_.get());
    int width = 0, height = 0;
    SDL_GetWindowSizeInPixels(canvas_.get(), &width, &height);
    if (!(flags & SDL_WINDOW_SHOWN) || (flags & SDL_WINDOW_MINIMIZED)) {
      return fail(
          changed("the SLM's window was hidden or minimised: exclude it from window management"));
    }
    if (SDL_GetWindowDisplayIndex(canvas_.get()) != index || width != info_.width ||
        height != info_.height) {
      return fail(changed("the SLM's window does not cover output " + info_.output +
                          " pixel for pixel; set the output's scale to 1"));
    }
    return {};
  }

 private:
  bool lost_ = false;
};

}  // namespace

Result<std::unique_ptr<Display>> open_named_window(const std::string& driver,
                                                   const SdlConfig& config) {
  auto video = Video::open(driver);
  if (!video) return fail(video.error());
  const auto output = choose_output(read_displays(), config);
  if (!output) return fail(output.error());
  auto window = std::make_unique<NamedWindow>(std::move(*video), *output, config);
  if (const auto opened = window->open(); !opened) return fail(opened.error());
  return window;
}

}  // namespace ovws::sdl
