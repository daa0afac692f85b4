#include "daemon/ovwsd/procedures/gain_sweep.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/spots/position_fit.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/procedures/sweep_frames.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/origin.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using Places = std::vector<Vec2>;

constexpr int kMaxFramesToFind = 20;                // search runs at least every 16th frame
constexpr std::size_t kMaxImagePixels = 9'000'000;  // keeps a reply with the image below 16 MiB
constexpr double kExposureTolerance = 1e-3;  // relative: a reopened camera may round differently

bool is_same(const std::string& name, const json& before, const json& now) {
  if (name == "camera" && now.is_null()) return true;
  if (name == "exposure_us" && before.is_number() && now.is_number()) {
    const double was_us = before.get<double>();
    return std::abs(now.get<double>() - was_us) <= kExposureTolerance * was_us;
  }
  return before == now;
}

SensorSet sensor_of(const SweepArm& arm) {
  SensorSet set;
  set.put(&SensorConfig::charge, arm.charge);
  set.put(&SensorConfig::alternate_charge, std::optional<int>());
  set.put(&SensorConfig::charges, std::vector<int>());
  set.put(&TrackingSettings::tracker, arm.tracker.kind);
  set.put(&TrackingSettings::mode_operator, OperatorKind::slopes);
  set.put(&TrackingSettings::mode_count, std::optional<int>());
  return set;
}

int count_saturated(const std::vector<SeriesFrame>& frames) {
  return int(std::count_if(frames.begin(), frames.end(),
                           [](const SeriesFrame& f) { return f.saturated_fraction > 0.0F; }));
}

Result<Reconstructor> reconstructor_of(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                       const std::vector<Vec2>& reference_px) {
  const auto lattice = make_lattice(sensor.sensor, slm);
  if (!lattice) return fail(lattice.error());
  if (lattice->subapertures.size() != reference_px.size()) {
    return fail(
        Errc::internal, "",
        "the sweep's reference belongs to another lattice: repeat the sweep with \"anew\": true");
  }
  const int charge = sensor.sensor.charge;
  const double tilt = sensor.tracking.tracker == TrackerKind::fit
                          ? position_fit_tilt_radius(charge)
                          : tilt_radius(charge, sensor.tracking);
  const std::vector<double> tilts(reference_px.size(), tilt);
  const ModeOperator model =
      slope_operator(*lattice, sensor.sensor, tilts, px_per_cycle(sensor.optics, slm));
  return Reconstructor(model.slopes, model.modes_j, reference_px);
}

Result<double> set_gain(Bench& bench, double gain_db) {
  const double now_db = bench.camera().settings.gain_db;
  return now_db == gain_db ? Result<double>(now_db) : bench.set_gain(gain_db);
}

std::ptrdiff_t count_lost(const Places& places) {
  return std::count_if(places.begin(), places.end(), [](Vec2 p) { return std::isnan(p.x); });
}

Result<void> check_reference(const SweepArm& arm, const ReferenceMeasured& measured) {
  if (2 * measured.saturated_frames > measured.frames) {
    return fail(Errc::refused, "camera.exposure_us",
                fmt::format("at the reference's gain of {} dB the spots of charge {} are "
                            "saturated: lower the exposure",
                            measured.gain_db, arm.charge));
  }
  const auto lost = count_lost(measured.positions_px);
  if (lost == 0) return {};
  return fail(
      Errc::refused, "camera.exposure_us",
      fmt::format("at the reference's gain of {} dB {} finds {} of {} spots of charge {} in "
                  "too few frames: increase the exposure, or check the alignment",
                  measured.gain_db, to_json(arm.tracker).get<std::string>(), lost,
                  measured.positions_px.size(), arm.charge));
}

/// Takes one image, reduced to 8 bits. None: the image is too large for a reply.
Result<std::optional<CellMeasured::Picture>> take_image(Bench& bench) {
  const auto seen = bench.picture(1);
  if (!seen) return fail(seen.error());
  if (seen->pixels.size() > kMaxImagePixels) return std::nullopt;
  const int shift = significant_bits(bench.camera().settings.pixel_format) - 8;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(seen->pixels.size());
  for (const float dn : seen->pixels) {
    bytes.push_back(std::isnan(dn) ? 255 : std::uint8_t(std::ldexp(dn, -shift)));
  }
  return CellMeasured::Picture{seen->width, seen->height,
                               base64_of(std::span<const std::uint8_t>(bytes))};
}

/// Whether to store an image: at the requested gains, for the first aberration and the first arm of
/// each charge.
bool wants_image(const GainSweep& sweep, const GainSweep::Cell& at) {
  const auto first = std::find_if(sweep.arms.begin(), sweep.arms.end(), [&](const SweepArm& arm) {
    return arm.charge == sweep.arms[at.arm].charge;
  });
  const auto& gains = sweep.picture_gains_db;
  return at.aberration == 0 && first == sweep.arms.begin() + std::ptrdiff_t(at.arm) &&
         std::find(gains.begin(), gains.end(), sweep.gains_db[at.gain]) != gains.end();
}

class Sweep {
 public:
  Sweep(Bench& bench, const SlmGeometry& slm, const ExperimentRun& run, ExperimentArchive& archive)
      : bench_(bench), slm_(slm), run_(run), sweep_(run.request), archive_(archive) {}

  /// Errc::refused: the bench settings differ from the bench settings of the run.
  Result<void> check_bench() const;
  /// Errc::refused: the spots of the first arm with a reference have moved since it was taken.
  Result<void> check_table();
  Result<void> measure_reference(int arm);
  Result<void> measure_cell(int number);

 private:
  Result<Places> find_spots();
  Result<Places> find_spots_at(double gain_db);
  Result<std::vector<SeriesFrame>> series(const SweepArm& arm, int frames, FromPixels from = {});
  Result<std::vector<SeriesFrame>> reference_series(const SweepArm& arm);
  Bench& bench_;
  const SlmGeometry& slm_;
  const ExperimentRun& run_;
  const GainSweep& sweep_;
  ExperimentArchive& archive_;
};

Result<void> Sweep::check_bench() const {
  return check_same_bench(run_.bench,
                          sweep_bench(*bench_.sensor(), bench_.camera(), run_.bench["optics"]));
}

/// Waits until all spots are found, for kMaxFramesToFind frames at most. NaN: the spot is lost. The
/// frame path searches for spots lost at the previous gain only every few frames. Frames before the
/// search would still show the effect of the previous gain.
Result<Places> Sweep::find_spots() {
  Places found;
  for (int k = 0; k < kMaxFramesToFind && (k == 0 || count_lost(found) > 0); ++k) {
    const auto frame = bench_.series(1);
    if (!frame) return fail(frame.error());
    found.clear();
    for (const SpotFix& spot : frame->front().spots) found.push_back({spot.x, spot.y});
  }
  return found;
}

/// Finds the sensor's spots at the gain `gain_db`, then restores the previous gain.
Result<Places> Sweep::find_spots_at(double gain_db) {
  const double before_db = bench_.camera().settings.gain_db;
  if (auto set = set_gain(bench_, gain_db); !set) return fail(set.error());
  const auto found = find_spots();
  if (auto set = set_gain(bench_, before_db); !set) return fail(set.error());
  return found;
}

/// Records a series of frames. During a job the frame path measures spot positions; for the tracker
/// `fit` the positions are then measured again from all pixels.
Result<std::vector<SeriesFrame>> Sweep::series(const SweepArm& arm, int frames, FromPixels from) {
  if (arm.tracker.kind == TrackerKind::fit) {
    const SensorView now = bench_.sensor();
    auto tracker = make_position_fit(
        spot_model(now->sensor, now->optics, slm_, bench_.camera().settings.pixel_format));
    if (!tracker) return fail(tracker.error());
    from.tracker = std::move(*tracker);
  }
  return bench_.series(frames, std::move(from));
}

/// Frames without an aberration at the reference's gain, measured with the arm's tracker.
Result<std::vector<SeriesFrame>> Sweep::reference_series(const SweepArm& arm) {
  if (auto shown = bench_.show(sensor_of(arm), {}); !shown) return fail(shown.error());
  if (auto set = set_gain(bench_, sweep_.reference_gain_db); !set) return fail(set.error());
  if (auto found = find_spots(); !found) return fail(found.error());
  return series(arm, sweep_.reference_frames);
}

/// Compares the tracker's positions even if the arm uses fixed windows: the centroid in a fixed
/// window follows only part of a spot's motion.
Result<void> Sweep::check_table() {
  for (int arm = 0; arm < int(sweep_.arms.size()); ++arm) {
    const SweepArm& with = sweep_.arms[std::size_t(arm)];
    const json reference = archive_.reference(arm);
    const auto before_px =
        reference_places(reference, arm, with.tracker.fixed_cell ? "cells_px" : "positions_px");
    if (!before_px) continue;
    const auto frames = reference_series(with);
    if (!frames) return fail(frames.error());
    const SensorView now = bench_.sensor();
    return check_unmoved(
        spot_motion(*before_px, reference.value("frames", 1), *frames),
        kMaxMotion * lambda_d_px(now->optics, slm_, now->sensor),
        fmt::format("charge {}, {}", with.charge, to_json(with.tracker).get<std::string>()));
  }
  return {};
}

Result<void> Sweep::measure_reference(int arm) {
  if (reference_places(archive_.reference(arm), arm)) return {};
  const SweepArm& with = sweep_.arms[std::size_t(arm)];
  ReferenceMeasured measured;
  measured.arm = arm;
  measured.with = with;
  measured.t_begun_ns = utc_ns();
  auto frames = reference_series(with);
  if (frames && with.tracker.fixed_cell) {
    measured.cells_px = mean_positions(*frames);
    if (count_lost(measured.cells_px) == 0) {
      frames = series(with, sweep_.reference_frames, {.windows_px = measured.cells_px});
    }
  }
  if (!frames) return fail(frames.error());
  measured.gain_db = bench_.camera().settings.gain_db;
  measured.frames = int(frames->size());
  measured.saturated_frames = count_saturated(*frames);
  measured.levels = levels_of(*frames);
  measured.positions_px = mean_positions(*frames);
  if (auto usable = check_reference(with, measured); !usable) return usable;
  if (auto same = check_bench(); !same) return same;
  archive_.put_reference(arm, to_json(measured), bench_.stop());
  return {};
}

Result<void> Sweep::measure_cell(int number) {
  if (archive_.has_cell(number)) return {};
  const GainSweep::Cell at = sweep_.cell(std::size_t(number));
  const std::vector<Mode>& introduced = sweep_.aberrations[at.aberration].modes;
  CellMeasured cell;
  cell.cell = number;
  cell.at = at;
  cell.with = sweep_.arms[at.arm];
  cell.t_begun_ns = utc_ns();
  if (auto shown = bench_.show(sensor_of(sweep_.arms[at.arm]), introduced); !shown) return shown;
  const auto gain_db = set_gain(bench_, sweep_.gains_db[at.gain]);
  if (!gain_db) return fail(gain_db.error());
  const json reference = archive_.reference(int(at.arm));
  FromPixels from;
  if (cell.with.tracker.fixed_cell) {
    from.windows_px = reference_places(reference, int(at.arm), "cells_px").value_or(Places{});
  } else {
    auto found = find_spots();
    if (found && count_lost(*found) > 0 && cell.with.tracker.kind == TrackerKind::fit) {
      // The frame path loses spots with saturated tops, which `fit` can still measure.
      found = find_spots_at(sweep_.reference_gain_db);
    }
    if (!found) return fail(found.error());
    from.starts_px = std::move(*found);
  }
  const auto frames = series(cell.with, sweep_.frames, std::move(from));
  if (!frames) return fail(frames.error());
  if (wants_image(sweep_, at)) {
    auto picture = take_image(bench_);
    if (!picture) return fail(picture.error());
    cell.picture = std::move(*picture);
  }
  const auto positions = reference_places(reference, int(at.arm));
  const auto reconstructor = reconstructor_of(*bench_.sensor(), slm_, positions.value_or(Places{}));
  if (!reconstructor) return fail(reconstructor.error());
  const CameraSettings camera = bench_.camera().settings;
  cell.gain_db = *gain_db;
  cell.exposure_us = camera.exposure_us;
  cell.frame_rate_hz = camera.frame_rate_hz;
  cell.subapertures = bench_.sensor()->subapertures;
  cell.modes_j = reconstructor->modes_j();
  cell.frames = judge_frames(*frames, *reconstructor, introduced);
  cell.levels = levels_of(*frames);
  if (auto same = check_bench(); !same) return same;
  archive_.put_cell(number, to_json(CellReport{CellSummary(std::move(cell))}), bench_.stop());
  return {};
}

/// Order of the cells: arms in alternating direction from gain to gain. A slow drift of the bench
/// then favours no arm, and the charge changes only once for each gain.
std::vector<int> order_of(const GainSweep& sweep) {
  std::vector<int> order;
  const int arms = int(sweep.arms.size());
  for (int row = 0; row < int(sweep.cells()) / arms; ++row) {
    for (int k = 0; k < arms; ++k) order.push_back(row * arms + (row % 2 == 0 ? k : arms - 1 - k));
  }
  return order;
}

}  // namespace

json sweep_bench(const SensorSnapshot& sensor, const CameraSnapshot& camera, json optics) {
  SweepBench bench;
  bench.program = OVWS_VERSION;
  if (camera.connected) bench.camera = camera_name(camera.info);
  bench.settings = camera.settings;
  bench.sensor.json = to_json(sensor.sensor);
  bench.sensor.json.erase("charge");
  bench.kernel_radius = sensor.tracking.kernel_radius;
  bench.optics.json = std::move(optics);
  bench.slm.json = sensor.slm->identity;
  if (sensor.registration) bench.registration_t_taken_ns = sensor.registration->t_taken_ns;
  bench.correction = sensor.correction;
  return to_json(bench);
}

Result<void> check_same_bench(const json& before, const json& now) {
  std::string changed;
  for (const auto& [name, value] : now.items()) {
    if (is_same(name, before.value(name, json()), value)) continue;
    changed += (changed.empty() ? "" : ", ") + name;
  }
  if (changed.empty()) return {};
  return fail(Errc::refused, "",
              "the bench has changed since the sweep began: " + changed +
                  "; restore it and call again to continue, or call again for a new sweep");
}

Result<void> measure_gain_sweep(Bench& bench, const SlmGeometry& slm, const ExperimentRun& run,
                                ExperimentArchive& archive) {
  Sweep sweep(bench, slm, run, archive);
  if (auto same = sweep.check_bench(); !same) return same;
  if (auto opened = archive.open(run.anew, bench.stop()); !opened) return opened;
  const std::vector<int> order = order_of(run.request);
  const bool complete =
      std::all_of(order.begin(), order.end(), [&](int cell) { return archive.has_cell(cell); });
  if (complete) return {};
  if (auto unmoved = sweep.check_table(); !unmoved) return unmoved;
  for (int arm = 0; arm < int(run.request.arms.size()); ++arm) {
    if (auto measured = sweep.measure_reference(arm); !measured) return measured;
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (auto measured = sweep.measure_cell(order[k]); !measured) return measured;
    bench.report_progress(double(k + 1) / double(order.size()));
  }
  return {};
}

}  // namespace ovws
