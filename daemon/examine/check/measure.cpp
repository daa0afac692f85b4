#include "daemon/examine/check/measure.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/optics/zernike.hpp"
#include "core/port/clock.hpp"
#include "daemon/examine/check/frame_reader.hpp"
#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/status_questions.hpp"
#include "daemon/shared/borrow.hpp"

namespace ovws::examine {
namespace {

using cli::Answer;
using cli::Part;
using cli::stop;
using nlohmann::json;

constexpr double kQuickS = 10.0, kLoopS = 8.0, kQuickLoopS = 4.0;
constexpr double kLongWatchMs = 1000.0;
constexpr double kJobS = 7.0;   // roughly, for the time left
constexpr double kPokeS = 0.8;  // roughly, of one image of a mode
constexpr int kFrames = 20, kQuickFrames = 6;
/// Largest standard error of frames that count, in those of the wavefront at rest: templates of
/// the wavefront before a poke measure the first frames less exactly.
constexpr double kExactSigmas = 3.0;
constexpr int kMostWaits = 3;      // unread modes for whose templates it waits
constexpr double kSlowSlmS = 1.0;  // watched after the last hologram, in case that the SLM is slow

/// A measurement in progress.
class Run {
 public:
  Run(const cli::Common& common, const Options& options, const Hooks& hooks)
      : common_(common), options_(options), hooks_(hooks) {
    seconds_ = options.quick ? std::min(options.seconds, kQuickS) : options.seconds;
  }

  tl::expected<Measured, cli::CallFailure> operator()() {
    auto done = cli::attempt([this] {
      for (const auto step : {&Run::look, &Run::may_run, &Run::settle, &Run::table, &Run::record,
                              &Run::response, &Run::loop}) {
        (this->*step)();
        if (hooks_.interrupted()) stop("interrupted; the bench is as before");
      }
    });
    if (borrowed_) done = borrowed_->restore_after(std::move(done));
    if (!done) return tl::make_unexpected(done.error());
    return std::move(measured_);
  }

 private:
  void look() {
    measured_.version = OVWS_VERSION;
    measured_.t_ns = utc_ns();
    measured_.quick = options_.quick;
    const std::array parts{std::pair{"system.status", &measured_.status},
                           std::pair{"sensor.get", &measured_.sensor},
                           std::pair{"reference.get", &measured_.reference},
                           std::pair{"registration.get", &measured_.registration},
                           std::pair{"lut.get", &measured_.lut},
                           std::pair{"flatness.get", &measured_.flatness},
                           std::pair{"calibration.get", &measured_.calibration},
                           std::pair{"config.get", &measured_.config}};
    for (const auto& [method, part] : parts) *part = call(method);
    modes_j_ = measured_.sensor.at("modes_j").get<std::vector<int>>();
    borrowed_.emplace(common_, cli::needed(cli::parts_of(common_, {Part::lut, Part::aberration,
                                                                   Part::correction, Part::loop})));
  }

  void may_run() {
    if (measured_.config.value("modulator", "slm") == "fixed") {
      stop(
          "the check pokes modes with holograms, and a fixed array of lenslets shows none: "
          "ovws status, ovws watch and ovws doctor work");
    }
    if (auto why = why_not_ready(measured_.status); !why.empty()) stop(std::move(why));
    if (borrowed_->before(Part::loop).at("closed") == false) return;
    if (!options_.open_loop) {
      stop(
          "the loop is closed: open it first (ovws loop open), or let the check open it and "
          "close it again (--open-loop)");
    }
    call("loop.open", {{"keep", true}});
  }

  /// Time left after a step that needs `of_step` more seconds.
  void progress(const std::string& text, double of_step) {
    hooks_.progress(text, of_step + seconds_after_);
  }

  /// Plans the time of the steps after the present one, for the progress.
  void begin(int step) {
    const double pokes = 4.0 * kPokeS * double(modes_j_.size()) * (options_.quick ? 0.5 : 1.0);
    const std::array left{kJobS, options_.quick ? 0.0 : kJobS, seconds_, pokes,
                          options_.close_loop ? loop_s() : 0.0};
    seconds_after_ = 0.0;
    for (std::size_t i = std::size_t(step) + 1; i < left.size(); ++i) seconds_after_ += left[i];
  }
  double loop_s() const { return options_.quick ? kQuickLoopS : kLoopS; }

  json call(const char* method, const json& params = json::object()) {
    return cli::needed(cli::call_patiently(common_, method, params));
  }

  FrameReader reader() { return cli::needed(FrameReader::open(common_, hooks_.interrupted)); }

  /// Shows the aberration as it was plus `waves` of mode j.
  json poke(int j, double waves) {
    json params = borrowed_->before(Part::aberration);
    json& modes = params["modes"];
    const auto same =
        std::ranges::find_if(modes, [j](const json& one) { return one.at("j") == j; });
    if (same == modes.end()) {
      modes.push_back({{"j", j}, {"waves", waves}});
    } else {
      (*same)["waves"] = same->at("waves").get<double>() + waves;
    }
    return call("aberration.set", params);
  }

  /// Runs a job; an interrupt cancels it. A failed job is no failure of the check.
  JobResult job(const char* method, const json& params) {
    const auto show = [&](const json& now) {
      progress(method, kJobS * (1.0 - now.at("progress").get<double>()));
    };
    Answer result = cli::call_and_wait(common_, method, params, {hooks_.interrupted, show});
    if (!result) return {json(), cli::message_of(result.error())};
    return {std::move(*result), ""};
  }

  void settle() {
    begin(0);
    const int repetitions = options_.quick ? 5 : 20;
    measured_.settle = job("slm.settle", {{"repetitions", repetitions}});
    if (measured_.settle.result.is_object() || hooks_.interrupted()) return;
    // The SLM may be slower than the time that was watched.
    measured_.settle = job("slm.settle", {{"repetitions", 5}, {"watch_ms", kLongWatchMs}});
  }

  /// Measures the SLM's phase response if no table was measured. The new table is not kept.
  void table() {
    begin(1);
    if (measured_.lut.at("measured").get<bool>()) return;
    measured_.lut_run.reason = "left out (--quick)";
    if (options_.quick) return;
    measured_.lut_run = job("lut.run", {{"levels", 17}, {"frames", 2}});
    call("lut.clear");
  }

  void record() {
    begin(2);
    FrameReader frames = reader();
    frames.record(kSlowSlmS, [](double /*left*/) {});
    measured_.open =
        frames.record(seconds_, [&](double left) { progress("noise and drift", left); });
    measured_.counters_after = call("system.status").at("counters");
  }

  void response() {
    begin(3);
    FrameReader frames = reader();
    measured_.response.modes_j = modes_j_;
    const Stability rest = stability_of(measured_.open);
    Wanted wanted;
    wanted.modes_j = modes_j_;
    if (!std::isnan(rest.stated)) wanted.most_sigma_waves = kExactSigmas * rest.stated;
    wanted.count = options_.quick ? kQuickFrames : kFrames;
    int unread = 0;
    for (std::size_t k = 0; k < modes_j_.size() && !hooks_.interrupted(); ++k) {
      progress("response: " + zernike_name(modes_j_[k]),
               4.0 * kPokeS * double(modes_j_.size() - k) * (options_.quick ? 0.5 : 1.0));
      std::array<Shown, 4> shown;
      wanted.least_s = k == 0 ? kSlowSlmS : 0.0;
      for (std::size_t i = 0; i < shown.size() && !hooks_.interrupted(); ++i) {
        const double sign = i == 0 || i == 3 ? 1.0 : -1.0;
        const json poked = poke(modes_j_[k], sign * kPokeWaves);
        shown[i] = frames.shown(poked.at("hologram_id").get<std::uint64_t>(), wanted);
        if (!shown[i].rest.empty()) continue;
        note_why_unread();
        if (++unread == kMostWaits) wanted.templates_s = wanted.longest_s;
        break;
      }
      measured_.response.pokes.push_back(poke_of(modes_j_[k], shown));
    }
    measured_.response.spots = frames.spots();
    const json shown = call("aberration.set", borrowed_->before(Part::aberration));
    frames.shown(shown.at("hologram_id").get<std::uint64_t>(), wanted);
  }

  /// Keeps the daemon's first reason for frames of a mode that are not valid.
  void note_why_unread() {
    if (!measured_.response.reason.empty()) return;
    const json invalid = call("system.status").at("sensor").at("invalid");
    if (invalid.is_object()) measured_.response.reason = invalid.at("reason").get<std::string>();
  }

  void loop() {
    begin(4);
    LoopResult& result = measured_.loop;
    result.reason = "left out (--no-loop)";
    if (!options_.close_loop) return;
    const json params = borrowed_->before(Part::loop).value("params", json::object());
    if (const Answer closed = cli::call_patiently(common_, "loop.close", params); !closed) {
      result.reason = cli::message_of(closed.error());
      return;
    }
    FrameReader frames = reader();
    const auto tick = [&](double left) { progress("closed loop", left); };
    frames.record(0.5 * loop_s(), tick);
    result.record = frames.record(0.5 * loop_s(), tick);
    json state = call("loop.get");
    result.failed = !state.at("closed").get<bool>();
    if (!result.failed) {
      result.loop = std::move(state);
    } else if (state.at("opened_because").is_string()) {
      result.reason = state.at("opened_because").get<std::string>();
    }
  }

  const cli::Common& common_;
  const Options& options_;
  const Hooks& hooks_;
  std::optional<cli::Borrow> borrowed_;
  Measured measured_;
  std::vector<int> modes_j_;
  double seconds_ = 0.0, seconds_after_ = 0.0;
};

}  // namespace

tl::expected<Measured, cli::CallFailure> measure(const cli::Common& common, const Options& options,
                                                 const Hooks& hooks) {
  return Run(common, options, hooks)();
}

}  // namespace ovws::examine
