#include "core/wavefront/shape_templates.hpp"

#include <algorithm>
#include <cmath>

#include "core/tracking/spot_shape.hpp"

namespace ovws {
namespace {

constexpr double kBinsPerLambdaD = 49.0;  // as fine as the shifts of a TemplateBank

int bins_per_px(const SpotModel& spots) {
  return std::max(1, int(std::ceil(kBinsPerLambdaD / spots.lambda_d_px)));
}

/// A spot's image from SpotOptics, interpolated bilinearly, with its brightest bin made 1.
class RenderedShape final : public SpotShape {
 public:
  RenderedShape(SpotOptics::Picture picture, double bins_per_px)
      : picture_(std::move(picture)), bins_per_px_(bins_per_px) {
    picture_ /= picture_.maxCoeff();
  }

  ShapeSample at(Vec2 from_centre) const override {
    const double middle = 0.5 * double(picture_.rows() - 1);
    const double x = middle + bins_per_px_ * from_centre.x;
    const double y = middle + bins_per_px_ * from_centre.y;
    // Central differences over two bins err by less than 1 % at 49 bins per lambda/d.
    return {value(x, y), 0.5 * bins_per_px_ * (value(x + 1.0, y) - value(x - 1.0, y)),
            0.5 * bins_per_px_ * (value(x, y + 1.0) - value(x, y - 1.0))};
  }

 private:
  double value(double x, double y) const {
    const double last = double(picture_.rows()) - 1.001;
    x = std::clamp(x, 0.0, last);
    y = std::clamp(y, 0.0, last);
    const auto column = Eigen::Index(x), row = Eigen::Index(y);
    const auto right = float(x - double(column)), down = float(y - double(row));
    const float* cell = picture_.data() + column * picture_.rows() + row;
    const float* next = cell + picture_.rows();
    const float here = cell[0] + down * (cell[1] - cell[0]);
    return double(here + right * (next[0] + down * (next[1] - next[0]) - here));
  }

  SpotOptics::Picture picture_;
  double bins_per_px_;
};

}  // namespace

SpotOptics template_optics(const Lattice& lattice, const SensorConfig& sensor,
                           const std::vector<int>& modes_j, const PxPerCycle& px_per_cycle,
                           const SpotModel& spots) {
  const int cells = bins_per_px(spots);
  const double reach_px = matched_window(spots.charge) * spots.lambda_d_px + 3.0;
  return {lattice, sensor, modes_j, px_per_cycle / (1.0 / cells), int(std::ceil(reach_px * cells))};
}

std::vector<std::shared_ptr<const TemplateBank>> shape_templates(const SpotOptics& optics,
                                                                 const SpotModel& spots,
                                                                 const Eigen::VectorXd& waves,
                                                                 const std::vector<bool>& wanted) {
  std::vector<std::shared_ptr<const TemplateBank>> templates(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    const RenderedShape shape(optics.intensity(int(i), waves, {}), bins_per_px(spots));
    auto bank = std::make_shared<TemplateBank>(spots, shape);
    if (bank->regular()) templates[i] = std::move(bank);
  }
  return templates;
}

}  // namespace ovws
