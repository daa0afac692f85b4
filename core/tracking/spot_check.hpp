/// Spot validation: accepts a found position only if the pixels around it look like a spot.
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

/// Spot check: compares the mean intensity of a small disc at a found position with the means of 16
/// azimuthal sectors of two annuli around the disc. The outer annulus lies at the first dark ring
/// and also gives the local background.
///
/// Charge not 0: the inner annulus is the bright ring, where the profile exceeds half its maximum.
/// The core must be darker than the ring on every azimuth. The outer annulus must not be much
/// brighter than the ring; otherwise the "ring" is only the rim of something brighter.
///
/// Charge 0: the inner annulus is the flank of the bright core; a hot pixel has no flank. The outer
/// annulus must be dark on every azimuth.
///
/// The difference between bright and dark must also be significant against the pixel noise measured
/// in the patch. If noise makes the disc and the annuli inconclusive, a fit of the ideal spot to
/// all pixels within the dark ring decides.
class SpotCheck {
 public:
  struct Verdict {
    bool passed = false;
    double quality = 0.0;  ///< contrast: 1 - dark/bright part above background, or the fit's share
    double level = 0.0;    ///< mean of the bright core or ring above the background, DN
    double noise = 0.0;    ///< RMS pixel noise, DN
  };

  /// `patch_half`: half-width of the patches that will be checked.
  SpotCheck(const SpotModel& spots, const SpotGeometry& geometry, int patch_half);

  /// Half-width of the square of pixels that `look` reads around a position.
  static int reach_px(const SpotModel& spots, const SpotGeometry& geometry);
  /// Half-width of the spot itself, which must lie inside the image.
  static double spot_half_px(const SpotModel& spots, const SpotGeometry& geometry);

  /// Checks the position `at`. The patch must extend reach_px around it. RT-safe.
  Verdict look(const Patch& patch, Vec2 at) const OVWS_NONBLOCKING;
  /// Mean of the darker half of the outer sectors around `at`: the local background. RT-safe.
  double background(const Patch& patch, Vec2 at) const OVWS_NONBLOCKING;

 private:
  static constexpr int kSectors = 16;
  using Means = std::array<double, kSectors>;

  /// Pixels of an annulus: offsets from its centre within a patch, sector by sector.
  struct Annulus {
    std::vector<int> offsets;
    std::array<int, kSectors + 1> begin{};
    Means means(const float* centre) const;
  };
  static Annulus annulus(double inner_px, double outer_px, int side);

  struct Outside {
    double mean = 0.0;
    double background = 0.0;  ///< mean of the darker half of the sectors
    double brightest = 0.0;   ///< largest mean of a sector
  };
  Outside outside(const float* centre) const;
  Verdict vortex(double core, const Means& ring, const Outside& out, double noise) const;
  Verdict bright(double core, const Means& flank, const Outside& out, double noise) const;
  Verdict whole(const float* centre, double core, const Means& ring, double noise) const;
  double significance(std::size_t around) const;

  int charge_;
  std::vector<int> core_;
  Annulus around_;
  Annulus outer_;
  std::vector<int> disc_;       ///< offsets of the pixels within the dark ring
  std::vector<float> ideal_;    ///< ideal spot (maximum 1) at the pixels of disc_, minus its mean
  double ideal_mean_ = 0.0;     ///< mean of the ideal spot over disc_
  double ideal_bright_ = 0.0;   ///< mean of the ideal spot where it exceeds 1/2
  double ideal_squares_ = 0.0;  ///< sum of the squares of ideal_
};

}  // namespace ovws
