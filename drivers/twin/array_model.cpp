#include "drivers/twin/array_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics/lattice.hpp"
#include "core/optics/wavefront_rows.hpp"
#include "core/wavefront/slope_model.hpp"
#include "drivers/twin/array_layout.hpp"

namespace ovws::twin {
namespace {

/// Grid points per lenslet and across the pupil, whichever are closer.
constexpr double kPointsPerPitch = 4.0, kPointsPerPupil = 96.0;

PhaseGrid grid_of(const ArrayConfig& array) {
  double reach = 0.0;
  for (const Vec2 centre : lenslet_centres(array)) {
    reach = std::max({reach, std::abs(centre.x), std::abs(centre.y)});
  }
  // A lenslet's square of samples, at 45 degrees, reaches one pitch from its centre.
  const double step = std::min(array.pitch_um / kPointsPerPitch, pupil_um(array) / kPointsPerPupil);
  return PhaseGrid::covering(reach + array.pitch_um, step);
}

}  // namespace

ArrayModel::ArrayModel(const Config& config) : config_(config), grid_(grid_of(config.array)) {
  light_ = config.truth;
  aberration_waves_ = sample(light_.aberration);
  if (config.mirror) mirror_.emplace(*config.mirror, pupil_line(), pupil_line());
  if (mirror_) mirror_waves_ = mirror_->waves(light_.mirror_waves);
}

PupilLine ArrayModel::pupil_line() const {
  const double radius = pupil_um(config_.array) / 2;
  return {grid_.first_um() / radius, grid_.step_um / radius, grid_.points};
}

CameraMap ArrayModel::map(const CameraGeometry& geometry) const {
  return camera_map(geometry, {}, geometry.magnification / config_.optics.camera_pitch_um);
}

Eigen::MatrixXf ArrayModel::sample(const std::vector<Mode>& modes) const {
  const double centre = (grid_.points - 1) / 2.0;
  const WavefrontRows wavefront(modes, {centre, centre}, pupil_um(config_.array) / grid_.step_um);
  Eigen::VectorXd line(grid_.points);
  Eigen::MatrixXf waves(grid_.points, grid_.points);
  for (int y = 0; y < grid_.points; ++y) {
    wavefront.waves(y, 0, {line.data(), std::size_t(grid_.points)});
    waves.col(y) = line.cast<float>();
  }
  return waves;
}

void ArrayModel::set_light(const Light& light) {
  if (light.aberration != light_.aberration) aberration_waves_ = sample(light.aberration);
  if (mirror_ && light.mirror_waves != light_.mirror_waves) {
    mirror_waves_ = mirror_->waves(light.mirror_waves);
  }
  if (light.shades != light_.shades || light.scintillation != light_.scintillation ||
      light.branch_points != light_.branch_points) {
    fields_.reset();
  }
  light_ = light;
}

void ArrayModel::set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) {
  turbulence_waves_.resize(0, 0);
  if (turbulence == nullptr) return;
  const PupilLine line = pupil_line();
  turbulence_waves_ = turbulence->sample({line.first, line.first}, line.step, line.count, t_ns);
}

void ArrayModel::set_window(const Roi& window, const CameraGeometry& geometry) {
  window_ = window;
  geometry_ = geometry;
  fields_.reset();
}

float ArrayModel::beam_amplitude(Vec2 at_um) const {
  if (!config_.array.beam_diameter_mm) return 1.0F;
  const double ratio = norm(at_um) / (500.0 * *config_.array.beam_diameter_mm);
  if (config_.light.shape == LightShape::uniform) return ratio <= 1.0 ? 1.0F : 0.0F;
  return float(std::exp(-ratio * ratio));
}

std::complex<float> ArrayModel::incident(Vec2 at_um) const {
  float amplitude = beam_amplitude(at_um);
  const Vec2 px = map(geometry_).pixel(at_um);
  for (const Shade& shade : light_.shades) {
    if (norm(px - shade.centre_px) > shade.radius_px) continue;
    amplitude *= float(std::sqrt(shade.transmission));
  }
  std::complex<float> light = amplitude;
  const Vec2 at = (2.0 / pupil_um(config_.array)) * at_um;
  for (const LightVortex& vortex : light_.branch_points) light *= field_about(vortex, at);
  return light;
}

Image<float> ArrayModel::intensity(const Image<std::uint8_t>&) {
  if (!fields_) {
    Eigen::MatrixXf screen;
    if (light_.scintillation) {
      screen = amplitude_screen(*light_.scintillation, pupil_line(), pupil_line());
    }
    fields_.emplace(
        config_, map(geometry_), *window_, grid_, [this](Vec2 at_um) { return incident(at_um); },
        screen);
  }
  Eigen::MatrixXf waves = aberration_waves_;
  for (const Eigen::MatrixXf* added : {&mirror_waves_, &turbulence_waves_}) {
    if (added->size() > 0) waves += *added;
  }
  return fields_->intensity(waves);
}

std::vector<Vec2> ArrayModel::true_spots_px(const Truth& truth) const {
  const double half = std::sqrt(0.5);
  Lattice lattice{config_.array.pitch_um, {}};
  for (const Vec2 centre : lenslet_centres(config_.array)) {
    if (double(beam_amplitude(centre)) >= half) lattice.subapertures.push_back({centre, {}});
  }
  std::vector<int> modes_j;
  Eigen::VectorXd waves(Eigen::Index(truth.aberration.size()));
  for (const Mode& mode : truth.aberration) {
    waves[Eigen::Index(modes_j.size())] = mode.waves;
    modes_j.push_back(mode.j);
  }
  SensorConfig pupil = config_.sensor;
  pupil.pupil_diameter_px = pupil_um(config_.array);
  // A slope of one wave per micrometre moves the spot by lambda f.
  const Eigen::VectorXd moved_um =
      slope_matrix(lattice, pupil, modes_j, pupil.charge == 0 ? kGradientTilt : kVortexTilt,
                   config_.optics.wavelength_nm * config_.optics.focal_length_mm) *
      waves;
  const CameraMap to_px = map(truth.geometry);
  std::vector<Vec2> spots;
  for (const Subaperture& s : lattice.subapertures) {
    const auto i = Eigen::Index(2 * spots.size());
    spots.push_back(to_px.pixel(s.centre_px + Vec2{moved_um[i], moved_um[i + 1]}));
  }
  return spots;
}

double ArrayModel::photons_per_peak_photon(const CameraGeometry& geometry) const {
  // As for the SLM: by Parseval, with S camera pixels per cycle per micrometre.
  const double round_um2 = std::numbers::pi * config_.array.pitch_um * config_.array.pitch_um / 4;
  const double scale = config_.optics.wavelength_nm * config_.optics.focal_length_mm *
                       map(geometry).scale / (kVortexPeak * round_um2);
  return scale * scale * lenslet_area(config_.array);
}

}  // namespace ovws::twin
