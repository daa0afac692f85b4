/// ovws metrics: serves a daemon's metrics to Prometheus.
#include "daemon/ovws/metrics/exporter.hpp"

#include <csignal>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/shared/stream_follower.hpp"

namespace ovws::cli {
namespace {

constexpr std::chrono::milliseconds kReceiveTimeout{200};
constexpr double kMetricsTimeoutS = 1.0;

}  // namespace

int serve_metrics(Common common, const std::string& address) {
  auto exporter = metrics::Exporter::serve(address);
  if (!exporter) return report(common, exporter.error());
  catch_interrupts({SIGINT, SIGTERM});
  print("metrics at http://{}/metrics\n", address);
  std::fflush(stdout);
  common.timeout_s = kMetricsTimeoutS;
  StreamFollower stream(common, "endpoint", {"status", "wavefront"}, kStreamQueue);
  while (!was_interrupted()) {
    auto message = stream.receive(kReceiveTimeout);
    if (message) exporter->take(message->topic, std::move(message->json));
  }
  return kOk;
}

}  // namespace ovws::cli
