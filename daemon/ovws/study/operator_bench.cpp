#include "daemon/ovws/study/operator_bench.hpp"

#include <cmath>
#include <stdexcept>

#include "core/wavefront/diffractive_matrix.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/wavefront_bound.hpp"

namespace ovws::study {
namespace {

constexpr int kFitRenderings = 6;  // of the spots, in the fit of all pixels
// Index of the tracker's own slope operator among the operators; the fit starts at its result.
constexpr std::size_t kOwn = 2;

SensorConfig operator_sensor(const OperatorTools& tools) {
  SensorConfig sensor = tools.geometry.sensor;
  sensor.charge = tools.charge;
  return sensor;
}

}  // namespace

OperatorNames operator_names(int charge) {
  return {"G-tilt", charge == 0 ? "Z-tilt" : "V-tilt", "tracker's own", "diffractive", "fit"};
}

OperatorTools::OperatorTools(int l)
    : charge(l),
      geometry(default_bench()),
      model(model_of(geometry, charge)),
      measurer(geometry, {"lg", charge, {TrackerKind::lg}}, model) {
  const SensorConfig sensor = operator_sensor(*this);
  for (const double radius : {kGradientTilt, charge == 0 ? kZernikeTilt : kVortexTilt,
                              tilt_radius(charge, measurer.method().tracking)}) {
    slopes.push_back(
        slope_matrix(model->lattice(), sensor, modes_j(), radius, model->px_per_cycle()));
  }
  SensorField field =
      SensorField::make(sensor, geometry.slm, geometry.optics, kImagePx, kImagePx).value();
  const ModeOperator own{OperatorKind::slopes, modes_j(), slopes.back()};
  const auto made = diffractive_operator(field, measurer.tracker(), own, model->spots_px());
  if (!made) throw std::logic_error(made.error().reason);
  slopes.push_back(made->slopes);
}

OperatorBench::OperatorBench(const OperatorTools& tools)
    : tools_(tools),
      model_(model_of(tools.geometry, tools.charge)),
      vortex_(tools.charge == 1 ? model_ : model_of(tools.geometry, 1)),
      renderer_(renderer_of(tools.geometry, tools.charge, tools.modes_j())),
      bound_renderer_(bound_renderer_of(tools.geometry, tools.charge, tools.modes_j())) {}

Image<float> OperatorBench::light_e(std::span<const Mode> modes, Light light) {
  return electrons(*model_, *vortex_, modes, light);
}

Readings OperatorBench::read(const Image<float>& light_e, std::span<const Mode> modes,
                             double read_noise_e, std::uint64_t seed) {
  const Exposure exposure =
      read_noise_e > 0.0 ? expose(light_e, read_noise_e, seed) : noise_free(light_e);
  const auto fixes = tools_.measurer.track(exposure, tools_.measurer.predicted_px(modes));
  Readings readings;
  for (std::size_t k = 0; k < tools_.slopes.size(); ++k) {
    readings[k] = linear(tools_.slopes[k], fixes);
  }
  readings[4] = fitted_waves(renderer_, exposure, read_noise_e, readings[kOwn], kFitRenderings);
  return readings;
}

double OperatorBench::bound_waves(const Image<float>& light_e, std::span<const Mode> modes,
                                  double read_noise_e) {
  return std::sqrt(pixel_covariance(bound_renderer_, modes, light_e, read_noise_e).trace());
}

std::vector<double> OperatorBench::linear(const Eigen::MatrixXd& slopes,
                                          std::span<const SpotFix> fixes) const {
  const Reconstructor reconstructor(slopes, tools_.modes_j(), tools_.measurer.reference_px());
  Reconstructor::Scratch scratch = reconstructor.make_scratch();
  std::vector<float> waves(tools_.modes_j().size());
  reconstructor.solve(fixes, scratch, waves);
  return {waves.begin(), waves.end()};
}

}  // namespace ovws::study
