/// Light of a lenslet array on the camera, which stands in the focal plane of the lenslets.
///
/// By Fresnel's integral, with the lenslet's quadratic phase, the field at x is, but for a factor
/// that all lenslets share,
///
///     u(x) = sum_i exp(i pi |x - c_i|^2 / (lambda f))
///                  integral over lenslet i of A exp(i phi) exp(-2 pi i (x - c_i) s / (lambda f))
///                  ds
///
/// with s from the lenslet's centre c_i. Each lenslet's field is computed in a box of pixels around
/// its spot, and the fields of overlapping boxes add as complex amplitudes.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_map.hpp"
#include "drivers/twin/complex_sums.hpp"
#include "drivers/twin/phase_grid.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// The fields of all lenslets whose light reaches a window of the camera. A lenslet is sampled by
/// squares of constant light whose sides are parallel to the camera's: then the field in a box is a
/// product of two small matrices and the samples. Use it in one thread at a time.
class LensletFields {
 public:
  /// Light at a position in the array's plane, micrometres; its amplitude is at most 1.
  using Incident = std::function<std::complex<float>(Vec2)>;

  /// `map`: from the array's plane, micrometres, to sensor pixels. `grid`: that of the wavefront.
  /// `screen`: a smooth factor on the amplitude, on that grid; empty: none.
  LensletFields(const Config& config, const CameraMap& map, const Roi& window,
                const PhaseGrid& grid, const Incident& incident, const Eigen::MatrixXf& screen);

  /// Intensity in the window for a wavefront (waves) on the grid, in the unit of OpticalModel.
  Image<float> intensity(const Eigen::MatrixXf& waves);

  int count() const { return int(lenslets_.size()); }  ///< lenslets that are computed

 private:
  using Phasors = std::vector<std::complex<float>>;
  /// Real and imaginary parts of a matrix, row by row.
  struct Planes {
    Planes(int width, int height) : re(std::size_t(width) * height), im(re.size()), stride(width) {}
    SplitRows rows(std::ptrdiff_t first = 0) {
      return {re.data() + first, im.data() + first, stride};
    }
    std::vector<float> re, im;
    std::ptrdiff_t stride;
  };
  struct Lenslet {
    int x, y;         ///< first pixel of its box, in the window
    Phasors light;    ///< its light with a flat wavefront, samples row by row
    Phasors columns;  ///< factors on the columns of its box
    Phasors rows;     ///< factors on the rows of its box
  };
  Phasors cell_light(const Config& config, const CameraMap& map) const;
  void fill_kernel();
  void add_lenslet(const CameraMap& map, Vec2 centre_um, Vec2 spot_px, const Phasors& cell,
                   const Incident& incident);
  void dim(const Eigen::MatrixXf& screen);
  Phasors box_factors(double offset_px) const;
  void add_field(const Lenslet& lenslet, Phasors& light);

  int width_, height_;
  int reach_;       ///< a box is 2 reach_ + 1 pixels wide
  int box_stride_;  ///< that, as a multiple of kSplitLanes
  int samples_;
  double side_um_;  ///< of a lenslet's square of samples
  bool exact_;      ///< the samples' squares fill the lenslets exactly
  double px_um_;    ///< a camera pixel in the array's plane
  double lambda_f_;
  Planes kernel_;           ///< from samples to columns of the box, samples_ x box_stride_
  Phasors kernel_by_rows_;  ///< the same transposed, box rows x samples_
  std::vector<Lenslet> lenslets_;
  std::optional<LensletInterpolation> interpolation_;
  Planes half_;   ///< a lenslet after the first product
  Planes field_;  ///< of the window, with a margin of box_stride_ on each side
};

}  // namespace ovws::twin
