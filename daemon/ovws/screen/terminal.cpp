#include "daemon/ovws/screen/terminal.hpp"

#define NCURSES_NOMACROS
#include <langinfo.h>
#include <ncurses.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

namespace ovws::screen {
namespace {

constexpr short kBluePair = 1, kOrangePair = 2;
constexpr int kManyColours = 256;

/// Starts colour output if the terminal has colours and NO_COLOR is not set. Blue and orange are
/// distinguishable with colour blindness. Symbols and words repeat what the colours mean.
bool begin_colours() {
  const char* const no_colour = std::getenv("NO_COLOR");
  if ((no_colour != nullptr && *no_colour != '\0') || !has_colors()) return false;
  start_color();
  use_default_colors();
  const bool many = COLORS >= kManyColours;
  init_pair(kBluePair, many ? 39 : COLOR_CYAN, -1);
  init_pair(kOrangePair, many ? 208 : COLOR_YELLOW, -1);
  return true;
}

attr_t weight_of(Style style) {
  switch (style) {
    case Style::normal:
    case Style::positive:
    case Style::negative:
      return A_NORMAL;
    case Style::dim:
      return A_DIM;
    case Style::strong:
      return A_BOLD;
    case Style::title:
      return A_REVERSE;
    case Style::alarm:
      return A_REVERSE | A_BOLD;
  }
  return A_NORMAL;
}

short pair_of(Style style) {
  if (style == Style::positive) return kBluePair;
  return style == Style::negative || style == Style::alarm ? kOrangePair : 0;
}

}  // namespace

struct Terminal::Impl {
  SCREEN* screen = nullptr;
  bool unicode = false, colours = false;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (screen == nullptr) return;
    endwin();
    delscreen(screen);
  }
};

Terminal::Terminal(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Terminal::Terminal(Terminal&&) noexcept = default;
Terminal& Terminal::operator=(Terminal&&) noexcept = default;
Terminal::~Terminal() = default;

Result<Terminal> Terminal::open() {
  std::setlocale(LC_CTYPE, "");
  auto impl = std::make_unique<Impl>();
  impl->screen = newterm(nullptr, stdout, stdin);
  if (impl->screen == nullptr) {
    return fail(Errc::unavailable, "TERM",
                "this terminal does not support full-screen output: use --plain");
  }
  impl->unicode = std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
  impl->colours = begin_colours();
  cbreak();
  noecho();
  curs_set(0);
  keypad(stdscr, true);
  nodelay(stdscr, true);
  set_escdelay(25);
  return Terminal(std::move(impl));
}

Canvas Terminal::blank() const {
  return {getmaxx(stdscr), getmaxy(stdscr), impl_->unicode};
}

void Terminal::show(const Canvas& canvas) {
  werase(stdscr);
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width();) {
      const Style style = canvas.at(x, y).style;
      std::wstring run;
      const int begin = x;
      while (x < canvas.width() && canvas.at(x, y).style == style) {
        run += wchar_t(canvas.at(x++, y).glyph);
      }
      wattr_set(stdscr, weight_of(style), impl_->colours ? pair_of(style) : short(0), nullptr);
      mvwaddnwstr(stdscr, y, begin, run.c_str(), int(run.size()));
    }
  }
  wrefresh(stdscr);
}

int Terminal::key() {
  constexpr std::pair<int, char> kPagerKeys[]{{ERR, '\0'},      {KEY_UP, 'k'},    {KEY_DOWN, 'j'},
                                              {KEY_PPAGE, 'b'}, {KEY_NPAGE, 'f'}, {KEY_HOME, 'g'},
                                              {KEY_END, 'G'}};
  const int code = wgetch(stdscr);
  for (const auto& [known, key] : kPagerKeys) {
    if (code == known) return key;
  }
  return code;
}

}  // namespace ovws::screen
