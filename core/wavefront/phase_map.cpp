#include "core/wavefront/phase_map.hpp"

#include <algorithm>
#include <limits>

#include "core/optics/zernike.hpp"

namespace ovws {

PhaseMap::PhaseMap(std::span<const int> modes_j, int size_px) : size_(size_px) {
  std::vector<Vec2> points;
  for (int r = 0; r < size_; ++r) {
    for (int c = 0; c < size_; ++c) {
      const Vec2 at{(2.0 * c + 1.0) / size_ - 1.0, (2.0 * r + 1.0) / size_ - 1.0};
      if (norm(at) > 1.0) continue;
      inside_.push_back(r * size_ + c);
      points.push_back(at);
    }
  }
  basis_.resize(Eigen::Index(points.size()), Eigen::Index(modes_j.size()));
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      basis_(i, k) = float(zernike(modes_j[k], points[i]));
    }
  }
}

void PhaseMap::render(std::span<const float> coefficients, Image<float>& waves) const {
  if (waves.width != size_ || waves.height != size_) waves = Image<float>(size_, size_);
  std::fill(waves.pixels.begin(), waves.pixels.end(), std::numeric_limits<float>::quiet_NaN());
  const Eigen::Map<const Eigen::VectorXf> a(coefficients.data(), basis_.cols());
  const Eigen::VectorXf inside = basis_ * a;
  for (std::size_t i = 0; i < inside_.size(); ++i) waves.pixels[inside_[i]] = inside(i);
}

}  // namespace ovws
