#include "drivers/twin/sources_model.hpp"

#include <algorithm>

namespace ovws::twin {

void SourcesModel::set_light(const Light& light) {
  main_->set_light(light);
  set_further(light);
}

void SourcesModel::set_further(const Light& light) {
  further_.resize(light.sources.size());
  for (std::size_t k = 0; k < further_.size(); ++k) {
    Further& one = further_[k];
    const bool moved = one.model == nullptr || one.source.offset_px != light.sources[k].offset_px;
    one.source = light.sources[k];
    if (one.model == nullptr) one.model = make_();
    Light own = light;
    own.aberration = one.source.aberration;
    one.model->set_light(own);
    if (moved && placed_) place(one);
  }
}

void SourcesModel::set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) {
  main_->set_turbulence(turbulence, t_ns);
  for (Further& one : further_) one.model->set_turbulence(turbulence, t_ns);
}

void SourcesModel::set_window(const Roi& window, const CameraGeometry& geometry) {
  window_ = window;
  geometry_ = geometry;
  placed_ = true;
  main_->set_window(window, geometry);
  for (Further& one : further_) place(one);
}

void SourcesModel::place(Further& one) const {
  CameraGeometry displaced = geometry_;
  displaced.centre_px = displaced.centre_px + one.source.offset_px;
  one.model->set_window(window_, displaced);
}

Image<float> SourcesModel::intensity(const Image<std::uint8_t>& grey) {
  Image<float> sum = main_->intensity(grey);
  for (Further& one : further_) {
    if (one.source.power == 0.0) continue;
    const Image<float> more = one.model->intensity(grey);
    std::transform(sum.pixels.begin(), sum.pixels.end(), more.pixels.begin(), sum.pixels.begin(),
                   [power = float(one.source.power)](float a, float b) { return a + power * b; });
  }
  return sum;
}

void SourcesModel::prepare(const Image<std::uint8_t>& grey) {
  main_->prepare(grey);
  for (Further& one : further_) {
    if (one.source.power > 0.0) one.model->prepare(grey);
  }
}

}  // namespace ovws::twin
