/// The daemon's state machine as tables: conditions, states, and the actions that each permits.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

/// Daemon states in order of precedence: the current state is the first whose condition holds.
enum class DaemonState : std::uint8_t {
  stopping,             ///< shutdown requested
  starting,             ///< drivers have not been opened yet
  fault,                ///< a device is present but unusable until a person fixes it
  waiting_for_camera,   ///< no camera; possibly no display either
  waiting_for_display,  ///< a camera, but no display
  job_running,          ///< a job controls the sensor
  running,
  count,
};

/// Kinds of client requests; kActions says which conditions block each kind.
enum class Action : std::uint8_t {
  read,
  set_camera,
  set_sensor,
  set_aberration,
  show_pattern,
  start_job,
  clear_reference,
  cancel_job,
  save_config,
  set_refine,
  close_loop,
  open_loop,
  set_correction,
  reload_config,
  record,
  watch,    ///< a job that only watches frames
  present,  ///< a client's picture; the procedure thread checks for other jobs
  grab,
  set_corrector,
  start_hologram_job,  ///< a job that shows holograms
  count,
};

/// The conditions that determine the state.
struct Conditions {
  bool started = false;
  bool camera = false;
  bool display = false;
  bool job = false;        ///< a job holds the sensor
  bool measuring = false;  ///< that job also depends on the camera's settings
  bool loop = false;       ///< the control loop is closed
  bool fixed = false;      ///< the subapertures are fixed: nothing shows holograms
  bool reload = false;     ///< a reload changes devices and sensor, or is about to
  bool lattice = false;    ///< lattice.use changes camera and sensor, or is about to
  bool fault = false;
  bool stopping = false;
  friend constexpr bool operator==(const Conditions&, const Conditions&) = default;
};

namespace control {

template <class Key, class Row>
using Table = std::array<Row, std::size_t(Key::count)>;

struct StateRow {
  std::string_view name;
  /// The state holds if this condition equals `when`; nullptr (`running`): always.
  bool Conditions::*condition;
  bool when;
};
constexpr Table<DaemonState, StateRow> kStates{{
    {"stopping", &Conditions::stopping, true},
    {"starting", &Conditions::started, false},
    {"fault", &Conditions::fault, true},
    {"waiting_for_camera", &Conditions::camera, false},
    {"waiting_for_display", &Conditions::display, false},
    {"job_running", &Conditions::job, true},
    {"running", nullptr, true},
}};

/// A condition that blocks actions, and the error that says what the client must do.
struct Obstacle {
  bool Conditions::*condition;
  bool when;
  Errc code;
  std::string_view reason;
};
inline constexpr std::string_view kJobRuns =
    "a job is running; wait until it ends or cancel it with job.cancel";
inline constexpr std::string_view kReloads =
    "the configuration is being reloaded; repeat the request in a moment";
inline constexpr std::string_view kLatticeChanges =
    "a prepared lattice is being taken into use; repeat the request in a moment";
constexpr std::array<Obstacle, 10> kObstacles{{
    {&Conditions::stopping, true, Errc::refused,
     "the daemon is stopping; start it again and repeat the request"},
    {&Conditions::started, false, Errc::refused,
     "the daemon is still starting; repeat the request in a moment"},
    {&Conditions::camera, false, Errc::unavailable,
     "no camera is in use; system.status gives the reason, and the daemon reconnects by itself"},
    {&Conditions::display, false, Errc::unavailable,
     "the SLM's display is not in use; system.status gives the reason, and the daemon reconnects "
     "by itself"},
    {&Conditions::job, true, Errc::refused, kJobRuns},
    {&Conditions::measuring, true, Errc::refused, kJobRuns},
    {&Conditions::loop, true, Errc::refused, "the loop is closed; open it with loop.open first"},
    {&Conditions::fixed, true, Errc::refused,
     "the sensor is a fixed array of lenslets, which shows no holograms, so this is not possible; "
     "a "
     "loop can be closed with a corrector of your own (corrector.set)"},
    {&Conditions::reload, true, Errc::refused, kReloads},
    {&Conditions::lattice, true, Errc::refused, kLatticeChanges},
}};

/// Which obstacles block an action, in the order of kObstacles.
struct ActionRow {
  std::array<bool, kObstacles.size()> blocked_by;
};
// Columns: stopping starting camera display job measuring loop fixed reload lattice; `x` blocks the
// action.
constexpr auto kActions = [] {
  constexpr bool x = true, o = false;
  return Table<Action, ActionRow>{{
      {{o, o, o, o, o, o, o, o, o, o}},  // read
      {{x, x, o, o, o, x, o, o, x, x}},  // set_camera: the camera actor checks further
      {{x, x, o, x, x, o, x, o, x, x}},  // set_sensor
      {{x, x, o, x, x, o, o, x, x, x}},  // set_aberration
      {{x, x, o, x, x, o, x, x, x, x}},  // show_pattern
      {{x, x, x, x, x, o, x, o, x, x}},  // start_job
      {{x, x, o, o, x, o, x, o, x, x}},  // clear_reference
      {{x, x, o, o, o, o, o, o, o, o}},  // cancel_job
      {{x, x, o, o, x, o, o, o, x, x}},  // save_config: a job may have changed settings
      {{x, x, o, o, o, o, o, o, x, o}},  // set_refine
      {{x, x, x, x, x, o, x, x, x, x}},  // close_loop
      {{x, x, o, o, o, o, o, o, o, o}},  // open_loop
      {{x, x, o, x, x, o, x, x, x, x}},  // set_correction
      {{x, x, o, o, x, o, x, o, x, x}},  // reload_config
      {{x, x, o, o, o, o, o, o, o, o}},  // record
      {{x, x, x, x, x, o, o, o, x, x}},  // watch
      {{x, x, o, o, o, o, x, x, x, x}},  // present
      {{x, x, x, o, o, o, o, o, o, o}},  // grab
      {{x, x, o, o, o, o, o, o, o, o}},  // set_corrector
      {{x, x, x, x, x, o, x, x, x, x}},  // start_hologram_job
  }};
}();

}  // namespace control

constexpr std::string_view state_name(DaemonState state) {
  return control::kStates[std::size_t(state)].name;
}

constexpr DaemonState state_of(const Conditions& conditions) {
  for (std::size_t s = 0; s < control::kStates.size(); ++s) {
    const control::StateRow& row = control::kStates[s];
    if (row.condition == nullptr || conditions.*row.condition == row.when) return DaemonState(s);
  }
  return DaemonState::running;
}

/// The first obstacle that blocks `action`; nullptr if it is allowed.
constexpr const control::Obstacle* obstacle(const Conditions& conditions, Action action) {
  const control::ActionRow& row = control::kActions[std::size_t(action)];
  for (std::size_t o = 0; o < control::kObstacles.size(); ++o) {
    const control::Obstacle& it = control::kObstacles[o];
    if (row.blocked_by[o] && conditions.*it.condition == it.when) return &it;
  }
  return nullptr;
}

/// Permits an action, or returns an error whose reason names the obstacle and how to proceed.
inline Result<void> permit(const Conditions& conditions, Action action) {
  const control::Obstacle* const it = obstacle(conditions, action);
  if (it == nullptr) return {};
  return fail(it->code, "", std::string(it->reason));
}

}  // namespace ovws
