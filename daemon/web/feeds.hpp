/// From the daemon to the board: its streams, what must be asked for, and whether the bench is
/// well.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "daemon/shared/client.hpp"
#include "daemon/web/bench_view.hpp"
#include "daemon/web/board.hpp"
#include "daemon/web/health.hpp"
#include "daemon/web/trend.hpp"

namespace ovws::web {

/// What a browser is told of this server beside the bench's health.
struct ServerFacts {
  int browsers = 0;
  nlohmann::json refused;
};

/// The spots of the last frames, so that those of an image's frame can be shown with it.
/// Thread-safe.
class SpotShelf {
 public:
  void add(std::uint64_t frame_id, std::string packet);
  /// None if they have not come, or are long gone.
  std::optional<std::string> of_frame(std::uint64_t frame_id) const;

 private:
  static constexpr std::size_t kFrames = 256;
  mutable std::mutex mutex_;
  std::deque<std::pair<std::uint64_t, std::string>> kept_;
};

/// While the loop or a hand on a slider changes the hologram many times a second, most frames are
/// not valid: those that are stay in sight for a while. One thread at a time.
class HeldValid {
 public:
  explicit HeldValid(std::chrono::milliseconds hold) : hold_(hold) {}

  /// Whether a frame that is (not) valid is to be shown.
  bool shows(bool valid);

 private:
  std::chrono::milliseconds hold_;
  std::chrono::steady_clock::time_point last_{};
};

/// Three threads of its own, from the construction to the destruction, which waits for them (a
/// question's time-out at most).
class Feeds {
 public:
  /// `server_facts` is called from a thread of this class. All outlive it.
  Feeds(const cli::Common& common, Board& board, std::function<ServerFacts()> server_facts);
  ~Feeds();
  Feeds(const Feeds&) = delete;
  Feeds& operator=(const Feeds&) = delete;

  /// Thread-safe. Pictures and questions cost the daemon something: only while somebody looks.
  HologramPicturePtr hologram() const { return view_.hologram(); }

 private:
  using Clock = std::chrono::steady_clock;

  void take_numbers();
  void take_pictures();
  void ask();
  void take(const StreamMessage& message);
  void take_wavefront(const StreamMessage& message);
  void take_status(const StreamMessage& message);
  void take_spots(const StreamMessage& message);
  void take_picture(const StreamMessage& message);
  void tell_health();
  bool watched() const { return server_facts_().browsers > 0; }
  void rest(std::chrono::milliseconds time) const;

  const cli::Common& common_;
  Board& board_;
  std::function<ServerFacts()> server_facts_;
  BenchView view_;
  SpotShelf spots_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> hologram_change_{0};  ///< counts changes that `status` told
  std::atomic<Clock::rep> last_picture_{0};

  std::mutex pattern_mutex_;
  std::string pattern_;

  // Of the thread of numbers.
  BenchFacts facts_;
  Clock::time_point status_at_{}, wavefront_at_{}, health_at_{};
  RiseLately lost_, missed_;
  Trend trend_;
  HeldValid valid_wavefront_{std::chrono::milliseconds(500)};

  // Of the thread of pictures: there are ten a second at most, and few of them may be valid.
  HeldValid valid_phase_{std::chrono::milliseconds(2000)};

  std::thread numbers_, pictures_, questions_;
};

}  // namespace ovws::web
