/// Keeps the C locale in the whole process. Every program has this file by ovws_program or
/// ovws_test_program, and it runs before main, so no program and no thread can forget it.
///
/// SDL calls setlocale(LC_ALL, "") each time it opens a window, and restores the locale up to 0.14
/// s later. In between, strtod would end every thread's numbers at the decimal point if the user's
/// locale has decimal commas. The environment therefore names the C locale, so that such calls
/// change nothing. It keeps the user's UTF-8, which terminals need and no number depends on.
#include <langinfo.h>

#include <clocale>
#include <cstdlib>
#include <cstring>

namespace {

bool hold_c_locale() {
  const bool is_utf8 =
      std::setlocale(LC_CTYPE, "") != nullptr && std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
  return ::setenv("LC_ALL", is_utf8 ? "C.UTF-8" : "C", 1) == 0 &&
         std::setlocale(LC_ALL, "C") != nullptr;
}

[[maybe_unused]] const bool is_held = hold_c_locale();

}  // namespace
