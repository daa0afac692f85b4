#include "daemon/ovwsd/slm/slm_loop.hpp"

#include <spdlog/fmt/fmt.h>
#include <zlib.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/devices/device_lists.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"
#include "proto/limits.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(20);
constexpr auto kShowTimeout = std::chrono::seconds(2);
constexpr std::int64_t kRetryNs = 1'000'000'000;
constexpr std::int64_t kCheckNs = 100'000'000;
constexpr std::int64_t kFadeInNs = 1'000'000'000;
constexpr int kMinReads = 5;  ///< also if the first ones take that long, on a machine that is busy

std::uint32_t crc32_of(const std::vector<std::uint8_t>& bytes) {
  return std::uint32_t(::crc32(0, bytes.data(), uInt(bytes.size())));
}

Error stopping() {
  return {Errc::refused, "", "the daemon is stopping"};
}

/// What the output shows of a hologram.
struct SeenLevels {
  std::vector<std::uint8_t> levels;  ///< as those of the hologram
  int differing_pixels = 0;
  int given = 0, shown = 0;  ///< level of the hologram that differs most, and what is shown of it
};

SeenLevels compared(const Image<std::uint32_t>& shown, const std::vector<std::uint8_t>& given) {
  SeenLevels seen{std::vector<std::uint8_t>(given.size())};
  const std::size_t bytes = given.size() / shown.pixels.size();  // 1 or 3 per pixel
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    bool same = true;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::size_t k = bytes * i + (bytes == 3 ? channel : 0);
      const auto level = std::uint8_t(shown.pixels[i] >> (16 - 8 * channel));
      seen.levels[k] = level;
      same = same && level == given[k];
      if (std::abs(level - given[k]) < std::abs(seen.shown - seen.given)) continue;
      seen.given = given[k];
      seen.shown = level;
    }
    seen.differing_pixels += same ? 0 : 1;
  }
  return seen;
}

Error changed_levels(const SeenLevels& seen, double share) {
  return {Errc::refused, "slm.display",
          fmt::format("the output does not show the grey levels of the hologram: {:.0f} % of the "
                      "pixels differ, and level {} is shown as {}; stop the compositor, or exclude "
                      "the window \"ovws SLM\" from its effects",
                      100.0 * share, seen.given, seen.shown)};
}

}  // namespace

SlmLoop::SlmLoop(SlmConfig config, SlmLoopDeps deps)
    : config_(std::move(config)), deps_(std::move(deps)) {
  snapshot_.change([this](SlmSnapshot& now) {
    now.fault = "not opened yet";
    now.settings = config_;
  });
}

SlmLoop::~SlmLoop() = default;

bool SlmLoop::do_work() {
  const Pending pending = wait_for_work();
  if (pending.when_possible) {
    requested_ = pending.when_possible;
    if (display_) (void)present(*requested_);
  }
  if (!display_ && requested_ && monotonic_ns() >= next_try_ns_) try_open();
  if (pending.job) carry_out(*pending.job);
  for (const Change& one : pending.changes) one.done(use(one));
  if (!pending.verify.empty() || !pending.outputs.empty()) {
    inspections_.run([&] { inspect(pending); });
  }
  if (display_ && monotonic_ns() >= next_check_ns_) {
    next_check_ns_ = monotonic_ns() + kCheckNs;
    if (const auto healthy = display_->check(); !healthy) fault(healthy.error());
  }
  return pending.when_possible || pending.job;
}

void SlmLoop::inspect(const Pending& asked) {
  if (!asked.verify.empty()) {
    const auto verdict = compare_output();
    for (const auto& done : asked.verify) done(verdict);
  }
  if (!asked.outputs.empty()) {
    const auto outputs = ovws::list_outputs(config_);
    for (const auto& done : asked.outputs) done(outputs);
  }
}

void SlmLoop::carry_out(Job& job) {
  const std::optional<HologramRequest> before = requested_;
  Result<void> done = present(job.request);
  bool abandoned = false;
  {
    const std::lock_guard lock(mutex_);
    abandoned = job.abandoned;
    job.done.set_value(done);
  }
  // The caller of `show` got a timeout error and assumes that the previous hologram is shown:
  // present the previous one again, or when the display is there again.
  if (abandoned && done && before && !present(*before)) requested_ = before;
}

void SlmLoop::close() {
  auto pending = [this] {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    return std::exchange(pending_, {});
  }();
  if (pending.job) pending.job->done.set_value(fail(stopping()));
  for (const auto& done : pending.verify) done(fail(stopping()));
  for (const auto& done : pending.outputs) done(fail(stopping()));
  for (const Change& one : pending.changes) one.done(fail(stopping()));
}

Result<void> SlmLoop::show(HologramRequest request) {
  auto job = std::make_shared<Job>();
  job->request = std::move(request);
  auto result = job->done.get_future();
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return fail(stopping());
    pending_.job = job;
  }
  ready_.notify_one();
  if (result.wait_for(kShowTimeout) == std::future_status::ready) return result.get();
  const std::lock_guard lock(mutex_);
  if (result.wait_for(std::chrono::seconds(0)) == std::future_status::ready) return result.get();
  job->abandoned = true;
  if (pending_.job == job) pending_.job.reset();
  return fail(Errc::unavailable, "slm",
              "the display did not accept the hologram within 2 s; check slm in system.status");
}

void SlmLoop::show_when_possible(HologramRequest request) {
  {
    const std::lock_guard lock(mutex_);
    pending_.when_possible = std::move(request);
  }
  ready_.notify_one();
}

/// Adds a request to its queue. Returns false after close.
template <class Request>
bool SlmLoop::add(std::vector<Request> Pending::*queue, Request request) {
  const std::lock_guard lock(mutex_);
  if (closed_) return false;
  (pending_.*queue).push_back(std::move(request));
  ready_.notify_one();
  return true;
}

void SlmLoop::verify(const VerifyDone& done) {
  if (!add(&Pending::verify, done)) done(fail(stopping()));
}

void SlmLoop::list_outputs(const OutputsDone& done) {
  if (!add(&Pending::outputs, done)) done(fail(stopping()));
}

void SlmLoop::change(SlmSet change, const SettingsDone& done) {
  if (!add(&Pending::changes, {std::move(change), done})) done(fail(stopping()));
}

Result<SlmSettings> SlmLoop::use(const Change& asked) {
  const SlmSettings wanted = asked.change.applied_to(config_);
  SlmConfig next = config_;
  static_cast<SlmSettings&>(next) = wanted;
  if (next.display != config_.display || next.allow_primary != config_.allow_primary) {
    if (auto usable = check_output(next); !usable) return fail(usable.error());
    if (auto opened = reopen(next); !opened) return fail(opened.error());
  }
  config_ = next;
  snapshot_.change([&wanted](SlmSnapshot& now) { now.settings = wanted; });
  deps_.events.status_changed();
  return wanted;
}

/// Closes the display and opens the one of `config`; if that fails, the former one again.
Result<void> SlmLoop::reopen(const SlmConfig& config) {
  const SlmConfig before = std::exchange(config_, config);
  display_.reset();
  shown_ = ShownHologram{};
  deps_.shown.write(shown_);
  if (!requested_) return {};
  try_open();
  if (display_) return {};
  const Error why{Errc::device, "slm.display", snapshot_.get().fault};
  config_ = before;
  try_open();
  return fail(why);
}

Result<VerifyReport> SlmLoop::compare_output() {
  if (!display_) {
    return fail(Errc::unavailable, "slm", "there is no display: " + snapshot_.get().fault);
  }
  if (!requested_) return fail(Errc::unavailable, "slm", "no hologram has been shown yet");
  const auto shown = display_->read_back();
  if (!shown) return fail(shown.error());
  const std::vector<std::uint8_t>& given = requested_->levels->pixels;
  const SeenLevels seen = compared(*shown, given);
  const VerifyReport verdict{requested_->hologram_id, crc32_of(given), crc32_of(seen.levels),
                             seen.differing_pixels};
  if (verdict.differing_pixels > 0) {
    deps_.counters.add(Counter::display_faults);
    deps_.events.emit("slm", Severity::error,
                      fmt::format("slm: {} pixels of the output differ from hologram {}: close "
                                  "what another program draws there (a window, a pointer)",
                                  verdict.differing_pixels, verdict.hologram_id),
                      {{"hologram_id", verdict.hologram_id},
                       {"crc32", verdict.crc32},
                       {"crc32_shown", verdict.crc32_shown},
                       {"differing_pixels", verdict.differing_pixels}});
  }
  return verdict;
}

/// Takes the work to do now. Requests to inspect the display stay until it is their time.
SlmLoop::Pending SlmLoop::wait_for_work() {
  std::unique_lock lock(mutex_);
  ready_.wait_for(lock, kTurn, [this] {
    const bool inspects = !pending_.verify.empty() || !pending_.outputs.empty();
    return pending_.when_possible || pending_.job || !pending_.changes.empty() ||
           (inspects && inspections_.is_due());
  });
  Pending now = std::exchange(pending_, {});
  if (inspections_.is_due()) return now;
  pending_.verify.swap(now.verify);
  pending_.outputs.swap(now.outputs);
  return now;
}

/// Opens the display, checks that it shows the levels of the requested hologram, and presents that.
/// Only then is the display reported as open.
void SlmLoop::try_open() {
  next_try_ns_ = monotonic_ns() + kRetryNs;
  auto opened = open_display(config_);
  if (!opened) return publish_snapshot(opened.error());
  display_ = std::move(*opened);
  if (const auto exact = check_levels(*requested_->levels); !exact) {
    display_.reset();
    next_try_ns_ = monotonic_ns() + kRetryNs;
    return publish_snapshot(exact.error());
  }
  if (!present(*requested_)) return;
  const DisplayInfo& info = display_->info();
  deps_.events.emit("slm", Severity::info,
                    fmt::format("SLM output {} is open: {} x {} at {:.1f} Hz ({})", info.output,
                                info.width, info.height, info.refresh_hz, info.driver));
}

/// Presents the levels and reads them back. A compositor shows them some refreshes later, or fades
/// a new window in, so that they are read again for a second, and at least kMinReads times.
Result<void> SlmLoop::check_levels(const Image<std::uint8_t>& levels) {
  if (auto presented = display_->present(levels); !presented) return fail(presented.error());
  const std::int64_t end_ns = monotonic_ns() + kFadeInNs;
  for (int reads = 1;; ++reads) {
    const auto shown = display_->read_back();
    if (!shown && shown.error().code == Errc::unavailable) return {};  // it cannot be read
    if (!shown) return fail(shown.error());
    const SeenLevels seen = compared(*shown, levels.pixels);
    const double share = double(seen.differing_pixels) / double(shown->pixels.size());
    if (share <= limits::kMaxDifferingPixels) return {};
    if (reads >= kMinReads && monotonic_ns() >= end_ns) return fail(changed_levels(seen, share));
    std::this_thread::sleep_for(kTurn);
  }
}

Result<void> SlmLoop::present(const HologramRequest& request) {
  if (!display_) {
    return fail(Errc::unavailable, "slm", "there is no display: " + snapshot_.get().fault);
  }
  const std::int64_t asked_ns = monotonic_ns();
  t_refresh_mono_ns_ = display_->wait_for_refresh();
  refresh_wait_ns_ = monotonic_ns() - asked_ns;
  ShownHologram next = shown_;
  next.healthy = true;
  next.previous = shown_.healthy ? shown_.current : ShownHologram::One{};
  next.current = {request.hologram_id, request.sensor_epoch, monotonic_ns(), ShownHologram::kNever,
                  request.sequence};
  deps_.shown.write(next);
  const auto presented_ns = display_->present(*request.levels);
  if (!presented_ns) {
    fault(presented_ns.error());
    return fail(presented_ns.error());
  }
  next.current.t_settled_mono_ns = *presented_ns + std::int64_t(config_.settle_ms * 1e6);
  deps_.shown.write(next);
  shown_ = next;
  requested_ = request;
  t_presented_mono_ns_ = *presented_ns;
  publish_snapshot(std::nullopt);
  return {};
}

/// Closes the display after a fault. No hologram counts as shown until try_open has opened the
/// display again.
void SlmLoop::fault(const Error& why) {
  display_.reset();
  shown_ = ShownHologram{};
  deps_.shown.write(shown_);
  deps_.counters.add(Counter::display_faults);
  publish_snapshot(why);
}

void SlmLoop::publish_snapshot(const std::optional<Error>& why) {
  SlmSnapshot now;
  now.healthy = display_ != nullptr;
  if (display_) now.info = display_->info();
  now.hologram_id = shown_.current.hologram_id;
  now.kind = requested_ ? requested_->kind : HologramKind::sensor;
  now.t_presented_mono_ns = t_presented_mono_ns_;
  now.t_begin_mono_ns = shown_.current.t_begin_mono_ns;
  now.t_settled_mono_ns = shown_.current.t_settled_mono_ns;
  now.t_refresh_mono_ns = t_refresh_mono_ns_;
  now.refresh_wait_ns = refresh_wait_ns_;
  if (why) now.fault = why->reason;
  now.at_fault = why && needs_intervention(*why);
  now.settings = config_;
  const SlmSnapshot before = snapshot_.get();
  snapshot_.change([&](SlmSnapshot& published) {
    if (now.healthy != before.healthy || now.fault != before.fault) deps_.on_change(now);
    published = now;
  });
  if (!now.fault.empty() && now.fault != before.fault) {
    deps_.events.emit("slm", Severity::error, "slm: " + now.fault);
  }
  deps_.events.status_changed();
}

}  // namespace ovws
