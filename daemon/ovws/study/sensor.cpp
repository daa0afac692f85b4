#include "daemon/ovws/study/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/optics/detector.hpp"
#include "core/spots/position_fit.hpp"
#include "core/tracking/cell_centroid.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws::study {
namespace {

/// The factor that scales the model's image to kPeakE in the spots' brightest pixel.
double to_peak(const SensorModel& model, const Image<float>& intensity,
               std::span<const Mode> modes) {
  return kPeakE / model.peak_of_spots(intensity, modes);
}

}  // namespace

std::vector<int> first_modes_j(int count) {
  std::vector<int> modes_j(static_cast<std::size_t>(count));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  return modes_j;
}

std::vector<double> waves_of(std::span<const Mode> modes, const std::vector<int>& modes_j) {
  std::vector<double> waves(modes_j.size(), 0.0);
  for (const Mode& mode : modes) {
    const auto at = std::ranges::find(modes_j, mode.j);
    if (at != modes_j.end()) waves[std::size_t(at - modes_j.begin())] += mode.waves;
  }
  return waves;
}

Geometry default_bench() {
  return {};
}

Geometry thousand_px_bench() {
  Geometry geometry;
  geometry.slm.height_px = 1024;
  geometry.sensor.pupil_diameter_px = 1000.0;
  return geometry;
}

double snr_of_read_noise(double read_noise_e) {
  return kPeakE / std::sqrt(kPeakE + read_noise_e * read_noise_e);
}

double read_noise_of_snr(double snr) {
  return std::sqrt(std::max(0.0, kPeakE * kPeakE / (snr * snr) - kPeakE));
}

std::string name_of(Light light) {
  return nlohmann::json(light).get<std::string>();
}

const char* suffix_of(Light light) {
  return light == Light::equal_peak ? "" : "-photons";
}

Exposure Exposure::clipped() const {
  Exposure out = *this;
  const int black = int(std::lround(black_dn));
  for (std::uint16_t& pixel : out.dn.pixels) pixel = std::uint16_t(std::max(0, int(pixel) - black));
  out.black_dn = 0.0;
  return out;
}

Exposure noise_free(const Image<float>& electrons) {
  Exposure exposure;
  exposure.dn_per_e = 20.0;  // finer than expose(); the brighter spots at equal photons still fit
  exposure.dn = Image<std::uint16_t>(electrons.width, electrons.height);
  std::transform(electrons.pixels.begin(), electrons.pixels.end(), exposure.dn.pixels.begin(),
                 [&](float e) {
                   const double dn = std::min(65535.0, double(e) * exposure.dn_per_e);
                   return std::uint16_t(std::lround(dn));
                 });
  return exposure;
}

Exposure expose(const Image<float>& electrons, double read_noise_e, std::uint64_t seed) {
  constexpr int kBits = 16;
  Exposure exposure;
  DetectorConfig config;
  config.quantum_efficiency = 1.0;
  config.prnu = 0.0;
  config.dark_current_e_per_s = 0.0;
  config.read_noise_e = read_noise_e;
  config.bits = kBits;
  config.full_well_e = ((1 << kBits) - 1) / exposure.dn_per_e;
  config.black_level_dn = std::round(4.0 * read_noise_e * exposure.dn_per_e);
  config.seed = seed;
  exposure.black_dn = config.black_level_dn;
  Detector(config, electrons.width, electrons.height).expose(electrons, 1.0, 0.0, exposure.dn);
  return exposure;
}

std::vector<SpotFix> cell_centroids(const Exposure& exposure, std::span<const Vec2> centres_px,
                                    int half_px) {
  const Exposure clipped = exposure.clipped();
  std::vector<SpotFix> fixes(centres_px.size());
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const auto centroid = cell_centroid(clipped.view(), centres_px[i], half_px);
    if (!centroid) continue;
    fixes[i].x = float(centroid->x);
    fixes[i].y = float(centroid->y);
  }
  return fixes;
}

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  for (const TrackerKind kind : {TrackerKind::lg, TrackerKind::fit}) {
    methods.push_back({"vortex, " + std::string(tracker_name(kind)), 1, {kind}});
  }
  methods.push_back({"Shack-Hartmann, centroid of a fixed cell", 0, {TrackerKind::centroid}, true});
  for (const TrackerKind kind : {TrackerKind::centroid, TrackerKind::thresholded,
                                 TrackerKind::weighted, TrackerKind::lg, TrackerKind::fit}) {
    methods.push_back({"Shack-Hartmann, " + std::string(tracker_name(kind)), 0, {kind}});
  }
  return methods;
}

std::shared_ptr<SensorModel> model_of(Geometry geometry, int charge) {
  geometry.sensor.charge = charge;
  return std::make_shared<SensorModel>(value_of(
      SensorModel::make(geometry.sensor, geometry.slm, geometry.optics, kImagePx, kImagePx)));
}

Image<float> SensorPair::electrons(int charge, std::span<const Mode> modes, Light light) const {
  Image<float> image = value_of(of(charge)->intensity(modes));
  // Same laser and exposure: each subaperture sends the same number of photons for both charges.
  const bool as_vortex = light == Light::equal_photons && charge == 0;
  scale(image, as_vortex ? to_peak(*vortex_, value_of(vortex_->intensity(modes)), modes)
                         : to_peak(*of(charge), image, modes));
  return image;
}

Measurer::Measurer(const Geometry& geometry, const Method& method,
                   std::shared_ptr<SensorModel> model)
    : method_(method), model_(std::move(model)) {
  const SpotModel spots{method.charge, model_->lambda_d_px()};
  tracker_ = value_of(make_tracker(method.tracking, spots));
  if (method.tracking.tracker == TrackerKind::fit)
    position_fit_ = value_of(make_position_fit(spots));
  SensorConfig sensor = geometry.sensor;
  sensor.charge = method.charge;
  const std::vector<int> modes_j =
      first_modes_j(optimal_mode_count(geometry.sensor.subapertures_across));
  slopes_ = slope_matrix(model_->lattice(), sensor, modes_j,
                         tilt_radius(method.charge, method.tracking), model_->px_per_cycle());
  Image<float> flat = value_of(model_->intensity({}));
  scale(flat, to_peak(*model_, flat, {}));
  reference_px_ = model_->spots_px();
  cell_half_px_ = cell_half_px(reference_px_);
  reference_px_ = noise_free_px(flat, model_->spots_px());
  reconstructor_ = std::make_unique<Reconstructor>(slopes_, modes_j, reference_px_);
}

std::vector<SpotFix> Measurer::track(const Exposure& exposure,
                                     std::span<const Vec2> starts_px) const {
  if (method_.fixed_cell) return cell_centroids(exposure, reference_px_, cell_half_px_);
  const bool plain = method_.tracking.tracker == TrackerKind::centroid;
  const Exposure given = plain ? exposure.clipped() : exposure;
  const SpotTracker& tracker = position_fit_ ? *position_fit_ : *tracker_;
  TrackScratch scratch = tracker.make_scratch();
  std::vector<SpotFix> fixes;
  for (const Vec2 start : starts_px) fixes.push_back(tracker.track(given.view(), start, scratch));
  return fixes;
}

std::vector<double> Measurer::modes(std::span<const SpotFix> spots) const {
  Reconstructor::Scratch scratch = reconstructor_->make_scratch();
  std::vector<float> found(modes_j().size());
  reconstructor_->solve(spots, scratch, found);
  return {found.begin(), found.end()};
}

std::vector<Vec2> Measurer::noise_free_px(const Image<float>& intensity,
                                          std::span<const Vec2> near_px) const {
  const Exposure exposure = noise_free(intensity);
  std::vector<Vec2> found;
  for (const SpotFix& fix : track(exposure, near_px)) found.push_back({fix.x, fix.y});
  return found;
}

std::vector<Vec2> Measurer::predicted_px(std::span<const Mode> modes) const {
  const std::vector<double> waves = waves_of(modes, modes_j());
  const Eigen::VectorXd moved =
      slopes_ * Eigen::Map<const Eigen::VectorXd>(waves.data(), slopes_.cols());
  std::vector<Vec2> out = reference_px_;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = out[i] + Vec2{moved[Eigen::Index(2 * i)], moved[Eigen::Index(2 * i + 1)]};
  }
  return out;
}

}  // namespace ovws::study
