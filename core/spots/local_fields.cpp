#include "core/spots/local_fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "core/base/decompositions.hpp"
#include "core/base/median.hpp"
#include "core/optics/piece_moments.hpp"

namespace ovws {
namespace {

constexpr auto kCount = Eigen::Index(PieceMoments::kCount);
constexpr double kUsual = 1.0;         // expected standard deviation of a coefficient
constexpr double kMaxFieldStep = 0.5;  // norm of a step of all coefficients of a spot

using Field = SensorField::LocalField;
static_assert(std::tuple_size_v<Field> == std::size_t(PieceMoments::kCount));

/// Coefficients as a vector: real parts, then imaginary parts.
Eigen::VectorXd numbers_of(const Field& field) {
  Eigen::VectorXd all(2 * kCount);
  for (Eigen::Index k = 0; k < kCount; ++k) {
    all(k) = field[std::size_t(k)].real();
    all(kCount + k) = field[std::size_t(k)].imag();
  }
  return all;
}

Field field_of(const Eigen::VectorXd& numbers) {
  Field field;
  for (Eigen::Index k = 0; k < kCount; ++k) {
    field[std::size_t(k)] = {numbers(k), numbers(kCount + k)};
  }
  return field;
}

/// Fit results of a spot that its pixel weights need: chi-squared per binned pixel, and DN.
struct Cells {
  double chi2, background_dn, ceiling_dn;
};

/// Least-squares change of the coefficients (`numbers_of`) for the residual of `cells`.
Eigen::VectorXd step_of(const Eigen::VectorXd& cells, const RenderedSpot& rendered,
                        const Eigen::MatrixXf& per_number, double level, const Cells& of,
                        const PixelNoise& noise, const Eigen::VectorXd& now) {
  const int pixels = rendered.window.bin * rendered.window.bin;
  const Eigen::VectorXd light = level * rendered.light.cast<double>();
  Eigen::VectorXd weights(light.size());
  for (Eigen::Index c = 0; c < light.size(); ++c) {
    const double brightest = std::max(light(c), cells(c) - of.background_dn * pixels);
    const bool used = rendered.window.is_lit(c) && brightest < of.ceiling_dn * pixels;
    weights(c) = !used ? 0.0 : 1.0 / (std::max(1.0, of.chi2) * noise.variance(light(c), pixels));
  }
  Eigen::MatrixXd change(light.size(), 2 * kCount + 1);
  change.leftCols(2 * kCount) = level * per_number.cast<double>();
  change.col(kCount).setZero();  // the overall phase of a spot is not observable
  change.col(2 * kCount).setConstant(pixels);
  const Eigen::MatrixXd weighted = weights.asDiagonal() * change;
  Eigen::MatrixXd normal = change.transpose() * weighted;
  Eigen::VectorXd right = weighted.transpose() * (cells - light);
  const double ridge = 1.0 / (kUsual * kUsual);
  normal.diagonal().head(2 * kCount).array() += ridge;
  right.head(2 * kCount) -= ridge * now;
  return solve_symmetric(normal, right).head(2 * kCount);
}

}  // namespace

void take_up_fields(const ImageView& image, const SpotPass& pass,
                    std::span<const RenderedSpot> rendered,
                    std::span<const Eigen::MatrixXf> per_field, const PixelNoise& noise,
                    std::span<const double> px_per_wave, SpotDeviations& deviations) {
  deviations.offsets_px.resize(rendered.size());
  deviations.fields.resize(rendered.size());
  std::vector<double> levels;
  for (const SpotEstimates& found : pass.found) {
    if (found.level > 0.0F) levels.push_back(double(found.level));
  }
  const double usual_dn = median(std::move(levels));
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    const SpotEstimates& found = pass.found[i];
    Field& field = deviations.fields[i];
    if (!(found.level > 0.0F)) {
      field = {};
      field[0] = -1.0;
      continue;
    }
    const SpotWindow& window = rendered[i].window;
    const double level = usual_dn * window.bin * window.bin;
    const Eigen::VectorXd now = numbers_of(field);
    Eigen::VectorXd step = step_of(
        cells_of(image, window), rendered[i], per_field[i], level,
        {double(found.chi2_per_cell), double(found.background), pass.ceiling_dn}, noise, now);
    if (const double size = step.norm(); size > kMaxFieldStep) step *= kMaxFieldStep / size;
    Eigen::VectorXd next = now + step;
    // Move the tilt into the displacement of the spot, because a displacement may be large.
    const double per_radian = px_per_wave[i] / (2.0 * std::numbers::pi);
    deviations.offsets_px[i] =
        deviations.offsets_px[i] + per_radian * Vec2{next(kCount + PieceMoments::kAlongX),
                                                     next(kCount + PieceMoments::kAlongY)};
    next(kCount + PieceMoments::kAlongX) = next(kCount + PieceMoments::kAlongY) = 0.0;
    field = field_of(next);
  }
}

}  // namespace ovws
