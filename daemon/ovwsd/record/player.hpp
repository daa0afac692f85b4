/// Plays a recording through the pipeline, frame by frame, each under the verdicts of its time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {

struct PlayedFrame {
  RecordedFrame recorded;
  bool replayed = false;  ///< else `reason` says why not
  std::string reason;
  bool same = false;  ///< every spot, every coefficient and what is said of them, bit for bit
  bool valid = false;
  std::vector<int> modes_j;
  std::vector<float> coefficients;  ///< waves, as measured now
};

/// One thread, and the pipeline's own, which it starts.
class Player {
 public:
  /// Errors as of RecordingReader::open and RecordedPlans::of.
  static Result<std::unique_ptr<Player>> open(const std::string& path);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  RecordingReader& reader();
  /// The next frame of the recording; none: it was the last. An error: the file is damaged.
  Result<std::optional<PlayedFrame>> step();

 private:
  struct Impl;
  explicit Player(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
