/// ovws watch: shows the bench full-screen, or prints a stream's messages as tables or JSON lines.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/watch_screen.hpp"
#include "daemon/ovws/cli/watch_table.hpp"
#include "daemon/shared/client.hpp"
#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

std::atomic<bool> stop_requested{false};

/// Prints one topic's messages on standard output.
class Watch {
 public:
  Watch(const Common& common, const WatchOptions& options, const json& status)
      : common_(common),
        options_(options),
        table_(!common.json && has_table(options.topic)),
        in_place_(table_ && isatty(STDOUT_FILENO) != 0),
        status_(status) {}

  /// Returns the exit code.
  int run(Subscriber& stream) {
    auto last = Clock::now();  // message of the topic
    for (int shown = 0; !stop_requested && (options_.count == 0 || shown < options_.count);) {
      const auto message = stream.receive(std::chrono::milliseconds(100));
      if (output_has_no_reader()) return kError;
      if (message && message->topic == options_.topic) last = Clock::now();
      if (options_.timeout_s && Clock::now() - last > Seconds(*options_.timeout_s)) {
        return report_silence();
      }
      if (!message) continue;
      if (table_ && message->topic == "status") status_ = json_of(message->json);
      if (message->topic != options_.topic || is_too_soon()) continue;
      ++shown;
      show(*message);
      if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return kError;
    }
    return kOk;
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  int report_silence() const {
    const std::string text =
        fmt::format("no {} message arrived within {:g} s", options_.topic, *options_.timeout_s);
    return report_failure(common_, {false, {{"message", text}}});
  }

  /// Limits a table that is redrawn in place to 20 updates per second.
  bool is_too_soon() {
    const auto now = Clock::now();
    if (in_place_ && now - last_ < std::chrono::milliseconds(50)) return true;
    last_ = now;
    return false;
  }

  void show(const StreamMessage& message) const {
    if (!table_) return print("{}\n", message.json);
    if (in_place_) print("\033[H\033[J");
    const json body = json_of(message.json);
    options_.topic == "refined" ? print_refined(body) : print_wavefront(body, status_);
  }

  const Common& common_;
  const WatchOptions& options_;
  bool table_;
  bool in_place_;
  json status_;  ///< the newest
  Clock::time_point last_{};
};

bool is_for_screen(const Common& common, const WatchOptions& options) {
  return options.topic == "wavefront" && options.count == 0 && !options.plain && !common.json &&
         can_show_screen();
}

}  // namespace

int watch(const Common& common, const WatchOptions& options) {
  if (is_for_screen(common, options)) return show_screen(common);
  const bool is_picture = options.topic == "image" || options.topic == "phase";
  const auto endpoint = stream_endpoint(common, is_picture ? "image_endpoint" : "endpoint");
  if (!endpoint) return report_failure(common, endpoint.error());
  std::vector<std::string> topics{options.topic};
  if (options.topic == "wavefront")
    topics.emplace_back("status");  // provides reference and pattern
  auto stream = subscribe(common, *endpoint, topics, 100);
  if (!stream) return report(common, stream.error());
  const auto status = call(common, "system.status", json::object());
  if (!status) return report_failure(common, status.error());
  if (options.topic == "refined" && status->at("refine").at("state") == "off") {
    return report(common, {Errc::refused, "refine.enabled",
                           "refinement is off, so there are no messages; switch it on with your "
                           "camera's electrons per DN: ovws call refine.set '{\"enabled\": true, "
                           "\"electrons_per_dn\": 39.2}'"});
  }
  std::signal(SIGINT, [](int) { stop_requested.store(true); });
  std::signal(SIGTERM, [](int) { stop_requested.store(true); });
  return Watch(common, options, *status).run(*stream);
}

}  // namespace ovws::cli
