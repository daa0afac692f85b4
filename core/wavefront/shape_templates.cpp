#include "core/wavefront/shape_templates.hpp"

#include "core/base/image.hpp"
#include "core/tracking/reference_shape.hpp"

namespace ovws {
namespace {

constexpr float kScale = 1000.0F;  // any that a detector has

Image<float> image_of(const SpotOptics::Picture& picture) {
  Image<float> image(int(picture.cols()), int(picture.rows()));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) image.at(x, y) = kScale * picture(y, x);
  }
  return image;
}

}  // namespace

std::vector<std::shared_ptr<const TemplateBank>> shape_templates(const SpotOptics& optics,
                                                                 const SpotModel& spots,
                                                                 const Eigen::VectorXd& waves,
                                                                 const std::vector<bool>& wanted) {
  std::vector<std::shared_ptr<const TemplateBank>> templates(wanted.size());
  const Vec2 middle{double(optics.half_cells()), double(optics.half_cells())};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    const Image<float> image = image_of(optics.light(int(i), waves, {}));
    templates[i] = reference_templates(spots, image, {&middle, 1}).front();
  }
  return templates;
}

}  // namespace ovws
