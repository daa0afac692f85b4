#include "daemon/ovwsd/procedures/pokes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr double kMaxStep = 0.01;     // lambda/d, motion between two measurements, beyond noise
constexpr double kMaxChange = 0.02;   // of a mode's response between two measurements, beyond noise
constexpr double kNoiseFactor = 4.0;  // standard errors that count as noise
constexpr int kMaxTries = 4;          // repetitions of a poke until two are the same
constexpr int kMinFrames = 2;
constexpr int kMaxHalvings = 2;  // of the poke amplitude
// Least share of its light at rest that a found spot keeps, relative to the best spot's share.
constexpr double kMinLevel = 0.25;

std::vector<Mode> with_poke(std::vector<Mode> shown, int j, double waves) {
  add_mode(shown, {j, waves});
  return shown;
}

SpotMeans means_of(const SpotAverage& average) {
  return {found_positions(average), average.standard_error_px};
}

/// Mean intensity of the spots' lit binned pixels above each window's darkest one, DN.
double intensity_of(const SpotCells& cells, std::span<const SpotWindow> windows) {
  double sum = 0.0;
  int known = 0;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const auto all = cells.col(Eigen::Index(i));
    if (!all.allFinite()) continue;
    std::vector<float> lit;
    for (Eigen::Index c = 0; c < all.size(); ++c) {
      if (windows[i].is_lit(c)) lit.push_back(all(c));
    }
    const Eigen::Map<const Eigen::VectorXf> values(lit.data(), Eigen::Index(lit.size()));
    sum += double(values.mean() - values.minCoeff());
    ++known;
  }
  return known > 0 ? sum / known : 0.0;
}

/// Uniform pixel noise of average size, so that positions agree with displacement_operator at any
/// intensity.
PixelNoise even(const PixelNoise& noise, double mean_dn) {
  return {noise.constant_dn2 + noise.per_dn * mean_dn, 0.0};
}

/// Motion of the bench between two measurements of a poke, camera pixels RMS beyond noise.
double step_px(const Poke& first, const Poke& second) {
  const SpotDrift plus = drift_between(first.places.plus, second.places.plus);
  const SpotDrift minus = drift_between(first.places.minus, second.places.minus);
  return std::max(plus.rms_px - kNoiseFactor * plus.noise_px,
                  minus.rms_px - kNoiseFactor * minus.noise_px);
}

/// Relative change of a mode's response from one measurement of a poke to the next, beyond noise.
/// Shows what is small beside a motion of the bench, but not beside a weak poke: a frame of the
/// hologram before.
double response_change(const PushPull& first, const PushPull& second) {
  double changes = 0.0, squares = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < first.plus.at_px.size(); ++i) {
    const Vec2 one = first.plus.at_px[i] - first.minus.at_px[i];
    const Vec2 other = second.plus.at_px[i] - second.minus.at_px[i];
    const Vec2 mean = 0.5 * (one + other), change = other - one;
    if (std::isnan(mean.x)) continue;
    changes += mean.x * change.x + mean.y * change.y;
    squares += mean.x * mean.x + mean.y * mean.y;
    for (const SpotMeans* part : {&first.plus, &first.minus, &second.plus, &second.minus}) {
      const Vec2& error = part->standard_error_px[i];
      variance += std::pow(mean.x * error.x, 2) + std::pow(mean.y * error.y, 2);
    }
  }
  if (squares == 0.0) return 0.0;
  return (std::abs(changes) - kNoiseFactor * std::sqrt(variance)) / squares;
}

Poke mean_of_both(const Poke& first, const Poke& second) {
  return {{first.places.j, first.places.amplitude_waves,
           mean_of_both(first.places.plus, second.places.plus),
           mean_of_both(first.places.minus, second.places.minus)},
          {first.cells.amplitude_waves, 0.5F * (first.cells.plus + second.cells.plus),
           0.5F * (first.cells.minus + second.cells.minus)}};
}

struct RestingPlaces {
  std::vector<Vec2> found_px;     ///< NaN: lost
  std::vector<Vec2> expected_px;  ///< also of lost spots
};

/// Spot positions of the reference; without a reference, those found in frames, and those of the
/// model.
Result<RestingPlaces> places_of_spots(Bench& bench, int frames) {
  const SlmGeometry& slm = bench.geometry();
  const SensorView sensor = bench.sensor();
  if (sensor->reference) {
    return RestingPlaces{known_positions(*sensor->reference), sensor->reference->positions_px};
  }
  const auto lattice = make_lattice(sensor->sensor, slm);
  if (!lattice) return fail(lattice.error());
  const auto average = bench.spots(frames);
  if (!average) return fail(average.error());
  const Roi roi = bench.camera().settings.roi;
  return RestingPlaces{
      means_of(*average).at_px,
      model_spots_px(*lattice, sensor->sensor, slm, sensor->optics, roi.width, roi.height)};
}

}  // namespace

Result<SpotMeter> SpotMeter::of_images(Bench& bench, int frames) {
  const SensorView sensor = bench.sensor();
  SpotMeter meter;
  meter.format_ = bench.camera().settings.pixel_format;
  std::array<Image<float>, 2> pictures;
  for (Image<float>& picture : pictures) {
    auto mean = bench.picture(frames);
    if (!mean) return fail(mean.error());
    picture = std::move(*mean);
  }
  const int cols = pictures[0].width, rows = pictures[0].height;
  const SpotWindow window =
      window_of(lambda_d_px(sensor->optics, bench.geometry(), sensor->sensor),
                window_half_width(int(sensor->modes_j.size()), sensor->sensor.subapertures_across),
                lit_pixels(meter.format_, sensor->optics.wavelength_nm));
  if (window.width_px() > std::min(cols, rows)) {
    return fail(Errc::refused, "camera.roi", "is smaller than the window around a spot");
  }
  const auto places = places_of_spots(bench, frames);
  if (!places) return fail(places.error());
  for (std::size_t i = 0; i < places->found_px.size(); ++i) {
    const bool is_lost = std::isnan(places->found_px[i].x);
    if (is_lost) meter.lost_.push_back(Eigen::Index(i));
    meter.places_px_.push_back((is_lost ? places->expected_px : places->found_px)[i]);
    meter.windows_.push_back(moved_to(meter.places_px_.back(), window, cols, rows));
  }
  const SpotCells resting = 0.5F * (meter.cells_of(pictures[0]) + meter.cells_of(pictures[1]));
  meter.resting_ = measured_spots(meter.windows_, meter.places_px_, resting, {});
  const auto first = in_16_bits(pictures[0], meter.format_),
             second = in_16_bits(pictures[1], meter.format_);
  const std::array views{view_of(first, PixelFormat::mono16), view_of(second, PixelFormat::mono16)};
  const double mean_intensity =
      to_16_bits(meter.format_) * intensity_of(resting, meter.windows_) / (window.bin * window.bin);
  meter.noise_ = even(noise_of(views, meter.resting_), mean_intensity);
  return meter;
}

SpotCells SpotMeter::cells_of(const Image<float>& mean_dn) const {
  SpotCells cells = cells_in(mean_dn, windows_);
  for (const Eigen::Index i : lost_) cells.col(i).setConstant(NAN);
  return cells;
}

Result<ShownSpots> SpotMeter::measure(Bench& bench, int frames) const {
  if (uses_images()) {
    const auto picture = bench.picture(frames);
    if (!picture) return fail(picture.error());
    return measured_in(*picture);
  }
  const auto average = bench.spots(frames);
  if (!average) return fail(average.error());
  return ShownSpots{means_of(*average), {}};
}

ShownSpots SpotMeter::measured_in(const Image<float>& mean_dn) const {
  const auto image = in_16_bits(mean_dn, format_);
  const SpotPass pass = fit_spots(view_of(image, PixelFormat::mono16), resting_, noise_, 2);
  ShownSpots shown{{}, cells_of(mean_dn)};
  const std::vector<double> levels_dn = pass.levels_dn();
  const double brightest = *std::max_element(levels_dn.begin(), levels_dn.end());
  for (std::size_t i = 0; i < pass.found.size(); ++i) {
    const SpotEstimates& found = pass.found[i];
    const double pixels = windows_[i].bin * windows_[i].bin;
    const bool lit = levels_dn[i] > kMinLevel * brightest;
    const double error_px = pass.templates[i].px_error / (levels_dn[i] * pixels);
    shown.places.at_px.push_back(lit ? Vec2{double(found.x), double(found.y)} : Vec2{NAN, NAN});
    shown.places.standard_error_px.push_back({error_px, error_px});
  }
  return shown;
}

Pokes::Pokes(Bench& bench, SpotMeter meter, int frames, double lambda_d_px)
    : bench_(bench),
      meter_(std::move(meter)),
      aberration_(bench.sensor()->aberration),
      frames_(frames),
      max_step_px_(kMaxStep * lambda_d_px) {}

Result<ShownSpots> Pokes::rest() {
  return shown(aberration_, frames_);
}

Result<ShownSpots> Pokes::shown(const std::vector<Mode>& aberration, int frames) {
  if (auto shown = bench_.show(aberration); !shown) return fail(shown.error());
  return meter_.measure(bench_, frames);
}

Result<Poke> Pokes::once(int j, double amplitude_waves) {
  const int frames = std::max(kMinFrames, (frames_ + 1) / 2);
  auto plus = shown(with_poke(aberration_, j, amplitude_waves), frames);
  if (!plus) return fail(plus.error());
  auto minus = shown(with_poke(aberration_, j, -amplitude_waves), frames);
  if (!minus) return fail(minus.error());
  return Poke{{j, amplitude_waves, std::move(plus->places), std::move(minus->places)},
              {amplitude_waves, std::move(plus->cells), std::move(minus->cells)}};
}

/// Repeats a poke until two successive measurements agree, and returns their mean: motion of the
/// bench during a poke would add to the derivative, and a frame of the hologram before would change
/// it. If none agree, those that agree best are used, unless the bench has moved.
Result<Poke> Pokes::twice(int j, double amplitude_waves) {
  auto last = once(j, amplitude_waves);
  std::optional<Poke> best;
  double step = 0.0, least_change = std::numeric_limits<double>::infinity();
  for (int tries = 0; last && tries < kMaxTries && least_change > kMaxChange; ++tries) {
    auto next = once(j, amplitude_waves);
    if (!next) return next;
    step = step_px(*last, *next);
    const double change = response_change(last->places, next->places);
    if (step <= max_step_px_ && change < least_change) {
      best = mean_of_both(*last, *next);
      best->is_steady = change <= kMaxChange;
      least_change = change;
    }
    last = std::move(next);
  }
  if (best) return std::move(*best);
  if (!last) return last;
  return fail(
      Errc::refused, "",
      fmt::format("the bench moves: the spots of mode j = {} moved by {:.2f} px RMS from one "
                  "measurement to the next, {} times in a row (limit {:.2f} px): let it "
                  "settle, and measure again, or average more frames (frames)",
                  j, step, kMaxTries, max_step_px_));
}

Result<Poked> Pokes::unless_refused(int j, double amplitude_waves) {
  auto poke = twice(j, amplitude_waves);
  if (poke) return Poked{std::move(*poke), ""};
  const Error& why = poke.error();
  if (why.code != Errc::invalid || why.field != "modes") return fail(why);
  return Poked{std::nullopt, "the SLM cannot show it: " + why.reason};
}

Result<Poked> Pokes::poke(int j, double amplitude_waves, const SpotMeans& resting) {
  Result<Poked> poked = fail(Errc::refused, "", "");
  for (int halvings = 0; halvings <= kMaxHalvings; ++halvings) {
    poked = unless_refused(j, std::ldexp(amplitude_waves, -halvings));
    if (!poked || (poked->poke && lost_by(poked->poke->places, resting).empty())) return poked;
  }
  return poked;
}

}  // namespace ovws
