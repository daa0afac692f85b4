#include "drivers/twin/x_output.hpp"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XShm.h>
#include <X11/extensions/Xdamage.h>
#include <X11/extensions/Xrandr.h>
#include <sys/ipc.h>
#include <sys/mman.h>
#include <sys/shm.h>

#include <utility>

namespace ovws::twin {
namespace {

// Global, because Xlib's error callbacks have no context; only one thread uses Xlib.
bool x_error = false;

int note_error(::Display*, XErrorEvent*) {
  x_error = true;
  return 0;
}
int note_io_error(::Display*) {
  return 0;
}
void on_io_error_exit(::Display*, void* dead) {
  *static_cast<bool*>(dead) = true;
}

/// Whether no X error occurred since `x_error` was last cleared; waits for the server.
bool requests_succeeded(::Display* display) {
  XSync(display, False);
  return !std::exchange(x_error, false);
}

/// The moment of a server time: milliseconds of the machine's monotonic clock in 32 bits, which
/// wrap. A server with another clock, or that is ahead, counts as prompt.
std::chrono::steady_clock::time_point moment_of(Time server_ms) {
  constexpr std::uint32_t kLongestDelayMs = 10'000;
  const auto now = std::chrono::steady_clock::now();
  const auto now_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  const std::uint32_t age_ms = std::uint32_t(now_ms) - std::uint32_t(server_ms);
  return age_ms < kLongestDelayMs ? now - std::chrono::milliseconds(age_ms) : now;
}

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Rectangle of the output `name` on the X screen; an error lists the active outputs.
Result<Rectangle> find_output(::Display* display, const std::string& name) {
  Rectangle area;
  std::string names;
  bool found = false;
  XRRScreenResources* all = XRRGetScreenResourcesCurrent(display, DefaultRootWindow(display));
  for (int i = 0; all != nullptr && i < all->noutput; ++i) {
    XRROutputInfo* output = XRRGetOutputInfo(display, all, all->outputs[i]);
    if (output == nullptr) continue;
    XRRCrtcInfo* crtc = output->crtc != 0 ? XRRGetCrtcInfo(display, all, output->crtc) : nullptr;
    if (crtc != nullptr) names += std::string(names.empty() ? "" : ", ") + output->name;
    if (crtc != nullptr && name == output->name) {
      area = {crtc->x, crtc->y, int(crtc->width), int(crtc->height)};
      found = true;
    }
    if (crtc != nullptr) XRRFreeCrtcInfo(crtc);
    XRRFreeOutputInfo(output);
  }
  if (all != nullptr) XRRFreeScreenResources(all);
  if (found) return area;
  return fail(Errc::unavailable, "slm.display",
              "no output " + name + " is on; there are: " + (names.empty() ? "none" : names));
}

}  // namespace

struct XOutput::Impl {
  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();

  std::chrono::steady_clock::time_point changed_at;
  bool dead = false;  // set by Xlib's I/O error handler, which keeps this address
  ::Display* display = nullptr;
  Rectangle area;
  XShmSegmentInfo segment{};
  XImage* image = nullptr;
  Damage damage = 0;
  int damage_event = 0, randr_event = 0;

  Result<void> connect(const std::string& name);
  Result<void> watch(const std::string& output, int width, int height);
  bool share_memory();
};

XOutput::Impl::~Impl() {
  if (image != nullptr) {
    if (!dead) XShmDetach(display, &segment);
    shmdt(segment.shmaddr);
    image->data = nullptr;
    XDestroyImage(image);
  }
  if (display != nullptr) XCloseDisplay(display);
  x_error = false;
}

Result<void> XOutput::Impl::connect(const std::string& name) {
  XSetErrorHandler(note_error);
  XSetIOErrorHandler(note_io_error);
  display = XOpenDisplay(name.empty() ? nullptr : name.c_str());
  if (display == nullptr) {
    return fail(Errc::unavailable, "", "no X server answers at display '" + name + "'");
  }
  // Exit handler: without one, Xlib ends the process when the server ends.
  XSetIOErrorExitHandler(display, on_io_error_exit, &dead);
  int error = 0;
  if (!XDamageQueryExtension(display, &damage_event, &error) ||
      !XRRQueryExtension(display, &randr_event, &error) || !XShmQueryExtension(display)) {
    return fail(Errc::unavailable, "",
                "the X server at '" + name + "' lacks DAMAGE, RANDR or MIT-SHM");
  }
  return {};
}

bool XOutput::Impl::share_memory() {
  const int screen = DefaultScreen(display);
  XImage* shared = XShmCreateImage(display, DefaultVisual(display, screen),
                                   unsigned(DefaultDepth(display, screen)), ZPixmap, nullptr,
                                   &segment, unsigned(area.width), unsigned(area.height));
  if (shared == nullptr) return false;
  const std::size_t size = std::size_t(shared->bytes_per_line) * std::size_t(shared->height);
  segment.shmid = shmget(IPC_PRIVATE, size, IPC_CREAT | 0600);
  void* address = segment.shmid < 0 ? MAP_FAILED : shmat(segment.shmid, nullptr, 0);
  const bool mapped = address != MAP_FAILED;  // shmat reports failure as (void*)-1, too
  bool attached = false;
  if (mapped) {
    segment.shmaddr = static_cast<char*>(address);
    shared->data = segment.shmaddr;
    attached = XShmAttach(display, &segment) != 0 && requests_succeeded(display);
  }
  // Mark the segment for removal now: the kernel frees it once this process and the X server have
  // detached, even after a crash.
  if (segment.shmid >= 0) shmctl(segment.shmid, IPC_RMID, nullptr);
  const bool rgb = shared->bits_per_pixel == 32 && shared->red_mask == 0xff0000 &&
                   shared->blue_mask == 0xff && shared->byte_order == LSBFirst;
  if (attached && rgb) {
    image = shared;
    return true;
  }
  if (attached) XShmDetach(display, &segment);
  if (mapped) shmdt(segment.shmaddr);
  shared->data = nullptr;
  XDestroyImage(shared);
  return false;
}

Result<void> XOutput::Impl::watch(const std::string& output, int width, int height) {
  const auto found = find_output(display, output);
  if (!found) return fail(found.error());
  area = *found;
  if (area.width != width || area.height != height) {
    return fail(Errc::refused, "slm.width",
                output + " shows " + std::to_string(area.width) + " x " +
                    std::to_string(area.height) + ", the SLM has " + std::to_string(width) + " x " +
                    std::to_string(height) + " pixels");
  }
  if (!share_memory()) {
    return fail(Errc::unavailable, "slm.display",
                "the X server provides no shared-memory images of depth 24: run ovws-twin on the X "
                "server's machine, with 24-bit colour");
  }
  const Window root = DefaultRootWindow(display);
  XRRSelectInput(display, root, RRScreenChangeNotifyMask | RRCrtcChangeNotifyMask);
  damage = XDamageCreate(display, root, XDamageReportNonEmpty);
  if (!requests_succeeded(display) || dead) {
    return fail(
        Errc::unavailable, "",
        "the X server does not report changes of the screen: check that it still runs and has the "
        "extensions RANDR and DAMAGE");
  }
  return {};
}

XOutput::XOutput(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
XOutput::~XOutput() = default;

Result<std::unique_ptr<XOutput>> XOutput::open(const std::string& display,
                                               const std::string& output, int width, int height) {
  auto impl = std::make_unique<Impl>();
  if (auto done = impl->connect(display); !done) return fail(done.error());
  if (auto done = impl->watch(output, width, height); !done) return fail(done.error());
  return std::unique_ptr<XOutput>(new XOutput(std::move(impl)));
}

int XOutput::descriptor() const {
  return ConnectionNumber(impl_->display);
}

XOutput::Change XOutput::read_changes() {
  Change change = Change::none;
  while (!impl_->dead && XPending(impl_->display) > 0) {
    XEvent event;
    XNextEvent(impl_->display, &event);
    if (event.type == impl_->damage_event + XDamageNotify) {
      const auto& notice = reinterpret_cast<const XDamageNotifyEvent&>(event);
      if (change == Change::none) impl_->changed_at = moment_of(notice.timestamp);
      // Clear the damage before reading pixels, so that a change during the read is reported again.
      XDamageSubtract(impl_->display, impl_->damage, None, None);
      change = Change::pixels;
    } else if (event.type == impl_->randr_event + RRScreenChangeNotify ||
               event.type == impl_->randr_event + RRNotify) {
      return Change::lost;
    }
  }
  return impl_->dead || x_error ? Change::lost : change;
}

XOutput::Change XOutput::sync_changes() {
  if (!impl_->dead) XSync(impl_->display, False);
  return read_changes();
}

std::chrono::steady_clock::time_point XOutput::changed_at() const {
  return impl_->changed_at;
}

bool XOutput::grab(const std::function<void(const std::uint32_t* pixels, int y)>& visit_row) {
  const Rectangle& area = impl_->area;
  const bool received = XShmGetImage(impl_->display, DefaultRootWindow(impl_->display),
                                     impl_->image, area.x, area.y, AllPlanes) != 0;
  if (!received || impl_->dead || x_error) return false;
  for (int y = 0; y < area.height; ++y) {
    const char* const line = impl_->image->data + std::ptrdiff_t(y) * impl_->image->bytes_per_line;
    visit_row(reinterpret_cast<const std::uint32_t*>(line), y);
  }
  return true;
}

}  // namespace ovws::twin
