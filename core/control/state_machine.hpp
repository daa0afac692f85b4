/// The daemon's states, what moves it from one to another, and what each permits: all as data.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws {

/// Where several hold, the first in this order is the daemon's state, `running` the last.
enum class DaemonState : std::uint8_t {
  stopping,             ///< asked to end
  starting,             ///< drivers have not been tried yet
  fault,                ///< a device is there and cannot be used until somebody mends it
  waiting_for_camera,   ///< no camera; perhaps no display either
  waiting_for_display,  ///< a camera, and no display
  job_running,          ///< a job has the sensor
  running,
  count,
};

enum class DaemonEvent : std::uint8_t {
  started,
  camera_connected,
  camera_lost,
  display_connected,
  display_lost,
  job_begun,
  job_ended,
  loop_closed,
  loop_opened,
  fault_raised,
  fault_cleared,
  stop_requested,
  count,
};

/// What a client may ask for, as far as the state decides.
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
  count,
};

/// Everything the state is made of.
struct Conditions {
  bool started = false;
  bool camera = false;
  bool display = false;
  bool job = false;
  bool loop = false;  ///< closed
  bool fault = false;
  bool stopping = false;
  friend constexpr bool operator==(const Conditions&, const Conditions&) = default;
};

namespace control {

template <class Key, class Row>
using Table = std::array<Row, std::size_t(Key::count)>;

struct StateRow {
  std::string_view name;
  /// The condition that makes the daemon be in this state; none for `running`.
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

struct EventRow {
  bool Conditions::*condition;
  bool becomes;
};
constexpr Table<DaemonEvent, EventRow> kEvents{{
    {&Conditions::started, true},   // started
    {&Conditions::camera, true},    // camera_connected
    {&Conditions::camera, false},   // camera_lost
    {&Conditions::display, true},   // display_connected
    {&Conditions::display, false},  // display_lost
    {&Conditions::job, true},       // job_begun
    {&Conditions::job, false},      // job_ended
    {&Conditions::loop, true},      // loop_closed
    {&Conditions::loop, false},     // loop_opened
    {&Conditions::fault, true},     // fault_raised
    {&Conditions::fault, false},    // fault_cleared
    {&Conditions::stopping, true},  // stop_requested
}};

/// What stands in the way of an action, and the way out.
struct Obstacle {
  bool Conditions::*condition;
  bool when;
  Errc code;
  std::string_view reason;
};
constexpr std::array<Obstacle, 6> kObstacles{{
    {&Conditions::stopping, true, Errc::refused,
     "the daemon is stopping; start it again and repeat the request"},
    {&Conditions::started, false, Errc::refused,
     "the daemon is still starting; repeat the request in a moment"},
    {&Conditions::camera, false, Errc::unavailable,
     "no camera is in use; system.status says why, and it is opened by itself when it can be"},
    {&Conditions::display, false, Errc::unavailable,
     "the SLM's display is not in use; system.status says why, and it is opened by itself when it "
     "can be"},
    {&Conditions::job, true, Errc::refused,
     "a job is running; wait for its end or cancel it with job.cancel"},
    {&Conditions::loop, true, Errc::refused, "the loop is closed; open it with loop.open first"},
}};

/// Which obstacles matter to an action, in the order of kObstacles.
struct ActionRow {
  std::array<bool, kObstacles.size()> minds;
};
//                               stopping starting camera display job loop
constexpr Table<Action, ActionRow> kActions{{
    {{false, false, false, false, false, false}},  // read
    {{true, true, false, false, true, false}},     // set_camera: the camera's keeper knows more
    {{true, true, false, true, true, true}},       // set_sensor
    {{true, true, false, true, true, false}},      // set_aberration
    {{true, true, false, true, true, true}},       // show_pattern
    {{true, true, true, true, true, true}},        // start_job
    {{true, true, false, false, true, true}},      // clear_reference
    {{true, true, false, false, false, false}},    // cancel_job
    {{true, true, false, false, true, false}},   // save_config: a job may have settings of its own
    {{true, true, false, false, false, false}},  // set_refine
    {{true, true, true, true, true, true}},      // close_loop
    {{true, true, false, false, false, false}},  // open_loop
    {{true, true, false, true, true, true}},     // set_correction
    {{true, true, false, false, true, true}},    // reload_config
    {{true, true, false, false, false, false}},  // record
}};

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

constexpr Conditions after(Conditions conditions, DaemonEvent event) {
  const control::EventRow& row = control::kEvents[std::size_t(event)];
  conditions.*row.condition = row.becomes;
  return conditions;
}

/// The first obstacle that `action` minds; nullptr if it is allowed.
constexpr const control::Obstacle* obstacle(const Conditions& conditions, Action action) {
  const control::ActionRow& row = control::kActions[std::size_t(action)];
  for (std::size_t o = 0; o < control::kObstacles.size(); ++o) {
    const control::Obstacle& it = control::kObstacles[o];
    if (row.minds[o] && conditions.*it.condition == it.when) return &it;
  }
  return nullptr;
}

/// Allowed, or an error whose reason names the obstacle and the way out.
inline Result<void> permit(const Conditions& conditions, Action action) {
  const control::Obstacle* const it = obstacle(conditions, action);
  if (it == nullptr) return {};
  return fail(it->code, "", std::string(it->reason));
}

}  // namespace ovws
