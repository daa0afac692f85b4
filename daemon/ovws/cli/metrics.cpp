/// ovws metrics: serves a daemon's metrics to Prometheus.
#include "daemon/ovws/metrics/exporter.hpp"

#include <atomic>
#include <csignal>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/shared/stream_follower.hpp"

namespace ovws::cli {
namespace {

constexpr std::chrono::milliseconds kReceiveTimeout{200};
constexpr double kCallTimeoutS = 1.0;
constexpr int kQueue = 1000;

std::atomic<bool> stop_requested{false};

}  // namespace

int serve_metrics(Common common, const std::string& address) {
  auto exporter = metrics::Exporter::serve(address);
  if (!exporter) return report(common, exporter.error());
  std::signal(SIGINT, [](int) { stop_requested.store(true); });
  std::signal(SIGTERM, [](int) { stop_requested.store(true); });
  print("metrics at http://{}/metrics\n", address);
  std::fflush(stdout);
  common.timeout_s = kCallTimeoutS;
  StreamFollower stream(common, "endpoint", {"status", "wavefront"}, kQueue);
  while (!stop_requested) {
    auto message = stream.receive(kReceiveTimeout);
    if (message) exporter->take(message->topic, std::move(message->json));
  }
  return kOk;
}

}  // namespace ovws::cli
