#include "drivers/twin/screen.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <thread>

#include "drivers/twin/x_output.hpp"

namespace ovws::twin {
namespace {

// Short enough to end at once when asked to, long enough to cost nothing.
constexpr int kPollMs = 50;
constexpr int kPollsBetweenTries = 6;

}  // namespace

Screen::Screen(const SlmConfig& slm, std::string x_display, Bench& bench)
    : slm_(slm), x_display_(std::move(x_display)), bench_(bench) {
  status_.text = "not looked for yet";
}

void Screen::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto output =
        XOutput::open(x_display_, slm_.display, slm_.geometry.width_px, slm_.geometry.height_px);
    if (output) {
      report(true, slm_.display);
      follow(**output, stop);
      if (!stop.stop_requested()) report(false, "the X server went away or changed its screens");
      bench_.go_dark();
    } else {
      report(false, output.error().reason);
    }
    for (int i = 0; i < kPollsBetweenTries && !stop.stop_requested(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPollMs));
    }
  }
}

void Screen::follow(XOutput& output, const std::stop_token& stop) {
  Image<std::uint8_t> grey;
  XOutput::News news = XOutput::News::pixels;
  while (!stop.stop_requested() && news != XOutput::News::lost) {
    if (news == XOutput::News::pixels) {
      if (!output.grab(grey)) return;
      bench_.show(grey);
      const std::lock_guard lock(mutex_);
      ++status_.grabs;
    }
    news = output.read_news();
    if (news != XOutput::News::none) continue;
    pollfd readable{output.descriptor(), POLLIN, 0};
    if (poll(&readable, 1, kPollMs) > 0) news = output.read_news();
  }
}

void Screen::report(bool shown, const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (status_.shown != shown || status_.text != text) {
    spdlog::info("display: {}", shown ? "reading " + text : text);
  }
  if (shown) ++status_.connects;
  status_.shown = shown;
  status_.text = text;
}

ScreenStatus Screen::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace ovws::twin
