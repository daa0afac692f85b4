/// ovws hologram and ovws farfield: compute the hologram and the far-field image offline.
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>

#include "config/config.hpp"
#include "core/optics/detector.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/sensor_model.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/text/mode_names.hpp"
#include "daemon/shared/slm_files.hpp"

namespace ovws::cli {
namespace {

Result<Config> hologram_config(const ImageOptions& options) {
  auto config = load_config_and_masks(options.config_path);
  if (config && config->modulator == Modulator::fixed) {
    return fail(Errc::invalid, "modulator",
                "a fixed array of lenslets has no hologram, whose grey levels or far field could "
                "be computed");
  }
  return config;
}

Result<std::vector<Mode>> requested_modes(const ImageOptions& options) {
  return parse_modes(options.modes, options.norm == "unit" ? ZernikeNorm::unit : ZernikeNorm::rms);
}

/// Renders the hologram's grey levels with the requested modes. Fails if the SLM's pixels cannot
/// sample the phase.
Result<Image<std::uint8_t>> render(const HologramConfig& hologram, const ImageOptions& options) {
  const auto modes = requested_modes(options);
  if (!modes) return fail(modes.error());
  auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  if (auto sampled = renderer->check_sampling(*modes); !sampled) return fail(sampled.error());
  Image<std::uint8_t> grey;
  renderer->render(HologramKind::sensor, *modes, grey);
  return grey;
}

Result<void> make_hologram(const ImageOptions& options) {
  const auto config = hologram_config(options);
  if (!config) return fail(config.error());
  const auto hologram = load_hologram_config(*config);
  if (!hologram) return fail(hologram.error());
  const auto grey = render(*hologram, options);
  if (!grey) return fail(grey.error());
  return write_image(options.output, matrix_on(*grey));
}

/// Far-field image of an ideal SLM, in electrons per pixel of the camera's region. It is scaled to
/// the requested peak or total.
Result<Image<float>> electrons(const Config& config, const FarFieldOptions& options,
                               double full_well_e) {
  const auto modes = requested_modes(options);
  if (!modes) return fail(modes.error());
  const Roi& roi = config.camera.settings.roi;
  auto model =
      SensorModel::make(config.sensor, config.slm.geometry, config.optics, roi.width, roi.height);
  if (!model) return fail(model.error());
  auto intensity = model->intensity(*modes);
  if (!intensity) return intensity;
  const double peak_e = options.peak_e.value_or(0.8 * full_well_e);
  scale(*intensity, options.total_e ? *options.total_e / total(*intensity)
                                    : peak_e / model->peak_of_spots(*intensity, *modes));
  return intensity;
}

int finish(const Common& common, const std::string& output, const Result<void>& done) {
  return done ? report_file(common, output) : report(common, done.error());
}

int save_hologram(const Common& common, const ImageOptions& options) {
  return finish(common, options.output, make_hologram(options));
}

int save_farfield(const Common& common, const FarFieldOptions& options) {
  const auto config = hologram_config(options);
  if (!config) return report(common, config.error());
  return finish(common, options.output, write_farfield(*config, options));
}

void add_image_options(CLI::App& command, ImageOptions& options) {
  command.add_option("--config,-c", options.config_path, kConfigHelp);
  command
      .add_option(
          "--modes", options.modes,
          "Zernike modes added to the hologram: \"MODE:waves;MODE:waves\", each mode by n,m, by "
          "j or by name, e.g. \"2,-2:0.5;defocus:0.1\"")
      ->check([](const std::string& text) {
        const auto modes = parse_modes(text, ZernikeNorm::rms);
        return modes ? std::string() : modes.error().reason;
      });
  command
      .add_option("--norm", options.norm,
                  "normalisation of modes: RMS over the pupil, or unit amplitude at its edge")
      ->check(CLI::IsMember({"rms", "unit"}))
      ->capture_default_str();
  command.add_option("--output,-o", options.output, "PNG file to write")->required();
}

}  // namespace

Result<void> write_farfield(const Config& config, const FarFieldOptions& options) {
  DetectorConfig detector;
  detector.quantum_efficiency = 1.0;
  detector.bits = options.bits;
  detector.seed = options.seed;
  detector.read_noise_e = options.noise_free ? 0.0 : options.read_noise_e;
  detector.shot_noise = !options.noise_free;
  if (options.noise_free) detector.prnu = detector.dark_current_e_per_s = 0.0;
  const auto collected = electrons(config, options, detector.full_well_e);
  if (!collected) return fail(collected.error());
  Image<std::uint16_t> dn;
  Detector(detector, collected->width, collected->height)
      .expose(*collected, config.camera.settings.exposure_us, options.gain_db, dn);
  cv::Mat picture = matrix_on(dn);
  if (options.bits <= 8) picture.convertTo(picture, CV_8U);
  return write_image(options.output, picture);
}

void add_pictures(CLI::App& app, const Common& common, int& status) {
  auto [hologram, image] = add_command(
      app, common, status, "hologram",
      "write the sensor's hologram for a configuration as PNG: the SLM's grey levels pixel by "
      "pixel, with the configuration's LUT and flatness; works offline",
      save_hologram);
  add_image_options(hologram, image);
  auto [command, options] =
      add_command(app, common, status, "farfield",
                  "write the camera image of that hologram on an ideal bench as PNG, computed with "
                  "noise; works offline",
                  save_farfield);
  add_image_options(command, options);
  auto* peak =
      command
          .add_option("--peak", options.peak_e,
                      "light level: electrons in the spots' brightest pixel (default 8000)")
          ->check(number_from(1e-3, 1e9));
  command
      .add_option("--photons", options.total_e,
                  "light level: electrons in the whole image, instead of --peak")
      ->check(number_from(1e-3, 1e15))
      ->excludes(peak);
  command
      .add_option("--read-noise", options.read_noise_e, "read noise of the camera, electrons RMS")
      ->check(number_from(0.0, 1e6))
      ->capture_default_str();
  command.add_option("--gain-db", options.gain_db, "camera gain, dB")
      ->check(number_from(limits::kGainDb))
      ->capture_default_str();
  command.add_option("--bits", options.bits, "bits per pixel; above 8 the PNG has 16")
      ->check(CLI::Range(8, 16))
      ->capture_default_str();
  command
      .add_option("--seed", options.seed, "seed of the noise: the same seed gives the same image")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_flag("--noise-free", options.noise_free, "no noise of any kind");
}

}  // namespace ovws::cli
