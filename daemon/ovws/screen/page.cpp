#include "daemon/ovws/screen/page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "daemon/ovws/text/fill.hpp"
#include "proto/dark_image.hpp"
#include "proto/measurable_image.hpp"

namespace ovws::screen {
namespace {

using cli::fill;
using nlohmann::json;

constexpr int kTopRows = 3, kMinRight = 34, kMaxRight = 70;
constexpr int kLatencyRows = 5, kMinMapRows = 7;
constexpr const char* kKeys =
    " q quit  p pause  r reference  +/- exposure  l loop  c clear  ? help";
constexpr const char* kPausedKeys = " PAUSED   p resume   q quit   up/down modes   ? help";

constexpr const char* kHelp[]{
    "q         quit",
    "p         pause, resume",
    "up, down  scroll the modes; also k and j, page up, page down, home, end",
    "r         take a reference of 100 frames",
    "+, -      exposure a quarter longer, a fifth shorter",
    "l         close or open the loop",
    "c         remove the introduced aberration; these four ask before they act",
    "?         show or hide this help",
    "",
    "modes     OSA/ANSI, RMS-normalised, waves: aberration minus reference",
    "RMS       root sum square of the modes without tilts",
    "Strehl    exp(-(2 pi RMS)^2): good below about 0.1 wave RMS",
    "spots     at their reference positions on the camera; an arrow shows the",
    "          direction of a displacement of more than one pixel",
    "latency   of the last second, from a frame's arrival until it was tracked,",
    "          reconstructed, published; arrived: delay of the arrival itself",
    "losses    since the daemon's start, and their increase in the last second",
};

struct Layout {
  Rect modes, spots, latency, losses, events;
};

Layout layout(const Canvas& canvas, const View& view) {
  const int event_rows = std::clamp(canvas.height() / 6, 3, 12);
  const int events_y = canvas.height() - 1 - event_rows;
  const int body = events_y - kTopRows;
  const int right = std::clamp(canvas.width() * 2 / 5, kMinRight, kMaxRight);
  const int x = canvas.width() - right;
  const int wanted = 1 + std::max(1, int(view.losses.size()));
  const int losses = std::clamp(body - kLatencyRows - kMinMapRows, 2, wanted);
  const int spots = std::max(body - kLatencyRows - losses, 0);
  return {{0, kTopRows, x - 1, body},
          {x, kTopRows, right, spots},
          {x, kTopRows + spots, right, kLatencyRows},
          {x, kTopRows + spots + kLatencyRows, right, losses},
          {0, events_y, canvas.width(), event_rows}};
}

std::string state_text(const json& status) {
  json said = status;
  const json brightest = status.at("camera").value("brightest", json());
  said["is_dark"] = brightest.is_number() && is_dark(brightest.get<double>());
  return fill(
      "{state}  [is_dark?DARK ({camera.brightest*100:.1f} % of full scale): ovws exposure auto  ]"
      "[sensor.reference_introduced_rms_waves?reference contains an aberration]"
      "[!sensor.reference_introduced_rms_waves?[sensor.reference=in_force?referenced]"
      "[sensor.reference=stale?reference stale][sensor.reference=none?no reference]]  "
      "[camera.fault?camera: {camera.fault}][!camera.fault?[!camera.connected?no camera]"
      "[camera.connected?{rates.published_hz:.1f} frames/s]]  loop {loop}  "
      "[slm.fault?SLM: {slm.fault}][!slm.fault?[!slm.connected?no SLM][slm.connected?SLM shows "
      "{slm.pattern}, hologram {slm.hologram_id}[!slm.settled?, settling]]]",
      said);
}

void draw_state(Canvas& canvas, const View& view) {
  canvas.fill({0, 0, canvas.width(), 1}, {U' ', Style::title});
  if (view.status.is_null()) {
    canvas.text(1, 0, canvas.width() - 1,
                fmt::format("no message for {:.0f} s: waiting for the daemon", view.silent_s),
                Style::alarm);
    return;
  }
  canvas.text(1, 0, canvas.width() - 1, state_text(view.status), Style::title);
}

void draw_frame(Canvas& canvas, const View& view) {
  if (view.wavefront.is_null()) {
    if (view.status.is_null()) return;
    const std::string why = why_not_measurable(view.status);
    canvas.text(0, 1, canvas.width(), why.empty() ? "no frames arrive" : why, Style::alarm);
    return;
  }
  const json& frame = view.wavefront;
  const bool valid = frame.at("valid").get<bool>();
  const int x = canvas.text(
      0, 1, canvas.width(),
      fill("frame {frame_id:d}  charge {charge} ({tracker})  spots {tracked}/{subapertures}  "
           "saturated {saturated*100:.0f} %  latency {latency_us:.0f} us  ",
           frame));
  if (valid) canvas.text(x, 1, canvas.width() - x, "valid", Style::strong);
  const double rms_waves = valid ? frame.at("rms_waves").get<double>() : 0.0;
  const double strehl = std::exp(-std::pow(2.0 * std::numbers::pi * rms_waves, 2.0));
  if (!valid) {
    canvas.text(0, 2, canvas.width(), "NOT VALID: " + view.not_valid, Style::alarm);
    return;
  }
  const int end =
      canvas.text(0, 2, canvas.width(),
                  fmt::format("RMS {:.4f} wave  Strehl {:.3f}", rms_waves, strehl), Style::strong);
  // The gain is in the camera's own unit. Older daemons do not send `gain_raw`.
  canvas.text(
      end, 2, canvas.width() - end,
      fill("  residual [fit_residual_px?{fit_residual_px:.3f}][!fit_residual_px?-] px  gain "
           "[gain_db=null?{gain_raw:.0f} (raw)][!gain_db=null?{gain_db:.1f} dB]  exposure "
           "[exposure_us?{exposure_us:.0f}][!exposure_us?-] us",
           frame));
}

void draw_help(Canvas& canvas) {
  const int rows = int(std::size(kHelp));
  const Rect box{0, kTopRows, canvas.width(), canvas.height() - kTopRows - 1};
  canvas.fill(box, Cell{});
  for (int k = 0; k < rows; ++k) canvas.text(2, kTopRows + k, canvas.width() - 3, kHelp[k]);
}

void draw_parts(Canvas& canvas, const View& view, Choice& choice) {
  draw_state(canvas, view);
  draw_frame(canvas, view);
  const Layout parts = layout(canvas, view);
  draw_modes(canvas, parts.modes, view, choice.first_mode);
  draw_spots(canvas, parts.spots, view);
  draw_latency(canvas, parts.latency, view);
  draw_losses(canvas, parts.losses, view);
  draw_events(canvas, parts.events, view);
}

}  // namespace

void draw(Canvas& canvas, const View& view, Choice& choice) {
  canvas.fill(canvas.all(), Cell{});
  if (canvas.width() < kMinWidth || canvas.height() < kMinHeight) {
    canvas.text(0, 0, canvas.width(),
                fmt::format("{} x {} is too small: enlarge the terminal to {} x {}", canvas.width(),
                            canvas.height(), kMinWidth, kMinHeight));
    return;
  }
  try {
    draw_parts(canvas, view, choice);
  } catch (const json::exception&) {
    canvas.text(0, 2, canvas.width(),
                "a message has an unknown format: install the same version of ovws and ovwsd",
                Style::alarm);
  }
  const int last = canvas.height() - 1;
  const Style style = choice.paused || !choice.note.empty() ? Style::alarm : Style::title;
  canvas.fill({0, last, canvas.width(), 1}, {U' ', style});
  const std::string keys = choice.paused ? kPausedKeys : kKeys;
  canvas.text(0, last, canvas.width(), choice.note.empty() ? keys : " " + choice.note, style);
  if (choice.help) draw_help(canvas);
}

}  // namespace ovws::screen
