#include "core/optics/far_field.hpp"

#include <cassert>
#include <vector>

#include "core/optics/chirp_z.hpp"

namespace ovws {

FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows) {
  const double step = 1.0 / camera_px_per_cycle(optics, slm);
  const Vec2 base_cpp{sensor.grooves[0] / slm.width_px, sensor.grooves[1] / slm.height_px};
  const Vec2 base_px = base_spot_px(optics, image_cols, image_rows);
  return {image_cols, image_rows, base_cpp - step * base_px, step};
}

struct FarField::Impl {
  struct Passes {
    ChirpZ along_x, along_y;
  };
  SlmGeometry slm;
  FarFieldWindow window;
  std::vector<Passes> of_worker;
  Image<std::complex<float>> columns;  ///< field after the x pass, transposed
};

FarField::FarField(SlmGeometry slm, FarFieldWindow window, int workers) {
  assert(slm.width_px > 0 && slm.height_px > 0 && window.cols > 0 && window.rows > 0);
  const double step_y = window.step_y_cpp != 0.0 ? window.step_y_cpp : window.step_cpp;
  impl_ = std::make_unique<Impl>(Impl{slm, window, {}, {slm.height_px, window.cols}});
  for (int worker = 0; worker < workers; ++worker) {
    impl_->of_worker.push_back(
        {ChirpZ({slm.width_px, window.cols, window.origin_cpp.x, window.step_cpp}),
         ChirpZ({slm.height_px, window.rows, window.origin_cpp.y, step_y})});
  }
}

FarField::~FarField() = default;
FarField::FarField(FarField&&) noexcept = default;
FarField& FarField::operator=(FarField&&) noexcept = default;

void FarField::propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out) {
  out.width = impl_->window.cols;
  out.height = impl_->window.rows;
  out.pixels.resize(std::size_t(out.width) * out.height);
  // Transform along x first: this pass needs only one transform per SLM row.
  transform_rows(field, 0, field.height, 0);
  transform_columns(0, out.width, 0, out);
}

void FarField::transform_rows(const Image<std::complex<float>>& field, int first, int end,
                              int worker) {
  Impl& d = *impl_;
  assert(field.width == d.slm.width_px && field.height == d.slm.height_px);
  d.of_worker[std::size_t(worker)].along_x.transform(
      field.row(first), end - first, d.columns.pixels.data() + first, d.columns.width);
}

void FarField::transform_columns(int first, int end, int worker, Image<std::complex<float>>& out) {
  Impl& d = *impl_;
  assert(out.width == d.window.cols && out.height == d.window.rows);
  d.of_worker[std::size_t(worker)].along_y.transform(d.columns.row(first), end - first,
                                                     out.pixels.data() + first, out.width);
}

}  // namespace ovws
