/// The bench as a step sees it: calls and jobs of the daemon, and camera images. Blocking and
/// cancellable; used from one thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/finding.hpp"
#include "daemon/shared/borrow.hpp"

namespace ovws::commission {

/// What a step judges of a frame of the stream `wavefront`.
struct WatchedFrame {
  std::uint64_t hologram_id = 0;
  double arrival_s = 0.0;           ///< in the daemon, by its clock
  std::optional<double> rms_waves;  ///< none: the frame is not valid
};

/// The frames that arrived within the last `seconds` before the newest one, which is included.
std::span<const WatchedFrame> newest(std::span<const WatchedFrame> frames, double seconds);

/// Median of the RMS of the valid frames; none: no frame is valid.
std::optional<double> median_rms_waves(std::span<const WatchedFrame> frames);

struct Settings {
  cli::Common daemon;  ///< connection and time-out
  /// Questions about this machine, some seconds, asked in the thread of the commissioning. Empty:
  /// the step `doctor` judges by the daemon's status only.
  std::function<examine::Findings()> examine{};
};

/// Ends a step that cannot go on: the step then fails with this error.
struct StepFailed {
  Error error;
};

/// Functions that return no Result throw StepFailed.
class Bench {
 public:
  using Progress = std::function<void(double done, const std::string& text)>;

  /// `cancelled` and `settings` must outlive the Bench. `progress` is called in the same thread.
  Bench(const Settings& settings, const std::atomic<bool>& cancelled, Progress progress)
      : settings_(settings), cancelled_(cancelled), progress_(std::move(progress)) {}

  const Settings& settings() const { return settings_; }
  bool cancelled() const { return cancelled_; }

  /// Reports what happens at present. The progress stays.
  void say(const std::string& text) { progress_(done_, text); }

  /// Calls a method and returns its result. Errors: as the daemon's, with its field; if it does not
  /// answer, Errc::unavailable.
  Result<nlohmann::json> try_call(const std::string& method,
                                  const nlohmann::json& params = nlohmann::json::object());
  nlohmann::json call(const std::string& method,
                      const nlohmann::json& params = nlohmann::json::object());
  /// Starts a job, reports its progress, and returns its result. Once the step is cancelled,
  /// cancels the job and fails. Tolerates a daemon that does not answer for about 30 s.
  Result<nlohmann::json> job(const std::string& method, const nlohmann::json& params,
                             const std::string& text);

  /// A camera image, as fractions of full scale, whose exposure began after this call, and after
  /// the SLM has settled. Errc::unavailable if none comes.
  Image<float> image();
  /// Shows a pattern of slm.show and returns an image of it.
  Image<float> image_of(const std::string& pattern);
  /// The frames of stream `wavefront` that arrive within `seconds`, and further ones until they are
  /// `enough`, for at most cli::kTemplates_s more. `enough` is asked some times a second.
  std::vector<WatchedFrame> frames(
      double seconds, const std::function<bool(std::span<const WatchedFrame>)>& enough);
  /// Numbers of the spots that are found in less than half of the settled frames of a second.
  std::vector<int> lost_spots();

  /// What a step changes, to be restored.
  cli::Parts parts(std::initializer_list<cli::Part> parts);
  /// Hooks of a cli::Borrow that restores during a step. They use this object.
  cli::Borrow::Hooks restoring();
  /// What could not be restored, and how to do it; empty if everything was.
  const std::string& not_restored() const { return not_restored_; }

 private:
  void stop_if_cancelled() const;
  Subscriber subscriber(const char* key, const std::string& topic, int queue);

  const Settings& settings_;
  const std::atomic<bool>& cancelled_;
  Progress progress_;
  double done_ = 0.0;
  std::string not_restored_;
};

}  // namespace ovws::commission
