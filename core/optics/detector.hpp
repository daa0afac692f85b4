/// Detector model: camera noise, stage by stage (after Konnik and Welsh, "High-level numerical
/// simulations of noise in CCD and CMOS photosensors", 2014).
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.hpp"

namespace ovws {

struct DetectorConfig {
  double quantum_efficiency = 0.6;  ///< electrons per photon, 0 .. 1
  double prnu = 0.005;              ///< photo-response non-uniformity, relative RMS, fixed pattern
  bool shot_noise = true;
  double dark_current_e_per_s = 5.0;
  double read_noise_e = 5.0;     ///< electrons RMS
  double full_well_e = 10000.0;  ///< electrons at which a pixel saturates
  double black_level_dn = 2.0;   ///< added before quantisation, DN of the output
  int bits = 8;                  ///< bit depth, 1 .. 16: full_well_e gives 2^bits - 1 at 0 dB
  std::uint64_t seed = 1;
};

/// System gain in DN per electron: full_well_e at 0 dB spans the full scale of 2^bits - 1. The
/// black level is added on top.
double dn_per_electron(const DetectorConfig& config, double gain_db);

/// Detector stages: photons -> PRNU -> dark signal -> shot noise -> full well -> read noise -> gain
/// -> black level -> clip -> quantise. Photon and dark electrons both have shot noise.
class Detector {
 public:
  Detector(const DetectorConfig& config, int width, int height);

  /// Simulates one exposure. `photons`: mean number per pixel and exposure; the image must have the
  /// constructor's size. `gain_db`: 20 log10 of the gain. Each call draws new noise; equal seeds
  /// give equal sequences of exposures.
  void expose(const Image<float>& photons, double exposure_us, double gain_db,
              Image<std::uint16_t>& dn);

 private:
  DetectorConfig config_;
  int width_;
  int height_;
  std::vector<float> response_;
  std::vector<float> mean_e_;  ///< of the last exposure
  std::uint64_t realisation_ = 0;
};

}  // namespace ovws
