/// A spot's template on the pixel grid for every sub-pixel shift, prepared off the frame path.
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

/// The window's radius in units of lambda/d: 0.98 of the first dark ring's, at least 1.5. That is
/// 1.5 for charge 0, 1.84 for charge 1, 2.43 for charge 2, and holds 96 to 99.7 % of the Fisher
/// information: wider, only a neighbour's light is gained.
double matched_window(int charge);

/// What the noise's variance may be, sigma^2 + kappa a T, as the dark part's share of the bright
/// part's: s = sigma^2 / (kappa a). Weights are 1 / (s + T). Above s = 0.01 the level nearest to
/// the truth costs at most 3 % of RMS; a fit between the fits at two of them costs less.
constexpr std::array<double, 3> kNoiseLevels{0.03, 0.2, 1.0};
/// The level that is assumed where none is known yet.
constexpr int kMiddleNoise = 1;
/// The one that stands for all of them in the slope model.
constexpr double kSlopeNoise = 0.12;

/// Immutable. A spot of lambda/d = 12.55 px and charge 1 takes 0.9 MB.
class TemplateBank {
 public:
  /// The image pixel in the window's middle, and which of the shifts is nearest.
  struct Place {
    int x = 0, y = 0;
    int shift = 0;
    Vec2 centre;  ///< where the template of that shift is, image pixels

    friend bool operator==(const Place& a, const Place& b) {
      return a.x == b.x && a.y == b.y && a.shift == b.shift;
    }
  };

  /// Of one shift at one noise level.
  struct Solver {
    std::array<float, 16> inverse{};  ///< of the normal matrix, order: 1, value, cx, cy
    double weight = 0.0;              ///< sum of w
    double contrast = 0.0;            ///< sum of w (T - mean T)^2
    /// Sums of w^2, w^2 T, w^2 T^2: what turns ResidualSums into a variance in dark and in bright.
    double ww = 0.0, wwt = 0.0, wwtt = 0.0;
    bool regular = false;
  };

  /// Pixels of the window where the template is bright, by their direction from the centre, and
  /// those of a vortex's dark core: offsets into the window, of the unshifted template.
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
  bool regular() const { return regular_; }           ///< every normal matrix has an inverse

  /// The same spot for images whose pixels are summed in squares of bin() x bin(): at its unshifted
  /// place only, and in bins for pixels. None if lambda/d is too few pixels for bins of 2.
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
  void divide(const SpotModel& spots);

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
