#include "drivers/sdl/x_server.hpp"

#include <X11/Xatom.h>
#include <X11/Xutil.h>
#include <X11/extensions/Xrandr.h>
#include <X11/extensions/dpms.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>

#include "drivers/sdl/video.hpp"

namespace {

// Global, because Xlib's handlers are per process and take no user data.
bool lost = false;
std::array<char, 128> refusal{};

int on_broken_connection(Display*) {
  lost = true;
  return 0;
}

void on_io_error_exit(Display*, void*) {
  lost = true;
}

int on_request_error(Display* display, XErrorEvent* event) {
  XGetErrorText(display, event->error_code, refusal.data(), int(refusal.size()));
  return 0;
}

}  // namespace

// Symbol interposition: the dynamic linker prefers these functions to those of libX11 and libXi, in
// SDL, too. NOLINTBEGIN(readability-identifier-naming): Xlib's names

extern "C" Display* XOpenDisplay(const char* name) {
  using Open = Display* (*)(const char*);
  static const auto open = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "XOpenDisplay"));
  Display* display = open(name);
  if (display != nullptr) XSetIOErrorExitHandler(display, on_io_error_exit, nullptr);
  return display;
}

// Null check: SDL frees the list of input devices even if it is null because the server ended.
extern "C" void XIFreeDeviceInfo(void* list) {
  using Free = void (*)(void*);
  static const auto free_list = reinterpret_cast<Free>(dlsym(RTLD_NEXT, "XIFreeDeviceInfo"));
  if (list != nullptr) free_list(list);
}

// NOLINTEND(readability-identifier-naming)

namespace ovws::sdl {
namespace {

template <auto Free>
struct Freer {
  template <class T>
  void operator()(T* pointer) const {
    Free(pointer);
  }
};
using Resources = std::unique_ptr<XRRScreenResources, Freer<XRRFreeScreenResources>>;
using OutputInfo = std::unique_ptr<XRROutputInfo, Freer<XRRFreeOutputInfo>>;
using CrtcInfo = std::unique_ptr<XRRCrtcInfo, Freer<XRRFreeCrtcInfo>>;
using Gamma = std::unique_ptr<XRRCrtcGamma, Freer<XRRFreeGamma>>;

int ramp_value(int i, int size) {
  return int(65535L * i / (size - 1));
}

bool is_linear(XDisplay* display, RRCrtc crtc) {
  const Gamma gamma(XRRGetCrtcGamma(display, crtc));
  if (gamma == nullptr || gamma->size < 2) return true;  // the driver has no gamma ramp
  constexpr int kOneGreyLevel = 256;
  for (int i = 0; i < gamma->size; ++i) {
    const int expected = ramp_value(i, gamma->size);
    for (const unsigned short* channel : {gamma->red, gamma->green, gamma->blue}) {
      if (std::abs(int(channel[i]) - expected) >= kOneGreyLevel) return false;
    }
  }
  return true;
}

std::string read_monitor_name(XDisplay* display, RROutput output) {
  constexpr long kWords = 32;  // EDID base block: 128 bytes in words of 4 bytes
  Atom type = None;
  int format = 0;
  unsigned long count = 0, rest = 0;
  unsigned char* bytes = nullptr;
  const Atom edid = XInternAtom(display, RR_PROPERTY_RANDR_EDID, False);
  const int status = XRRGetOutputProperty(display, output, edid, 0, kWords, False, False,
                                          AnyPropertyType, &type, &format, &count, &rest, &bytes);
  if (status != Success || bytes == nullptr) return {};
  const std::unique_ptr<unsigned char, Freer<XFree>> owner(bytes);
  return format == 8 ? edid_monitor_name({bytes, count}) : std::string{};
}

double refresh_hz(const XRRModeInfo& mode) {
  double lines = mode.vTotal;
  if (mode.modeFlags & RR_DoubleScan) lines *= 2.0;
  if (mode.modeFlags & RR_Interlace) lines /= 2.0;
  const double pixels = lines * mode.hTotal;
  return pixels > 0.0 ? double(mode.dotClock) / pixels : 0.0;
}

void read_crtc(XDisplay* display, const Resources& resources, RRCrtc crtc, Output& out) {
  const CrtcInfo info(XRRGetCrtcInfo(display, resources.get(), crtc));
  if (info == nullptr || info->mode == None) return;
  out.crtc = crtc;
  out.x = info->x;
  out.y = info->y;
  out.width = int(info->width);
  out.height = int(info->height);
  out.upright = info->rotation == RR_Rotate_0;
  out.linear_gamma = is_linear(display, crtc);
  const std::span modes(resources->modes, std::size_t(resources->nmode));
  const auto mode = std::ranges::find(modes, info->mode, &XRRModeInfo::id);
  if (mode == modes.end()) return;
  out.mode_width = int(mode->width);
  out.mode_height = int(mode->height);
  out.refresh_hz = refresh_hz(*mode);
}

}  // namespace

Result<Connection> connect_to_x() {
  XSetIOErrorHandler(on_broken_connection);
  XSetErrorHandler(on_request_error);
  if (!Video::is_open()) {
    lost = false;
    refusal[0] = '\0';
  }
  Connection display(XOpenDisplay(nullptr));
  if (display != nullptr) return display;
  return fail(Errc::unavailable, "slm.display",
              "the X server DISPLAY=" + environment("DISPLAY") +
                  " does not answer: start it, and give this user access to it (XAUTHORITY)");
}

Power power_of(XDisplay* display) {
  int event_base = 0, error_base = 0;
  CARD16 level = DPMSModeOn;
  BOOL enabled = False;
  if (!DPMSQueryExtension(display, &event_base, &error_base) || !DPMSCapable(display) ||
      !DPMSInfo(display, &level, &enabled) || !enabled) {
    return {};
  }
  return {true, level != DPMSModeOn};
}

bool x_server_lost() {
  return lost;
}

std::string take_x_error() {
  std::string text = refusal.data();
  refusal[0] = '\0';
  return text;
}

std::vector<Output> read_outputs(XDisplay* display) {
  std::vector<Output> outputs;
  const Window root = DefaultRootWindow(display);
  const Resources resources(XRRGetScreenResourcesCurrent(display, root));
  if (resources == nullptr) return outputs;
  const RROutput primary = XRRGetOutputPrimary(display, root);
  for (const RROutput id : std::span(resources->outputs, std::size_t(resources->noutput))) {
    const OutputInfo info(XRRGetOutputInfo(display, resources.get(), id));
    if (info == nullptr) continue;
    Output& out = outputs.emplace_back();
    out.name.assign(info->name, std::size_t(info->nameLen));
    out.connected = info->connection != RR_Disconnected;
    out.primary = id == primary;
    if (out.connected) out.monitor = read_monitor_name(display, id);
    if (info->crtc != None) read_crtc(display, resources, info->crtc, out);
  }
  return outputs;
}

void set_linear_gamma(XDisplay* display, const Output& output) {
  const int size = XRRGetCrtcGammaSize(display, output.crtc);
  if (size < 2) return;
  const Gamma gamma(XRRAllocGamma(size));
  if (gamma == nullptr) return;
  for (int i = 0; i < size; ++i) {
    const auto value = static_cast<unsigned short>(ramp_value(i, size));
    gamma->red[i] = gamma->green[i] = gamma->blue[i] = value;
  }
  XRRSetCrtcGamma(display, output.crtc, gamma.get());
  XSync(display, False);
}

Result<Image<std::uint32_t>> colours_of(XImage& image) {
  const bool eight_bits = image.depth == 24 && image.red_mask == 0xff0000UL &&
                          image.green_mask == 0x00ff00UL && image.blue_mask == 0x0000ffUL;
  if (!eight_bits) {
    return fail(Errc::unavailable, "slm.display",
                "the X server's image of the output does not have 8 bits per colour: set "
                "DefaultDepth 24 in its configuration");
  }
  Image<std::uint32_t> picture(image.width, image.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      picture.at(x, y) = std::uint32_t(XGetPixel(&image, x, y) & 0xffffffU);
    }
  }
  return picture;
}

}  // namespace ovws::sdl
