/// The command line of ovws design.
#include <CLI/CLI.hpp>
#include <memory>

#include "config/devices.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/design.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"

namespace ovws::cli {
namespace {

template <class Model>
std::string help_of(const char* what, const std::vector<Model>& models) {
  std::string names;
  for (const Model& model : models) names += (names.empty() ? "" : ", ") + model.name;
  return std::string(what) + ": a model (" + names +
         "), or WIDTHxHEIGHT@PITCH in pixels and micrometres, e.g. 1920x1080@8";
}

CLI::Validator range(limits::Numbers of) {
  return number_from(of.min, of.max);
}

void add_bench_options(CLI::App& command, DesignOptions& options) {
  const Devices& known = known_devices();
  design::Bench& bench = options.bench;
  command.add_option("--slm", options.slm, help_of("SLM", known.slms));
  command.add_option("--camera", options.camera, help_of("camera sensor", known.cameras));
  command.add_option("--wavelength", bench.wavelength_nm, "wavelength of the laser, nm")
      ->check(range(limits::kWavelengthNm))
      ->capture_default_str();
  command.add_option("--focal-length", bench.focal_length_mm, "focal length of the lens, mm")
      ->check(range(limits::kFocalLengthMm))
      ->capture_default_str();
  command
      .add_option("--magnification", bench.magnification,
                  "magnification from the lens's focal plane to the camera")
      ->check(range(limits::kMagnification))
      ->capture_default_str();
  command
      .add_option("--beam", bench.beam_mm,
                  "beam diameter on the SLM, mm (default: it covers the SLM's smaller side)")
      ->check(number_from(0.001, 1000.0));
  command.add_option("--modes", bench.modes, "measure at least this number of Zernike modes")
      ->check(CLI::Range(1, 1000));
  command.add_option("--charge", bench.charge, "charge of the vortices; 0: bright spots")
      ->check(CLI::Range(limits::kCharge.min, limits::kCharge.max))
      ->capture_default_str();
  command.add_option("--pixel-format", options.pixel_format, "pixel format of the camera")
      ->check(CLI::IsMember(kNames<PixelFormat>()))
      ->capture_default_str();
}

}  // namespace

void add_design(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "design",
      "design a bench: from SLM, camera, lens, wavelength and beam to a configuration, or to what "
      "makes it impossible and the changes that help; works offline");
  auto options = std::make_shared<DesignOptions>();
  add_bench_options(*command, *options);
  command->add_option(
      "--config,-c", options->config_path,
      "configuration file whose other keys are kept (default: every key's default)");
  command->add_option("--output,-o", options->output, "configuration file to write");
  command->add_flag("--replace", options->replace, "replace an existing configuration file");
  command->add_option("--farfield", options->farfield,
                      "PNG file to write: the camera image that is expected, with noise");
  command->add_flag("--list", options->list, "list the models of SLMs and camera sensors");
  command->callback([&common, &status, options] {
    if (!options->list && (options->slm.empty() || options->camera.empty())) {
      throw CLI::RequiredError(options->slm.empty() ? "--slm" : "--camera");
    }
    status = design_bench(common, *options);
  });
}

}  // namespace ovws::cli
