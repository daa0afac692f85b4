#include "drivers/twin/twin.hpp"

#include <functional>
#include <string_view>
#include <utility>

namespace ovws::twin {

Twin::Twin(const Config& config, const std::string& x_display)
    : config_(config),
      bench_(config),
      frames_(config.optics.wavelength_nm),
      screen_(config, x_display, bench_) {}

Result<std::unique_ptr<Twin>> Twin::start(const Config& config, const std::string& x_display) {
  std::unique_ptr<Twin> twin(new Twin(config, x_display));
  Twin* const t = twin.get();
  const auto answer = [t](const ControlRequest& request, SendReply reply) {
    const auto call = [t](const RpcCall& asked, const RpcReply& answered) {
      answered(t->methods_->call(asked.method, asked.params));
    };
    handle_rpc(request.bytes, {}, call, std::move(reply));
  };
  auto control = ControlServer::bind(
      config.control_endpoint, {kMaxRequestBytes, 0, oversize_reply(), overload_reply()}, answer);
  if (!control) {
    control.error().field = "control.endpoint";
    return fail(control.error());
  }
  auto camera = FakeCamera::plug_in(config.camera,
                                    {twin->screen_, twin->bench_, twin->frames_, twin->faults_});
  if (!camera) return fail(camera.error());
  twin->control_ = std::move(*control);
  twin->camera_ = std::move(*camera);
  twin->methods_ = std::make_unique<Methods>(
      config,
      Methods::Deps{twin->bench_, twin->frames_, twin->faults_, twin->screen_, *twin->camera_});

  t->bench_thread_ = std::jthread([t](const std::stop_token& stop) { t->bench_.work(stop); });
  t->noise_thread_ = std::jthread([t](const std::stop_token& stop) { t->frames_.work(stop); });
  t->screen_thread_ = std::jthread([t](const std::stop_token& stop) { t->screen_.work(stop); });
  t->camera_thread_ = std::jthread([t](const std::stop_token& stop) { t->camera_->work(stop); });
  t->control_thread_ = std::jthread([t](const std::stop_token& stop) {
    while (!stop.stop_requested()) t->control_->do_work();
    t->control_->on_close();
  });
  return twin;
}

Twin::~Twin() {
  for (std::jthread* thread :
       {&control_thread_, &camera_thread_, &screen_thread_, &noise_thread_, &bench_thread_}) {
    thread->request_stop();
  }
  if (camera_) camera_->request_stop();
}

std::string Twin::addresses() const {
  return "camera=" + config_.camera.address + ":3956/udp control=" + config_.control_endpoint +
         " slm=" + (config_.slm.display.empty() ? "none" : config_.slm.display);
}

}  // namespace ovws::twin
