/// Feeds the board from the daemon: its streams, polled data, and the health of the bench.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "daemon/examine/status_questions.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/shared/guarded.hpp"
#include "daemon/web/bench_view.hpp"
#include "daemon/web/board.hpp"
#include "daemon/web/picture.hpp"
#include "daemon/web/trend.hpp"

namespace ovws::web {

/// Facts about the web server that browsers receive with the state of daemon, camera and SLM.
struct ServerFacts {
  int browsers = 0;
  nlohmann::json refused;
};

/// Spots of the last frames, so that an image is shown with the spots of its own frame.
/// Thread-safe.
class SpotShelf {
 public:
  void add(std::uint64_t frame_id, std::string packet);
  /// The spots of this frame; none if the spots have not arrived or are no longer kept.
  std::optional<std::string> of_frame(std::uint64_t frame_id) const;

 private:
  static constexpr std::size_t kFrames = 256;
  mutable std::mutex mutex_;
  std::deque<std::pair<std::uint64_t, std::string>> kept_;
};

/// Feeds the board in three threads, from construction to destruction. The destructor joins the
/// threads, which takes at most the timeout of one request.
class Feeds {
 public:
  /// Threads of this class call `server_facts`. All arguments must outlive it.
  Feeds(const cli::Common& common, Board& board, std::function<ServerFacts()> server_facts);
  ~Feeds();
  Feeds(const Feeds&) = delete;
  Feeds& operator=(const Feeds&) = delete;

  /// The newest hologram image. Thread-safe. Images and polled data are fetched only while a
  /// browser is connected, because they cost the daemon time.
  HologramImagePtr hologram() const { return view_.hologram(); }

  /// Says that a command may have changed what was measured. Thread-safe.
  void look_again() {
    ++jobs_;
    ++hologram_change_;
  }

  /// The camera's newest image at full resolution, as long as the board's is reduced; else null.
  /// Thread-safe.
  CameraImagePtr image() const { return image_.get(); }

 private:
  using Clock = std::chrono::steady_clock;

  void take_numbers();
  void take_images();
  void poll_bench();
  void take(StreamMessage message);
  void take_wavefront(const StreamMessage& message);
  void take_status(const StreamMessage& message);
  void take_spots(const StreamMessage& message);
  void take_image(StreamMessage message);
  void publish_health();
  bool watched() const { return server_facts_().browsers > 0; }
  void sleep_unless_stopped(std::chrono::milliseconds time) const;

  const cli::Common& common_;
  Board& board_;
  std::function<ServerFacts()> server_facts_;
  BenchView view_;
  SpotShelf spots_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> hologram_change_{0};  ///< counts changes in `status`
  std::atomic<std::int64_t> jobs_{0};             ///< counts events and commands
  std::atomic<Clock::rep> last_image_{0};

  Guarded<CameraImagePtr> image_;

  // Used only by the thread numbers_.
  examine::DaemonFacts facts_;
  Clock::time_point status_at_{}, wavefront_at_{}, valid_at_{}, health_at_{};
  examine::RiseLately lost_, missed_;
  Trend trend_{kTrendBinNs}, history_{kHistoryBinNs};

  std::thread numbers_, pictures_, polling_;
};

}  // namespace ovws::web
