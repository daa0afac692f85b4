/// ovws watch: a stream's messages, as a table that stays in place or as lines of JSON.
#include <fmt/core.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>

#include "core/optics/zernike.hpp"
#include "daemon/cli/client.hpp"
#include "daemon/cli/commands.hpp"
#include "drivers/zmq/client.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

struct WatchOptions {
  std::string topic = "wavefront";
  int count = 0;  ///< messages; 0: until Ctrl-C
};

constexpr int kBarHalfWidth = 20;

std::atomic<bool> stop_requested{false};

/// A bar that grows from the middle, `full_scale` waves wide to each side.
std::string signed_bar(double waves, double full_scale) {
  const int length =
      std::min(kBarHalfWidth, int(std::abs(waves) / full_scale * kBarHalfWidth + 0.5));
  std::string left(std::size_t(kBarHalfWidth), ' ');
  std::string right = left;
  for (int i = 0; i < length; ++i) {
    (waves < 0 ? left[std::size_t(kBarHalfWidth - 1 - i)] : right[std::size_t(i)]) = '#';
  }
  return left + "|" + right;
}

void print_wavefront(const json& message, bool in_place) {
  if (in_place) fmt::print("\033[H\033[J");
  fmt::print("frame {}  hologram {}{}  charge {} ({})  spots {}/{}  {}  latency {:.0f} us\n",
             message["frame_id"].get<std::uint64_t>(), message["hologram_id"].get<std::uint64_t>(),
             message["settled"].get<bool>() ? "" : " (changing)", message["charge"].get<int>(),
             message["tracker"].get<std::string>(), message["tracked"].get<int>(),
             message["subapertures"].get<int>(),
             message["valid"].get<bool>() ? "valid" : "NOT VALID",
             message["latency_us"].get<double>());
  if (!message["valid"].get<bool>()) return;
  double full_scale = 0.1;
  for (const json& value : message["coefficients"]) {
    full_scale = std::max(full_scale, std::abs(value.get<double>()));
  }
  for (std::size_t i = 0; i < message["j"].size(); ++i) {
    const int j = message["j"][i].get<int>();
    const double waves = message["coefficients"][i].get<double>();
    fmt::print("{:>3} {:<28} {:+9.4f} {}\n", j, zernike_name(j), waves,
               signed_bar(waves, full_scale));
  }
  fmt::print("RMS {:.4f} wave without tilts, fit residual {:.4f} px, bar {:.2f} wave\n",
             message["rms_waves"].get<double>(), message["fit_residual_px"].get<double>(),
             full_scale);
}

int watch(const Common& common, const WatchOptions& options) {
  const bool is_picture = options.topic == "image" || options.topic == "phase";
  const auto endpoint = stream_endpoint(common, is_picture ? "image_endpoint" : "endpoint");
  if (!endpoint) return report_failure(common, endpoint.error());
  auto stream = Subscriber::connect(*endpoint, {options.topic}, 100);
  if (!stream) return report(common, stream.error());
  std::signal(SIGINT, [](int) { stop_requested.store(true); });
  std::signal(SIGTERM, [](int) { stop_requested.store(true); });
  const bool table = !common.json && options.topic == "wavefront";
  const bool in_place = table && isatty(STDOUT_FILENO) != 0;
  auto last = std::chrono::steady_clock::time_point{};
  for (int shown = 0; !stop_requested && (options.count == 0 || shown < options.count);) {
    const auto message = stream->receive(std::chrono::milliseconds(100));
    if (!message || message->topic != options.topic) continue;
    const auto now = std::chrono::steady_clock::now();
    if (in_place && now - last < std::chrono::milliseconds(50)) continue;
    last = now;
    ++shown;
    if (table) {
      print_wavefront(json::parse(message->json), in_place);
    } else {
      fmt::print("{}\n", message->json);
    }
    std::fflush(stdout);
  }
  return kOk;
}

}  // namespace

void add_watch(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("watch", "live view of a stream; with --json its messages");
  auto options = std::make_shared<WatchOptions>();
  command->add_option("topic", options->topic, "stream")
      ->check(CLI::IsMember({"wavefront", "spots", "image", "phase", "status", "event"}))
      ->capture_default_str();
  command->add_option("-n,--count", options->count, "end after so many messages");
  command->callback([&common, &status, options] { status = watch(common, *options); });
}

}  // namespace ovws::cli
