#include "daemon/reload.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/config_check.hpp"
#include "daemon/config_in_use.hpp"
#include "daemon/log.hpp"
#include "daemon/service_notify.hpp"

namespace ovws {
namespace {

/// What begins so, and is not among the fixed ones, changes live.
constexpr std::array<std::string_view, 10> kLive{"camera.pixel_format",
                                                 "camera.exposure_us",
                                                 "camera.gain_db",
                                                 "camera.frame_rate_hz",
                                                 "camera.roi.",
                                                 "sensor.",
                                                 "tracking.",
                                                 "refine.",
                                                 "stream.image_rate_hz",
                                                 "log.level"};
constexpr std::array<std::string_view, 1> kFixed{"tracking.kernel_radius"};

bool is_live(std::string_view key) {
  const auto begins = [key](std::string_view start) { return key.starts_with(start); };
  return std::any_of(kLive.begin(), kLive.end(), begins) &&
         std::none_of(kFixed.begin(), kFixed.end(), begins);
}

CameraSet camera_set(const CameraSettings& to) {
  CameraSet change;
  change.gain_db = to.gain_db;
  change.exposure_us = to.exposure_us;
  change.frame_rate_hz = to.frame_rate_hz;
  change.pixel_format = to.pixel_format;
  change.roi = {to.roi.x, to.roi.y, to.roi.width, to.roi.height};
  return change;
}

SensorSet sensor_set(const Config& to) {
  SensorSet change;
  change.charge = to.sensor.charge;
  change.grid = to.sensor.grid;
  change.subapertures_across = to.sensor.subapertures_across;
  change.pupil_diameter_px = to.sensor.pupil_diameter_px;
  change.grooves = to.sensor.grooves;
  change.spacing = to.sensor.spacing;
  change.tracker = to.tracking.tracker;
  change.templates = to.tracking.templates;
  change.mode_operator = to.tracking.mode_operator;
  return change;
}

RefineSet refine_set(const RefineSetup& to) {
  RefineSet change;
  change.enabled = to.enabled;
  change.rate_hz = to.rate_hz;
  change.electrons_per_dn = to.electrons_per_dn;
  change.read_noise_e = to.read_noise_e;
  change.black_level_dn = to.black_level_dn;
  change.saturation_dn = to.saturation_dn;
  change.spot_amplitudes = to.spot_amplitudes;
  return change;
}

/// The parts name their keys as their methods do, a file's reader knows them with their room.
Error in_room(std::string room, Error error) {
  for (const char* key : {"tracker", "template", "operator"}) {
    if (error.field == key) room = "tracking";
  }
  if (!error.field.empty() && !error.field.starts_with(room)) {
    error.field = room + "." + error.field;
  }
  return error;
}

std::string listed(const std::vector<std::string>& keys) {
  return fmt::format("{}", fmt::join(keys, ", "));
}

}  // namespace

void Reloader::look() {
  if (busy_.load() || !requested_.exchange(false)) return;
  busy_.store(true);
  service::notify_reloading();
  deps_.instrument.after_changes([this] { begin(); });
}

void Reloader::begin() {
  if (deps_.path.empty()) {
    return refuse({Errc::refused, "", "the daemon was started without --config FILE"});
  }
  if (const auto allowed = deps_.state.check(Action::reload_config); !allowed) {
    return refuse(allowed.error());
  }
  if (const auto free = deps_.instrument.check_free(); !free) return refuse(free.error());
  const auto read = load_config(deps_.path);
  if (!read) return refuse(read.error());
  if (const auto usable = check_usable(*read); !usable) return refuse(usable.error());
  Reload reload;
  reload.before = config_in_use(deps_.config.get(), deps_.camera, deps_.instrument, deps_.refiner);
  reload.after = *read;
  reload.difference = difference(reload.before, reload.after);
  change_camera(reload);
}

Reloader::Difference Reloader::difference(const Config& before, const Config& after) {
  const auto now = nlohmann::json::parse(dump_config(before), nullptr, false).flatten();
  const auto wanted = nlohmann::json::parse(dump_config(after), nullptr, false).flatten();
  Difference keys;
  const auto look_at = [&](const nlohmann::json& these, const nlohmann::json& others, bool all) {
    for (const auto& [pointer, value] : these.items()) {
      const bool there = others.contains(pointer);
      if (there && (!all || others[pointer] == value)) continue;
      std::string key = pointer.substr(1);
      std::replace(key.begin(), key.end(), '/', '.');
      (is_live(key) ? keys.live : keys.restart).push_back(std::move(key));
    }
  };
  look_at(wanted, now, true);
  look_at(now, wanted, false);  // a list became null
  return keys;
}

void Reloader::change_camera(const Reload& reload) {
  if (reload.after.camera.settings == reload.before.camera.settings) return change_refine(reload);
  deps_.camera.change_or_want(camera_set(reload.after.camera.settings),
                              [this, reload](const Result<CameraSnapshot>& used) {
                                if (!used) return refuse(in_room("camera", used.error()));
                                change_refine(reload);
                              });
}

void Reloader::change_refine(const Reload& reload) {
  const auto used = deps_.refiner.change(refine_set(reload.after.refine),
                                         reload.after.camera.settings.pixel_format);
  if (!used) return put_back_camera(reload, in_room("refine", used.error()));
  change_sensor(reload);
}

void Reloader::change_sensor(const Reload& reload) {
  SensorSet change = sensor_set(reload.after);
  if (reload.after.tracking.mode_operator == reload.before.tracking.mode_operator) {
    change.mode_operator.reset();  // it stays also where it could not be asked for anew
  }
  const bool same = reload.after.sensor == reload.before.sensor &&
                    change.applied_to(reload.before.tracking) == reload.before.tracking;
  if (same) return finish(reload);
  deps_.instrument.change_sensor(change, [this, reload](const Result<SensorSnapshot>& used) {
    if (!used) return put_back(reload, in_room("sensor", used.error()));
    finish(reload);
  });
}

/// The sensor comes last: of what was changed only refinement and camera go back.
void Reloader::put_back(const Reload& reload, const Error& why) {
  if (!(reload.after.refine == reload.before.refine)) {
    (void)deps_.refiner.change(refine_set(reload.before.refine),
                               reload.before.camera.settings.pixel_format);
  }
  put_back_camera(reload, why);
}

/// Also where a job has begun meanwhile: its client knows the settings of before.
void Reloader::put_back_camera(const Reload& reload, const Error& why) {
  if (reload.after.camera.settings == reload.before.camera.settings) return refuse(why);
  deps_.camera.change_for_job(
      camera_set(reload.before.camera.settings), [this, why](const Result<CameraSnapshot>& used) {
        if (used) return refuse(why);
        Error told = why;
        told.reason += "; the camera keeps the new settings, for " + used.error().reason;
        refuse(told, "all but the camera goes on as it was");
      });
}

void Reloader::finish(const Reload& reload) {
  deps_.images.set_rate(reload.after.stream.image_rate_hz);
  set_log_level(reload.after.log.level);
  deps_.config.change([&](Config& config) {
    config.stream.image_rate_hz = reload.after.stream.image_rate_hz;
    config.log.level = reload.after.log.level;
  });
  const auto& [live, restart] = reload.difference;
  std::string text = "configuration reloaded: ";
  text += live.empty() ? "nothing that can change now has changed" : "applied " + listed(live);
  if (!restart.empty()) text += "; left until a restart: " + listed(restart);
  deps_.events.emit("config", restart.empty() ? Severity::info : Severity::warning, text,
                    {{"reloaded", true}, {"applied", live}, {"restart", restart}});
  done();
}

void Reloader::refuse(const Error& why, const char* what_stays) {
  deps_.events.emit("config", Severity::error,
                    fmt::format("configuration not reloaded, {}: {}{}{}", what_stays, why.field,
                                why.field.empty() ? "" : ": ", why.reason),
                    {{"reloaded", false}, {"field", why.field}, {"reason", why.reason}});
  done();
}

void Reloader::done() {
  service::notify_ready();
  busy_.store(false);
}

}  // namespace ovws
