#include "core/spots/wavefront_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/decompositions.hpp"
#include "core/base/median.hpp"
#include "core/base/pixels.hpp"

namespace ovws {
namespace {

constexpr double kRoundingDn2 = 1.0 / 12.0;  // rounding to whole DN
// Least constant part, fraction of the mean variance: with less, dark pixels would outweigh all
// others if the squares contain more than noise.
constexpr double kMinDark = 0.01;
constexpr double kMinChange = 1e-3;     // of a spot: smaller ones are sums of the others
constexpr double kMinNoiseShare = 0.5;  // of a binned pixel's noise
constexpr double kUnsaturated = 0.9;    // of full scale: a binned pixel may hold a brighter pixel
constexpr double kMinModesConditioning = 1e-12;
constexpr double kUsualStepWaves = 0.014;  // expected step of a mode, for unlike spots

int pixels_of(const SpotWindow& window) {
  return window.bin * window.bin;
}

bool has_rows(const SpotTemplates& spot) {
  return spot.rows.rows() > 0;
}

std::vector<SpotEstimates> fit_all(const ImageView& image, const SpotFit& fit) {
  SpotFit::Scratch scratch = fit.make_scratch();
  std::vector<SpotEstimates> found;
  for (std::size_t i = 0; i < fit.spots().size(); ++i) {
    found.push_back(fit.fit(image, i, scratch));
  }
  return found;
}

}  // namespace

Eigen::VectorXd cells_of(const ImageView& image, const SpotWindow& window) {
  Eigen::VectorXd cells = Eigen::VectorXd::Zero(window.cells());
  const int left = window.left / window.plane_step(), top = window.top / window.plane_step();
  const int count = window.side * window.bin;
  visit_rows(seen_by(window, image), left, top, count, count,
             [&](int x, int y, const auto* pixels, int run) {
               for (int k = 0; k < run; ++k) {
                 cells((y - top) / window.bin * window.side + (x + k - left) / window.bin) +=
                     double(pixels[k]);
               }
             });
  return cells;
}

std::vector<double> SpotPass::levels_dn() const {
  std::vector<double> levels;
  for (const SpotEstimates& spot : found) levels.push_back(double(spot.level));
  return levels;
}

double SpotPass::chi2() const {
  double sum = 0.0;
  int lit = 0;
  for (const SpotEstimates& spot : found) {
    if (!(spot.level > 0.0F)) continue;
    sum += double(spot.chi2_per_cell), ++lit;
  }
  return sum / std::max(lit, 1);
}

double SpotPass::excess() const {
  std::vector<double> all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].level > 0.0F) all.push_back(excess_intensity(templates[i], found[i]));
  }
  return all.empty() ? 1.0 : median(std::move(all));
}

double SpotPass::excess_scatter() const {
  std::vector<double> all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].level > 0.0F) all.push_back(excess_scatter_of(templates[i], found[i].level));
  }
  const double spots = double(std::max<std::size_t>(all.size(), 1));
  return median(std::move(all)) / std::sqrt(spots);
}

SpotPass fit_spots(const ImageView& image, std::span<const RenderedSpot> rendered,
                   const PixelNoise& noise, int estimates, Saturated saturated) {
  // First pass with equal weights, because the levels are not known yet.
  std::vector<CellLevel> levels(rendered.size());
  const SpotFit even(make_templates(rendered, levels, noise, 0));
  const std::vector<SpotEstimates> first = fit_all(image, even);
  std::vector<double> lit, dark;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (first[i].level > 0.0F) lit.push_back(double(first[i].level));
    if (has_rows(even.spots()[i])) dark.push_back(double(first[i].background));
  }
  const double usual = median(std::move(lit));
  SpotPass pass;
  const double full_dn = std::min(full_scale_dn(image.format), noise.saturated_dn);
  pass.ceiling_dn = kUnsaturated * full_dn - median(std::move(dark));
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    const double level = first[i].level > 0.0F ? double(first[i].level) : usual;
    const int pixels = pixels_of(rendered[i].window);
    levels[i].intensity_dn = level * pixels;
    if (saturated == Saturated::left_out) levels[i].ceiling_dn = pass.ceiling_dn * pixels;
  }
  pass.templates = make_templates(rendered, levels, noise, estimates);
  pass.found = fit_all(image, SpotFit(pass.templates));
  return pass;
}

namespace {

/// Estimates of a spot and their derivatives by the modes, scaled to errors of 1.
struct Whitened {
  Eigen::MatrixXd rows;  ///< estimates x modes
  Eigen::VectorXd values;
  double noise;  ///< sum of the estimates' variances by noise alone

  Whitened(const SpotTemplates& spot, const SpotEstimates& found, double higher_waves)
      : noise(spot.estimates()) {
    const double level = double(found.level) * pixels_of(spot.window);
    rows = level * spot.per_wave;
    values =
        level *
        Eigen::Map<const Eigen::VectorXf>(found.values.data(), spot.estimates()).cast<double>();
    const Eigen::MatrixXd white = higher_errors(spot, level, higher_waves).whitening;
    if (white.size() == 0) return;
    rows = white * rows;
    values = white * values;
    noise = white.squaredNorm();
  }
};

bool has_estimates(const SpotTemplates& spot, const SpotEstimates& found) {
  return found.level > 0.0F && spot.estimates() > 0;
}

/// Normal equations of the modes; `factors` multiply the variances of each spot's estimates.
struct ModeSums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;

  ModeSums(const SpotPass& pass, std::span<const double> factors) {
    for (std::size_t i = 0; i < pass.found.size(); ++i) {
      if (!has_estimates(pass.templates[i], pass.found[i])) continue;
      const Whitened spot(pass.templates[i], pass.found[i], pass.higher_waves);
      if (normal.size() == 0) {
        normal.setZero(spot.rows.cols(), spot.rows.cols());
        right.setZero(spot.rows.cols());
      }
      normal += spot.rows.transpose() * spot.rows / factors[i];
      right += spot.rows.transpose() * spot.values / factors[i];
    }
  }

  std::optional<WavefrontStep> solved() const {
    if (normal.size() == 0) return std::nullopt;
    const Cholesky factors(normal);
    if (!(factors.reciprocal_condition() > kMinModesConditioning)) return std::nullopt;
    return WavefrontStep{factors.solve(right), factors.inverse()};
  }
};

}  // namespace

std::optional<WavefrontStep> step_from(const SpotPass& pass) {
  return ModeSums(pass, std::vector<double>(pass.found.size(), 1.0)).solved();
}

std::optional<WavefrontStep> damped_step(const SpotPass& pass) {
  std::vector<double> factors;
  double described = 0.0, used = 0.0;
  for (std::size_t i = 0; i < pass.found.size(); ++i) {
    factors.push_back(std::max(1.0, double(pass.found[i].chi2_per_cell)));
    if (!has_estimates(pass.templates[i], pass.found[i])) continue;
    described += 1.0 / factors.back();
    used += 1.0;
  }
  const double undescribed = 1.0 - described / std::max(used, 1.0);
  ModeSums sums(pass, factors);
  sums.normal.diagonal().array() += undescribed / (kUsualStepWaves * kUsualStepWaves);
  return sums.solved();
}

double higher_waves_of(const SpotPass& pass, const WavefrontStep& step) {
  double left = 0.0, noise = 0.0, count = 0.0;
  for (std::size_t i = 0; i < pass.found.size(); ++i) {
    if (!has_estimates(pass.templates[i], pass.found[i])) continue;
    const Whitened spot(pass.templates[i], pass.found[i], pass.higher_waves);
    left += (spot.values - spot.rows * step.waves).squaredNorm();
    noise += spot.noise;
    count += double(spot.values.size());
  }
  const double free = count - double(step.waves.size());
  if (!(free > 0.0) || !(noise < count)) return pass.higher_waves;
  const double by_noise = noise / count;
  return pass.higher_waves * std::sqrt(std::max(0.0, left / free - by_noise) / (1.0 - by_noise));
}

namespace {

/// Straight-line fit of squared noise residuals over the intensity.
struct NoiseSums {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;

  void add(double light, double square) {
    n += 1.0, x += light, y += square, xx += light * light, xy += light * square;
  }
  /// `pixels`: number of camera pixels in one binned pixel.
  PixelNoise line(double pixels) const {
    const double spread = n * xx - x * x;
    PixelNoise noise;
    noise.per_dn = spread > 0.0 ? std::max(0.0, (n * xy - x * y) / spread) : 0.0;
    const double least = std::max(kRoundingDn2, kMinDark * y / (std::max(n, 1.0) * pixels));
    noise.constant_dn2 = n > 0.0 ? std::max((y - noise.per_dn * x) / (n * pixels), least) : 1.0;
    return noise;
  }
};

struct PairNoise {
  PixelNoise noise;
  double squares = 0.0;  ///< sum of the squared differences
};

/// Orthonormal columns, which span all changes of a spot's lit binned pixels by its level, its
/// background and the wavefront, to first order.
Eigen::MatrixXd changes_of(const RenderedSpot& spot) {
  const Eigen::MatrixXf& bends = spot.per_monomial.size() > 0 ? spot.per_monomial : spot.per_wave;
  Eigen::MatrixXd changes(bends.rows(), bends.cols() + 2);
  changes << bends.cast<double>(), spot.light.cast<double>(), Eigen::VectorXd::Ones(bends.rows());
  for (Eigen::Index c = 0; c < changes.rows(); ++c) {
    if (!spot.window.is_lit(c)) changes.row(c).setZero();
  }
  for (auto change : changes.colwise()) change.stableNormalize();
  return orthonormal_basis(changes, kMinChange);
}

PairNoise noise_between(const ImageView& one, const ImageView& other,
                        std::span<const RenderedSpot> rendered) {
  NoiseSums sums;
  double pixels = 1.0;
  for (const RenderedSpot& spot : rendered) {
    if (!(spot.light.maxCoeff() > 0.0F)) continue;
    pixels = pixels_of(spot.window);
    const Eigen::VectorXd a = cells_of(one, spot.window), b = cells_of(other, spot.window);
    const double floor = dark_level(Eigen::VectorXf((0.5 * (a + b)).cast<float>()), spot.window);
    const Eigen::MatrixXd changes = changes_of(spot);
    const Eigen::VectorXd left = a - b - changes * (changes.transpose() * (a - b));
    for (Eigen::Index c = 0; c < a.size(); ++c) {
      const double share = 1.0 - changes.row(c).squaredNorm();  // of the noise that is left
      if (!spot.window.is_lit(c) || !(share >= kMinNoiseShare)) continue;
      sums.add(0.5 * (a(c) + b(c)) - floor, 0.5 * std::pow(left(c), 2) / share);
    }
  }
  return {sums.line(pixels), sums.y};
}

}  // namespace

PixelNoise noise_of(std::span<const ImageView> images, std::span<const RenderedSpot> rendered) {
  if (images.size() == 1) return noise_of(images[0], rendered);
  PairNoise least = noise_between(images[0], images[1], rendered);
  for (std::size_t k = 2; k < images.size(); ++k) {
    const PairNoise next = noise_between(images[k - 1], images[k], rendered);
    if (next.squares < least.squares) least = next;
  }
  return least.noise;
}

PixelNoise noise_of(const ImageView& image, std::span<const RenderedSpot> rendered) {
  Eigen::Matrix3f kernel;
  kernel << 1, -2, 1, -2, 4, -2, 1, -2, 1;
  NoiseSums sums;
  for (const RenderedSpot& spot : rendered) {
    SpotWindow window = spot.window;
    window.side *= std::exchange(window.bin, 1);
    const Eigen::VectorXf pixels = cells_of(image, window).cast<float>();
    const double floor = dark_level(pixels, window);
    const Eigen::Index step = window.colour_step(), last = window.side - 1 - step;
    for (Eigen::Index c = 0; c < pixels.size(); ++c) {
      const Eigen::Index y = c / window.side, x = c % window.side;
      if (!window.is_lit(c) || std::min(x, y) < step || std::max(x, y) > last) continue;
      Eigen::Matrix3f around;
      for (Eigen::Index k = 0; k < 9; ++k) {
        around(k) = pixels(c + step * ((k / 3 - 1) * window.side + k % 3 - 1));
      }
      const double left = double(around.cwiseProduct(kernel).sum());
      sums.add(double(around.mean()) - floor, left * left / double(kernel.squaredNorm()));
    }
  }
  return sums.line(1.0);
}

}  // namespace ovws
