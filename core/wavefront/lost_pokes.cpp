#include "core/wavefront/lost_pokes.hpp"

#include <cmath>

namespace ovws {
namespace {

constexpr double kModelError = 0.2;  // relative error of a displacement taken from the model

bool is_found(const SpotMeans& spots, std::size_t i) {
  return std::isfinite(spots.at_px[i].x) && std::isfinite(spots.at_px[i].y);
}

/// Measured over modelled displacement, by least squares over the spots found in both images.
double factor_of(const PushPull& poke, const Eigen::Ref<const Eigen::VectorXd>& model) {
  double both = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < poke.plus.at_px.size(); ++i) {
    if (!is_found(poke.plus, i) || !is_found(poke.minus, i)) continue;
    const Vec2 moved = poke.plus.at_px[i] - poke.minus.at_px[i];
    const auto row = 2 * Eigen::Index(i);
    const double x = 2.0 * poke.amplitude_waves * model[row];
    const double y = 2.0 * poke.amplitude_waves * model[row + 1];
    both += moved.x * x + moved.y * y;
    squares += x * x + y * y;
  }
  return squares > 0.0 ? both / squares : 1.0;
}

/// Lost in one image: the position in the other image, mirrored about the resting position.
void mirror(const SpotMeans& seen, const SpotMeans& resting, std::size_t i, SpotMeans& lost) {
  const Vec2 &a = seen.standard_error_px[i], &b = resting.standard_error_px[i];
  lost.at_px[i] = 2.0 * resting.at_px[i] - seen.at_px[i];
  lost.standard_error_px[i] = {std::hypot(a.x, 2.0 * b.x), std::hypot(a.y, 2.0 * b.y)};
}

/// Lost in both images: the displacement of the model, with a standard error of a fifth of it.
void follow_model(const SpotMeans& resting, const Eigen::Vector2d& px_per_wave, std::size_t i,
                  PushPull& poke) {
  const Vec2 moved = poke.amplitude_waves * Vec2{px_per_wave.x(), px_per_wave.y()};
  poke.plus.at_px[i] = resting.at_px[i] + moved;
  poke.minus.at_px[i] = resting.at_px[i] - moved;
  const double error_px = kModelError * norm(moved);
  poke.plus.standard_error_px[i] = poke.minus.standard_error_px[i] = {error_px, error_px};
}

}  // namespace

void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& poke) {
  const std::vector<int> lost = lost_by(poke, resting);
  std::size_t spots = 0;
  for (std::size_t i = 0; i < resting.at_px.size(); ++i) spots += is_found(resting, i) ? 1 : 0;
  if (double(lost.size()) > kMaxLostByMode * double(spots)) return;
  const double factor = factor_of(poke, model);
  for (const int spot : lost) {
    const auto i = std::size_t(spot);
    if (is_found(poke.plus, i)) {
      mirror(poke.plus, resting, i, poke.minus);
    } else if (is_found(poke.minus, i)) {
      mirror(poke.minus, resting, i, poke.plus);
    } else {
      follow_model(resting, factor * model.segment<2>(2 * spot), i, poke);
    }
  }
}

}  // namespace ovws
