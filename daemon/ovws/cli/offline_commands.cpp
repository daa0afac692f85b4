#include "daemon/ovws/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/design.hpp"
#include "daemon/ovws/study/studies.hpp"
#include "daemon/ovws/text/modes_text.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"

namespace ovws::cli {
namespace {

/// Help of --config. Saved settings are ignored, so that the same file gives the same result on
/// every machine.
constexpr const char* kConfigHelp =
    "the daemon's configuration file (default: every key's default); saved settings are ignored: "
    "ovwsd --check-config --config FILE > NEW prints a file that includes them";

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

void add_hologram(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "hologram",
      "write the sensor's hologram for a configuration as PNG: the SLM's grey levels pixel by "
      "pixel, with the configuration's LUT and flatness; works offline");
  auto options = std::make_shared<ImageOptions>();
  add_image_options(*command, *options);
  command->callback([&common, &status, options] { status = save_hologram(common, *options); });
}

void add_farfield(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("farfield",
                                     "write the camera image of that hologram on an ideal bench as "
                                     "PNG, computed with noise; works "
                                     "offline");
  auto options = std::make_shared<FarFieldOptions>();
  add_image_options(*command, options->picture);
  auto* peak =
      command
          ->add_option("--peak", options->peak_e,
                       "light level: electrons in the spots' brightest pixel (default 8000)")
          ->check(number_from(1e-3, 1e9));
  command
      ->add_option("--photons", options->total_e,
                   "light level: electrons in the whole image, instead of --peak")
      ->check(number_from(1e-3, 1e15))
      ->excludes(peak);
  command
      ->add_option("--read-noise", options->read_noise_e, "read noise of the camera, electrons RMS")
      ->check(number_from(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--gain-db", options->gain_db, "camera gain, dB")
      ->check(number_from(limits::kGainDb.min, limits::kGainDb.max))
      ->capture_default_str();
  command->add_option("--bits", options->bits, "bits per pixel; above 8 the PNG has 16")
      ->check(CLI::Range(8, 16))
      ->capture_default_str();
  command
      ->add_option("--seed", options->seed, "seed of the noise: the same seed gives the same image")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--noise-free", options->noise_free, "no noise of any kind");
  command->callback([&common, &status, options] { status = save_farfield(common, *options); });
}

void add_measure(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "measure", "measure the wavefronts of image files (PNG, TIFF, PGM); works offline");
  auto options = std::make_shared<MeasureOptions>();
  command->add_option("--config,-c", options->config_path, kConfigHelp);
  auto* reference =
      command->add_option("--reference,-r", options->reference,
                          "image without aberration, from which displacements are measured");
  command
      ->add_flag("--model-reference", options->model_reference,
                 "measure displacements from the positions that the configuration predicts")
      ->excludes(reference);
  command->add_option("--tracker", options->tracker, "tracker, instead of the configuration's")
      ->check(CLI::IsMember(kNames<TrackerKind>()));
  command
      ->add_option("--operator", options->mode_operator,
                   "operator from displacements to modes, instead of the configuration's: "
                   "diffractive is better up to about 0.1 wave")
      ->check(CLI::IsMember(kNames<OperatorKind>()));
  auto* refine =
      command->add_flag("--refine", options->refine,
                        "fit all pixels of the spots with this camera's noise, and report how "
                        "well the model explains them");
  command
      ->add_option("--electrons-per-dn", options->camera.electrons_per_dn,
                   "camera gain for --refine")
      ->check(number_from(1e-6, 1e6))
      ->needs(refine)
      ->capture_default_str();
  command
      ->add_option("--read-noise", options->camera.read_noise_e,
                   "read noise for --refine, electrons RMS")
      ->check(number_from(0.0, 1e6))
      ->needs(refine)
      ->capture_default_str();
  command
      ->add_option("--saturation", options->camera.saturated_dn,
                   "for --refine: ignore pixels from this DN on (default: the file's full scale)")
      ->check(number_from(1.0, 65535.0))
      ->needs(refine);
  command->add_option("--black-level", options->camera.black_dn, "black level for --refine, DN")
      ->check(number_from(0.0, 65535.0))
      ->needs(refine)
      ->capture_default_str();
  command
      ->add_flag("--spot-amplitudes", options->spot_amplitudes,
                 "for --refine: also report each subaperture's amplitude")
      ->needs(refine);
  command->add_option("images", options->images, "image files, each a camera frame")->required();
  command->callback([&common, &status, options] { status = measure_images(common, *options); });
}

void add_keygen(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "keygen",
      "make a key pair for a daemon or a client, write it to a file that only you can read, and "
      "print the public key; --server-key stores the daemon's public key in the same file; works "
      "offline");
  auto options = std::make_shared<KeygenOptions>();
  command->add_option("--output,-o", options->output, "JSON file to write")->required();
  command->add_flag("--replace", options->replace, "replace an existing file, and keep its owner");
  command->callback([&common, &status, options] { status = make_keys(common, *options); });
}

/// Why a text was refused; empty: it was not.
template <class T>
std::string why_refused(const Result<T>& read) {
  return read ? std::string() : read.error().reason;
}

CLI::Option* add_shard(CLI::App& command, std::optional<Shard>& shard, const std::string& help) {
  return command
      .add_option_function<std::string>(
          "--shard", [&shard](const std::string& text) { shard = *parse_shard(text); }, help)
      ->type_name("i/N")
      ->check([](const std::string& text) { return why_refused(parse_shard(text)); });
}

void add_refine_options(CLI::App& command, ReplayOptions& options) {
  auto* refine = command.add_flag(
      "--refine", options.refine,
      "also fit all pixels of the spots of each frame with the camera's noise; each value below "
      "replaces that of refine in the recording's configuration");
  RefineOverrides& camera = options.camera;
  command
      .add_option("--electrons-per-dn", camera.electrons_per_dn,
                  "for --refine: electrons per DN of the configured pixel format at a gain of 0 dB")
      ->check(number_from(limits::kElectronsPerDn.min, limits::kElectronsPerDn.max))
      ->needs(refine);
  command
      .add_option("--read-noise", camera.read_noise_e, "for --refine: read noise, electrons RMS")
      ->check(number_from(limits::kReadNoiseE.min, limits::kReadNoiseE.max))
      ->needs(refine);
  command.add_option("--black-level", camera.black_level_dn, "for --refine: black level, DN")
      ->check(number_from(limits::kBlackLevelDn.min, limits::kBlackLevelDn.max))
      ->needs(refine);
  command
      .add_option("--saturation", camera.saturation_dn,
                  "for --refine: ignore pixels from this DN on")
      ->check(number_from(limits::kSaturationDn.min, limits::kSaturationDn.max))
      ->needs(refine);
}

void add_replay(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "replay",
      "measure the images of a recording again with the recorded settings and compare the results; "
      "exit code 1 if they differ or if there is nothing to measure");
  auto options = std::make_shared<ReplayOptions>();
  command->add_option("file", options->path, "recording made by record.start")->required();
  auto* speed = command
                    ->add_option("--speed", options->speed,
                                 "1: as recorded; 0 (default): as fast as possible")
                    ->check(number_from(0.0, 1e6));
  auto* step =
      command->add_flag("--step", options->step, "measure one frame at a time; Enter continues");
  auto* frames =
      command
          ->add_option_function<std::string>(
              "--frames",
              [options](const std::string& text) {
                options->print_frames = true;
                if (!text.empty()) options->frames = *parse_range(text);
              },
              "print each frame as one line of JSON; with A:B only the frames at the positions A "
              "to B-1 of the recording, counted from 0")
          ->expected(0, 1)
          ->type_name("[A:B]")
          ->check([](const std::string& text) {
            const std::string wrong = text.empty() ? "" : why_refused(parse_range(text));
            return wrong.empty() ? wrong : wrong + "; without a range, give it after the file";
          });
  add_shard(*command, options->shard,
            "replay only the i-th of N nearly equal ranges of frames, 1/N to N/N")
      ->excludes(frames);
  command
      ->add_option("--output,-o", options->folder,
                   "write the frames to this folder, as a part for ovws merge, which then reports "
                   "differences")
      ->excludes(speed)
      ->excludes(step);
  add_refine_options(*command, *options);
  command->callback([&common, &status, options] { status = replay_recording(common, *options); });
}

void add_merge(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "merge",
      "join the parts of ovws study --shard into the study's figures, or those of ovws replay -o "
      "into one list of frames; the result does not depend on the number of parts; works offline");
  auto options = std::make_shared<MergeOptions>();
  command->add_option("parts", options->parts, "all parts (JSON lines), in any order")->required();
  command->add_option("--output,-o", options->folder, "folder for the files")->required();
  command->callback([&common, &status, options] { status = merge_parts(common, *options); });
}

void add_study(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("study",
                                     "run a study and write its figures, numbers and summary to a "
                                     "folder; experiment and rejection "
                                     "run on a daemon's bench, the others work offline");
  auto options = std::make_shared<StudyOptions>();
  std::vector<std::string> names;
  std::string help = "one of:";
  for (const study::Study& one : study::kStudies) {
    names.emplace_back(one.name);
    help += std::string("\n") + one.name + ": " + one.what;
  }
  names.emplace_back(kExperiment);
  help += std::string("\n") + kExperiment +
          ": the paper's experiment on a daemon's bench: residual variance against camera gain";
  names.emplace_back(kRejection);
  help += std::string("\n") + kRejection +
          ": on a daemon's bench, the closed loop's disturbance rejection by frequency, with the "
          "laws integrator, optimised and predictor, or with the law that --params names";
  command->add_option("name", options->name, help)->required()->check(CLI::IsMember(names));
  command
      ->add_option("--output,-o", options->folder,
                   "folder for the files; replaces those of the same study")
      ->required();
  command->add_flag(
      "--quick", options->quick,
      "fewer levels and realisations: seconds instead of minutes; rejection ignores it");
  command->add_option("--threads", options->threads, "number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "random seed: the same seed gives the same numbers")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_shard(
      *command, options->shard,
      "measure only every N-th item of the study, 1/N to N/N, and write a part for ovws merge "
      "instead of the figures");
  command
      ->add_option(
          "--seconds", options->seconds,
          "rejection only: duration of each recording: one with the loop open, and one with each "
          "law")
      ->check(number_from(5.0, 86400.0))
      ->capture_default_str();
  command->add_option("--params", options->params,
                      "experiment and rejection only: what to measure (see the guide), or params "
                      "of loop.close as a JSON "
                      "object; see ovws describe");
  command->callback([&common, &status, options] { status = study_command(common, *options); });
}

}  // namespace

void add_offline_commands(CLI::App& app, const Common& common, int& status) {
  add_design(app, common, status);
  add_advise(app, common, status);
  add_hologram(app, common, status);
  add_farfield(app, common, status);
  add_measure(app, common, status);
  add_keygen(app, common, status);
  add_replay(app, common, status);
  add_export(app, common, status);
  add_study(app, common, status);
  add_merge(app, common, status);
}

}  // namespace ovws::cli
