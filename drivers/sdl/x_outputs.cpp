#include "drivers/sdl/x_outputs.hpp"

#include <X11/Xatom.h>
#include <X11/extensions/Xrandr.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

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
  constexpr long kWords = 32;  // the base block of 128 bytes
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

}  // namespace ovws::sdl
