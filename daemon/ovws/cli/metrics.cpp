/// ovws metrics: serves a daemon's metrics to Prometheus.
#include "daemon/ovws/metrics/exporter.hpp"

#include <atomic>
#include <csignal>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/stream_follower.hpp"

namespace ovws::cli {
namespace {

constexpr std::chrono::milliseconds kReceiveTimeout{200};
constexpr std::chrono::milliseconds kCallTimeout{1000};

std::atomic<bool> stop_requested{false};

int serve_metrics(const Common& common, const std::string& address) {
  auto exporter = metrics::Exporter::serve(address);
  if (!exporter) return report(common, exporter.error());
  std::signal(SIGINT, [](int) { stop_requested.store(true); });
  std::signal(SIGTERM, [](int) { stop_requested.store(true); });
  print("metrics at http://{}/metrics\n", address);
  std::fflush(stdout);
  StreamFollower stream(common, {"status", "wavefront"}, kCallTimeout);
  while (!stop_requested) {
    auto message = stream.receive(kReceiveTimeout);
    if (message) exporter->take(message->topic, std::move(message->json));
  }
  return kOk;
}

}  // namespace

void add_metrics(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "metrics",
      "serve the daemon's metrics to Prometheus (http://ADDRESS:PORT/metrics) until Ctrl-C; "
      "reconnects when the daemon restarts");
  auto address = std::make_shared<std::string>("127.0.0.1:7705");
  command
      ->add_option("--listen", *address,
                   "ADDRESS:PORT with a numeric loopback address, because metrics need no key")
      ->envname("OVWS_METRICS_LISTEN")
      ->capture_default_str();
  command->callback([&common, &status, address] { status = serve_metrics(common, *address); });
}

}  // namespace ovws::cli
