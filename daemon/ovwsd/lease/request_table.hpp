/// Who may change what, as one table: kinds of requests, what each needs, which parts of the bench
/// it changes, and what a refusal says.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

/// Whose lease it is. A client's lease lasts for one change; the others last for longer, and keep
/// their parts from everybody else.
enum class Holder : std::uint8_t { nobody, client, job, loop, reload, lattice };

/// Kinds of requests. kRequests says what each needs.
enum class Request : std::uint8_t {
  read,
  act,   ///< changes no part that a holder may have
  grab,  ///< waits for frames
  set_camera,
  set_devices,  ///< another camera or output
  set_sensor,
  set_measured,  ///< reference, calibration, registration, flatness, LUT
  set_aberration,
  set_correction,
  show_pattern,
  set_refinement,
  save_settings,
  run_job,
  run_hologram_job,  ///< a job that shows holograms
  present,           ///< a client's pictures: a job that leaves the camera's settings to clients
  watch,             ///< a job that only watches frames
  close_loop,
  use_lattice,
  reload,
  count,
};

/// Parts of the bench: a request changes some, a holder depends on some.
namespace part {
using Set = std::uint8_t;
constexpr Set kCamera = 1;       ///< its settings
constexpr Set kDevices = 2;      ///< which camera and output, and the output's settings
constexpr Set kSensor = 4;       ///< subapertures, tracking, measurements, the pattern shown
constexpr Set kAberration = 8;   ///< introduced on purpose
constexpr Set kCorrection = 16;  ///< subtracted by the loop
constexpr Set kProcedures = 32;  ///< the procedure thread
constexpr Set kRefinement = 64;  ///< its settings
constexpr Set kSaved = 128;      ///< the settings as they are to be saved
constexpr Set kNone = 0, kAll = 255;
}  // namespace part

/// What a request needs besides its parts.
namespace need {
using Set = std::uint8_t;
constexpr Set kNothing = 0;
constexpr Set kRunning = 1;  ///< the daemon has started, and does not stop
constexpr Set kCamera = 3;   ///< and a camera is connected
constexpr Set kDisplay = 5;  ///< and a display is connected
constexpr Set kBench = 7;    ///< both
constexpr Set kSlm = 9;      ///< an SLM, not a fixed array of lenslets
}  // namespace need

struct RequestRow {
  Request request;
  Holder holder;
  part::Set parts;
  need::Set needs;
};

constexpr std::array<RequestRow, std::size_t(Request::count)> kRequests{{
    {Request::read, Holder::client, part::kNone, need::kNothing},
    {Request::act, Holder::client, part::kNone, need::kRunning},
    {Request::grab, Holder::client, part::kNone, need::kCamera},
    {Request::set_camera, Holder::client, part::kCamera, need::kRunning},
    {Request::set_devices, Holder::client, part::kDevices, need::kRunning},
    {Request::set_sensor, Holder::client, part::kSensor, need::kDisplay},
    {Request::set_measured, Holder::client, part::kSensor, need::kRunning},
    {Request::set_aberration, Holder::client, part::kAberration, need::kDisplay | need::kSlm},
    {Request::set_correction, Holder::client, part::kCorrection, need::kDisplay | need::kSlm},
    {Request::show_pattern, Holder::client, part::kSensor, need::kDisplay | need::kSlm},
    {Request::set_refinement, Holder::client, part::kRefinement, need::kRunning},
    {Request::save_settings, Holder::client, part::kSaved, need::kRunning},
    {Request::run_job, Holder::job, part::kAll & ~part::kRefinement, need::kBench},
    {Request::run_hologram_job, Holder::job, part::kAll & ~part::kRefinement,
     need::kBench | need::kSlm},
    {Request::present, Holder::job, part::kAll & ~(part::kRefinement | part::kCamera), need::kSlm},
    {Request::watch, Holder::job, part::kProcedures, need::kBench},
    {Request::close_loop, Holder::loop, part::kDevices | part::kSensor | part::kCorrection,
     need::kBench | need::kSlm},
    {Request::use_lattice, Holder::lattice, part::kAll & ~(part::kRefinement | part::kProcedures),
     need::kDisplay | need::kSlm},
    {Request::reload, Holder::reload, part::kAll & ~part::kProcedures, need::kRunning},
}};

static_assert(std::ranges::all_of(kRequests, [](const RequestRow& row) {
  return &row == &kRequests[std::size_t(row.request)];
}));

constexpr const RequestRow& row_of(Request request) {
  return kRequests[std::size_t(request)];
}

/// Why a request is refused while a lease of `holder` has one of its parts, and what to do.
constexpr std::string_view refusal_of(Holder holder) {
  switch (holder) {
    case Holder::job:
      return "a job is running; wait until it ends or cancel it with job.cancel";
    case Holder::loop:
      return "the loop is closed; open it with loop.open first";
    case Holder::reload:
      return "the configuration is being reloaded; repeat the request in a moment";
    case Holder::lattice:
      return "a prepared lattice is being taken into use; repeat the request in a moment";
    case Holder::nobody:
    case Holder::client:
      break;
  }
  return "";
}

/// What the daemon knows of itself and its devices.
struct Conditions {
  bool started = false;
  bool camera = false;   ///< connected
  bool display = false;  ///< connected
  bool fault = false;    ///< a device is present but unusable until a person fixes it
  bool stopping = false;
};

/// Checks what a request needs besides its parts. The error says what the client must do.
/// `fixed`: the sensor is a fixed array of lenslets.
inline Result<void> check_needs(const Conditions& now, bool fixed, need::Set needs) {
  const auto needed = [needs](need::Set one) { return (needs & one) == one; };
  const auto refuse = [](Errc code, const char* reason) -> Result<void> {
    return fail(code, "", reason);
  };
  if (needed(need::kRunning) && now.stopping) {
    return refuse(Errc::refused, "the daemon is stopping; start it again and repeat the request");
  }
  if (needed(need::kRunning) && !now.started) {
    return refuse(Errc::refused, "the daemon is still starting; repeat the request in a moment");
  }
  if (needed(need::kSlm) && fixed) {
    return refuse(Errc::refused,
                  "the sensor is a fixed array of lenslets, which shows no holograms, so this is "
                  "not possible; a loop can be closed with a corrector of your own "
                  "(corrector.set)");
  }
  if (needed(need::kCamera) && !now.camera) {
    return refuse(Errc::unavailable,
                  "no camera is in use; system.status gives the reason, and the daemon reconnects "
                  "by itself");
  }
  if (needed(need::kDisplay) && !now.display) {
    return refuse(Errc::unavailable,
                  "the SLM's display is not in use; system.status gives the reason, and the "
                  "daemon reconnects by itself");
  }
  return {};
}

}  // namespace ovws
