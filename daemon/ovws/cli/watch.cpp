/// ovws watch: shows the bench full-screen, or prints a stream's messages as tables or JSON lines.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovws/text/mode_names.hpp"
#include "daemon/shared/client.hpp"
#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

struct WatchOptions {
  std::string topic = "wavefront";
  int count = 0;  ///< number of messages to show; 0: until Ctrl-C
  bool plain = false;
  const CLI::Option* timeout = nullptr;  ///< if it is given, it limits the wait for a message
};

constexpr int kBarHalfWidth = 20;

/// Text bar that grows from the middle to the left or right; each half spans `full_scale` waves.
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

/// Prints one line per mode, with its standard error if the message contains one. Returns the full
/// scale of the bars in waves.
double print_modes(const json& message) {
  double full_scale = 0.1;
  for (const json& value : message.at("coefficients")) {
    full_scale = std::max(full_scale, std::abs(value.get<double>()));
  }
  const std::size_t name_width = longest_name(message.at("j"));
  const json sigma = message.value("sigma", json::array());
  const bool has_errors = !sigma.empty() && sigma.front().is_number();
  for (std::size_t i = 0; i < message.at("j").size(); ++i) {
    const int j = message.at("j").at(i).get<int>();
    const double waves = message.at("coefficients").at(i).get<double>();
    const std::string bar = signed_bar(waves, full_scale);
    if (has_errors) {
      print("{:>3} {:<{}} {:>10} +-{:.5f} {}\n", j, zernike_name(j), name_width,
            signed_decimals(waves, 5), sigma.at(i).get<double>(), bar);
    } else {
      print("{:>3} {:<{}} {:>9} {}\n", j, zernike_name(j), name_width, signed_decimals(waves, 4),
            bar);
    }
  }
  return full_scale;
}

/// Whether messages of this topic contain coefficients, which are shown as a table.
bool has_table(const std::string& topic) {
  return topic == "wavefront" || topic == "refined";
}

/// Prints a `wavefront` or `refined` message. `status` explains an invalid frame by its reference
/// and SLM pattern.
void print_frame(const json& message, bool is_refined, const json& status) {
  json said = message;
  if (is_refined) {
    said["age_s"] = 1e-9 * double(message.at("t_publish_ns").get<std::int64_t>() -
                                  message.at("t_arrival_ns").get<std::int64_t>());
  } else if (!message.at("valid").get<bool>()) {
    said["reason"] = why_not_valid(message, status);
  }
  print("{}\n", fill("frame {frame_id}  hologram {hologram_id}  charge {charge}", said) +
                    fill(is_refined ? "  relative to the {against}  {age_s:.1f} s after its frame"
                                    : " ({tracker})  spots {tracked}/{subapertures}  saturated "
                                      "{saturated*100:.0f} %  latency {latency_us:.0f} us",
                         said) +
                    fill("  [valid?valid][!valid?NOT VALID: {reason}]", said));
  if (!message.at("valid").get<bool>()) return;
  said["full_bar"] = print_modes(message);
  print("{}\n",
        fill(is_refined
                 ? "RMS {rms_waves:.5f} wave without tilts, chi2 per pixel {chi2_per_pixel:.2f}, "
                   "peak {peak_e:.0f} electrons, {iterations} iterations in {duration_ms:.0f} ms, "
                   "full bar {full_bar:.2f} wave"
                 : "RMS {rms_waves:.4f} wave without tilts, fit residual {fit_residual_px:.4f} px, "
                   "full bar {full_bar:.2f} wave",
             said));
}

/// Prints one topic's messages on standard output.
class Watch {
 public:
  Watch(const Common& common, const WatchOptions& options, const json& status)
      : common_(common),
        options_(options),
        table_(!common.json && has_table(options.topic)),
        in_place_(table_ && isatty(STDOUT_FILENO) != 0),
        event_lines_(!common.json && options.topic == "event" && isatty(STDOUT_FILENO) != 0),
        status_(status) {}

  /// Shows messages until the count, the timeout or a stop request. Returns the exit code.
  int run(Subscriber& stream) {
    auto last = Clock::now();  // arrival of the topic's last message
    for (int shown = 0; !was_interrupted() && (options_.count == 0 || shown < options_.count);) {
      const auto message = stream.receive(std::chrono::milliseconds(100));
      if (output_has_no_reader()) return kError;
      if (message && message->topic == options_.topic) last = Clock::now();
      if (options_.timeout->count() > 0 && Clock::now() - last > Seconds(common_.timeout_s)) {
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
        fmt::format("no {} message arrived within {:g} s", options_.topic, common_.timeout_s);
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
    if (event_lines_) return print("{}\n", event_text(json_of(message.json)));
    if (!table_) return print("{}\n", message.json);
    if (in_place_) print("\033[H\033[J");
    print_frame(json_of(message.json), options_.topic == "refined", status_);
  }

  const Common& common_;
  const WatchOptions& options_;
  bool table_;
  bool in_place_;
  bool event_lines_;  ///< events as lines for people
  json status_;       ///< the newest status message
  Clock::time_point last_{};
};

bool is_for_screen(const Common& common, const WatchOptions& options) {
  return options.topic == "wavefront" && options.count == 0 && !options.plain && !common.json &&
         can_show_screen();
}

int watch(const Common& common, const WatchOptions& options) {
  if (is_for_screen(common, options)) return show_screen(common);
  const bool is_image = options.topic == "image" || options.topic == "phase";
  std::vector<std::string> topics{options.topic};
  if (options.topic == "wavefront")
    topics.emplace_back("status");  // explains invalid frames (reference and SLM pattern)
  auto stream = needed(open_stream(common, is_image ? "image_endpoint" : "endpoint", topics, 100));
  const json status = needed(call(common, "system.status", json::object()));
  if (options.topic == "refined" && status.at("refine").at("state") == "off") {
    return report(common, {Errc::refused, "refine.enabled",
                           "refinement is off, so there are no messages; switch it on with your "
                           "camera's electrons per DN: ovws call refine.set enabled=true "
                           "electrons_per_dn=39.2"});
  }
  catch_interrupts({SIGINT, SIGTERM});
  return Watch(common, options, status).run(stream);
}

}  // namespace

void add_watch(CLI::App& app, const Common& common, int& status) {
  auto [command, options] =
      add_command(app, common, status, "watch",
                  "show the bench full-screen (press ? for help). Piped, or with --plain or "
                  "-n: the topics wavefront and refined as a table, and on a terminal event "
                  "as one line per event. With --json, and otherwise: one JSON object per "
                  "line. With --timeout: end if no message "
                  "arrives for that long",
                  watch);
  command.add_option("topic", options.topic, "stream")
      ->check(CLI::IsMember(
          {"wavefront", "refined", "spots", "corrector", "image", "phase", "status", "event"}))
      ->capture_default_str();
  command.add_option("-n,--count", options.count, "end after this many messages; 0: never")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  command.add_flag("--plain", options.plain, "print a table on a terminal too");
  options.timeout = app.get_option("--timeout");
}

}  // namespace ovws::cli
