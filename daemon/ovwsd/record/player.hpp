/// Replays a recording through the pipeline, frame by frame, with the plan, hologram and settings
/// recorded for each frame.
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
  bool replayed = false;  ///< if false, `reason` says why
  std::string reason;
  /// Spots, coefficients, standard errors and verdicts equal the recorded ones bit by bit.
  bool same = false;
  bool valid = false;
  std::vector<int> modes_j;
  /// As measured in the replay, waves. Standard errors are NaN if positions measured the frame.
  std::vector<float> coefficients, sigma_waves;
};

/// Called by one thread; starts the pipeline's acquisition thread itself.
class Player {
 public:
  /// Errors: see RecordingReader::open and RecordedPlans::of.
  static Result<std::unique_ptr<Player>> open(const std::string& path);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  RecordingReader& reader();
  /// Replays the next frame; none at the end of the recording. Errors: the file is damaged.
  Result<std::optional<PlayedFrame>> step();

 private:
  struct Impl;
  explicit Player(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
