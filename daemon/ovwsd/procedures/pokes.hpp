/// Pokes of calibration.run: shows each mode with both signs and measures the spots.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/spots/measured_spots.hpp"
#include "core/wavefront/interaction_matrix.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Spot measurements of one hologram, averaged over frames.
struct ShownSpots {
  SpotMeans places;
  SpotCells cells;  ///< empty: measured by the tracker's positions
};

/// Spot meter: uses either the tracker's positions in frames, or positions fitted to the spots'
/// pixels in a mean image. Pixels give a position for every lit spot, even if trackers lose it
/// while it is poked. Spots that are lost at rest, or that the reference lacks, stay lost.
class SpotMeter {
 public:
  /// Measures the spots at rest (without a poke) in two mean images. The SLM must already show the
  /// hologram at rest. Errors: those of Bench; Errc::refused, field "camera.roi": the spots'
  /// windows do not fit.
  static Result<SpotMeter> of_images(Bench& bench, int frames);
  static SpotMeter of_positions() { return {}; }

  /// Measures the spots of the current hologram in `frames` frames. Errors: those of Bench.
  Result<ShownSpots> measure(Bench& bench, int frames) const;

  bool uses_images() const { return !windows_.empty(); }
  const std::vector<SpotWindow>& windows() const { return windows_; }
  const std::vector<Vec2>& places_px() const { return places_px_; }

 private:
  ShownSpots measured_in(const Image<float>& mean_dn) const;
  SpotCells cells_of(const Image<float>& mean_dn) const;  ///< NaN: a lost spot's

  std::vector<SpotWindow> windows_;  ///< empty: measures by the tracker's positions
  std::vector<Vec2> places_px_;
  std::vector<Eigen::Index> lost_;  ///< numbers of the spots without light of their own
  PixelFormat format_ = PixelFormat::mono8;
  std::vector<RenderedSpot> resting_;
  PixelNoise noise_;  ///< pixel noise of a mean image scaled to 16 bits
};

struct Poke {
  PushPull places;
  PokedSpots cells;       ///< empty: measured by the tracker's positions
  bool is_steady = true;  ///< the response was the same in both measurements, but for noise
};

/// Result of a poke; without `poke`, `reason` tells why the SLM cannot show the mode.
struct Poked {
  std::optional<Poke> poke;
  std::string reason;
};

/// Pokes modes on top of the aberration that the SLM shows when the object is constructed.
class Pokes {
 public:
  /// Averages `frames` frames for each sign, half of them in each of two measurements.
  Pokes(Bench& bench, SpotMeter meter, int frames, double lambda_d_px);

  const SpotMeter& meter() const { return meter_; }

  /// Measures the spots without a poke. Errors: those of Bench.
  Result<ShownSpots> rest();
  /// Pokes mode `j` with both signs and measures it at least twice. Halves the amplitude up to two
  /// times if the SLM cannot show it, or if spots of `resting` are lost: strong pokes of high modes
  /// may lose spots at the rim. Repeats a poke whose response or spots differ from those before; if
  /// no two are the same, the two that differ least are used, and it is not steady. Errors: those
  /// of Bench; Errc::refused: the bench moved between all repetitions.
  Result<Poked> poke(int j, double amplitude_waves, const SpotMeans& resting);

 private:
  Result<ShownSpots> shown(const std::vector<Mode>& aberration, int frames);
  Result<Poke> once(int j, double amplitude_waves);
  Result<Poke> twice(int j, double amplitude_waves);
  Result<Poked> unless_refused(int j, double amplitude_waves);

  Bench& bench_;
  SpotMeter meter_;
  std::vector<Mode> aberration_;
  int frames_;
  double max_step_px_;
};

}  // namespace ovws
