/// Replays a recording through the pipeline, frame by frame, with the plan, hologram and settings
/// recorded for each frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovwsd/fitter/refine_model.hpp"
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
  std::optional<RefinedFrame> refined;  ///< none: not requested, or it could not be refined
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
  /// The configuration of the daemon when the recording began. Errc::invalid, field "path": it is
  /// missing, or this version cannot read it.
  Result<Config> configuration() const;
  /// Replays only the frames at the positions `begin` to `end` - 1 of the recording; at most all.
  void select(std::size_t begin, std::size_t end);
  /// Also refines each frame that the daemon could have refined. Templates of an earlier frame are
  /// used again within a block of 100 positions, whose first frames are refined even if they are
  /// not selected. `setup` must have electrons_per_dn. Call it before the first step.
  void refine(const RefineSetup& setup, const SlmGeometry& slm);
  /// Replays the next frame; none after the last. A frame gives the same result whatever frames
  /// are selected. Errors: the file is damaged.
  Result<std::optional<PlayedFrame>> step();

 private:
  struct Impl;
  explicit Player(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
