/// ovws study experiment: the paper's gain sweep on a daemon's bench.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/base/pixels.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/experiment_bench.hpp"
#include "daemon/ovws/cli/experiment_images.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/study/gain_sweep.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/sweep_sensor.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "proto/tables/camera.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using study::SweepSensor;

/// Checks the gains against the camera's range. With `clamp`, leaves out those outside it.
Result<GainSweep> within(GainSweep sweep, const Range<double>& range) {
  const auto has = [&range](double gain_db) {
    return gain_db >= range.min && gain_db <= range.max;
  };
  const auto outside = [&range](const char* field, double gain_db) {
    return fail(Error{Errc::invalid, field,
                      fmt::format("{} dB is outside the camera's range of {} to {} dB: choose "
                                  "another gain, or leave out such gains with \"clamp\"",
                                  gain_db, range.min, range.max),
                      range.min, range.max});
  };
  if (!has(sweep.reference_gain_db)) return outside("reference_gain_db", sweep.reference_gain_db);
  if (sweep.clamp) std::erase_if(sweep.gains_db, [&](double gain_db) { return !has(gain_db); });
  const auto wrong = std::ranges::find_if_not(sweep.gains_db, has);
  if (wrong != sweep.gains_db.end()) return outside("gains_db", *wrong);
  if (sweep.gains_db.empty()) return outside("gains_db", range.max);
  return sweep;
}

/// The measured cells. Each is written to both CSV files as soon as it is measured; the first one
/// replaces the files of an earlier run.
class CellFiles {
 public:
  explicit CellFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  Result<void> add(json cell) {
    if (cells_.empty()) {
      if (auto removed = remove_findings("experiment", folder_); !removed) return removed;
      begin();
    }
    const int number = cell.at("cell").get<int>();
    const json& kept = cells_[number] = std::move(cell);
    return write(kept);
  }
  /// Rewrites both files in the order of the cells' numbers.
  Result<void> write_in_order() {
    begin();
    for (const auto& [number, cell] : cells_) {
      if (auto written = write(cell); !written) return written;
    }
    return {};
  }
  const study::SweepCells& cells() const { return cells_; }

 private:
  void begin() {
    cells_file_ = std::ofstream(folder_ / "cells.csv");
    frames_file_ = std::ofstream(folder_ / "frames.csv");
    cells_file_ << study::cells_csv_header() << std::flush;
  }
  Result<void> write(const json& cell) {
    if (frames_file_.tellp() == 0) frames_file_ << study::frames_csv_header(cell);
    cells_file_ << study::cells_csv_row(cell) << std::flush;
    frames_file_ << study::frames_csv_rows(cell) << std::flush;
    if (cells_file_.good() && frames_file_.good()) return {};
    return fail(Errc::unavailable, "output", "a CSV file cannot be written");
  }

  std::filesystem::path folder_;
  std::ofstream cells_file_, frames_file_;
  study::SweepCells cells_;
};

Image<std::uint8_t> eight_bits(const ImageView& image) {
  const int shift = significant_bits(image.format) - 8;
  Image<std::uint8_t> out(image.width, image.height);
  visit_rows(image, 0, 0, image.width, image.height, [&](int x, int y, const auto* row, int count) {
    for (int i = 0; i < count; ++i) out.at(x + i, y) = std::uint8_t(row[i] >> shift);
  });
  return out;
}

/// The whole sweep. A row is one aberration at one gain. In each row all arms of a charge measure
/// the same images; the charges come in alternating order, so that a slow drift favours none.
class Sweep {
 public:
  Sweep(GainSweep sweep, ExperimentBench& bench, std::filesystem::path folder)
      : sweep_(std::move(sweep)), bench_(bench), files_(std::move(folder)) {}

  /// Ends early, without an error, if it is interrupted. Throws CallFailed.
  void measure() try {
    make_sensors();
    const std::vector<int> charges(charges_.begin(), charges_.end());
    for (const int charge : charges) {
      take_references(charge);
      if (was_interrupted()) return;
    }
    const std::size_t rows = sweep_.aberrations.size() * sweep_.gains_db.size();
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t k = 0; k < charges.size(); ++k) {
        const int charge = charges[row % 2 == 0 ? k : charges.size() - 1 - k];
        measure_row(row, charge);
        if (was_interrupted()) return;
        show_progress();
      }
    }
  } catch (const CallFailed&) {
    if (!was_interrupted()) throw;  // an interrupt may have ended the call
  }
  bool is_complete() const { return files_.cells().size() == sweep_.cells(); }
  const GainSweep& params() const { return sweep_; }
  CellFiles& files() { return files_; }
  const CameraFrames& camera_frames() const { return frames_; }
  /// Of a complete sweep.
  json summary() const;

 private:
  void make_sensors();
  void take_references(int charge);
  void measure_row(std::size_t row, int charge);
  std::vector<Vec2> starts(std::size_t aberration, int charge);
  void keep_image(const GainSweep::Cell& at, int charge, const GrabbedImages& images,
                  double peak_dn);
  void show_progress() const;

  const GainSweep sweep_;
  ExperimentBench& bench_;
  CellFiles files_;
  const std::int64_t t_begun_ns_ = utc_ns();
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::set<int> charges_;
  std::vector<SweepSensor> sensors_;  ///< one per arm
  std::vector<ReferenceMeasured> references_;
  std::map<int, std::vector<Vec2>> flat_px_;  ///< places of the spots without an aberration
  /// The same with the aberration, by it and the charge: found at the reference's gain, as bright
  /// spots with saturated tops are not found elsewhere.
  std::map<std::pair<std::size_t, int>, std::vector<Vec2>> starts_px_;
  CameraFrames frames_;
};

void Sweep::make_sensors() {
  for (const SweepArm& arm : sweep_.arms) {
    sensors_.push_back(needed(SweepSensor::make(arm, bench_.config())));
    charges_.insert(arm.charge);
  }
  references_.resize(sensors_.size());
}

void Sweep::take_references(int charge) {
  bench_.set_gain(sweep_.reference_gain_db);
  bench_.show(charge, {});
  const auto places = bench_.find_spots();
  const std::int64_t now_ns = utc_ns();
  const GrabbedImages images = bench_.grab(sweep_.reference_frames);
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    if (sweep_.arms[k].charge != charge) continue;
    ReferenceMeasured& taken = references_[k];
    taken = needed(sensors_[k].take_reference(images.views, places));
    taken.arm = int(k);
    taken.gain_db = images.gain_db;
    taken.t_begun_ns = now_ns;
  }
}

/// Where the spots of this aberration are. Shows it.
std::vector<Vec2> Sweep::starts(std::size_t aberration, int charge) {
  bench_.show(charge, sweep_.aberrations[aberration].modes);
  const auto known = starts_px_.find({aberration, charge});
  if (known != starts_px_.end()) return known->second;
  bench_.set_gain(sweep_.reference_gain_db);
  return starts_px_[{aberration, charge}] = bench_.find_spots();
}

void Sweep::measure_row(std::size_t row, int charge) {
  const std::size_t first = row * sweep_.arms.size();
  const GainSweep::Cell place = sweep_.cell(first);
  const auto places = starts(place.aberration, charge);
  bench_.set_gain(sweep_.gains_db[place.gain]);
  const std::int64_t now_ns = utc_ns();
  const GrabbedImages images = bench_.grab(sweep_.frames);
  bool kept = false;
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    if (sweep_.arms[k].charge != charge) continue;
    CellMeasured cell;
    cell.cell = int(first + k);
    cell.at = sweep_.cell(first + k);
    cell.gain_db = images.gain_db;
    cell.exposure_us = bench_.config().camera.settings.exposure_us;
    cell.frame_rate_hz = bench_.config().camera.settings.frame_rate_hz;
    cell.t_begun_ns = now_ns;
    sensors_[k].measure(images.views, places, sweep_.aberrations[place.aberration].modes, cell);
    if (!std::exchange(kept, true)) keep_image(place, charge, images, cell.levels.peak_dn);
    needed(files_.add(report_of(cell)));
  }
}

void Sweep::keep_image(const GainSweep::Cell& at, int charge, const GrabbedImages& images,
                       double peak_dn) {
  const double gain_db = sweep_.gains_db[at.gain];
  const auto& wanted = sweep_.picture_gains_db;
  if (at.aberration != 0 || std::ranges::find(wanted, gain_db) == wanted.end()) return;
  frames_.push_back({charge, images.gain_db, peak_dn, eight_bits(images.views.front())});
}

void Sweep::show_progress() const {
  const double done = double(files_.cells().size()) / double(sweep_.cells());
  const double passed_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
  study::print_progress(fmt::format("{} of {} cells, {} left", files_.cells().size(),
                                    sweep_.cells(),
                                    time_text(std::ceil(passed_s * (1.0 - done) / done))));
}

json Sweep::summary() const {
  json cells = json::array(), references = json::array();
  for (const auto& [number, cell] : files_.cells()) cells.push_back(summary_of(cell));
  for (const ReferenceMeasured& one : references_) references.push_back(report_of(one));
  const CameraSettings& camera = bench_.config().camera.settings;
  return {{"study", "experiment"},
          {"comparisons", study::sweep_comparisons(sweep_, files_.cells())},
          {"t_begun_ns", t_begun_ns_},
          {"request", to_json(sweep_)},
          {"bench",
           {{"exposure_us", camera.exposure_us},
            {"pixel_format", pixel_format_name(camera.pixel_format)},
            {"roi", to_json(camera.roi)},
            {"optics", to_json(bench_.config().optics)}}},
          {"references", std::move(references)},
          {"cells_total", sweep_.cells()},
          {"cells_done", files_.cells().size()},
          {"cells", std::move(cells)}};
}

/// Writes summary, table, figures and images.
Result<void> write_all(Sweep& sweep, json summary, const std::string& table,
                       const std::filesystem::path& folder) {
  if (auto done = sweep.files().write_in_order(); !done) return done;
  summary["version"] = OVWS_VERSION;
  const study::SweepCells& cells = sweep.files().cells();
  const auto draw_images = [&]() -> Result<void> {
    if (auto done = draw_camera_frames(sweep.camera_frames(), folder); !done) return done;
    return draw_residuals(sweep.params(), cells, folder);
  };
  if (auto done = study::write_text(table, folder / "table.txt"); !done) return done;
  return write_findings(summary, study::sweep_figures(sweep.params(), cells), folder, draw_images);
}

int print_findings(const Common& common, const json& summary, const std::string& table,
                   const std::filesystem::path& folder) {
  std::string text = table + "\n";
  for (const json& one : summary.at("comparisons")) {
    text += fill("{arm} is below {other} in {lower} of {cells} cells", one) + "\n";
  }
  return print_result(common, summary, text + "see " + folder.string());
}

}  // namespace

int run_experiment(const Common& common, const json& params, const std::filesystem::path& folder) {
  catch_interrupts();
  const auto asked = decode<GainSweep>(params);
  if (!asked) return report_mistake(common, asked.error());
  ExperimentBench bench(common);
  auto possible = within(*asked, bench.gains_db());
  if (!possible) return report(common, possible.error());
  Sweep sweep(std::move(*possible), bench, folder);
  auto measured = bench.restore_after(attempt([&] { sweep.measure(); }));
  study::print_progress("");
  needed(std::move(measured));
  if (!sweep.is_complete()) {
    return report(common, {Errc::refused, "",
                           fmt::format("the study was stopped; {} cells are in {}",
                                       sweep.files().cells().size(), folder.string())});
  }
  const json summary = sweep.summary();
  const std::string table = study::sweep_table(sweep.params(), sweep.files().cells());
  if (auto written = write_all(sweep, summary, table, folder); !written) {
    return report(common, written.error());
  }
  return print_findings(common, summary, table, folder);
}

}  // namespace ovws::cli
