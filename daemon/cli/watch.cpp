/// ovws watch: a stream's messages, as a table that stays in place or as lines of JSON.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <limits>
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

std::size_t longest_name(const json& modes_j) {
  std::size_t length = 0;
  for (const json& j : modes_j) length = std::max(length, zernike_name(j.get<int>()).size());
  return length;
}

void print_wavefront(const json& message, bool referenced, bool in_place) {
  if (in_place) print("\033[H\033[J");
  const bool valid = message["valid"].get<bool>();
  print(
      "frame {}  hologram {}  charge {} ({})  spots {}/{}  saturated {:.0f} %  latency {:.0f} us  "
      "{}\n",
      message["frame_id"].get<std::uint64_t>(), message["hologram_id"].get<std::uint64_t>(),
      message["charge"].get<int>(), message["tracker"].get<std::string>(),
      message["tracked"].get<int>(), message["subapertures"].get<int>(),
      100.0 * message["saturated"].get<double>(), message["latency_us"].get<double>(),
      valid ? "valid" : "NOT VALID: " + why_not_valid(message, referenced));
  if (!valid) return;
  double full_scale = 0.1;
  for (const json& value : message["coefficients"]) {
    full_scale = std::max(full_scale, std::abs(value.get<double>()));
  }
  const std::size_t name_width = longest_name(message["j"]);
  for (std::size_t i = 0; i < message["j"].size(); ++i) {
    const int j = message["j"][i].get<int>();
    const double waves = message["coefficients"][i].get<double>();
    print("{:>3} {:<{}} {:+9.4f} {}\n", j, zernike_name(j), name_width, waves,
          signed_bar(waves, full_scale));
  }
  print("RMS {:.4f} wave without tilts, fit residual {:.4f} px, bar {:.2f} wave\n",
        message["rms_waves"].get<double>(), message["fit_residual_px"].get<double>(), full_scale);
}

/// One topic's messages on their way to standard output.
class Watch {
 public:
  Watch(const Common& common, const WatchOptions& options, bool referenced)
      : options_(options),
        table_(!common.json && options.topic == "wavefront"),
        in_place_(table_ && isatty(STDOUT_FILENO) != 0),
        referenced_(referenced) {}

  /// Returns the exit code.
  int run(Subscriber& stream) {
    for (int shown = 0; !stop_requested && (options_.count == 0 || shown < options_.count);) {
      const auto message = stream.receive(std::chrono::milliseconds(100));
      if (output_has_no_reader()) return kError;
      if (!message) continue;
      if (table_ && message->topic == "status") {
        referenced_ = json::parse(message->json)["sensor"]["referenced"].get<bool>();
      }
      if (message->topic != options_.topic || is_too_soon()) continue;
      ++shown;
      show(*message);
      if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return kError;
    }
    return kOk;
  }

 private:
  /// A table that stays in place is drawn only as often as eyes can follow.
  bool is_too_soon() {
    const auto now = std::chrono::steady_clock::now();
    if (in_place_ && now - last_ < std::chrono::milliseconds(50)) return true;
    last_ = now;
    return false;
  }

  void show(const StreamMessage& message) const {
    if (table_) {
      print_wavefront(json::parse(message.json), referenced_, in_place_);
    } else {
      print("{}\n", message.json);
    }
  }

  const WatchOptions& options_;
  bool table_;
  bool in_place_;
  bool referenced_;
  std::chrono::steady_clock::time_point last_{};
};

int watch(const Common& common, const WatchOptions& options) {
  const bool is_picture = options.topic == "image" || options.topic == "phase";
  const auto endpoint = stream_endpoint(common, is_picture ? "image_endpoint" : "endpoint");
  if (!endpoint) return report_failure(common, endpoint.error());
  std::vector<std::string> topics{options.topic};
  if (options.topic == "wavefront") topics.emplace_back("status");  // tells of the reference
  auto stream = Subscriber::connect(*endpoint, topics, 100);
  if (!stream) return report(common, stream.error());
  const auto status = call(common, "system.status", json::object());
  if (!status) return report_failure(common, status.error());
  std::signal(SIGINT, [](int) { stop_requested.store(true); });
  std::signal(SIGTERM, [](int) { stop_requested.store(true); });
  return Watch(common, options, (*status)["sensor"]["referenced"].get<bool>()).run(*stream);
}

}  // namespace

void add_watch(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("watch",
                                     "the wavefront as a live table; with --json, and always for "
                                     "the other topics, each message's JSON as a line");
  auto options = std::make_shared<WatchOptions>();
  command->add_option("topic", options->topic, "stream")
      ->check(CLI::IsMember({"wavefront", "spots", "image", "phase", "status", "event"}))
      ->capture_default_str();
  command->add_option("-n,--count", options->count, "end after so many messages; 0: never")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  command->callback([&common, &status, options] { status = watch(common, *options); });
}

}  // namespace ovws::cli
