/// ovws measure: wavefronts of image files.
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/tracking/tracker.hpp"
#include "daemon/cli/commands.hpp"
#include "daemon/cli/measurement.hpp"
#include "daemon/cli/refined.hpp"
#include "proto/encode.hpp"
#include "proto/names.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

struct MeasureOptions {
  std::string config_path;
  std::string reference;
  bool model_reference = false;
  std::string tracker;
  bool refine = false;
  RefineCamera camera;
  std::vector<std::string> images;
};

Result<Config> config_of(const MeasureOptions& options) {
  auto config =
      options.config_path.empty() ? Result<Config>{Config{}} : load_config(options.config_path);
  if (!config) return config;
  if (!options.tracker.empty()) {
    config->tracking.tracker = *tracker_from_name(options.tracker);
  }
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

/// A line of the form of the `wavefront` message; what only a camera knows is null.
json line_of(const std::string& file, const Config& config, const Measurement& measurement,
             const Measured& measured) {
  WavefrontMessage message;
  message.charge = config.sensor.charge;
  message.tracker = tracker_name(config.tracking.tracker);
  message.subapertures = int(measured.spots.size());
  message.tracked = measured.tracked;
  message.settled = true;
  message.valid = measured.valid;
  message.wavelength_nm = config.optics.wavelength_nm;
  if (measured.valid) {
    message.rms_waves = measured.reconstruction.rms_waves;
    message.fit_residual_px = measured.reconstruction.fit_residual_px;
  }
  message.saturated = measured.saturated;
  message.j = measurement.plan().reconstructor->modes_j();
  message.coefficients = measured.coefficients;
  std::string text;
  encode(message, text);
  json line = json::parse(text);
  for (const char* unknown : {"t_device_ns", "t_arrival_ns", "t_publish_ns", "latency_us"}) {
    line[unknown] = nullptr;
  }
  line["file"] = file;
  line["spots"] = spots_of(measured);
  return line;
}

void print_table(const json& line) {
  print("{}: {} of {} spots, {}\n", line["file"].get<std::string>(), line["tracked"].get<int>(),
        line["subapertures"].get<int>(), line["valid"].get<bool>() ? "valid" : "NOT VALID");
  if (!line["valid"].get<bool>()) return;
  for (std::size_t k = 0; k < line["j"].size(); ++k) {
    const int j = line["j"][k].get<int>();
    print("{:>4} {:<32} {:+9.4f}\n", j, zernike_name(j), line["coefficients"][k].get<double>());
  }
  print("RMS {:.4f} wave without tilts", line["rms_waves"].get<double>());
  if (line["fit_residual_px"].is_number()) {
    print(", fit residual {:.4f} px", line["fit_residual_px"].get<double>());
  }
  if (line.contains("refined")) {
    print(", refined: chi2 per pixel {:.3f}", line["refined"]["chi2_per_pixel"].get<double>());
  }
  print("\n");
}

/// The coefficients of all pixels instead of those of the spots' positions.
Result<void> refine(json& line, const MeasureOptions& options, const Config& config,
                    const Measurement& measurement, const Measured& measured,
                    const ImageView& image, const std::optional<ImageView>& reference) {
  const std::vector<int>& modes_j = measurement.plan().reconstructor->modes_j();
  RefineCamera camera = options.camera;
  const double full_scale_dn = (1 << significant_bits(image.format)) - 1;
  camera.saturated_dn = std::min(camera.saturated_dn, full_scale_dn);
  auto refined = RefinedMeasurement::make(config, image, reference, modes_j, camera);
  if (!refined) return fail(refined.error());
  const auto found = refined->measure(image, measured.coefficients);
  if (!found) return fail(found.error());
  double squares = 0.0;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (modes_j[k] > 2) squares += found->waves[k] * found->waves[k];
  }
  const bool valid = found->believable(camera);
  line["valid"] = valid;
  line["coefficients"] = valid ? json(found->waves) : json(std::vector<json>(modes_j.size()));
  line["rms_waves"] = valid ? json(std::sqrt(squares)) : json();
  line["refined"] = {{"sigma_waves", found->sigma_waves},
                     {"chi2_per_pixel", found->chi2_per_pixel}};
  return {};
}

Result<void> measure_one(const Common& common, const MeasureOptions& options, const Config& config,
                         const std::string& path) {
  const auto picture = read_picture(path);
  if (!picture) return fail(picture.error());
  std::optional<Picture> reference;
  if (!options.reference.empty()) {
    auto read = read_picture(options.reference);
    if (!read) return fail(read.error());
    reference = std::move(*read);
  }
  auto measurement = Measurement::make(config, picture->view(),
                                       reference ? std::optional(reference->view()) : std::nullopt);
  if (!measurement) return fail(measurement.error());
  const Measured measured = measurement->measure(picture->view());
  json line = line_of(path, config, *measurement, measured);
  if (options.refine) {
    const auto refined = refine(line, options, config, *measurement, measured, picture->view(),
                                reference ? std::optional(reference->view()) : std::nullopt);
    if (!refined) return refined;
  }
  if (common.json) {
    print("{}\n", line.dump());
  } else {
    print_table(line);
  }
  return {};
}

/// Every image is measured, also behind one that cannot be.
int measure(const Common& common, const MeasureOptions& options) {
  if (options.reference.empty() && !options.model_reference) {
    return report(common, {Errc::invalid, "reference",
                           "say what the positions count from: --reference FILE, or "
                           "--model-reference"}) == kOk
               ? kOk
               : kUsage;
  }
  const auto config = config_of(options);
  if (!config) return report(common, config.error());
  int status = kOk;
  for (const std::string& path : options.images) {
    if (const auto done = measure_one(common, options, *config, path); !done) {
      status = report(common, done.error());
    }
  }
  return status;
}

}  // namespace

void add_measure(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("measure", "wavefronts of image files (PNG, TIFF, PGM)");
  auto options = std::make_shared<MeasureOptions>();
  command->add_option("--config,-c", options->config_path,
                      "configuration file; defaults without it");
  auto* reference = command->add_option("--reference,-r", options->reference,
                                        "image without aberration: positions count from it");
  command
      ->add_flag("--model-reference", options->model_reference,
                 "positions count from where the configuration says that spots are")
      ->excludes(reference);
  command->add_option("--tracker", options->tracker, "instead of the configuration's")
      ->check(CLI::IsMember(tracker_names()));
  auto* refine = command->add_flag("--refine", options->refine,
                                   "fit every pixel by the diffraction model: seconds an image");
  command
      ->add_option("--electrons-per-dn", options->camera.electrons_per_dn,
                   "of the camera, to refine")
      ->check(number_from(1e-6, 1e6))
      ->needs(refine)
      ->capture_default_str();
  command->add_option("--read-noise", options->camera.read_noise_e, "electrons RMS, to refine")
      ->check(number_from(0.0, 1e6))
      ->needs(refine)
      ->capture_default_str();
  command
      ->add_option("--saturation", options->camera.saturated_dn,
                   "DN from which a pixel is left out, to refine (default: the file's full scale)")
      ->check(number_from(1.0, 65535.0))
      ->needs(refine);
  command->add_option("--black-level", options->camera.black_dn, "DN, to refine")
      ->check(number_from(0.0, 65535.0))
      ->needs(refine)
      ->capture_default_str();
  command->add_option("images", options->images, "files")->required();
  command->callback([&common, &status, options] { status = measure(common, *options); });
}

}  // namespace ovws::cli
