/// ovws metrics: serves a daemon's metrics to Prometheus.
#include "daemon/ovws/metrics/exporter.hpp"

#include <csignal>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/shared/stream_follower.hpp"

namespace ovws::cli {
namespace {

constexpr std::chrono::milliseconds kReceiveTimeout{200};
constexpr double kMetricsTimeoutS = 1.0;

int serve_metrics(const Common& given, const std::string& address) {
  Common common = given;
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

}  // namespace

void add_metrics(CLI::App& app, const Common& common, int& status) {
  auto [command, address] = add_command(
      app, common, status, "metrics",
      "serve the daemon's metrics to Prometheus (http://ADDRESS:PORT/metrics) until Ctrl-C; "
      "reconnects when the daemon restarts",
      serve_metrics);
  address = "127.0.0.1:7705";
  command
      .add_option("--listen", address,
                  "ADDRESS:PORT with a numeric loopback address, because metrics need no key")
      ->envname("OVWS_METRICS_LISTEN")
      ->capture_default_str();
}

}  // namespace ovws::cli
