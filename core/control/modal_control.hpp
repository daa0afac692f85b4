/// Modal control: one control law for each mode of the correction.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/control/loop_settings.hpp"
#include "core/control/mode_law.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Coefficients of one usable frame: settled, valid, and of a hologram whose correction is known.
struct LoopSample {
  std::int64_t t_ns = 0;  ///< about the middle of the exposure, CLOCK_MONOTONIC
  std::span<const int> modes_j;
  std::span<const float> residual_waves;  ///< in the order of modes_j
  std::span<const float> sigma_waves;     ///< their standard errors; NaN: unknown
};

/// Computes the correction of a closed loop. Not thread-safe.
class ModalControl {
 public:
  /// Makes the law of mode `j`, which begins with `correction_waves`.
  using MakeLaw = std::function<std::unique_ptr<ModeLaw>(int j, double correction_waves)>;

  /// Starts from `correction`, RMS-normalised waves; modes that are not corrected keep their value.
  ModalControl(LoopSettings settings, std::vector<Mode> correction, MakeLaw make_law);

  /// Takes a frame whose hologram had the correction `shown`. Modes that are not finite are left
  /// out.
  void observe(const LoopSample& sample, std::span<const Mode> shown);
  /// Computes the correction for the time `t_ns`, CLOCK_MONOTONIC, limited to `limit_waves` in each
  /// mode. Modes that the last frame did not have keep theirs.
  void step(std::int64_t t_ns);

  const std::vector<Mode>& correction() const { return correction_; }
  /// The last step limited a mode that the last frame had.
  bool at_limit() const { return at_limit_; }
  /// Root sum square of the last frame's residual, less the offsets, over the corrected modes.
  double residual_rms_waves() const { return residual_rms_waves_; }
  std::int64_t steps() const { return steps_; }

 private:
  struct Law {
    std::unique_ptr<ModeLaw> law;
    bool observed = false;  ///< in the last frame
  };
  bool is_corrected(int j) const;
  Law& law_of(int j);

  LoopSettings settings_;
  std::vector<Mode> correction_;
  MakeLaw make_law_;
  std::map<int, Law> laws_;  ///< by mode, of modes that were observed
  double residual_rms_waves_ = 0.0;
  std::int64_t steps_ = 0;
  bool at_limit_ = false;
};

}  // namespace ovws
