#include "daemon/ovwsd/settings/reload.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>

#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/shared/log.hpp"
#include "daemon/shared/service_notify.hpp"

namespace ovws {
namespace {

/// Completes the error's field to a configuration key, because control methods report it without
/// its section. For a saved value, adds the overlay's path to the reason: a person would otherwise
/// look in the configuration file.
Error with_section(std::string section, Error error, const LoadedConfig& read) {
  for (const char* key : {"tracker", "operator", "mode_count", "estimates"}) {
    if (error.field == key) section = "tracking";
  }
  const bool is_key = error.field.starts_with(section + ".") ||
                      error.field.starts_with("tracking.") || error.field.starts_with("beams[");
  if (!error.field.empty() && error.field != section && !is_key) {
    error.field = section + "." + error.field;
  }
  if (std::find(read.saved.begin(), read.saved.end(), error.field) != read.saved.end()) {
    error.reason +=
        " (a saved value: remove " + *read.overlay + " to use the configuration file's)";
  }
  return error;
}

/// Reads and checks the configuration. Catches exceptions, so that the event says what was wrong.
Result<LoadedConfig> read_again(const std::string& path) {
  try {
    auto read = load_with_saved(path);
    if (!read) return read;
    if (const auto usable = check_usable(read->effective); !usable) return fail(usable.error());
    if (const auto safe = check_security(read->effective); !safe) return fail(safe.error());
    return read;
  } catch (const std::exception& error) {
    return fail(Errc::internal, "", error.what());
  }
}

}  // namespace

void Reloader::poll() {
  if (busy_.load() || !requested_.exchange(false)) return;
  const auto turn = std::make_shared<Outcome>(*this);
  busy_.store(true);
  service::notify_reloading();
  deps_.disk.post([this, turn] { read(turn); });
}

/// Reads the file before the reload has the bench, because a disk may not answer for minutes.
void Reloader::read(const Turn& turn) {
  const std::string path = deps_.loaded.get().path;
  if (path.empty()) {
    return refuse(turn,
                  Error{Errc::refused, "",
                        "there is no file to read: the daemon was started without --config FILE"});
  }
  const auto read = read_again(path);
  if (!read) return refuse(turn, read.error());
  auto lease = deps_.leases.take(Request::reload);
  if (!lease) return refuse(turn, lease.error());
  turn->lease = std::move(*lease);
  turn->lease->begin([this, turn, read = *read] { change(turn, read); });
}

void Reloader::change(const Turn& turn, const LoadedConfig& read) {
  Reload reload;
  reload.turn = turn;
  reload.before = config_in_use(deps_.config, deps_.loaded.get(), deps_.camera, deps_.slm,
                                deps_.keeper, deps_.refiner);
  reload.after = read.effective;
  reload.read = read;
  const CameraSnapshot camera = deps_.camera.snapshot();
  reload.before.camera.settings = camera.asked;
  reload.after.camera.settings = as_requested(read.effective.camera.settings, camera);
  reload.keys = difference(reload.before, reload.after);
  reload.had_camera = camera.connected;
  change_slm(reload);
}

void Reloader::change_slm(const Reload& reload) {
  const SlmSettings before = settings_of(reload.before.slm), after = settings_of(reload.after.slm);
  if (after == before) return select_camera(reload);
  deps_.slm.change(SlmSet::difference(before, after),
                   [this, reload](const Result<SlmSettings>& used) {
                     if (!used)
                       return refuse(reload.turn, with_section("slm", used.error(), reload.read));
                     select_camera(reload);
                   });
}

/// Uses the camera of this id with the file's settings as a start does: it may appear later. But
/// one that cannot use the settings is refused.
void Reloader::select_camera(const Reload& reload) {
  const std::string& id = reload.after.camera.id;
  if (id == reload.before.camera.id) return change_camera(reload);
  const CameraSet change =
      CameraSet::difference(reload.before.camera.settings, reload.after.camera.settings);
  const auto selected = [this, reload](const Result<CameraSnapshot>& used) {
    if (!used) return roll_back_slm(reload, with_section("camera", used.error(), reload.read));
    if (used->at_fault)
      return roll_back_devices(reload, Error{Errc::invalid, "camera", used->fault});
    change_sensor(reload);
  };
  deps_.camera.select(id, change, true, selected);
}

void Reloader::change_camera(const Reload& reload) {
  const CameraSettings &before = reload.before.camera.settings,
                       &after = reload.after.camera.settings;
  if (after == before) return change_sensor(reload);
  deps_.camera.change_or_keep(
      CameraSet::difference(before, after), [this, reload](const Result<CameraSnapshot>& used) {
        if (!used)
          return roll_back_devices(reload, with_section("camera", used.error(), reload.read));
        change_sensor(reload);
      });
}

void Reloader::change_sensor(const Reload& reload) {
  SensorSettings before{reload.before.sensor, reload.before.tracking},
      after{reload.after.sensor, reload.after.tracking};
  const SensorConfig now = deps_.keeper.snapshot()->sensor;
  if (!now.lenslets.empty()) before.sensor = after.sensor = now;  // hardware: needs a restart
  SensorSet change = SensorSet::whole(after);
  if (after.tracking.mode_operator == before.tracking.mode_operator) {
    // Do not request the unchanged operator: the request could be refused now.
    change.forget(&TrackingSettings::mode_operator);
  }
  const bool same = to_json(after) == to_json(before);
  if (same) return finish(reload);
  deps_.keeper.edit(set_sensor(std::move(change), after.sensor.masks),
                    [this, reload](const Result<SensorView>& used) {
                      if (!used) {
                        return roll_back_camera(reload,
                                                with_section("sensor", used.error(), reload.read));
                      }
                      finish(reload);
                    });
}

void Reloader::Refusal::add(const char* part, const std::string& reason) {
  why.reason += fmt::format("; the {} could not be restored: {}", part, reason);
  not_restored.emplace_back(part);
}

void Reloader::roll_back_camera(const Reload& reload, const Refusal& refusal) {
  const CameraSettings &before = reload.before.camera.settings,
                       &after = reload.after.camera.settings;
  const bool is_same = reload.after.camera.id == reload.before.camera.id;
  if (!is_same || after == before) return roll_back_devices(reload, refusal);
  deps_.camera.change_or_keep(CameraSet::difference(after, before),
                              [this, reload, refusal](const Result<CameraSnapshot>& used) {
                                Refusal both = refusal;
                                if (!used) both.add("camera's settings", used.error().reason);
                                roll_back_devices(reload, both);
                              });
}

/// Returns to the previous camera, with its settings, and to the previous SLM.
void Reloader::roll_back_devices(const Reload& reload, const Refusal& refusal) {
  const Config &before = reload.before, &after = reload.after;
  if (after.camera.id == before.camera.id) return roll_back_slm(reload, refusal);
  const CameraSet change = CameraSet::difference(after.camera.settings, before.camera.settings);
  deps_.camera.select(before.camera.id, change, true,
                      [this, reload, refusal](const Result<CameraSnapshot>& used) {
                        Refusal both = refusal;
                        if (!used) {
                          both.add("camera", used.error().reason);
                        } else if (reload.had_camera && !used->connected) {
                          both.add("camera", used->fault);
                        }
                        roll_back_slm(reload, both);
                      });
}

void Reloader::roll_back_slm(const Reload& reload, const Refusal& refusal) {
  const SlmSettings before = settings_of(reload.before.slm), after = settings_of(reload.after.slm);
  if (after == before) return refuse(reload.turn, refusal);
  deps_.slm.change(SlmSet::difference(after, before),
                   [turn = reload.turn, refusal](const Result<SlmSettings>& used) {
                     Refusal both = refusal;
                     if (!used) both.add("SLM's settings", used.error().reason);
                     refuse(turn, both);
                   });
}

void Reloader::finish(const Reload& reload) {
  Reload used = reload;
  // The refiner checks the values that the file has passed already once more, in the pixel format
  // of the camera.
  if (!(used.after.refine == used.before.refine)) {
    const auto refined = deps_.refiner.change(RefineSet::whole(used.after.refine),
                                              used.after.camera.settings.pixel_format);
    if (!refined) used.refine_error = with_section("refine", refined.error(), used.read);
  }
  deps_.images.set_rate(reload.after.stream.image_rate_hz);
  set_log_level(reload.after.log.level);
  deps_.loaded.set(reload.read);
  const Turn turn = used.turn;
  deps_.disk.post([used = std::move(used)]() mutable {
    set_aside_if_invalid(used.read);
    report(used);
  });
  // All is changed: do not keep the bench while the disk may not answer. A client's config.save
  // comes to the disk after this task.
  turn->lease->end();
}

void Reloader::report(const Reload& reload) {
  auto [live, restart] = reload.keys;
  if (reload.refine_error) {
    std::erase_if(live, [](const std::string& key) { return key.starts_with("refine."); });
  }
  std::string text = "configuration reloaded: ";
  text += live.empty() ? "no run-time setting has changed" : "applied " + comma_list(live);
  if (!restart.empty()) text += "; a restart is needed for: " + comma_list(restart);
  if (const std::string saved = describe_saved(reload.read); !saved.empty()) text += "; " + saved;
  if (reload.refine_error) {
    text += "; the refinement keeps its settings: " + text_of(*reload.refine_error);
  }
  const bool all_used =
      restart.empty() && reload.read.unused_reason.empty() && !reload.refine_error;
  reload.turn->say(all_used ? Severity::info : Severity::warning, std::move(text),
                   {{"reloaded", true},
                    {"applied", live},
                    {"restart", restart},
                    {"saved", reload.read.saved},
                    {"edited", reload.read.edited}});
}

void Reloader::refuse(const Turn& turn, const Refusal& refusal) {
  const Error& why = refusal.why;
  const std::string what_stays = refusal.not_restored.empty()
                                     ? "nothing has changed"
                                     : fmt::format("all but the {} is unchanged",
                                                   fmt::join(refusal.not_restored, " and the "));
  turn->say(Severity::error,
            fmt::format("configuration not reloaded, {}: {}", what_stays, text_of(why)),
            {{"reloaded", false}, {"field", why.field}, {"reason", why.reason}});
}

/// Ends the lease first, because a client may start a job as soon as it receives the event.
void Reloader::end(Outcome& outcome) {
  outcome.lease.reset();
  deps_.events.emit("config", outcome.severity, outcome.text, outcome.data);
  service::notify_ready();
  busy_.store(false);
}

}  // namespace ovws
