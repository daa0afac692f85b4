/// Template bank: a spot's template at every sub-pixel shift, computed off the frame path.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/spot_shape.hpp"
#include "core/tracking/template_sums.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Radius of the matched filter's window in units of lambda/d: 0.98 of the first dark ring's, at
/// least 1.5. That is 1.5 for charge 0, 1.84 for charge 1, 2.43 for charge 2, and holds 96 to 99.7
/// % of the Fisher information. A wider window would add mostly neighbours' light.
double matched_window(int charge);

/// Noise levels s = sigma^2 / (kappa a) of the least-squares weights 1 / (s + T); symbols as in
/// MatchedTracker. For s > 0.01 the weights of the nearest level raise the RMS error by at most
/// 3 %; interpolating between the fits at two levels raises it less.
constexpr std::array<double, 3> kNoiseLevels{0.03, 0.2, 1.0};
/// Index of the level that is assumed before the noise is estimated.
constexpr int kMiddleNoise = 1;
/// The noise level that the slope model assumes (matched_tilt).
constexpr double kSlopeNoise = 0.12;

/// Immutable. A spot of lambda/d = 12.55 px and charge 1 takes 0.9 MB.
class TemplateBank {
 public:
  /// A tabulated position: the image pixel in the window's middle, and the nearest sub-pixel shift.
  struct Place {
    int x = 0, y = 0;
    int shift = 0;
    Vec2 centre;  ///< spot's position in the template of that shift, image pixels

    friend bool operator==(const Place& a, const Place& b) {
      return a.x == b.x && a.y == b.y && a.shift == b.shift;
    }
  };

  /// Precomputed normal equations of one shift at one noise level.
  struct Solver {
    std::array<float, 16> inverse{};  ///< of the normal matrix, order: 1, value, cx, cy
    double weight = 0.0;              ///< sum of w
    double contrast = 0.0;            ///< sum of w (T - mean T)^2
    /// Sums of w^2, w^2 T, w^2 T^2: they turn ResidualSums into the variances of dark and bright
    /// pixels.
    double ww = 0.0, wwt = 0.0, wwtt = 0.0;
    bool regular = false;
  };

  /// Pixels of the window where the unshifted template is bright, by azimuthal sector, then those
  /// of a vortex's dark core: offsets into the window.
  struct Parts {
    static constexpr int kSectors = 8;
    std::vector<int> offsets;
    std::array<int, kSectors + 2> begin{};  ///< sector by sector, then the core
    std::array<float, kSectors> value{};    ///< mean of the template
  };

  TemplateBank(const SpotModel& spots, const SpotShape& shape);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int pixels() const { return pixels_; }  ///< inside the disc
  double step_px() const { return 1.0 / steps_; }
  float mean_bright() const { return mean_bright_; }  ///< mean of T where it exceeds 1/2
  bool regular() const { return regular_; }           ///< every normal matrix is invertible

  /// The same spot for images binned by bin() x bin(), unshifted only, with lengths in bins. Null
  /// if lambda/d is too small for bins of 2.
  const TemplateBank* coarse() const { return coarse_.get(); }
  int bin() const { return bin_; }

  const Parts& parts() const { return parts_; }

  Place place(Vec2 at) const OVWS_NONBLOCKING;
  TemplateView view(const Place& place, int level) const OVWS_NONBLOCKING;
  const Solver& solver(const Place& place, int level) const OVWS_NONBLOCKING;

 private:
  struct alignas(64) Block {
    std::array<float, kTemplateBlock> lane{};
  };
  static constexpr int kLevels = int(kNoiseLevels.size());

  TemplateBank(const SpotModel& spots, const SpotShape& shape, int steps);
  float* plane(int shift, int k);
  const float* plane(int shift, int k) const;
  void fill(int shift, const SpotShape& shape, double radius_px);
  Solver solve(int shift, int level) const;
  void find_parts(const SpotModel& spots);

  int steps_;  ///< shifts per pixel and axis
  int columns_;
  int rows_;
  int pixels_ = 0;
  float mean_bright_ = 0.0F;
  bool regular_ = true;
  std::vector<Block> planes_;  ///< shift by shift: value, cx, cy, and a weight for each level
  std::vector<Solver> solvers_;
  Parts parts_;
  int bin_ = 1;
  std::shared_ptr<const TemplateBank> coarse_;
};

}  // namespace ovws
