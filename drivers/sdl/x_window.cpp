/// SLM window on an X server: an override-redirect window, created by Xlib and drawn by SDL.
#include <X11/Xatom.h>
#include <X11/Xutil.h>
#include <X11/extensions/dpms.h>

#include <algorithm>
#include <span>

#include "core/port/clock.hpp"
#include "drivers/sdl/refresh_clock.hpp"
#include "drivers/sdl/slm_window.hpp"
#include "drivers/sdl/x_server.hpp"

namespace ovws::sdl {

namespace {

struct DestroyImage {
  void operator()(XImage* image) const { XDestroyImage(image); }
};
using Picture = std::unique_ptr<XImage, DestroyImage>;

Error lost_server() {
  return {Errc::device, "slm.display",
          "the connection to the X server was lost (the server ended or closed it); start the "
          "server; ovwsd then opens the display by itself"};
}

constexpr std::int64_t kNoRefreshNs = 1'000'000'000;
constexpr const char* kHowToKeep =
    "; if this repeats, exclude the window from the desktop's window management";

Cursor make_blank_cursor(XDisplay* display, Window window) {
  const char nothing = 0;
  XColor black{};
  const Pixmap pixmap = XCreateBitmapFromData(display, window, &nothing, 1, 1);
  const Cursor cursor = XCreatePixmapCursor(display, pixmap, pixmap, &black, &black, 0, 0);
  XFreePixmap(display, pixmap);
  return cursor;
}

// Creates an override-redirect window: no window manager moves, decorates, iconifies or focuses it.
// The server paints the window black until the first image, so that the SLM does not flash.
Window create_window(XDisplay* display, const Output& output) {
  const int screen = DefaultScreen(display);
  constexpr long kPointerAndKeys =
      KeyPressMask | KeyReleaseMask | ButtonPressMask | ButtonReleaseMask | PointerMotionMask;
  XSetWindowAttributes wanted{};
  wanted.override_redirect = True;
  wanted.background_pixel = BlackPixel(display, screen);
  wanted.do_not_propagate_mask = kPointerAndKeys;  // so that clicks open no desktop menu
  wanted.event_mask = ExposureMask | StructureNotifyMask | VisibilityChangeMask;
  const Window window =
      XCreateWindow(display, DefaultRootWindow(display), output.x, output.y, unsigned(output.width),
                    unsigned(output.height), 0, CopyFromParent, InputOutput, CopyFromParent,
                    CWOverrideRedirect | CWBackPixel | CWDontPropagate | CWEventMask, &wanted);
  XStoreName(display, window, "ovws SLM");
  const long bypass = 1;  // asks the compositor to skip this window: it would delay it by a frame
  XChangeProperty(display, window, XInternAtom(display, "_NET_WM_BYPASS_COMPOSITOR", False),
                  XA_CARDINAL, 32, PropModeReplace, reinterpret_cast<const unsigned char*>(&bypass),
                  1);
  const Cursor cursor = make_blank_cursor(display, window);
  XDefineCursor(display, window, cursor);
  XFreeCursor(display, cursor);
  XMapRaised(display, window);
  XSync(display, False);  // the window must exist now: SDL uses it from another connection
  return window;
}

bool covers(const XWindowAttributes& above, const Output& output) {
  return above.map_state == IsViewable && above.c_class == InputOutput &&
         above.x < output.x + output.width && output.x < above.x + above.width &&
         above.y < output.y + output.height && output.y < above.y + above.height;
}

std::string title_of(XDisplay* display, Window window) {
  char* name = nullptr;
  if (!XFetchName(display, window, &name) || name == nullptr) return "without a name";
  std::string title = std::string("\"") + name + "\"";
  XFree(name);
  return title;
}

class XWindow final : public SlmWindow {
 public:
  XWindow(Connection display, Output output, const SdlConfig& config)
      : SlmWindow(config), display_(std::move(display)), output_(std::move(output)) {
    info_ = {output_.name, output_.width, output_.height, output_.refresh_hz, "x11"};
  }

  ~XWindow() override {
    canvas_.reset();  // before display_ closes, which destroys the X window
    video_.reset();
  }
  XWindow(const XWindow&) = delete;
  XWindow& operator=(const XWindow&) = delete;

  Result<void> open() {
    auto video = Video::open("x11");
    if (!video) return fail(video.error());
    video_ = std::move(*video);
    if (!output_.linear_gamma) set_linear_gamma(display_.get(), output_);
    if (power_of(display_.get()).asleep) DPMSForceLevel(display_.get(), DPMSModeOn);
    window_ = create_window(display_.get(), output_);
    // NOLINTNEXTLINE(performance-no-int-to-ptr): how SDL takes an X window
    canvas_.reset(SDL_CreateWindowFrom(reinterpret_cast<void*>(window_)));
    if (x_server_lost()) return fail(lost_server());
    if (canvas_ == nullptr) return fail(changed(std::string("SDL: ") + SDL_GetError()));
    if (output_.refresh_hz > 0.0) {
      refreshes_ = RefreshClock::open(std::uint32_t(window_), output_.refresh_hz);
    }
    return verify();
  }

  Events take_events() override {
    SDL_PumpEvents();
    SDL_FlushEvents(SDL_FIRSTEVENT, SDL_LASTEVENT);
    Events seen;
    while (XPending(display_.get()) > 0) {
      XEvent event;
      XNextEvent(display_.get(), &event);
      seen.redraw |= event.type == Expose;
      seen.verify_needed |= event.type != Expose;
    }
    take_x_error();  // dropped: SDL queries outputs that may be gone; only drawing errors count
    return seen;
  }

  std::int64_t wait_for_refresh() override {
    // Without an answer (the output is off, or the server is busy) no wait in the next second.
    if (!refreshes_ || monotonic_ns() < next_refresh_ns_) return 0;
    const std::int64_t refresh_ns = refreshes_->wait();
    if (refresh_ns == 0) next_refresh_ns_ = monotonic_ns() + kNoRefreshNs;
    return refresh_ns;
  }

  Result<void> connection() override {
    if (x_server_lost()) return fail(lost_server());
    const std::string refusal = take_x_error();
    if (refusal.empty()) return {};
    return fail(
        changed("the X server refused to draw the hologram: " + refusal + "; run ovws doctor"));
  }

  Result<Image<std::uint32_t>> read_back() override {
    const Window root = DefaultRootWindow(display_.get());
    const Picture seen(XGetImage(display_.get(), root, output_.x, output_.y,
                                 unsigned(output_.width), unsigned(output_.height), AllPlanes,
                                 ZPixmap));
    if (x_server_lost()) return fail(lost_server());
    if (seen == nullptr) {
      take_x_error();
      return fail(Errc::unavailable, "slm.display",
                  "the X server returned no image of output " + output_.name +
                      ": check that the output is on");
    }
    return colours_of(*seen);
  }

  Result<void> verify() override {
    const auto outputs = read_outputs(display_.get());
    const auto now = std::ranges::find(outputs, output_.name, &Output::name);
    if (x_server_lost()) return fail(lost_server());
    if (now == outputs.end()) return fail(changed("output " + output_.name + " is gone"));
    if (auto result = verify_output(*now); !result) return result;
    auto result = verify_window();
    if (x_server_lost()) return fail(lost_server());
    return result;
  }

 private:
  Result<void> verify_output(const Output& now) {
    if (const auto mode = check_mode(now, config_); !mode) {
      return fail({Errc::device, mode.error().field, mode.error().reason});
    }
    if (!now.connected && output_.connected) {
      return fail(changed("the monitor was unplugged from output " + output_.name));
    }
    if (now.x != output_.x || now.y != output_.y) {
      return fail(changed("output " + output_.name + " was moved on the desktop"));
    }
    if (!now.linear_gamma) {
      return fail(changed("the gamma ramp of output " + output_.name +
                          " is not linear, so the SLM does not get the exact grey levels; stop the "
                          "night-light or colour-management program that changed it"));
    }
    if (power_of(display_.get()).asleep) {
      return fail(changed("the screens are powered down: run xset dpms force on"));
    }
    return {};
  }

  Result<void> verify_window() {
    XWindowAttributes is{};
    if (!XGetWindowAttributes(display_.get(), window_, &is)) {
      return fail(changed("the SLM's window was destroyed"));
    }
    if (is.map_state != IsViewable)
      return fail(changed(std::string("the SLM's window was hidden or minimised") + kHowToKeep));
    if (is.x != output_.x || is.y != output_.y || is.width != output_.width ||
        is.height != output_.height) {
      return fail(changed("the SLM's window was moved or resized and no longer covers output " +
                          output_.name + kHowToKeep));
    }
    return verify_on_top();
  }

  Result<void> verify_on_top() {
    Window root = None, parent = None;
    Window* list = nullptr;
    unsigned count = 0;
    if (!XQueryTree(display_.get(), DefaultRootWindow(display_.get()), &root, &parent, &list,
                    &count)) {
      return {};  // XQueryTree fails only if the connection broke, which the caller checks
    }
    const std::span all(list, count);  // stacking order, bottom window first
    Window above = None;
    for (auto it = std::ranges::find(all, window_); it != all.end(); ++it) {
      XWindowAttributes other{};
      if (*it == window_ || !XGetWindowAttributes(display_.get(), *it, &other)) continue;
      if (covers(other, output_)) above = *it;
    }
    if (list != nullptr) XFree(list);
    take_x_error();  // dropped: a window that closed during the check is no fault
    if (above == None) return {};
    return fail(changed("a window " + title_of(display_.get(), above) + " covers output " +
                        output_.name + "; close it or move it"));
  }

  Connection display_;
  std::unique_ptr<RefreshClock> refreshes_;  ///< null: the server does not tell them
  std::int64_t next_refresh_ns_ = 0;
  Output output_;
  Window window_ = None;  // the X server destroys it when display_ closes
};

}  // namespace

Result<std::unique_ptr<Display>> open_x_window(const SdlConfig& config) {
  auto connected = connect_to_x();
  if (!connected) return fail(connected.error());
  Connection display = std::move(*connected);
  if (DefaultDepth(display.get(), DefaultScreen(display.get())) != kExactDepthBits) {
    return fail(Errc::refused, "slm.display",
                "the X server's colour depth is not 24, so grey levels would not be exact; set "
                "DefaultDepth 24 in its configuration");
  }
  const auto outputs = read_outputs(display.get());
  if (x_server_lost()) return fail(lost_server());
  auto output = choose_output(outputs, config);
  if (!output) return fail(output.error());
  auto window = std::make_unique<XWindow>(std::move(display), std::move(*output), config);
  if (const auto opened = window->open(); !opened) return fail(opened.error());
  return window;
}

}  // namespace ovws::sdl
