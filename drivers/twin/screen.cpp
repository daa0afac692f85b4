#include "drivers/twin/screen.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <thread>

#include "drivers/twin/x_output.hpp"

namespace ovws::twin {
namespace {

constexpr int kPollMs = 50;  // longest wait for X events; short, so that a stop takes effect soon
constexpr auto kBetweenTries = std::chrono::milliseconds(300);

}  // namespace

Screen::Screen(const Config& config, std::string x_display, Bench& bench)
    : slm_(config.slm),
      dmd_(config.dmd),
      x_display_(std::move(x_display)),
      bench_(bench),
      wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  status_.text = "not connected yet";
}

Screen::~Screen() {
  close(wake_fd_);
}

void Screen::work(const std::stop_token& stop) {
  if (slm_.display.empty()) return report(false, "the bench has no display");
  while (!stop.stop_requested()) {
    auto output =
        XOutput::open(x_display_, slm_.display, slm_.geometry.width_px, slm_.geometry.height_px);
    if (output) {
      report(true, slm_.display);
      follow(**output, stop);
      if (!stop.stop_requested())
        report(false, "the X server ended or changed its screens; waiting for the SLM's output");
      // The SLM keeps its last image until the output is opened again: the screens may only have
      // been rearranged.
      std::this_thread::sleep_for(std::chrono::milliseconds(kPollMs));
      continue;
    }
    report(false, output.error().reason);
    bench_.go_dark();
    const auto next_try = std::chrono::steady_clock::now() + kBetweenTries;
    while (!stop.stop_requested() && std::chrono::steady_clock::now() < next_try) {
      answer(asked());
      wait_for_events(-1);
    }
  }
}

void Screen::follow(XOutput& output, const std::stop_token& stop) {
  Patterns patterns = dark_patterns(dmd_, slm_.geometry.width_px, slm_.geometry.height_px);
  if (!forward(output, patterns, std::chrono::steady_clock::now())) return;
  while (!stop.stop_requested()) {
    const std::uint64_t asked_now = asked();
    // A waiting catch_up requires a round trip to the server; else the received events are enough.
    const XOutput::Change change =
        asked_now != answered_ ? output.sync_changes() : output.read_changes();
    if (change == XOutput::Change::lost) return;
    if (change == XOutput::Change::pixels && !forward(output, patterns, output.changed_at())) {
      return;
    }
    answer(asked_now);
    if (change == XOutput::Change::none) wait_for_events(output.descriptor());
  }
}

bool Screen::forward(XOutput& output, Patterns& patterns, Bench::Deadline since) {
  const auto read = [&](const std::uint32_t* pixels, int y) {
    read_row(dmd_, pixels, y, patterns);
  };
  if (!output.grab(read)) return false;
  bench_.show(patterns, since);
  const std::lock_guard lock(mutex_);
  ++status_.grabs;
  return true;
}

void Screen::wait_for_events(int descriptor) {
  std::array<pollfd, 2> readable{{{wake_fd_, POLLIN, 0}, {descriptor, POLLIN, 0}}};
  poll(readable.data(), descriptor < 0 ? 1 : 2, kPollMs);
  eventfd_t rung = 0;
  eventfd_read(wake_fd_, &rung);
}

bool Screen::catch_up(Bench::Deadline deadline, const std::stop_token& stop) {
  if (slm_.display.empty()) return true;
  std::unique_lock lock(mutex_);
  const std::uint64_t request = ++asked_;
  eventfd_write(wake_fd_, 1);
  return answered_now_.wait_until(lock, stop, deadline,
                                  [this, request] { return answered_ >= request; });
}

std::uint64_t Screen::asked() const {
  const std::lock_guard lock(mutex_);
  return asked_;
}

void Screen::answer(std::uint64_t asked) {
  const std::lock_guard lock(mutex_);
  if (answered_ == asked) return;
  answered_ = asked;
  answered_now_.notify_all();
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
