#include "core/optics/far_field.hpp"

#include <cassert>

#include "core/optics/chirp_z.hpp"

namespace ovws {
namespace {

ChirpZ::Axis axis(int inputs, int outputs, double first_cpp, double step_cpp) {
  return {inputs, outputs, 0.5 * (inputs - 1), first_cpp, step_cpp};
}

}  // namespace

FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows) {
  const double step = 1.0 / camera_px_per_cycle(optics, slm);
  const Vec2 base_cpp{sensor.grooves[0] / slm.width_px, sensor.grooves[1] / slm.height_px};
  const Vec2 base_px = base_spot_px(optics, image_cols, image_rows);
  return {image_cols, image_rows, base_cpp - step * base_px, step};
}

struct FarField::Impl {
  SlmGeometry slm;
  FarFieldWindow window;
  ChirpZ along_x;
  ChirpZ along_y;
  Image<std::complex<float>> columns;  ///< after the pass along x, transposed: one row per column
};

FarField::FarField(SlmGeometry slm, FarFieldWindow window) {
  assert(slm.width_px > 0 && slm.height_px > 0 && window.cols > 0 && window.rows > 0);
  const double step_y = window.step_y_cpp != 0.0 ? window.step_y_cpp : window.step_cpp;
  // The pass along x comes first: it needs only as many transforms as the SLM has rows.
  impl_ = std::make_unique<Impl>(
      Impl{slm,
           window,
           ChirpZ(axis(slm.width_px, window.cols, window.origin_cpp.x, window.step_cpp)),
           ChirpZ(axis(slm.height_px, window.rows, window.origin_cpp.y, step_y)),
           {slm.height_px, window.cols}});
}

FarField::~FarField() = default;
FarField::FarField(FarField&&) noexcept = default;
FarField& FarField::operator=(FarField&&) noexcept = default;

void FarField::propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out) {
  Impl& d = *impl_;
  assert(field.width == d.slm.width_px && field.height == d.slm.height_px);
  d.along_x.transform(field.pixels.data(), field.height, d.columns.pixels.data());
  out.width = d.window.cols;
  out.height = d.window.rows;
  out.pixels.resize(std::size_t(out.width) * out.height);
  d.along_y.transform(d.columns.pixels.data(), out.width, out.pixels.data());
}

}  // namespace ovws
