// LD_PRELOAD library that makes a library's switch of the locale last. SDL switches the process to
// the environment's locale each time it opens an output, and back some 0.1 s later; here the first
// switch remains, so that what happens meanwhile is the same in every run. localeconv still answers
// as before it: the parser of a JSON text asks when it begins, and the switch may come later. The
// decimal point that the switch brings is written to the file $OVWS_LOCALE_SEEN.
#include <dlfcn.h>
#include <fcntl.h>
#include <locale.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<bool> stuck{false};

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

lconv* real_localeconv() {
  static const auto real = next<lconv* (*)()>("localeconv");
  return real();
}

void note_decimal_point() {
  const char* const path = std::getenv("OVWS_LOCALE_SEEN");
  const int fd =
      path == nullptr ? -1 : ::open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) std::abort();
  const char* const point = real_localeconv()->decimal_point;
  if (::write(fd, point, std::strlen(point)) < 0) std::abort();
  ::close(fd);
}

}  // namespace

extern "C" {

lconv* localeconv() noexcept {
  static char point[] = ".";
  static lconv before = *real_localeconv();
  before.decimal_point = point;
  return &before;
}

char* setlocale(int category, const char* name) noexcept {
  static const auto real = next<char* (*)(int, const char*)>("setlocale");
  if (name == nullptr || stuck) return real(category, nullptr);
  char* const used = real(category, name);
  if (category == LC_ALL && *name == '\0') {
    stuck = true;
    note_decimal_point();
  }
  return used;
}
}
