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

inline std::vector<std::string> open_or_closed() {
  return {"open", "closed"};
}
inline std::vector<std::string> counter_names() {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < std::size_t(Counter::count_); ++k)
    names.emplace_back(counter_name(Counter(k)));
  return names;
}

inline constexpr const char* kFaultMeaning = "what is wrong and what to do; null: no fault";

template <>
struct Table<StatusMessage::CameraPart> {
  using P = StatusMessage::CameraPart;
  static constexpr const char* kName = "StatusCamera";
  static constexpr auto kFields =
      Fields{field("connected", &P::connected, "whether a camera is connected"),
             field("streaming", &P::streaming, "whether it is streaming"),
             field("info", &P::info, "identity of the camera"),
             field("settings", &P::settings, "the camera's settings"),
             field("fault", &P::fault, kFaultMeaning)};
};

template <>
struct Table<StatusMessage::SlmPart> {
  using P = StatusMessage::SlmPart;
  static constexpr const char* kName = "StatusSlm";
  static constexpr auto kFields = Fields{
      field("connected", &P::connected, "whether the display is open"),
      field("info", &P::info, "identity of the display"),
      field("pattern", &P::pattern, "pattern that is shown; test: an image of a job").among([] {
        return pattern_names();
      }),
      field("hologram_id", &P::hologram_id, "number of the hologram shown now; 0: none"),
      field("settled", &P::settled, "false while the hologram is changing"),
      field("fault", &P::fault, kFaultMeaning)};
};

template <>
struct Table<StatusMessage::SensorPart::Invalid> {
  using P = StatusMessage::SensorPart::Invalid;
  static constexpr const char* kName = "StatusInvalid";
  static constexpr auto kFields =
      Fields{field("t_since_ns", &P::t_since_ns,
                   "time of the first invalid frame, UNIX epoch UTC, nanoseconds"),
             field("reason", &P::reason, "why the frames are not valid"),
             field("action", &P::action, "what the daemon does about it, and when"),
             field("searches", &P::searches, "number of searches for the wavefront since then",
                   Bounds::at_least(0)),
             field("t_next_search_ns", &P::t_next_search_ns,
                   "latest time of the next search, UNIX epoch UTC, nanoseconds; an image that "
                   "changes is searched at once; null: a search is running")};
};

template <>
struct Table<StatusMessage::SensorPart> {
  using P = StatusMessage::SensorPart;
  static constexpr const char* kName = "StatusSensor";
  static constexpr auto kFields = Fields{
      inlined(&P::settings),
      inlined(&P::templates),
      inlined(&P::mode_operator),
      field("subapertures", &P::subapertures, "number of subapertures", Bounds::at_least(0)),
      field("modes", &P::modes, "number of reconstructed modes", Bounds::at_least(0)),
      field("referenced", &P::referenced, "whether there is a reference"),
      field("reference", &P::reference,
            "in_force: active; stale: active, but taken with another gain, exposure or pixel "
            "format, which reference.get reports")
          .among([] {
            return std::vector<std::string>{"none", "in_force", "stale"};
          }),
      field("reference_introduced_rms_waves", &P::reference_introduced_rms_waves,
            "RMS of the introduced aberration that the reference contains and coefficients "
            "therefore exclude, waves; 0: none",
            Bounds::at_least(0)),
      field("layout_fault", &P::layout_fault,
            "why spots lie outside the camera's region or too close for the tracker, with values "
            "that work; null: no fault")
          .or_null(),
      field("torn", &P::torn, "kept for older clients: always empty", Bounds::at_least(0)),
      field("invalid", &P::invalid,
            "why no frame is valid although settled frames come and there is a reference; null: "
            "frames are valid, or another field says why not")};
};

template <>
struct Table<StatusMessage::RefinePart> {
  using P = StatusMessage::RefinePart;
  static constexpr const char* kName = "StatusRefine";
  static constexpr auto kFields = Fields{
      field("state", &P::state, "off; waiting: for a frame, or until the next is due; refining")
          .among([] {
            return std::vector<std::string>{"off", "waiting", "refining"};
          }),
      field("done", &P::done, "number of refined frames since the start"),
      field("refused", &P::refused, "number of frames that could not be refined, since the start"),
      field("last_duration_ms", &P::last_duration_ms, "duration of the last fit, milliseconds",
            Bounds::at_least(0)),
      field("reason", &P::reason,
            "why nothing is refined now, or why the last frame could not be refined; null: no "
            "obstacle")};
};

template <>
struct Table<StatusMessage::StorePart> {
  using P = StatusMessage::StorePart;
  static constexpr const char* kName = "StatusStore";
  static constexpr auto kFields =
      Fields{field("directory", &P::directory,
                   "folder of the items that survive a restart; null: nothing is stored"),
             field("reason", &P::reason,
                   "why an item is not stored, and what to do; null: everything is stored")};
};

template <>
struct Table<StatusMessage::FailedJob> {
  using P = StatusMessage::FailedJob;
  static constexpr const char* kName = "FailedJob";
  static constexpr auto kFields =
      Fields{field("job", &P::job, "number of the job", limits::kJob),
             field("kind", &P::kind, "the method that started it"),
             field("field", &P::field, "dotted path of the key at fault; may be empty"),
             field("reason", &P::reason, "what was wrong and what to do"),
             field("t_failed_ns", &P::t_failed_ns, kTimeMeaning),
             time_text("t_failed", &P::t_failed_ns)};
};

template <>
struct Table<StatusMessage::Rates> {
  using P = StatusMessage::Rates;
  static constexpr const char* kName = "Rates";
  static constexpr auto kFields = Fields{
      field("grabbed_hz", &P::grabbed_hz, "frames taken from the camera, per second",
            Bounds::at_least(0)),
      field("published_hz", &P::published_hz, "frames published, per second", Bounds::at_least(0)),
      field("images_hz", &P::images_hz, "images published, per second", Bounds::at_least(0))};
};

template <>
struct Table<LatencyTotals> {
  static constexpr const char* kName = "LatencyTotals";
  static constexpr auto kFields = Fields{
      field("count", &LatencyTotals::count, "number of frames"),
      field("sum_us", &LatencyTotals::sum_us, "sum of all latencies, microseconds",
            Bounds::at_least(0)),
      computed<LatencyTotals>(
          "edges_us", [](const LatencyTotals&) { return LatencyTotals::edges_us(); },
          "edges of the histogram, ascending, microseconds"),
      field("below", &LatencyTotals::below, "number of frames that took less than each edge")};
};

template <>
struct Table<LatencySummary> {
  static constexpr const char* kName = "Latency";
  static constexpr auto kFields =
      Fields{field("count", &LatencySummary::count, "number of frames"),
             field("p50_us", &LatencySummary::p50_us, "median, microseconds", Bounds::at_least(0)),
             field("p99_us", &LatencySummary::p99_us, "99th percentile, microseconds",
                   Bounds::at_least(0)),
             field("p999_us", &LatencySummary::p999_us, "99.9th percentile, microseconds",
                   Bounds::at_least(0)),
             field("max_us", &LatencySummary::max_us, "maximum, microseconds", Bounds::at_least(0)),
             field("since_start", &LatencySummary::since_start,
                   "totals since the start, for cumulative histograms")};
};

template <>
struct Table<StatusMessage> {
  using M = StatusMessage;
  static constexpr const char* kName = "Status";
  static constexpr auto kFields = Fields{
      field("t_ns", &M::t_ns, kTimeMeaning),
      field("uptime_s", &M::uptime_s, "time since the start, seconds", Bounds::at_least(0)),
      field("state", &M::state,
            "what the daemon is doing: starting, waiting_for_camera, waiting_for_display, running, "
            "job_running, fault, stopping"),
      field("fault", &M::fault, kFaultMeaning),
      field("camera", &M::camera, "the camera"),
      field("slm", &M::slm, "the spatial light modulator"),
      field("sensor", &M::sensor, "the sensor, its tracking and its reference"),
      field("refine", &M::refine, "the live refinement of frames"),
      field("record", &M::record, "the current or the last recording"),
      field("store", &M::store, "storage of the items that survive a restart"),
      computed<M>(
          "loop", [](const M& m) { return m.loop_closed ? "closed" : "open"; },
          "whether the loop is closed")
          .among(open_or_closed),
      field("failed_job", &M::failed_job,
            "last failed job since the start whose kind has not succeeded since; null: none"),
      field("rates", &M::rates, "rates since the last status"),
      field("counters", &M::counters, "all counters, since the start").among(counter_names),
      field("latency", &M::latency,
            "latency by stage, since the last status: tracked, reconstructed and published count "
            "from the frame's arrival; arrived is the delay of its arrival against an undelayed "
            "frame, only with a camera that has device timestamps"),
      field("versions", &M::versions, "versions of the daemon and its libraries")};
};

}  // namespace ovws
