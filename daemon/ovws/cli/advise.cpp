/// ovws advise: which sensor suits the light and the modes that are wanted.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/design.hpp"
#include "daemon/ovws/design/advise.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/shared/slm_files.hpp"
#include "proto/field_json.hpp"
#include "proto/json_part.hpp"
#include "proto/limits.hpp"

namespace ovws::cli {
namespace {

constexpr std::size_t kShown = 5;

struct AdviseOptions {
  std::string config_path, camera;
  int modes = 0;
  double frame_rate_hz = 100.0;
  design::Light light;
};

/// The bench of a configuration, with the camera of --camera.
Result<design::Bench> bench_of(const Config& config, const AdviseOptions& options) {
  design::Bench bench = design::bench_of(config);
  if (!options.camera.empty()) {
    if (auto set = set_camera(bench, options.camera); !set) return fail(set.error());
  }
  bench.modes = options.modes;
  return bench;
}

const char* name_of(design::ExposureLimit limit) {
  return limit == design::ExposureLimit::time ? "frame rate" : "full well";
}

Json json_of_advice(const design::Advice& advice) {
  return {{"subapertures_across", advice.subapertures_across},
          {"subapertures", advice.subapertures},
          {"charge", advice.charge},
          {"exposure_us", advice.exposure_us},
          {"peak_e", advice.peak_e},
          {"error_waves", advice.error_waves},
          {"worst_mode_waves", advice.worst_waves},
          {"limited_by", name_of(advice.limited_by)},
          {"config", Json::parse(dump_config(advice.config))}};
}

/// The sensor of the configuration as it is, with or without advice.
using Configured = tl::expected<design::Advice, design::Unfit>;

Json json_of_unfit(const design::Unfit& one) {
  return {{"subapertures_across", one.subapertures_across},
          {"charge", one.charge},
          {"reason", one.reason}};
}

Json advice_json(const design::AdviceList& list, const Configured& configured) {
  Json best = Json::array(), unfit = Json::array();
  for (const design::Advice& advice : list.best_first) best.push_back(json_of_advice(advice));
  for (const design::Unfit& one : list.unfit) unfit.push_back(json_of_unfit(one));
  Json own = configured ? json_of_advice(*configured) : json_of_unfit(configured.error());
  if (configured) own["warning"] = text_or_null(configured->warning);
  return {{"best_first", best}, {"unfit", unfit}, {"configured", own}};
}

std::string row_text(const Json& advice) {
  return fill(
             "{subapertures_across:>6} {subapertures:>13} {charge:>7} {exposure_us:>12.0f} "
             "{peak_e:>9.0f} {error_waves:>12.5f} {worst_mode_waves:>12.5f}  {limited_by}",
             advice) +
         "\n";
}

/// `advice`: by advice_json. Without a final newline.
std::string advice_text(const Json& advice, int modes) {
  const Json &best = advice.at("best_first"), &own = advice.at("configured");
  const bool is_fit = !own.contains("reason");
  std::string text;
  if (is_fit || !best.empty()) {
    text =
        "across  subapertures  charge  exposure us    peak e  error waves   worst mode  limited "
        "by\n";
  }
  for (std::size_t k = 0; k < std::min(kShown, best.size()); ++k) text += row_text(best[k]);
  text += "the configuration as it is";
  if (is_fit) text += ":\n" + row_text(own);
  text += fill(
      "[reason?, {subapertures_across} across of charge {charge}, is left out: {reason}]"
      "[warning?  warning: {warning}]",
      own);
  if (text.ends_with('\n')) text.pop_back();
  if (best.empty()) return text;
  return text + fmt::format("\nbest for {} modes: ", modes) +
         fill(
             "{subapertures} subapertures of charge {charge}, exposure {exposure_us:.0f} us\n"
             "[limited_by=frame rate?the light limits it: a lower frame rate or more light reduces "
             "the error][limited_by=full well?the camera's full well limits it: the mean of more "
             "frames reduces the error]",
             best.front());
}

/// Says why no sensor is advised.
void print_none(const design::AdviceList& list, const AdviseOptions& options) {
  double least_e_per_s = 0.0;  // for the sensor that needs least; 0: more light helps none
  for (const design::Unfit& one : list.unfit) {
    const double needed = one.needed_e_per_s;
    if (needed > 0.0 && (least_e_per_s == 0.0 || needed < least_e_per_s)) least_e_per_s = needed;
  }
  if (least_e_per_s > 0.0) {
    fmt::print(stderr,
               "ovws: the light is too low for any sensor of this bench: --photons {:.2g}, and at "
               "{:g} frames per second {:.2g} are needed\n",
               options.light.e_per_s, options.frame_rate_hz, least_e_per_s);
  } else {
    fmt::print(stderr, "ovws: no sensor measures {} modes on this bench\n", options.modes);
  }
  for (const design::Unfit& one : list.unfit) {
    fmt::print(stderr, "  {} across, charge {}: {}\n", one.subapertures_across, one.charge,
               one.reason);
  }
}

int advise_bench(const Common& common, const AdviseOptions& options) {
  const auto config = load_config_and_masks(options.config_path);
  if (!config) return report(common, config.error());
  if (config->modulator == Modulator::fixed) {
    return report(common, {Errc::invalid, "modulator",
                           "the lenslets of a fixed array cannot be chosen: advise compares "
                           "lattices that an SLM or a DMD shows"});
  }
  const auto bench = bench_of(*config, options);
  if (!bench) return report(common, bench.error());
  design::Light light = options.light;
  light.longest_us = 1e6 / options.frame_rate_hz;
  const design::AdviceList list = design::advise(*bench, light, *config);
  const Configured configured = design::advise_on(*config, options.modes, light);
  const Json advice = advice_json(list, configured);
  print_result(common, advice, advice_text(advice, options.modes));
  if (!list.best_first.empty()) return kOk;
  if (!common.json) print_none(list, options);
  return kError;
}

}  // namespace

void add_advise(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "advise",
      "advise on the sensor of a configured bench: which number of subapertures, charge and "
      "exposure give the smallest error for the light and the modes that are wanted; works "
      "offline",
      advise_bench);
  command.add_option("--modes", options.modes, "number of Zernike modes that are wanted")
      ->required()
      ->check(CLI::Range(int(limits::kAdvisedModes.min), int(limits::kAdvisedModes.max)));
  command
      .add_option("--photons", options.light.e_per_s,
                  "photo-electrons per second that the light on the whole pupil gives on the "
                  "camera")
      ->required()
      ->check(number_from(limits::kPhotoElectronsPerS));
  command
      .add_option("--frame-rate", options.frame_rate_hz,
                  "frames per second; the exposure is at most their interval")
      ->check(number_from(limits::kFrameRateHz))
      ->capture_default_str();
  command.add_option("--full-well", options.light.full_well_e, "full well of a pixel, electrons")
      ->check(number_from(limits::kFullWellE))
      ->capture_default_str();
  command.add_option("--read-noise", options.light.read_noise_e, "read noise, electrons")
      ->check(number_from(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--config,-c", options.config_path,
                     "configuration file of the bench (default: every key's default)");
  command.add_option("--camera", options.camera,
                     "camera sensor, as in ovws design (default: the configured region)");
}

}  // namespace ovws::cli
