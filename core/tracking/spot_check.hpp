/// Tells a spot from everything else that a tracker may run into.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/patch.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Compares the mean of a small disc at a found position with the means of 16 azimuthal sectors of
/// two annuli around it, the outer one at the first dark ring, which also gives the local
/// background. Charge not 0: the inner annulus is the bright ring (where the profile exceeds half
/// its maximum); the core must be dark against it on every azimuth, and beyond it there must be
/// dark again, or the "ring" is but the rim of something brighter. Charge 0: the inner annulus is
/// the bright core's flank, which a hot pixel lacks; the outer one must be dark on every azimuth.
/// The difference of bright and dark must also stand out of the pixel noise, which is measured in
/// the same patch.
class SpotCheck {
 public:
  struct Verdict {
    bool passed = false;
    double quality = 0.0;  ///< 1 - dark part / bright part, both above the local background
    double level = 0.0;    ///< the bright part above the local background, DN
    double noise = 0.0;    ///< RMS of the pixels' noise, DN
    /// Not passed, but in so much noise that the ratios of small areas do not tell.
    bool unsure = false;
  };

  /// `patch_half`: half-width of the patches that will be looked at.
  SpotCheck(const SpotModel& spots, const SpotGeometry& geometry, int patch_half);

  /// Half-width of the square read around a position.
  static int reach_px(const SpotModel& spots, const SpotGeometry& geometry);
  /// Half-width of what counts as the spot itself: all of it must be in the image.
  static double spot_half_px(const SpotModel& spots, const SpotGeometry& geometry);

  /// The patch must reach reach_px around `at`. RT-safe.
  Verdict look(const Patch& patch, Vec2 at) const OVWS_NONBLOCKING;
  /// Mean of the darker half of the outer sectors around `at`: the local background. RT-safe.
  double background(const Patch& patch, Vec2 at) const OVWS_NONBLOCKING;

 private:
  static constexpr int kSectors = 16;
  using Means = std::array<double, kSectors>;

  /// Offsets into a patch, sector by sector.
  struct Annulus {
    std::vector<int> offsets;
    std::array<int, kSectors + 1> begin{};
    Means means(const float* centre) const;
  };
  static Annulus annulus(double inner_px, double outer_px, int side);

  struct Outside {
    double mean = 0.0;
    double background = 0.0;  ///< mean of the darker half of the sectors
    double brightest = 0.0;   ///< sector
  };
  Outside outside(const float* centre) const;
  static Verdict refused(double level, double noise);
  Verdict vortex(double core, const Means& ring, const Outside& out, double noise) const;
  Verdict bright(double core, const Means& flank, const Outside& out, double noise) const;
  double significance(std::size_t around) const;

  int charge_;
  std::vector<int> core_;
  Annulus around_;
  Annulus outer_;
};

}  // namespace ovws
