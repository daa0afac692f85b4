/// Reconstructs the modes of one image with every operator.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/spots/spot_renderer.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

constexpr std::size_t kOperatorCount = 5;
/// Names in the order of Readings: two textbook tilts, the tracker's own slopes, diffractive,
/// fit.
using OperatorNames = std::array<std::string, kOperatorCount>;
OperatorNames operator_names(int charge);

/// Coefficients in waves per operator, in the order of modes_j; NaN if an operator fails.
using Readings = std::array<std::vector<double>, kOperatorCount>;

/// Data shared by all images of one charge, tracked by `lg`. Its model may be used by one
/// thread at a time.
struct OperatorTools {
  explicit OperatorTools(int charge);
  const std::vector<int>& modes_j() const { return measurer.modes_j(); }

  int charge;
  Geometry geometry;
  std::shared_ptr<SensorModel> model;
  Measurer measurer;
  std::vector<Eigen::MatrixXd> slopes;  ///< linear operators, in the order of the names
};

/// Reconstructs images with every operator. Not thread-safe; `tools` must outlive it.
class OperatorBench {
 public:
  explicit OperatorBench(const OperatorTools& tools);

  /// Camera image in electrons per pixel, with these modes on the SLM.
  Image<float> light_e(std::span<const Mode> modes, Light light);
  /// Tracks one exposure of `light_e`, the image with `modes`, and applies every operator. Zero
  /// read noise also disables shot noise.
  Readings read(const Image<float>& light_e, std::span<const Mode> modes, double read_noise_e,
                std::uint64_t seed);
  /// The Cramer-Rao bound from all pixels: root sum square over all modes, waves.
  double bound_waves(const Image<float>& light_e, std::span<const Mode> modes, double read_noise_e);

 private:
  std::vector<double> linear(const Eigen::MatrixXd& slopes, std::span<const SpotFix> fixes) const;

  const OperatorTools& tools_;
  std::shared_ptr<SensorModel> model_, vortex_;
  SpotRenderer renderer_, bound_renderer_;
};

}  // namespace ovws::study
