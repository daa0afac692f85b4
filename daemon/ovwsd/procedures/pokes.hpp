/// Pokes of calibration.run: modes shown with either sign, and what frames show of them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/spots/measured_spots.hpp"
#include "core/wavefront/interaction_matrix.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Averages of one hologram.
struct ShownSpots {
  SpotMeans places;
  SpotCells cells;  ///< empty: measured by the tracker's positions
};

/// Either the tracker's positions in frames, or the spots' pixels in a mean image and positions
/// from these. Pixels give a position for every lit spot, also for those that trackers lose.
class SpotMeter {
 public:
  /// Measures the spots at rest, which the bench shows, in two mean images of a monochrome camera.
  /// Errors: those of Bench; Errc::refused, field "camera.roi": the spots' windows do not fit.
  static Result<SpotMeter> of_images(Bench& bench, const SlmGeometry& slm, int frames);
  static SpotMeter of_positions() { return {}; }

  /// Of the hologram that the bench shows. Errors: those of Bench.
  Result<ShownSpots> measure(Bench& bench, int frames) const;

  bool uses_images() const { return !windows_.empty(); }
  const std::vector<SpotWindow>& windows() const { return windows_; }
  const std::vector<Vec2>& places_px() const { return places_px_; }

 private:
  ShownSpots measured_in(const Image<float>& mean_dn) const;

  std::vector<SpotWindow> windows_;  ///< empty: positions
  std::vector<Vec2> places_px_;
  PixelFormat format_ = PixelFormat::mono8;
  std::vector<RenderedSpot> resting_;
  PixelNoise noise_;  ///< of a mean image in 16 bits
};

struct Poke {
  PushPull places;
  PokedSpots cells;  ///< empty: measured by the tracker's positions
};

/// A poke, or why the SLM cannot show it.
struct Poked {
  std::optional<Poke> poke;
  std::string reason;
};

/// On top of the aberration that is shown when it is made.
class Pokes {
 public:
  /// `frames` are averaged for each sign, half of them in a repetition.
  Pokes(Bench& bench, SpotMeter meter, int frames, double lambda_d_px);

  const SpotMeter& meter() const { return meter_; }

  /// Without any poke. Errors: those of Bench.
  Result<ShownSpots> rest();
  /// Halves the amplitude up to twice if the SLM cannot show it, or if spots of `resting` are lost:
  /// a strong poke of a high mode may lose spots at the rim. Everything is measured twice.
  /// Errors: those of Bench; Errc::refused: the bench moved each time.
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
