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

template <class T>
Result<void> outcome_of(const Result<T>& used) {
  return used ? Result<void>() : fail(used.error());
}

/// Reads and checks the configuration. Catches exceptions, so that the event says what was wrong.
Result<LoadedConfig> read_again(const LoadedConfig& running) {
  try {
    auto read = load_with_saved(running.path, std::nullopt, &running);
    if (!read) return read;
    if (const auto usable = check_usable(read->effective); !usable) return fail(usable.error());
    if (const auto safe = check_security(read->effective); !safe) return fail(safe.error());
    return read;
  } catch (const std::exception& error) {
    return fail(Errc::internal, "", error.what());
  }
}

}  // namespace

const std::array<Reloader::Part, 3> Reloader::kParts{
    {{"slm", "SLM's settings", &Reloader::apply_slm},
     {"camera", "camera", &Reloader::apply_camera},
     {"sensor", "sensor's settings", &Reloader::apply_sensor}}};

void Reloader::poll() {
  if (busy_.load() || deps_.leases.report().state == DaemonState::starting) return;
  if (!deps_.requested.exchange(false)) return;
  const auto reload = std::make_shared<Reload>(*this);
  busy_.store(true);
  service::notify_reloading();
  post_read(reload);
}

/// Saves counted until now are written before the read, as the disk carries out requests in order;
/// `change` notices later ones.
void Reloader::post_read(const ReloadPtr& reload) {
  reload->saves = deps_.settings.saves();
  deps_.disk.post([this, reload] { read(reload); });
}

/// Reads the file before the reload has the bench, because a disk may not answer for minutes.
void Reloader::read(const ReloadPtr& reload) {
  const auto give_up = [&reload](Error why) {
    reload->why_not = std::move(why);
    refuse(*reload);
  };
  const LoadedConfig running = deps_.settings.loaded();
  if (running.path.empty()) {
    return give_up({Errc::refused, "",
                    "there is no file to read: the daemon was started without --config FILE"});
  }
  auto read = read_again(running);
  if (!read) return give_up(read.error());
  reload->read = std::move(*read);
  auto lease = deps_.leases.take(Request::reload);
  if (!lease) return give_up(lease.error());
  reload->lease = std::move(*lease);
  reload->lease->begin([this, reload] { change(reload); });
}

void Reloader::change(const ReloadPtr& reload) {
  if (deps_.settings.saves() != reload->saves) {  // config.save came between: read what it wrote
    reload->lease.reset();
    return post_read(reload);
  }
  const CameraSnapshot camera = deps_.camera.snapshot();
  reload->before = deps_.settings.requested();
  reload->after = reload->read.effective;
  reload->after.camera.settings = as_requested(reload->after.camera.settings, camera);
  reload->keys = difference(reload->before, reload->after);
  reload->had_camera = camera.connected;
  apply_from(reload, 0);
}

void Reloader::apply_from(const ReloadPtr& reload, std::size_t part) {
  if (part == kParts.size()) return finish(reload);
  (this->*kParts[part].apply)(
      reload, reload->after, [this, reload, part](const Result<void>& used) {
        if (used) return apply_from(reload, part + 1);
        reload->why_not = with_section(kParts[part].section, used.error(), reload->read);
        roll_back(reload, part + 1);
      });
}

/// Rolls back the first `parts` parts, the last one first.
void Reloader::roll_back(const ReloadPtr& reload, std::size_t parts) {
  if (parts == 0) return refuse(*reload);
  const Part& part = kParts[parts - 1];
  (this->*part.apply)(
      reload, reload->before, [this, reload, parts, name = part.name](const Result<void>& back) {
        if (!back) {
          reload->not_restored.emplace_back(name);
          reload->why_not->reason +=
              fmt::format("; the {} could not be restored: {}", name, back.error().reason);
        }
        roll_back(reload, parts - 1);
      });
}

void Reloader::apply_slm(const ReloadPtr& /*reload*/, const Config& to, const Done& done) {
  const SlmSettings now = deps_.slm.snapshot().settings, wanted = to.slm;
  if (now == wanted) return done({});
  deps_.slm.change(SlmSet::difference(now, wanted),
                   [done](const Result<SlmSettings>& used) { done(outcome_of(used)); });
}

/// Uses a camera of another id with the settings as a start does: it may appear later. But one that
/// cannot use them is refused.
void Reloader::apply_camera(const ReloadPtr& reload, const Config& to, const Done& done) {
  const CameraSnapshot now = deps_.camera.snapshot();
  const CameraSet change = CameraSet::difference(now.asked, to.camera.settings);
  const auto changed = [done](const Result<CameraSnapshot>& used) { done(outcome_of(used)); };
  if (now.id == to.camera.id) {
    if (now.asked == to.camera.settings) return done({});
    return deps_.camera.change_or_keep(change, changed);
  }
  deps_.camera.select(to.camera.id, change, true, [=](const Result<CameraSnapshot>& used) {
    if (!used) return changed(used);
    const bool is_back = reload->why_not && reload->had_camera;
    const bool works = is_back ? used->connected : reload->why_not || !used->at_fault;
    done(works ? Result<void>() : fail(Errc::invalid, "camera", used->fault));
  });
}

void Reloader::apply_sensor(const ReloadPtr& /*reload*/, const Config& to, const Done& done) {
  const SensorView now = deps_.keeper.snapshot();
  const SensorSettings before{now->sensor, now->tracking};
  SensorSettings after{to.sensor, to.tracking};
  if (!now->sensor.lenslets.empty()) after.sensor = now->sensor;  // hardware: needs a restart
  if (to_json(after) == to_json(before)) return done({});
  SensorSet change = SensorSet::whole(after);
  if (after.tracking.mode_operator == before.tracking.mode_operator) {
    // Do not request the unchanged operator: the request could be refused now.
    change.forget(&TrackingSettings::mode_operator);
  }
  deps_.keeper.edit(set_sensor(std::move(change), after.sensor.masks),
                    [done](const Result<SensorView>& used) { done(outcome_of(used)); });
}

void Reloader::finish(const ReloadPtr& reload) {
  const Config& after = reload->after;
  // The refiner checks the values that the file has passed already once more, in the pixel format
  // of the camera.
  if (!(after.refine == reload->before.refine)) {
    const auto refined =
        deps_.refiner.change(RefineSet::whole(after.refine), after.camera.settings.pixel_format);
    if (!refined) reload->refine_error = with_section("refine", refined.error(), reload->read);
  }
  deps_.images.set_rate(after.stream.image_rate_hz);
  set_log_level(after.log.level);
  deps_.settings.set_loaded(reload->read);
  deps_.disk.post([reload] {
    set_aside_if_invalid(reload->read);
    report(*reload);
  });
  // All is changed: do not keep the bench while the disk may not answer. A client's config.save
  // comes to the disk after this task.
  reload->lease->end();
}

void Reloader::report(Reload& reload) {
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
  reload.say(all_used ? Severity::info : Severity::warning, std::move(text),
             {{"reloaded", true},
              {"applied", live},
              {"restart", restart},
              {"saved", reload.read.saved},
              {"edited", reload.read.edited}});
}

void Reloader::refuse(Reload& reload) {
  const Error& why = *reload.why_not;
  const std::string what_stays =
      reload.not_restored.empty()
          ? "nothing has changed"
          : fmt::format("all but the {} is unchanged", fmt::join(reload.not_restored, " and the "));
  reload.say(Severity::error,
             fmt::format("configuration not reloaded, {}: {}", what_stays, text_of(why)),
             {{"reloaded", false}, {"field", why.field}, {"reason", why.reason}});
}

/// Ends the lease first, because a client may start a job as soon as it receives the event.
void Reloader::end(Reload& reload) {
  reload.lease.reset();
  deps_.events.emit("config", reload.severity, reload.text, reload.data);
  service::notify_ready();
  busy_.store(false);
}

}  // namespace ovws
