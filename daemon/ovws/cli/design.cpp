#include "daemon/ovws/cli/design.hpp"

#include <sys/stat.h>

#include "config/device_tables.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/design/design_tables.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/shared/atomic_file.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

int list_models(const Common& common) {
  const Devices& known = known_devices();
  if (common.json) {
    print("{}\n", json_text(to_json(known)));
    return kOk;
  }
  const auto row = [](const auto& model, int width, int height, double pitch_um) {
    print("  {:<20} {:4} x {:4}  {:5.2f} um  {}{}\n", model.name, width, height, pitch_um,
          model.confirmed ? "" : "NOT CONFIRMED: ", model.source);
  };
  print("SLMs\n");
  for (const SlmModel& slm : known.slms) {
    row(slm, slm.geometry.width_px, slm.geometry.height_px, slm.geometry.pitch_um);
  }
  print("camera sensors\n");
  for (const CameraModel& one : known.cameras) row(one, one.width, one.height, one.pitch_um);
  return kOk;
}

int report_refusal(const Common& common, const design::Refusal& refusal) {
  if (common.json) {
    print("{}\n", json_text(Json{{"accepted", false},
                                 {"finding", to_json(refusal.finding)},
                                 {"changes", to_json(refusal.changes)}}));
    return kError;
  }
  fmt::print(stderr, "ovws: this bench cannot work ({}): {}\n", wire_name(refusal.finding.limit),
             refusal.finding.reason);
  for (const design::Change& change : refusal.changes) {
    fmt::print(stderr, "  {:<28} {}\n", change.options, change.meaning);
  }
  if (refusal.changes.empty()) fmt::print(stderr, "  no single change or pair was found to help\n");
  return kError;
}

void print_design(const design::Design& made) {
  const design::Figures& f = made.figures;
  const Config& config = made.config;
  const Roi& roi = config.camera.settings.roi;
  const auto line = [](const char* what, const std::string& text) {
    print("{:<15} {}\n", what, text);
  };
  line("subapertures",
       fmt::format("{}, {} across, each {:.3g} mm or {:.4g} SLM pixels", f.subapertures,
                   config.sensor.subapertures_across, f.subaperture_mm, f.subaperture_px));
  line("modes", std::to_string(f.modes));
  line("pupil", fmt::format("{:.4g} mm, to be covered by the beam", f.pupil_mm));
  line("spots", fmt::format("lambda/d {:.3g} px, neighbours {:.2g} lambda/d apart", f.lambda_d_px,
                            f.neighbours));
  line("range", fmt::format("{:.2g} waves over a subaperture, {:.2g} waves of defocus Z(2,0)",
                            f.range_waves, f.range_defocus_waves));
  line("gratings", fmt::format("period {:.3g} SLM pixels, the finest {:.2g}", f.grating_period_px,
                               f.finest_period_px));
  line("region", fmt::format("{} x {} px at ({}, {})", roi.width, roi.height, roi.x, roi.y));
  line("camera", fmt::format("its middle {:.2f} mm right of and {:.2f} mm below the zeroth order",
                             f.zeroth_order_mm[0], f.zeroth_order_mm[1]));
  line("settle time", fmt::format("{:g} ms until slm.settle measures it", config.slm.settle_ms));
  for (const design::Finding& finding : made.findings) {
    print("limited by {}: {}{}{}\n", wire_name(finding.limit), finding.reason,
          finding.help.empty() ? "" : "; helps: ", finding.help);
  }
}

Result<void> write_config(const DesignOptions& options, const Config& config) {
  if (options.output.empty()) return {};
  struct stat there {};
  if (!options.replace && ::stat(options.output.c_str(), &there) == 0) {
    return fail(Errc::refused, "--output",
                options.output + " exists: name another file, or give --replace");
  }
  const std::string heading = fmt::format(
      "// Designed by ovws for SLM {}, camera {}, a lens of {:g} mm and {:g} nm.\n", options.slm,
      options.camera, options.bench.focal_length_mm, options.bench.wavelength_nm);
  return replace_file(options.output, heading + dump_config(config));
}

Result<void> write_design(const DesignOptions& options, const Config& config) {
  if (auto usable = check_usable(config); !usable) return usable;
  if (auto written = write_config(options, config); !written) return written;
  if (options.farfield.empty()) return {};
  FarFieldOptions farfield;
  farfield.picture.output = options.farfield;
  return write_farfield(config, farfield);
}

}  // namespace

int design_bench(const Common& common, const DesignOptions& options) {
  if (options.list) return list_models(common);
  const auto bench = bench_of(options);
  if (!bench) {
    report(common, bench.error());
    return kUsage;
  }
  Config base;
  if (!options.config_path.empty()) {
    auto loaded = load_config(options.config_path);
    if (!loaded) return report(common, loaded.error());
    base = std::move(*loaded);
  }
  const auto made = design::design(*bench, base);
  if (!made) return report_refusal(common, made.error());
  if (auto written = write_design(options, made->config); !written) {
    return report(common, written.error());
  }
  if (common.json) {
    print("{}\n", json_text(Json{{"accepted", true},
                                 {"figures", to_json(made->figures)},
                                 {"findings", to_json(made->findings)},
                                 {"config", Json::parse(dump_config(made->config))}}));
  } else {
    print_design(*made);
  }
  return kOk;
}

}  // namespace ovws::cli
