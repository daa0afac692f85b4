/// Field tables of `status` and `system.status`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/rt/counters.hpp"
#include "proto/status_message.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {

inline const std::vector<std::string>& counter_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const CounterRow& row : all_counters()) all.emplace_back(row.name);
    return all;
  }();
  return names;
}

inline constexpr const char* kFaultMeaning = "what is wrong and what to do; null: no fault";

template <>
inline constexpr auto kTable<StatusMessage::CameraPart> = Fields{
    "StatusCamera",
    field<&StatusMessage::CameraPart::connected>("whether a camera is connected"),
    field<&StatusMessage::CameraPart::streaming>("whether it is streaming"),
    field<&StatusMessage::CameraPart::brightest>(
        "grey level that the 16 brightest pixels of the newest image reach, fraction of full "
        "scale; null: no images are sent",
        {0, 1}),
    field<&StatusMessage::CameraPart::info>("identity of the camera"),
    field<&StatusMessage::CameraPart::settings>("the camera's settings"),
    field<&StatusMessage::CameraPart::fault>(kFaultMeaning)};

template <>
inline constexpr auto kTable<StatusMessage::SlmPart> =
    Fields{"StatusSlm",
           field<&StatusMessage::SlmPart::connected>("whether the display is open"),
           field<&StatusMessage::SlmPart::info>("identity of the display"),
           field<&StatusMessage::SlmPart::pattern>("pattern that is shown; test: an image of a job")
               .among(kNames<HologramKind>),
           field<&StatusMessage::SlmPart::hologram_id>("number of the hologram shown now; 0: none"),
           field<&StatusMessage::SlmPart::settled>("false while the hologram is changing"),
           field<&StatusMessage::SlmPart::fault>(kFaultMeaning)};

template <>
inline constexpr auto kTable<StatusMessage::SensorPart::Invalid> = Fields{
    "StatusInvalid",
    field<&StatusMessage::SensorPart::Invalid::t_since_ns>(
        "when it began, UNIX epoch UTC, nanoseconds"),
    field<&StatusMessage::SensorPart::Invalid::reason>(
        "why the frames are not valid, or why the reference is not used"),
    field<&StatusMessage::SensorPart::Invalid::action>(
        "what the daemon or you do about it, and when"),
    field<&StatusMessage::SensorPart::Invalid::searches>(
        "number of searches for the wavefront since then", Bounds::at_least(0)),
    field<&StatusMessage::SensorPart::Invalid::t_next_search_ns>(
        "latest time of the next search, UNIX epoch UTC, nanoseconds; an image that changes is "
        "searched at once; null: a search is running, or none can help")};

template <>
inline constexpr auto kTable<StatusMessage::SensorPart::Beam> = [] {
  using P = StatusMessage::SensorPart::Beam;
  return Fields{
      "StatusBeam", field<&P::name>("its name in `beams` of the configuration"),
      field<&P::offset_px>("[x, y] by which its spots lie beside the main source's, camera pixels: "
                           "measured once both have a reference, until then as configured"),
      field<&P::referenced>("whether there is a reference of this source"),
      field<&P::reason>("why its frames are not valid; null: they are, or there is no reference")};
}();

template <>
inline constexpr auto kTable<StatusMessage::SensorPart> = [] {
  using P = StatusMessage::SensorPart;
  return Fields{
      "StatusSensor",
      inlined(&P::settings),
      inlined(&P::mode_operator),
      field<&P::subapertures>("number of subapertures", Bounds::at_least(0)),
      field<&P::modes>("number of reconstructed modes", Bounds::at_least(0)),
      field<&P::measurable>("whether the camera's image can be measured; `invalid` says why not"),
      field<&P::referenced>("whether there is a reference"),
      field<&P::reference>("in_force: active; stale: active, but taken with another gain, exposure "
                           "or pixel format, which reference.get reports")
          .among(texts<"none", "in_force", "stale">),
      field<&P::reference_introduced_rms_waves>(
          "RMS of the introduced aberration that the reference contains and coefficients therefore "
          "exclude, waves; 0: none",
          Bounds::at_least(0)),
      field<&P::layout_fault>("why spots lie outside the camera's region or too close for the "
                              "tracker, with values that work; null: no fault")
          .or_null(),
      field<&P::invalid>("why no frame is valid although settled frames come, or why the reference "
                         "is not used; null: frames are valid, or another field says why not"),
      field<&P::beams>("the further light sources on the camera")};
}();

template <>
inline constexpr auto kTable<StatusMessage::RefinePart> = [] {
  using P = StatusMessage::RefinePart;
  return Fields{
      "StatusRefine",
      field<&P::state>("off; waiting: for a frame, or until the next is due; refining")
          .among(texts<"off", "waiting", "refining">),
      field<&P::done>("number of refined frames since the start"),
      field<&P::refused>("number of frames that could not be refined, since the start"),
      field<&P::last_duration_ms>("duration of the last fit, milliseconds", Bounds::at_least(0)),
      field<&P::reason>("why nothing is refined now, or why the last frame could not be refined; "
                        "null: no obstacle")};
}();

template <>
inline constexpr auto kTable<StatusMessage::StorePart> =
    Fields{"StatusStore",
           field<&StatusMessage::StorePart::directory>(
               "folder of the items that survive a restart; null: nothing is stored"),
           field<&StatusMessage::StorePart::reason>(
               "why an item is not stored, and what to do; null: everything is stored")};

template <>
inline constexpr auto kTable<StatusMessage::FailedJob> =
    Fields{"FailedJob",
           field<&StatusMessage::FailedJob::job>("number of the job", limits::kJob),
           field<&StatusMessage::FailedJob::kind>("the method that started it"),
           field<&StatusMessage::FailedJob::field>("dotted path of the key at fault; may be empty"),
           field<&StatusMessage::FailedJob::reason>("what was wrong and what to do"),
           field<&StatusMessage::FailedJob::t_failed_ns>(kTimeMeaning),
           time_text("t_failed", &StatusMessage::FailedJob::t_failed_ns)};

template <>
inline constexpr auto kTable<StatusMessage::Rates> = Fields{
    "Rates",
    field<&StatusMessage::Rates::grabbed_hz>("frames taken from the camera, per second",
                                             Bounds::at_least(0)),
    field<&StatusMessage::Rates::published_hz>("frames published, per second", Bounds::at_least(0)),
    field<&StatusMessage::Rates::images_hz>("images published, per second", Bounds::at_least(0)),
    field<&StatusMessage::Rates::expected_hz>(
        "frame rate that grabbed_hz should reach; null: the camera is not connected or is "
        "triggered, a job is running, or the camera's settings changed within this second",
        Bounds::at_least(0))};

template <>
inline constexpr auto kTable<LatencyTotals> =
    Fields{"LatencyTotals", field<&LatencyTotals::count>("number of frames"),
           field<&LatencyTotals::sum_us>("sum of all latencies, microseconds", Bounds::at_least(0)),
           computed(
               "edges_us", [](const LatencyTotals&) { return LatencyTotals::edges_us(); },
               "edges of the histogram, ascending, microseconds"),
           field<&LatencyTotals::below>("number of frames that took less than each edge")};

template <>
inline constexpr auto kTable<LatencySummary> = Fields{
    "Latency",
    field<&LatencySummary::count>("number of frames"),
    field<&LatencySummary::p50_us>("median, microseconds", Bounds::at_least(0)),
    field<&LatencySummary::p99_us>("99th percentile, microseconds", Bounds::at_least(0)),
    field<&LatencySummary::p999_us>("99.9th percentile, microseconds", Bounds::at_least(0)),
    field<&LatencySummary::max_us>("maximum, microseconds", Bounds::at_least(0)),
    field<&LatencySummary::since_start>("totals since the start, for cumulative histograms")};

template <>
inline constexpr auto kTable<StatusMessage> = Fields{
    "Status",
    field<&StatusMessage::t_ns>(kTimeMeaning),
    field<&StatusMessage::uptime_s>("time since the start, seconds", Bounds::at_least(0)),
    field<&StatusMessage::state>("what the daemon is doing: starting, waiting_for_camera, "
                                 "waiting_for_display, running, job_running, fault, stopping"),
    field<&StatusMessage::fault>(kFaultMeaning),
    field<&StatusMessage::camera>("the camera"),
    field<&StatusMessage::slm>("the spatial light modulator"),
    field<&StatusMessage::sensor>("the sensor, its tracking and its reference"),
    field<&StatusMessage::refine>("the live refinement of frames"),
    field<&StatusMessage::record>("the current or the last recording"),
    field<&StatusMessage::store>("storage of the items that survive a restart"),
    computed(
        "loop",
        [](auto& m) { return m.loop_paused   ? "paused"
                             : m.loop_closed ? "closed"
                                             : "open"; },
        "whether the loop is closed; paused: it is, but holds its correction")
        .among(texts<"open", "closed", "paused">),
    field<&StatusMessage::failed_job>(
        "latest job that failed since the daemon's start, unless a later one of its kind "
        "succeeded; null: none"),
    field<&StatusMessage::rates>("rates of the last second"),
    field<&StatusMessage::counters>("all counters, since the start").among(counter_names),
    field<&StatusMessage::latency>(
        "latency by stage, since the last status: tracked, reconstructed and published count from "
        "the frame's arrival; arrived is the delay of its arrival against an undelayed frame, only "
        "with a camera that has device timestamps"),
    field<&StatusMessage::versions>("versions of the daemon and its libraries")};

}  // namespace ovws
