#include "daemon/ovwsd/app.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/camera/camera_finder.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/control/status_reporter.hpp"
#include "daemon/ovwsd/fitter/live_refiner.hpp"
#include "daemon/ovwsd/fitter/wavefront_search.hpp"
#include "daemon/ovwsd/loop/closed_loop.hpp"
#include "daemon/ovwsd/procedures/presentation.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/record/recorder.hpp"
#include "daemon/ovwsd/sensor/prepared_lattices.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/reload.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/ovwsd/streams/corrector.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"
#include "daemon/ovwsd/streams/stream_publisher.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"
#include "daemon/shared/service_notify.hpp"
#include "drivers/zmq/control_server.hpp"
#include "drivers/zmq/publisher.hpp"
#include "proto/rpc.hpp"

namespace ovws {
namespace {

constexpr int kMeasurementQueue = 1000;  ///< messages queued per subscriber; some kB each
constexpr double kStopTimeoutS = 1.2;
constexpr double kRecordingTimeoutS = 10.0;  ///< longest pause of the disk at a recording's end
constexpr double kDiskPollS = 0.2;
constexpr int kImageQueue = 4;  ///< images queued per subscriber; 1 MiB or more each
constexpr double kExitTimeoutS = 1.8;

std::atomic<int> exit_status{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler reads it");

bool log_failure(const Error& error) {
  spdlog::error("{}", text_of(error));
  return false;
}

[[noreturn]] void exit_now(const std::string& why, const Result<void>& written) {
  spdlog::warn("{}: exiting without waiting for it", why);
  if (!written) log_failure(written.error());
  std::_Exit(exit_status.load());
}

/// Ends the process by SIGALRM after `patience_s`. The alarm is needed because a display that does
/// not respond may block the main thread after all other threads have ended.
void exit_by_alarm_after(double patience_s) {
  std::signal(SIGALRM, [](int /*signal*/) {
    static constexpr char kMessage[] =
        "<4>the display does not respond: exiting without waiting for it\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1);
    std::_Exit(exit_status.load());
  });
  const auto whole_s = time_t(patience_s);
  const itimerval once{{0, 0}, {whole_s, suseconds_t(1e6 * (patience_s - double(whole_s)))}};
  ::setitimer(ITIMER_REAL, &once, nullptr);
}

PipelineConfig with_plans(const Config& config) {
  PipelineConfig pipeline = config.pipeline;
  pipeline.beams = int(config.beams.size());
  pipeline.patterns = std::max(config.dmd.slots - 1, 0);
  return pipeline;
}

/// Parts of the daemon, declared in the order of construction: dependencies first. Members are
/// destroyed in reverse order.
struct Parts {
  Config config;
  FolderLock state_lock;
  Counters counters;
  StreamQueue queue;
  Events events{queue};
  Leases leases{events, config.modulator == Modulator::fixed};
  std::unique_ptr<ClientGuard> clients;  ///< outlives all sockets, which use its gate
  Disk disk;
  Library library{config.state, events, &disk};
  NamedReferences named{library};
  PreparedLattices lattices{library};
  LatestValue<ShownHologram> shown;
  LatestValue<AppliedSettings> applied;
  LatencyHistogram published_latency;
  Pipeline pipeline;
  FrameTaps frames;
  Recorder recorder;
  ImageBrightness brightness;
  Corrector corrector{events};
  Jobs jobs{events};
  SlmLoop slm;
  FrameGrabs grabs{frames, [this] { return slm.snapshot().hologram_id; }};
  CameraActor camera;
  CameraFinder finder;
  std::unique_ptr<SensorKeeper> keeper;
  std::unique_ptr<Procedures> procedures;
  std::unique_ptr<Presentations> presentations;
  std::unique_ptr<ClosedLoop> loop;
  std::unique_ptr<WavefrontSearch> search;
  std::unique_ptr<LiveRefiner> refiner;
  std::unique_ptr<Settings> settings;
  std::unique_ptr<StreamPublisher> stream;
  std::unique_ptr<ImagePublisher> images;
  std::unique_ptr<Reloader> reloader;
  std::unique_ptr<StatusReporter> status;
  std::unique_ptr<Services> services;
  std::unique_ptr<ControlServer> control;
  std::atomic<bool> ending{false};
  int warned_of = 0;  ///< items of check_unwritten's warning
  ThreadPlan threads;

  Parts(const LoadedConfig& as_loaded, FolderLock lock)
      : config(as_loaded.effective),
        state_lock(std::move(lock)),
        pipeline(with_plans(config), {counters, shown, applied}),
        recorder(config, pipeline, frames, events),
        slm(config.slm,
            {shown, counters, events, [this](const SlmSnapshot& now) { display_changed(now); }}),
        camera(config.camera, {pipeline, applied, counters, events,
                               [this](const CameraSnapshot& now) { camera_changed(now); }}),
        finder([this] {
          CameraConfig now = config.camera;
          now.id = camera.snapshot().id;
          return now;
        }),
        threads(config.realtime, config.pipeline.cpus,
                [this](const ThreadFailure& failure) { thread_failed(failure); }) {
    disk.each_turn([this] { return library.turn(); });
  }

  void camera_changed(const CameraSnapshot& now) {
    if (now.connected) {
      keeper->camera_changed(now.settings, now.info);
    }
    recorder.camera_changed(now.settings, now.info);
    leases.set_device("camera", &Conditions::camera, now.connected, now.at_fault ? now.fault : "");
  }
  void display_changed(const SlmSnapshot& now) {
    leases.set_device("slm", &Conditions::display, now.healthy, now.at_fault ? now.fault : "");
  }

  void thread_failed(const ThreadFailure& failure) {
    const bool goes_on = failure.row->on_exception == OnException::go_on;
    events.emit("thread", Severity::error,
                fmt::format("thread {} failed: {}; {}", failure.row->name, failure.what,
                            goes_on ? "the thread continues" : "the daemon exits to be restarted"),
                {{"thread", failure.row->name}, {"failure", failure.what}, {"goes_on", goes_on}});
  }

  Result<void> make(const LoadedConfig& loaded, std::atomic<bool>& reload);
  Result<void> run(const std::atomic<bool>& stop_requested);
  Result<void> make_sensor(const LoadedConfig& loaded);
  Result<void> bind_streams(std::atomic<bool>& reload);
  Result<void> bind_control();
  Result<void> start_threads();
  Result<void> end_disk_work();
  Result<void> check_unwritten();
  void end_without_display();
  Result<void> stop();
};

Result<void> Parts::make_sensor(const LoadedConfig& loaded) {
  auto made = SensorKeeper::make(config, {pipeline, slm, events, library, leases,
                                          [this](const MeasurementPlan& plan, SensorView now) {
                                            corrector.sensor_changed(now->modes_j);
                                            recorder.add_plan(plan, std::move(now));
                                          }});
  if (!made) return fail(made.error());
  keeper = std::move(*made);
  leases.on_turn([this](Holder holder, std::function<void()> then) {
    keeper->take_turn(holder, std::move(then));
  });
  procedures =
      std::make_unique<Procedures>(BenchDeps{config, *keeper, camera, frames, slm, jobs, events});
  presentations = std::make_unique<Presentations>(leases, *procedures, config.slm.geometry);
  loop = std::make_unique<ClosedLoop>(
      ClosedLoopDeps{frames, *keeper, leases, slm, events, [this] { return search->found_ns(); },
                     [this] {
                       const auto why = search->why_invalid();
                       return why ? in_words(*why) : std::string();
                     },
                     [this](std::string kind, nlohmann::json content) {
                       recorder.add_loop(std::move(kind), std::move(content));
                     }});
  search = std::make_unique<WavefrontSearch>(config, frames, brightness, *keeper, events);
  refiner = std::make_unique<LiveRefiner>(config.refine, config.optics, config.slm.geometry, frames,
                                          *keeper, queue);
  settings = std::make_unique<Settings>(loaded, camera, slm, *keeper, *refiner);
  return {};
}

Result<void> Parts::bind_streams(std::atomic<bool>& reload) {
  auto measurement = Publisher::bind(config.stream.endpoint, kMeasurementQueue, clients->gate());
  if (!measurement) return fail(measurement.error());
  auto image_socket = Publisher::bind(config.stream.image_endpoint, kImageQueue, clients->gate());
  if (!image_socket) return fail(image_socket.error());
  const double wavelength_nm = config.optics.wavelength_nm;
  stream = std::make_unique<StreamPublisher>(
      std::move(*measurement), wavelength_nm,
      StreamPublisherDeps{pipeline, frames, [this] { return loop->is_closed(); }, corrector,
                          counters, queue, published_latency});
  images = std::make_unique<ImagePublisher>(std::move(*image_socket), wavelength_nm,
                                            config.stream.image_rate_hz, pipeline, counters, frames,
                                            grabs, brightness);
  reloader = std::make_unique<Reloader>(
      ReloadDeps{*settings, leases, camera, slm, *keeper, *refiner, *images, events, disk, reload});
  status = std::make_unique<StatusReporter>(
      StatusDeps{leases,   camera,    slm,      *keeper,
                 *search,  *images,   *loop,    *refiner,
                 recorder, jobs,      pipeline, published_latency,
                 counters, events,    library,  queue,
                 threads,  *reloader, *clients, [this] { end_without_display(); }});
  return {};
}

Result<void> Parts::bind_control() {
  services = std::make_unique<Services>(Services{
      config,         *settings, leases,  camera,   finder,   *keeper, jobs,     *procedures,
      *presentations, grabs,     library, named,    lattices, *loop,   *refiner, recorder,
      corrector,      *status,   slm,     counters, *clients, disk});
  const ControlHandler handle = [this](ControlRequest request, SendReply reply) {
    const RpcDispatch call = [&](RpcCall asked, RpcReply give) {
      dispatch(*services, request.client_key, std::move(asked), std::move(give));
    };
    handle_rpc(request.bytes, std::move(request.binary), call, std::move(reply));
  };
  const std::size_t binary_bytes =
      std::max(max_picture_bytes(config.slm.geometry), kMaxMatrixBytes);
  auto bound = ControlServer::bind(
      config.control.endpoint,
      {kMaxRequestBytes, binary_bytes, oversize_reply(binary_bytes), overload_reply()}, handle,
      clients->gate());
  if (!bound) return fail(bound.error());
  control = std::move(*bound);
  return {};
}

/// Starts all threads, consumers before producers, so that no output is lost. stop_all joins the
/// threads in reverse order.
Result<void> Parts::start_threads() {
  if (auto locked = threads.prepare_process(); !locked) return locked;
  struct Start {
    ThreadRole role;
    Agent& agent;
  };
  // Threads that fit are started first and so joined last: a fit takes up to a second to end.
  std::vector<Start> starts{{ThreadRole::refine, *refiner}, {ThreadRole::search, *search},
                            {ThreadRole::publish, *stream}, {ThreadRole::disk, disk},
                            {ThreadRole::write, recorder},  {ThreadRole::record, recorder.taker()},
                            {ThreadRole::images, *images},  {ThreadRole::control, *control},
                            {ThreadRole::prepare, *keeper}, {ThreadRole::status, *status}};
  if (config.pipeline.workers > 0)
    starts.push_back({ThreadRole::reconstruct, pipeline.reconstruction()});
  for (int k = 0; k < config.pipeline.workers; ++k) {
    starts.push_back({ThreadRole::track, pipeline.tracker(k)});
  }
  starts.push_back({ThreadRole::acquire, pipeline.acquisition()});
  starts.push_back({ThreadRole::camera, camera});
  starts.push_back({ThreadRole::discover, finder});
  starts.push_back({ThreadRole::procedure, *procedures});
  starts.push_back({ThreadRole::loop, *loop});
  disk.begin();  // before the start of any thread that may post work to the disk thread
  for (const Start& start : starts) {
    if (auto started = threads.start(start.role, start.agent); !started) return started;
  }
  return {};
}

Result<void> Parts::make(const LoadedConfig& loaded, std::atomic<bool>& reload) {
  if (auto made = make_sensor(loaded); !made) return made;
  named.load();
  lattices.load();
  auto guard = ClientGuard::make(config.security, counters, events, disk);
  if (!guard) return fail(guard.error());
  clients = std::move(*guard);
  if (auto bound = bind_streams(reload); !bound) return bound;
  return bind_control();
}

Result<void> Parts::run(const std::atomic<bool>& stop_requested) {
  if (auto started = start_threads(); !started) return started;
  leases.set(&Conditions::started, true);
  service::notify_ready();
  spdlog::info("listening: control {}, streams {} and {}", config.control.endpoint,
               config.stream.endpoint, config.stream.image_endpoint);
  if (!clients->public_key().empty()) {
    spdlog::info("clients need a key; the daemon's public key is {}", clients->public_key());
  }
  threads.run_here(ThreadRole::display, slm, stop_requested);
  return stop();
}

/// Writes the end of a recording and the queued state items. Gives up if the disk makes no progress
/// for kRecordingTimeoutS while a recording ends, or else for kStopTimeoutS. The error says which
/// data is lost.
Result<void> Parts::end_disk_work() {
  const std::vector<ThreadRole> roles{ThreadRole::write, ThreadRole::disk};
  const bool recording = recorder.report().state == "recording";
  const double patience_s = recording ? kRecordingTimeoutS : kStopTimeoutS;
  const auto done = [this] { return std::pair(recorder.report().frames, library.queued()); };
  auto before = done();
  std::int64_t last_ns = monotonic_ns();
  threads.end_soon(roles);
  for (std::string held; !(held = threads.wait_for_end(roles, kDiskPollS)).empty();) {
    service::notify_extend(2.0 * kRecordingTimeoutS);
    if (auto now = done(); now != before) {
      before = now;
      last_ns = monotonic_ns();
    }
    if (1e-9 * double(monotonic_ns() - last_ns) < patience_s) continue;
    if (held != "write") break;
    exit_status.store(1);
    return fail(
        Errc::unavailable, "record",
        fmt::format("the disk has not answered for {:.0f} s: the end of {} is lost; check the disk",
                    patience_s, recorder.report().file.value_or("")));
  }
  if (recorder.lost_at_stop() == 0) return check_unwritten();
  exit_status.store(1);
  return fail(Errc::unavailable, "record",
              fmt::format("{} frames at the end of {} could not be written",
                          recorder.lost_at_stop(), recorder.report().file.value_or("")));
}

/// Reports state items that were not written. If the disk has refused a write, that failure has
/// been reported already, so this is only a warning. A disk that did not answer is an error.
Result<void> Parts::check_unwritten() {
  const int items = library.queued();
  if (items == 0) return {};
  const auto refused = library.report().reason;
  const std::string text = fmt::format("items that were not written and are lost: {}", items);
  if (refused) {
    if (std::exchange(warned_of, items) != items) spdlog::warn("state: {}: {}", text, *refused);
    return {};
  }
  exit_status.store(1);
  return fail(Errc::unavailable, "state", text + ": the disk has not answered");
}

/// Ends the process while a display that does not respond blocks the main thread. Status thread.
void Parts::end_without_display() {
  if (ending.exchange(true)) return;
  exit_now("the display does not respond", end_disk_work());
}

/// Stops the threads, users before the threads that they need. Procedures and the closed loop end
/// first. Camera and sensor then answer their pending requests, while the control thread still
/// runs. Next the disk thread finishes its pending work. All other threads end last.
Result<void> Parts::stop() {
  while (ending.exchange(true)) ::pause();  // the status thread is ending the process
  service::notify_stopping();
  leases.set(&Conditions::stopping, true);
  procedures->end_soon();
  refiner->end_soon();
  grabs.end_soon();
  slm.close();
  threads.end_soon({ThreadRole::procedure, ThreadRole::loop, ThreadRole::write});
  (void)threads.wait_for_end({ThreadRole::procedure, ThreadRole::loop}, kStopTimeoutS);
  const std::vector<ThreadRole> asked{ThreadRole::camera, ThreadRole::prepare};
  threads.end_soon(asked);
  std::string held = threads.wait_for_end(asked, kStopTimeoutS);
  auto written = end_disk_work();
  if (!threads.fatal_failure().empty()) exit_status.store(1);
  exit_by_alarm_after(kExitTimeoutS);
  const std::string other = threads.stop_all(held.empty() ? kStopTimeoutS : kDiskPollS);
  if (held.empty()) held = other;
  if (written) written = check_unwritten();
  if (const std::string why = threads.fatal_failure(); !why.empty()) {
    exit_status.store(1);
    if (!written) log_failure(written.error());
    written = fail(Errc::internal, "", why);
  }
  if (!held.empty()) exit_now("thread " + held + " does not end in time", written);
  return written;
}

}  // namespace

bool run_daemon(const LoadedConfig& loaded, const std::atomic<bool>& stop,
                std::atomic<bool>& reload) {
  const auto state = state_directory_of(loaded.effective.state);
  auto lock = state ? lock_folder(*state) : FolderLock();
  if (!lock) return log_failure(lock.error());
  const auto parts = std::make_unique<Parts>(loaded, std::move(*lock));
  auto done = parts->make(loaded, reload);
  if (done) done = parts->run(stop);
  // The error is logged before the parts are destroyed: SIGALRM may end the process meanwhile.
  return done || log_failure(done.error());
}

}  // namespace ovws
