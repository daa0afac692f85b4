/// One image read by every operator from slopes to modes.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/wavefront/refine.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

constexpr std::size_t kOperatorCount = 6;
/// Two text-book tilts, the tracker's own, diffractive, relinearised, refined.
using OperatorNames = std::array<std::string, kOperatorCount>;
OperatorNames operator_names(int charge);

/// Waves in the order of the modes, an operator each; NaN where one has no answer.
using Readings = std::array<std::vector<double>, kOperatorCount>;

/// What is shared by all images of a charge, tracked by `matched`. Its model is for one thread at a
/// time.
struct OperatorTools {
  explicit OperatorTools(int charge);
  const std::vector<int>& modes_j() const { return measurer.modes_j(); }

  int charge;
  Geometry geometry;
  std::shared_ptr<SensorModel> model;
  Measurer measurer;
  std::vector<Eigen::MatrixXd> slopes;  ///< of the linear operators, in the order of the names
};

/// For one thread at a time; `tools` outlive it.
class OperatorBench {
 public:
  explicit OperatorBench(const OperatorTools& tools);

  /// Electrons with these modes shown.
  Image<float> light_e(std::span<const Mode> modes, Light light);
  /// `light_e` holds `modes`. With no read noise there is no shot noise either.
  Readings read(const Image<float>& light_e, std::span<const Mode> modes, double read_noise_e,
                std::uint64_t seed);
  /// The Cramer-Rao bound of all pixels: root sum square over all modes, waves. NaN: not told.
  double bound_waves(const Image<float>& light_e, std::span<const Mode> modes, double read_noise_e);

 private:
  std::vector<double> linear(const Eigen::MatrixXd& slopes, std::span<const SpotFix> fixes) const;
  std::vector<double> relinearised(std::span<const SpotFix> fixes,
                                   const std::vector<double>& start);
  std::vector<double> refined(const Exposure& exposure, double read_noise_e,
                              const std::vector<double>& start);

  const OperatorTools& tools_;
  SensorConfig sensor_;
  std::shared_ptr<SensorModel> model_, vortex_;
  Refiner refiner_;
};

}  // namespace ovws::study
