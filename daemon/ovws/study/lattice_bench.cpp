#include "daemon/ovws/study/lattice_bench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws::study {
namespace {

constexpr int kSpotPx = 6;       // lambda/d
constexpr int kWindowPx = 48;    // of one spot
constexpr int kCellHalfPx = 18;  // of the fixed cell: pitch of 6 lambda/d
constexpr double kReadNoiseE = 5.0;
constexpr int kHighestOrder = 8;  // 44 modes

SensorConfig lattice_sensor(int across, int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  sensor.grid = Grid::square;
  sensor.subapertures_across = across;
  sensor.pupil_diameter_px = kPupilPx;
  return sensor;
}

Wave flat_wave() {
  return {kWavePx, kWavePx, 1.0F};
}

constexpr double kPi = std::numbers::pi;

/// Fourier transform of all rows and columns; the inverse with its factor 1 / N^2.
void transform(Wave& wave, bool inverse) {
  Eigen::FFT<float> fft;
  std::vector<std::complex<float>> line(kWavePx), out(kWavePx);
  const auto run = [&](int first, int stride) {
    for (int k = 0; k < kWavePx; ++k)
      line[std::size_t(k)] = wave.pixels[std::size_t(first + k * stride)];
    if (inverse) {
      fft.inv(out, line);
    } else {
      fft.fwd(out, line);
    }
    for (int k = 0; k < kWavePx; ++k)
      wave.pixels[std::size_t(first + k * stride)] = out[std::size_t(k)];
  };
  for (int row = 0; row < kWavePx; ++row) run(row * kWavePx, 1);
  for (int column = 0; column < kWavePx; ++column) run(column, kWavePx);
}

/// Multiplies by `gain(f^2)`, f in cycles per pixel.
template <class Gain>
void filter(Wave& spectrum, const Gain& gain) {
  const auto frequency = [](int k) {
    return double(k < kWavePx / 2 ? k : k - kWavePx) / double(kWavePx);
  };
  for (int y = 0; y < kWavePx; ++y) {
    for (int x = 0; x < kWavePx; ++x) {
      const double fx = frequency(x), fy = frequency(y);
      spectrum.pixels[std::size_t(y * kWavePx + x)] *= gain(fx * fx + fy * fy);
    }
  }
}

/// exp(i phase) of the layer. White noise is filtered by the root of the spectrum.
Wave layer(double r0_px, std::uint64_t seed) {
  Wave wave(kWavePx, kWavePx);
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  for (auto& pixel : wave.pixels) {
    const float real = normal(random);
    pixel = {real, normal(random)};
  }
  const double outer = 1.0 / (kOuterScale * kPupilPx * kOuterScale * kPupilPx);
  filter(wave, [&](double f2) {
    const double power = 0.0229 * std::pow(r0_px, -5.0 / 3.0) * std::pow(f2 + outer, -11.0 / 6.0);
    return f2 > 0.0 ? float(std::sqrt(power) * kWavePx) : 0.0F;  // times N^2 df, df = 1 / N
  });
  transform(wave, true);
  for (auto& pixel : wave.pixels) pixel = std::polar(1.0F, pixel.real());
  return wave;
}

}  // namespace

Wave scintillated_wave(const Air& air, std::uint64_t seed) {
  const double r0_px = kPupilPx / air.pupils_per_r0;
  Wave wave = layer(r0_px, seed);
  if (air.rytov_variance <= 0.0) return wave;
  const double fresnel_px = r0_px * std::pow(air.rytov_variance / 1.145, 0.6);
  transform(wave, false);
  filter(wave, [&](double f2) {
    return std::polar(1.0F, float(std::remainder(-kPi * fresnel_px * fresnel_px * f2, 2.0 * kPi)));
  });
  transform(wave, true);
  return wave;
}

std::vector<PupilPixel> pupil_pixels() {
  std::vector<PupilPixel> pixels;
  constexpr double kCentre = 0.5 * (kWavePx - 1);
  for (int y = 0; y < kWavePx; y += 2) {
    for (int x = 0; x < kWavePx; x += 2) {
      const Vec2 at = (2.0 / kPupilPx) * Vec2{x - kCentre, y - kCentre};
      if (norm(at) <= 1.0) pixels.push_back({x, y, at});
    }
  }
  return pixels;
}

double scintillation_index(const Wave& wave) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const PupilPixel& pixel : pupil_pixels()) {
    const double intensity = std::norm(wave.pixels[std::size_t(pixel.y * kWavePx + pixel.x)]);
    sum += intensity;
    squares += intensity * intensity;
    ++count;
  }
  return squares * count / (sum * sum) - 1.0;
}

LatticeBench::LatticeBench(int across, const SpotMethod& method) : method_(method) {
  const SensorConfig sensor = lattice_sensor(across, method.charge);
  const Lattice lattice = value_of(make_lattice(sensor, {}));
  diameter_px_ = lattice.diameter_px;
  columns_ = int(std::ceil(std::sqrt(double(lattice.subapertures.size()))));
  for (const Subaperture& one : lattice.subapertures) cells_.push_back(cell_of(one));
  const TrackingConfig tracking{method.fixed_cell ? TrackerKind::centroid : TrackerKind::lg};
  tracker_ = value_of(make_tracker(tracking, {method.charge, double(kSpotPx)}));
  constexpr double kBrightE = 1e8;  // so bright that noise does not matter
  std::vector<Vec2> reference_px;
  const Image<float> light = spots_e(flat_wave(), kBrightE);
  float peak = 0.0F;
  for (const float e : light.pixels) peak = std::max(peak, e);
  Image<float> dimmed = light;
  for (float& e : dimmed.pixels) e *= 3000.0F / peak;
  for (const SpotFix& fix : track(noise_free(dimmed))) reference_px.push_back({fix.x, fix.y});
  for (int order = 2; order <= kHighestOrder; ++order) {
    const int modes = (order + 1) * (order + 2) / 2 - 1;
    const Eigen::MatrixXd slopes =
        slope_matrix(lattice, sensor, first_modes_j(modes), tilt_radius(method.charge, tracking),
                     kSpotPx * diameter_px_);
    if (determined_modes(slopes) < modes) break;
    mode_counts_.push_back(modes);
    reconstructors_.push_back(
        std::make_unique<const Reconstructor>(slopes, first_modes_j(modes), reference_px));
  }
}

LatticeBench::Cell LatticeBench::cell_of(const Subaperture& subaperture) const {
  const double centre = 0.5 * (kWavePx - 1), radius = 0.5 * diameter_px_;
  const Vec2 at = subaperture.centre_px + Vec2{centre, centre};
  const int size = int(std::ceil(diameter_px_)) + 1;
  Cell cell{int(std::floor(at.x - radius)), int(std::floor(at.y - radius)), {}, {}, {}};
  cell.imprint.resize(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Vec2 from = Vec2{double(cell.x + x), double(cell.y + y)} - at;
      const float angle = float(method_.charge) * float(std::atan2(from.y, from.x));
      cell.imprint(y, x) = norm(from) <= radius ? std::polar(1.0F, angle) : 0.0F;
    }
  }
  const auto transform = [&](double begin, bool by_rows) {
    Eigen::MatrixXcf matrix(kWindowPx, size);
    for (int p = 0; p < kWindowPx; ++p) {
      const double frequency = (p - 0.5 * (kWindowPx - 1)) / (kSpotPx * diameter_px_);
      for (int k = 0; k < size; ++k) {
        matrix(p, k) = std::polar(1.0F, float(-2.0 * std::numbers::pi * frequency * (begin + k)));
      }
    }
    return by_rows ? matrix : Eigen::MatrixXcf(matrix.transpose());
  };
  cell.along_y = transform(cell.y - at.y, true);
  cell.along_x = transform(cell.x - at.x, false);
  return cell;
}

Vec2 LatticeBench::centre_px(std::size_t spot) const {
  const double half = 0.5 * (kWindowPx - 1);
  return {half + kWindowPx * double(int(spot) % columns_),
          half + kWindowPx * double(int(spot) / columns_)};
}

/// Electrons in every pixel, with the windows of the spots side by side.
Image<float> LatticeBench::spots_e(const Wave& wave, double pupil_e) const {
  const int rows = (subapertures() + columns_ - 1) / columns_;
  Image<float> image(columns_ * kWindowPx, rows * kWindowPx);
  const double step = 1.0 / (kSpotPx * diameter_px_);
  const double pupil_px = std::numbers::pi * kPupilPx * kPupilPx / 4.0;
  const auto scale = float(pupil_e / pupil_px * step * step);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    Eigen::MatrixXcf field = cell.imprint;
    for (Eigen::Index x = 0; x < field.cols(); ++x) {
      for (Eigen::Index y = 0; y < field.rows(); ++y) {
        field(y, x) *= wave.pixels[std::size_t((cell.y + y) * kWavePx + cell.x + x)];
      }
    }
    const Eigen::MatrixXcf spot = cell.along_y * field * cell.along_x;
    const int left = int(i) % columns_ * kWindowPx, top = int(i) / columns_ * kWindowPx;
    for (int y = 0; y < kWindowPx; ++y) {
      for (int x = 0; x < kWindowPx; ++x) {
        image.pixels[std::size_t((top + y) * image.width + left + x)] =
            scale * std::norm(spot(y, x));
      }
    }
  }
  return image;
}

std::vector<SpotFix> LatticeBench::track(const Exposure& exposure) const {
  std::vector<Vec2> centres_px;
  for (std::size_t i = 0; i < cells_.size(); ++i) centres_px.push_back(centre_px(i));
  if (method_.fixed_cell) return cell_centroids(exposure, centres_px, kCellHalfPx);
  TrackScratch scratch = tracker_->make_scratch();
  std::vector<SpotFix> fixes;
  for (const Vec2 at : centres_px) fixes.push_back(tracker_->track(exposure.view(), at, scratch));
  drop_faint(fixes, subapertures());
  return fixes;
}

LatticeFrame LatticeBench::measure(const Wave& wave, double pupil_e, std::uint64_t seed) const {
  LatticeFrame frame;
  const auto fixes = track(expose(spots_e(wave, pupil_e), kReadNoiseE, seed));
  for (const SpotFix& fix : fixes) frame.lost += fix.found() ? 0 : 1;
  for (const auto& reconstructor : reconstructors_) {
    std::vector<float> waves(reconstructor->modes_j().size());
    Reconstructor::Scratch scratch = reconstructor->make_scratch();
    reconstructor->solve(fixes, scratch, waves);
    frame.waves.push_back(std::move(waves));
  }
  return frame;
}

}  // namespace ovws::study
