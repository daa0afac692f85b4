/// Methods of the daemon's other parts: config, job, loop, record, refine, system.
#include "config/config.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "daemon/ovwsd/control/status_reporter.hpp"
#include "daemon/ovwsd/loop/closed_loop.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/record/record_folder.hpp"
#include "daemon/ovwsd/settings/settings.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/record.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/status.hpp"

namespace ovws {
namespace {

void get_config(Services& services, const Reply<Config>& reply) {
  // dump_config uses the file's format: gain_db is 0 if the camera has no gain in dB.
  reply(JsonOf<Config>{json_of(dump_config(services.settings.in_use()))});
}

void save_config(Services& services, const ConfigSave& params, const Reply<SavedReport>& reply) {
  const LoadedConfig loaded = services.settings.loaded();
  if (!loaded.overlay) {
    return reply(Error{Errc::refused, "state.directory",
                       "there is no folder to save to: set state.directory in the configuration "
                       "file, or $STATE_DIRECTORY, and restart the daemon"});
  }
  const SavedValues values = values_to_save(loaded, services.settings.requested());
  if (params.preview) return reply(SavedReport{*loaded.overlay, values.keys});
  // Counted before either thread ends the lease: a reload that has read the file reads it again.
  const auto count = [&settings = services.settings] { settings.count_save(); };
  const auto asked = services.disk.request([path = *loaded.overlay, values, reply, count] {
    count();
    const auto saved = write_saved(path, values);
    if (!saved) return reply(saved.error());
    reply(SavedReport{path, values.keys});
  });
  count();
  if (!asked) return reply(asked.error());
  reply.end_lease();  // the disk may not answer for minutes
}

void get_job(Services& services, const JobNumber& which, const Reply<JobReport>& reply) {
  reply(services.jobs.get(which.job));
}

void cancel_job(Services& services, const JobNumber& which, const Reply<JobReport>& reply) {
  const auto cancelled = services.jobs.cancel(which.job);
  if (services.jobs.runs(which.job)) return reply(cancelled);  // its result is in use
  // Replies when the sensor is free again, so that the client can start the next job at once.
  services.procedures.when_over(which.job, [&services, which, reply] {
    (void)services.jobs.end_cancelled(which.job);  // if the procedure had returned before
    reply(services.jobs.get(which.job));
  });
}

void close_loop(Services& services, const LoopSettings& settings, const Reply<LoopReport>& reply) {
  services.loop.close(reply.take_lease(), settings, reply);
}

void open_loop(Services& services, const LoopOpen& how, const Reply<LoopReport>& reply) {
  services.loop.open(how.keep, reply);
}

void pause_loop(Services& services, const LoopPause& how, const Reply<LoopReport>& reply) {
  services.loop.pause(how.paused, reply);
}

void start_recording(Services& services, const RecordStart& asked,
                     const Reply<RecordReport>& reply) {
  services.keeper.ask([&services, asked, reply](const SensorEdit& edit) {
    if (auto can = check_no_sequence(edit.state); !can) return reply(can.error());
    const Config now = services.settings.in_use();
    services.recorder.start({asked, dump_config(now), now.camera.settings,
                             services.camera.snapshot().info, "ovwsd " OVWS_VERSION},
                            reply);
  });
}

void stop_recording(Services& services, const Reply<RecordReport>& reply) {
  services.recorder.stop(reply);
}

PixelFormat camera_format(const Services& services) {
  return services.camera.snapshot().settings.pixel_format;
}

void get_refine(Services& services, const Reply<RefineReport>& reply) {
  reply(RefineReport{in_format(services.refiner.settings(), camera_format(services))});
}

void set_refine(Services& services, const RefineSet& change, const Reply<RefineSetReport>& reply) {
  const auto applied = services.refiner.change(change, camera_format(services));
  if (!applied) return reply(applied.error());
  reply(RefineSetReport{change, {*applied}});
}

Json make_description() {
  Description all;
  all.versions = versions();
  all.roles = method_roles();
  constexpr std::string_view kStream = "stream.";
  for (const Schema& one : schemas()) {
    if (one.name.starts_with(kStream)) {
      all.streams.emplace_back(one.name.substr(kStream.size()), one.json);
      continue;
    }
    const auto text = [&one](const char* key) { return one.json.value(key, std::string()); };
    all.methods.emplace_back(
        one.name,
        MethodDescription{text("title"), text("description"), one.json["params"],
                          one.json["result"], text("binary_params"), text("binary_result")});
  }
  return to_json(all);
}

void describe(Services& /*services*/, const Reply<Description>& reply) {
  static const Json kDescription = make_description();  // made once, because it takes milliseconds
  reply(JsonOf<Description>{kDescription});
}

void status(Services& services, const Reply<StatusMessage>& reply) {
  reply(services.status.current());
}

void get_loop(Services& services, const Reply<LoopReport>& reply) {
  reply(services.loop.report());
}

KnownLoopModel known(const std::shared_ptr<const LoopModel>& model) {
  return {model ? std::optional(*model) : std::nullopt};
}

void get_loop_model(Services& services, const Reply<KnownLoopModel>& reply) {
  reply(known(services.loop.model()));
}

/// Timing of a loop on this bench, estimated from the settings.
LoopTiming estimated_timing(Services& services, const CameraSettings& camera) {
  const auto display = services.slm.snapshot().info;
  return estimated_timing(services.settings.in_use(), camera, display ? display->refresh_hz : 0.0);
}

Result<KnownLoopModel> identify_loop(Services& services, Bench& bench, const LoopIdentify& params) {
  constexpr double kOpenSamples = 4.0;  // a step: the spectrum reaches beyond the loop's
  constexpr int kEnoughSteps = 50;      // for a mean
  const LoopReport last = services.loop.report();
  const int measured = last.step.steps >= kEnoughSteps ? last.step.steps : 0;
  const LoopTiming timing =
      measured > 0 ? last.step.timing() : estimated_timing(services, bench.camera().settings);
  const auto series = watch_disturbance(bench, params.seconds,
                                        last.closed ? timing.step_s : timing.step_s / kOpenSamples);
  if (!series) return fail(series.error());
  LoopModel model =
      identify(*series, timing, last.settings.gain, last.settings.leak, [&bench](double done) {
        bench.report_progress(kWatchingShare + (1.0 - kWatchingShare) * done);
        return !bench.stopped();
      });
  if (bench.stopped()) return fail(Errc::refused, "", "the job was cancelled");
  if (model.modes.empty()) {
    return fail(Errc::refused, "seconds",
                "too few frames came for a spectrum of the disturbance: watch for longer");
  }
  model.measured_steps = measured;
  model.t_taken_ns = utc_ns();
  services.loop.use_model(std::move(model));
  return known(services.loop.model());
}

void get_recording(Services& services, const Reply<RecordReport>& reply) {
  reply(services.recorder.report());
}

void estimate_recording(Services& services, const RecordEstimate& asked,
                        const Reply<RecordSize>& reply) {
  services.recorder.size_of(services.camera.snapshot().settings, asked.pictures_every, reply);
}

void list_recordings(Services& services, const Reply<RecordingList>& reply) {
  const auto asked = services.disk.request(
      [folder = RecordFolder(services.config), reply] { reply(folder.list()); });
  if (!asked) reply(asked.error());
}

constexpr std::array kSystemRows{
    row<kConfigGet, get_config>(Role::read, Request::read),
    row<kConfigSave, save_config>(Role::control, Request::save_settings),
    row<kJobGet, get_job>(Role::read, Request::read),
    row<kJobCancel, cancel_job>(Role::control, Request::act),
    row<kLoopClose, close_loop>(Role::control, Request::close_loop),
    row<kLoopIdentify, run<kLoopIdentify, identify_loop, check_shows_one_sensor>>(Role::control,
                                                                                  Request::watch),
    row<kLoopModel, get_loop_model>(Role::read, Request::read),
    row<kLoopOpen, open_loop>(Role::control, Request::act),
    row<kLoopPause, pause_loop>(Role::control, Request::act),
    row<kLoopGet, get_loop>(Role::read, Request::read),
    row<kRecordEstimate, estimate_recording>(Role::read, Request::read),
    row<kRecordList, list_recordings>(Role::read, Request::read),
    row<kRecordStart, start_recording>(Role::control, Request::act),
    row<kRecordStop, stop_recording>(Role::control, Request::act),
    row<kRecordGet, get_recording>(Role::read, Request::read),
    row<kRefineGet, get_refine>(Role::read, Request::read),
    row<kRefineSet, set_refine>(Role::control, Request::set_refinement),
    row<kSystemDescribe, describe>(Role::read, Request::read),
    row<kSystemStatus, status>(Role::read, Request::read),
};

}  // namespace

std::span<const MethodRow> system_methods() {
  return kSystemRows;
}

}  // namespace ovws
