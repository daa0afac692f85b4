/// ovws measure: measures the wavefronts of image files.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/number_text.hpp"
#include "core/control/refine_settings.hpp"
#include "core/pipeline/frame_rules.hpp"
#include "core/spots/spot_fit.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/cli/measurement.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/shared/slm_files.hpp"
#include "proto/encode.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr double kElectronsPerDn = 1.0;  ///< unless it is given

struct MeasureOptions {
  std::string config_path;
  std::string reference;
  bool model_reference = false;
  std::string tracker;
  bool refine = false;
  RefineOverrides camera;  ///< used with `refine` only
  bool spot_amplitudes = false;
  std::vector<std::string> images;
};

Result<Config> measuring_config(const MeasureOptions& options) {
  auto config = load_config_and_masks(options.config_path);
  if (!config) return config;
  if (!options.tracker.empty()) config->tracking.tracker = *tracker_from_name(options.tracker);
  if (options.refine) config->tracking.tracker = TrackerKind::fit;
  return config;
}

json spots_of(const Measured& measured) {
  json spots = json::array();
  for (std::size_t i = 0; i < measured.spots.size(); ++i) {
    const SpotFix& spot = measured.spots[i];
    if (spot.found()) {
      spots.push_back({{"i", i}, {"x", spot.x}, {"y", spot.y}, {"quality", spot.quality}});
    } else {
      spots.push_back({{"i", i}, {"x", nullptr}, {"y", nullptr}, {"quality", 0.0}});
    }
  }
  return spots;
}

/// An image of a file.
struct Page {
  std::string file;
  int number = 0;  ///< from 0 on
  int count = 1;   ///< of the file

  std::string name() const {
    return count == 1 ? file : fmt::format("{}, page {} of {}", file, number + 1, count);
  }
};

/// One result line: a JSON object like the `wavefront` message. Fields that only a camera provides
/// are null.
json image_line(const Page& page, const Config& config, const Measurement& measurement,
                const Measured& measured) {
  WavefrontMessage message;
  message.charge = config.sensor.charge;
  message.tracker = tracker_name(config.tracking.tracker);
  message.subapertures = int(measured.spots.size());
  message.tracked = measured.tracked;
  message.settled = true;
  message.valid = measured.verdict == Verdict::valid;
  message.verdict = measured.verdict;
  message.wavelength_nm = config.optics.wavelength_nm;
  if (message.valid) message.rms_waves = measured.reconstruction.rms_waves;
  if (measured.reconstruction.determined) {
    message.fit_residual_px = measured.reconstruction.fit_residual_px;
  }
  message.saturated = measured.saturated;
  message.j = measurement.plan().modes_j;
  message.coefficients = measured.coefficients;
  message.sigma = measured.sigma_waves;
  message.fitted = measured.fitted;
  std::vector<BranchPointEntry> branch_points;
  for (const BranchPoint& one : measured.branch_points) {
    branch_points.push_back({one.at.x, one.at.y, double(one.charge)});
  }
  message.branch_points = branch_points;
  std::string text;
  encode(message, text);
  json line = json_of(text);
  for (const char* unknown : {"t_device_ns", "t_arrival_ns", "t_publish_ns", "latency_us"}) {
    line[unknown] = nullptr;
  }
  line["file"] = page.file;
  line["page"] = page.number + 1;
  line["spots"] = spots_of(measured);
  line["operator"] = wire_name(config.tracking.mode_operator);
  put_fields(line, measured.mode_operator);
  return line;
}

/// Adds the results of a refinement, which needs the camera's noise. If the model does not explain
/// the image, there are no coefficients and `refined.reason` says why.
void put_refined(json& line, const Measured& measured, bool amplitudes) {
  const std::vector<int> modes_j = line["j"];
  const bool valid = measured.verdict == Verdict::valid && measured.refined;
  const RefinedModes found = measured.refined.value_or(RefinedModes{});
  double squares = 0.0;
  for (std::size_t k = 0; valid && k < modes_j.size(); ++k) {
    if (modes_j[k] > 2) squares += found.waves[k] * found.waves[k];
  }
  line["valid"] = valid;
  line["coefficients"] = valid ? json(found.waves) : json(std::vector<json>(modes_j.size()));
  line["sigma"] = valid ? json(found.sigma_waves) : json(std::vector<json>(modes_j.size()));
  line["rms_waves"] = valid ? json(std::sqrt(squares)) : json();
  line["refined"] = {{"sigma_waves", found.sigma_waves},
                     {"chi2_per_pixel", measured.refined ? json(found.chi2_per_pixel) : json()},
                     {"reason", valid ? json() : json(measured.refused)}};
  if (amplitudes) line["refined"]["amplitudes"] = found.amplitudes;
}

/// The result of an image for people. `enough_found`: see frame_rules.hpp.
std::string page_text(const Page& page, const json& line, bool enough_found) {
  json said = line;
  said["name"] = page.name();
  said["saturated_spots"] =
      std::round(line["saturated"].get<double>() * double(line["spots"].size()));
  said["missing"] = line["subapertures"].get<int>() - line["tracked"].get<int>();
  said["enough"] = enough_found;
  said["why"] = verdict_text(line);
  std::string text = fill(
      "{name}: {tracked} of {subapertures} spots, [valid?valid][!valid?NOT VALID]"
      "[saturated_spots?\n{saturated_spots:.0f} of {subapertures} spots are saturated: lower the "
      "exposure or the gain][refined.reason?\nrefined: {refined.reason}]"
      "[branch_points*\nbranch point (phase singularity) near x {0:+.2f}, y {1:+.2f} pupil radii, "
      "charge {2:+.0f}]"
      "[!valid?[!enough?\n{missing} of {subapertures} spots are missing, more than a sixth: check "
      "the image and its exposure][enough?[!refined?\n{why}[fit_residual_px?; fit residual "
      "{fit_residual_px:.4f} px]]]]",
      said);
  if (!line["valid"].get<bool>()) return text;
  for (std::size_t k = 0; k < line["j"].size(); ++k) {
    const int j = line["j"][k].get<int>();
    text += fmt::format("\n{:>4} {:<32} {:>9}", j, zernike_name(j),
                        signed_decimals(line["coefficients"][k].get<double>(), 4));
  }
  return text + fill(
                    "\nRMS {rms_waves:.4f} wave without tilts[fit_residual_px?, fit residual "
                    "{fit_residual_px:.4f} px][refined.chi2_per_pixel?, refined: chi2 per pixel "
                    "{refined.chi2_per_pixel:.3f}]",
                    said);
}

/// Measurement for all images of one size and pixel depth; made for the first of these images.
struct Instrument {
  int width = 0, height = 0;
  PixelFormat format = PixelFormat::mono8;
  Result<Measurement> measurement;
};

/// Measures image files in sequence. The reference is measured once for each image size and depth.
/// Result of one image.
struct MeasuredPage {
  json line;
  bool enough_found = true;  ///< see enough_found of frame_rules.hpp
};

class ImageMeasurer {
 public:
  ImageMeasurer(const MeasureOptions& options, const Config& config)
      : options_(options), config_(config) {}

  /// Reads the reference image, if one is given. Call this before measuring images.
  Result<void> read_reference() {
    if (options_.reference.empty()) return {};
    auto file = ImageFile::open(options_.reference, config_.camera.settings.pixel_format);
    if (!file) return fail(Errc::invalid, "reference", file.error().reason);
    if (file->count() > 1) {
      return fail(Errc::invalid, "reference",
                  fmt::format("{} has {} pages: give a file with one image", options_.reference,
                              file->count()));
    }
    auto read = file->read(0);
    if (!read) return fail(Errc::invalid, "reference", read.error().reason);
    reference_ = std::move(*read);
    return {};
  }

  Result<MeasuredPage> measure(ImageFile& file, const Page& page) {
    const auto picture = file.read(page.number);
    if (!picture) return fail(picture.error());
    const ImageView image = picture->view();
    Instrument& instrument = instrument_for(image);
    if (!instrument.measurement) return fail(instrument.measurement.error());
    const Measured measured = instrument.measurement->measure(image);
    const MeasurementPlan& plan = instrument.measurement->plan();
    const bool enough = enough_found(measured.spots, plan.reference_px);
    if (enough && !reference_) {  // a reference image is checked when it is measured
      const auto straight = check_rotation(config_, plan, measured.spots, "image");
      if (!straight) return fail(straight.error());
    }
    json line = image_line(page, config_, *instrument.measurement, measured);
    if (options_.refine) put_refined(line, measured, options_.spot_amplitudes);
    return MeasuredPage{std::move(line), enough};
  }

 private:
  std::optional<ImageView> reference_view() const {
    return reference_ ? std::optional(reference_->view()) : std::nullopt;
  }

  Instrument& instrument_for(const ImageView& image) {
    for (Instrument& made : instruments_) {
      if (made.width == image.width && made.height == image.height && made.format == image.format) {
        return made;
      }
    }
    return instruments_.emplace_back(
        Instrument{image.width, image.height, image.format,
                   Measurement::make(config_, image, reference_view(), camera_of(image))});
  }

  /// Camera noise with which images are refined; none: images are not refined.
  std::optional<RefineCamera> camera_of(const ImageView& image) const {
    if (!options_.refine) return std::nullopt;
    RefineSetup setup;
    setup.electrons_per_dn = kElectronsPerDn;
    setup.format = image.format;
    return refine_camera(options_.camera.on(setup), image.format, 0.0);
  }

  const MeasureOptions& options_;
  const Config& config_;
  std::optional<Picture> reference_;
  std::deque<Instrument> instruments_;
};

/// Checks the combination of options. Returns the error; none: the options are valid.
std::optional<Error> fault_of(const MeasureOptions& options) {
  if (options.reference.empty() && !options.model_reference) {
    return Error{Errc::invalid, "reference",
                 "the reference is missing: give --reference FILE, or --model-reference"};
  }
  const bool other_tracker = !options.tracker.empty() && options.tracker != "fit";
  if (options.refine && other_tracker) {
    return Error{Errc::invalid, "--tracker", "--refine measures by the tracker fit"};
  }
  return std::nullopt;
}

/// Adds the name of the page at fault to the error text, unless it contains it; an error of the
/// reference gets the reference's path and the page that it was measured for.
Error of_page(Error error, const std::string& name, const std::string& reference) {
  if (error.field == "reference") {
    error.reason = reference + ", for " + name + ": " + error.reason;
  } else if (error.reason.find(name) == std::string::npos) {
    error.reason = name + ": " + error.reason;
  }
  return error;
}

/// Measures one image and prints the result, or why there is none. Returns the exit code.
int measure_page(const Common& common, ImageMeasurer& measurer, ImageFile& file, const Page& page,
                 const std::string& reference) {
  const auto measured = measurer.measure(file, page);
  if (!measured) return report(common, of_page(measured.error(), page.name(), reference));
  print_result(common, measured->line, page_text(page, measured->line, measured->enough_found));
  if (measured->line.at("tracked") != 0) return kOk;
  return report(common, {Errc::refused, "image",
                         page.name() + ": no spots are found: check the image, its exposure, and "
                                       "the configuration's sensor and optics"});
}

/// Measures every image of each file. After one that fails, the remaining ones are still measured.
int measure_images(const Common& common, const MeasureOptions& options) {
  if (const auto fault = fault_of(options)) return report_mistake(common, *fault);
  const auto config = measuring_config(options);
  if (!config) return report(common, config.error());
  if (const auto used = operator_report(config->tracking); !used.reason.empty()) {
    fmt::print(stderr, "ovws: the operator is {}, not {}: {}\n", wire_name(used.in_force),
               wire_name(config->tracking.mode_operator), used.reason);
  }
  ImageMeasurer measurer(options, *config);
  if (auto read = measurer.read_reference(); !read) return report(common, read.error());
  int status = kOk;
  for (const std::string& path : options.images) {
    auto file = ImageFile::open(path, config->camera.settings.pixel_format);
    if (!file) status = report(common, file.error());
    for (int page = 0; file && page < file->count(); ++page) {
      const int failed =
          measure_page(common, measurer, *file, {path, page, file->count()}, options.reference);
      if (failed != kOk) status = failed;
    }
  }
  return status;
}

}  // namespace

void add_measure(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "measure",
      "measure the wavefronts of image files (PNG, TIFF, PGM); works offline", measure_images);
  command.add_option("--config,-c", options.config_path, kConfigHelp);
  auto* reference =
      command.add_option("--reference,-r", options.reference,
                         "image without aberration, from which displacements are measured");
  command
      .add_flag("--model-reference", options.model_reference,
                "measure displacements from the positions that the configuration predicts")
      ->excludes(reference);
  command.add_option("--tracker", options.tracker, "tracker, instead of the configuration's")
      ->check(CLI::IsMember(kNames<TrackerKind>()));
  auto* refine =
      command.add_flag("--refine", options.refine,
                       "fit all pixels of the spots with this camera's noise, and report how "
                       "well the model explains them; defaults: a read noise of 5 electrons, a "
                       "black level of 0, the file's full scale");
  add_refine_camera(command, options.camera, refine, "for --refine: electrons per DN (default: 1)");
  command
      .add_flag("--spot-amplitudes", options.spot_amplitudes,
                "for --refine: also report each subaperture's amplitude")
      ->needs(refine);
  command.add_option("images", options.images, "image files, each a camera frame")->required();
}

}  // namespace ovws::cli
