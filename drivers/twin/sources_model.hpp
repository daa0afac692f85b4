/// Optical model of a bench with several sources of light, whose intensities add.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "drivers/twin/optical_model.hpp"

namespace ovws::twin {

/// The main source's model, and one more for each further source: the same bench, whose camera is
/// displaced. All sources have the same air, shades and mirror.
class SourcesModel : public OpticalModel {
 public:
  using Make = std::function<std::unique_ptr<OpticalModel>()>;
  SourcesModel(Make make, const Light& light) : make_(std::move(make)), main_(make_()) {
    set_further(light);
  }

  void set_light(const Light& light) override;
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) override;
  void set_window(const Roi& window, const CameraGeometry& geometry) override;
  Image<float> intensity(const Image<std::uint8_t>& grey) override;
  void prepare(const Image<std::uint8_t>& grey) override;

  // Of the main source.
  std::vector<Vec2> true_spots_px(const Truth& truth) const override {
    return main_->true_spots_px(truth);
  }
  double photons_per_peak_photon(const CameraGeometry& geometry) const override {
    return main_->photons_per_peak_photon(geometry);
  }
  std::unique_ptr<Judge> make_judge() const override { return main_->make_judge(); }

 private:
  struct Further {
    LightSource source;
    std::unique_ptr<OpticalModel> model;
  };
  void set_further(const Light& light);
  void place(Further& one) const;

  Make make_;
  std::unique_ptr<OpticalModel> main_;
  std::vector<Further> further_;
  bool placed_ = false;  ///< window_ and geometry_ are known
  Roi window_;
  CameraGeometry geometry_;
};

}  // namespace ovws::twin
