#include "daemon/ovws/study/sweep_sensor.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.hpp"
#include "core/optics/lattice.hpp"
#include "core/spots/position_fit.hpp"
#include "core/tracking/cell_centroid.hpp"
#include "core/tracking/patch.hpp"
#include "core/wavefront/residual_variance.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"

namespace ovws::study {
namespace {

int count_saturated(std::span<const SweepFrame> frames) {
  return int(std::ranges::count_if(
      frames, [](const SweepFrame& one) { return one.saturated_fraction > 0.0; }));
}

Result<void> check_reference(const ReferenceMeasured& measured) {
  const int charge = measured.with.charge;
  if (2 * measured.saturated_frames > measured.frames) {
    return fail(Errc::refused, "camera.exposure_us",
                fmt::format("at the reference's gain the spots of charge {} are saturated: lower "
                            "the exposure",
                            charge));
  }
  const auto lost =
      std::ranges::count_if(measured.positions_px, [](Vec2 at) { return std::isnan(at.x); });
  if (lost == 0) return {};
  return fail(Errc::refused, "camera.exposure_us",
              fmt::format("at the reference's gain {} finds {} of {} spots of charge {} in too few "
                          "frames: increase the exposure, or check the alignment",
                          to_json(measured.with.tracker).get<std::string>(), lost,
                          measured.positions_px.size(), charge));
}

}  // namespace

std::vector<Vec2> mean_positions(std::span<const SweepFrame> frames) {
  std::vector<Vec2> means(frames.empty() ? 0 : frames.front().spots.size());
  for (std::size_t i = 0; i < means.size(); ++i) {
    int found = 0;
    for (const SweepFrame& frame : frames) {
      const SpotFix& spot = frame.spots[i];
      if (!spot.found()) continue;
      means[i] = means[i] + Vec2{double(spot.x), double(spot.y)};
      ++found;
    }
    const bool counts = 2 * std::size_t(found) >= frames.size();
    means[i] = counts ? (1.0 / found) * means[i] : Vec2{NAN, NAN};
  }
  return means;
}

SpotLevels levels_of(std::span<const SweepFrame> frames) {
  std::vector<float> levels, noises;
  SpotLevels all{NAN, NAN, NAN};
  for (const SweepFrame& frame : frames) {
    for (const SpotFix& spot : frame.spots) {
      all.peak_dn = std::fmax(all.peak_dn, double(spot.peak));
      if (!spot.found()) continue;
      levels.push_back(spot.level);
      if (spot.noise > 0.0F) noises.push_back(spot.noise);
    }
  }
  if (!levels.empty()) all.level_dn = double(median(std::move(levels)));
  if (!noises.empty()) all.noise_dn = double(median(std::move(noises)));
  return all;
}

std::vector<CellMeasured::Frame> judge_frames(std::span<const SweepFrame> frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced) {
  Reconstructor::Scratch scratch = reconstructor.make_scratch();
  std::vector<float> waves(reconstructor.modes_j().size());
  std::vector<CellMeasured::Frame> judged;
  for (const SweepFrame& frame : frames) {
    CellMeasured::Frame one;
    one.saturated_fraction = frame.saturated_fraction;
    one.tracked = int(std::ranges::count_if(frame.spots, &SpotFix::found));
    one.variance_rad2 = NAN;
    if (reconstructor.solve(frame.spots, scratch, waves).determined) {
      one.coefficients.assign(waves.begin(), waves.end());
      one.variance_rad2 = residual_variance_rad2<float>(reconstructor.modes_j(), waves, introduced);
    }
    judged.push_back(std::move(one));
  }
  return judged;
}

Result<SweepSensor> SweepSensor::make(const SweepArm& arm, const Config& bench) {
  SensorConfig sensor = bench.sensor;
  sensor.charge = arm.charge;
  sensor.alternate_charge.reset();
  sensor.charges.clear();
  const SlmGeometry& slm = bench.slm.geometry;
  const auto lattice = make_lattice(sensor, slm);
  if (!lattice) return fail(lattice.error());
  const SpotModel spots{arm.charge, lambda_d_px(bench.optics, slm, sensor),
                        lit_pixels(bench.camera.settings.pixel_format, bench.optics.wavelength_nm)};
  const TrackingConfig tracking{arm.tracker.kind, bench.tracking.kernel_radius};
  const bool fits = arm.tracker.kind == TrackerKind::fit;
  auto tracker = fits ? make_position_fit(spots) : make_tracker(tracking, spots);
  if (!tracker) return fail(tracker.error());
  const std::vector<double> tilts(
      lattice->subapertures.size(),
      fits ? position_fit_tilt_radius(arm.charge) : tilt_radius(arm.charge, tracking));
  SweepSensor made;
  made.arm_ = arm;
  made.tracker_ = std::move(*tracker);
  made.scratch_ = made.tracker_->make_scratch();
  made.model_ = slope_operator(*lattice, sensor, tilts, px_per_cycle(bench.optics, slm));
  return made;
}

/// A lost spot is as bright as the pixels where it should be; if that is not known, as the image.
std::vector<SweepFrame> SweepSensor::find(std::span<const ImageView> images,
                                          std::span<const Vec2> starts_px) {
  constexpr int kLookPx = 12;
  const int half_px = cells_px_.empty() ? 0 : cell_half_px(cells_px_);
  std::vector<SweepFrame> frames;
  for (const ImageView& image : images) {
    SweepFrame& frame = frames.emplace_back();
    int saturated = 0;
    for (std::size_t i = 0; i < starts_px.size(); ++i) {
      const bool known = !std::isnan(starts_px[i].x);
      SpotFix spot;
      if (known) spot = tracker_->track(image, starts_px[i], scratch_);
      if (!spot.found()) {
        spot.peak = known ? brightest_pixel(image, starts_px[i], kLookPx)
                          : brightest_pixel(image, {}, std::max(image.width, image.height));
      }
      saturated += double(spot.peak) >= full_scale_dn(image.format) ? 1 : 0;
      if (!cells_px_.empty()) {
        const Vec2 at = cell_centroid(image, cells_px_[i], half_px).value_or(Vec2{NAN, NAN});
        spot.x = float(at.x);
        spot.y = float(at.y);
      }
      frame.spots.push_back(spot);
    }
    frame.saturated_fraction =
        double(saturated) / double(std::max<std::size_t>(1, starts_px.size()));
  }
  return frames;
}

Result<ReferenceMeasured> SweepSensor::take_reference(std::span<const ImageView> images,
                                                      std::span<const Vec2> starts_px) {
  if (model_.slopes.rows() != Eigen::Index(2 * starts_px.size())) {
    return fail(Errc::refused, "", "the sensor was changed meanwhile: run the study again");
  }
  std::vector<SweepFrame> frames = find(images, starts_px);
  ReferenceMeasured measured;
  measured.with = arm_;
  measured.frames = int(frames.size());
  measured.saturated_frames = count_saturated(frames);
  measured.levels = levels_of(frames);
  measured.positions_px = mean_positions(frames);
  if (auto usable = check_reference(measured); !usable) return fail(usable.error());
  if (arm_.tracker.fixed_cell) {
    cells_px_ = measured.cells_px = measured.positions_px;
    frames = find(images, starts_px);
    measured.positions_px = mean_positions(frames);
    if (auto usable = check_reference(measured); !usable) return fail(usable.error());
  }
  reconstructor_.emplace(model_.slopes, model_.modes_j, measured.positions_px);
  return measured;
}

void SweepSensor::measure(std::span<const ImageView> images, std::span<const Vec2> starts_px,
                          const std::vector<Mode>& introduced, CellMeasured& cell) {
  const std::vector<SweepFrame> frames = find(images, starts_px);
  cell.with = arm_;
  cell.subapertures = int(starts_px.size());
  cell.modes_j = model_.modes_j;
  cell.frames = judge_frames(frames, *reconstructor_, introduced);
  cell.levels = levels_of(frames);
}

}  // namespace ovws::study
