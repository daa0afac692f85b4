#include "drivers/sdl/x_guard.hpp"

#include <X11/Xlib.h>
#include <dlfcn.h>

#include <array>

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

// Symbol interposition: the dynamic linker finds these before those of libX11 and libXi, for SDL
// too. NOLINTBEGIN(readability-identifier-naming): Xlib's names

extern "C" Display* XOpenDisplay(const char* name) {
  using Open = Display* (*)(const char*);
  static const auto open = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "XOpenDisplay"));
  Display* display = open(name);
  if (display != nullptr) XSetIOErrorExitHandler(display, on_io_error_exit, nullptr);
  return display;
}

// SDL frees the list of input devices even if it is null because the server died.
extern "C" void XIFreeDeviceInfo(void* list) {
  using Free = void (*)(void*);
  static const auto free_list = reinterpret_cast<Free>(dlsym(RTLD_NEXT, "XIFreeDeviceInfo"));
  if (list != nullptr) free_list(list);
}

// NOLINTEND(readability-identifier-naming)

namespace ovws::sdl {

void guard_x_connections() {
  XSetIOErrorHandler(on_broken_connection);
  XSetErrorHandler(on_request_error);
  lost = false;
  refusal[0] = '\0';
}

bool x_server_lost() {
  return lost;
}

std::string take_x_error() {
  std::string text = refusal.data();
  refusal[0] = '\0';
  return text;
}

}  // namespace ovws::sdl
