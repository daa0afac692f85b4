#include "daemon/ovws/cli/design.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <regex>

#include "config/device_tables.hpp"
#include "config/devices.hpp"
#include "core/base/number_text.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/design/design.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/shared/atomic_file.hpp"
#include "proto/field_json.hpp"
#include "proto/json_part.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"

namespace ovws {

template <>
inline constexpr NamesOf kNames<design::Limit> =
    texts<"region", "neighbours", "scale", "grating", "orders", "modes", "beam">;

}  // namespace ovws

namespace ovws::design {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Change, options, meaning)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Figures, subapertures, modes, modes_by_positions, pupil_mm,
                                   subaperture_mm, subaperture_px, lambda_d_px, neighbours,
                                   range_waves, range_defocus_waves, grating_period_px,
                                   finest_period_px, zeroth_order_px, zeroth_order_mm)

inline void to_json(Json& out, const Finding& finding) {
  out = {{"limit", wire_name(finding.limit)},
         {"reason", finding.reason},
         {"help", text_or_null(finding.help)}};
}

}  // namespace ovws::design

namespace ovws::cli {
namespace {

struct DesignOptions {
  std::string slm, camera;  ///< the name of a model, or "WIDTHxHEIGHT@PITCH"
  design::Bench bench;      ///< without slm and camera
  std::string pixel_format = "Mono8";
  std::string config_path;  ///< configuration whose other keys are kept; empty: the defaults
  std::string output;       ///< configuration to write; empty: none
  std::string farfield;     ///< PNG to write; empty: none
  bool replace = false;
  bool list = false;
};

struct Panel {
  int width = 0, height = 0;
  double pitch_um = 0.0;
};

/// "1920x1080@8".
std::optional<Panel> parse_panel(const std::string& text) {
  static const std::regex form(R"((\d{1,5})x(\d{1,5})@(\d{1,4}(?:\.\d{1,6})?))");
  std::smatch found;
  if (!std::regex_match(text, found, form)) return std::nullopt;
  return Panel{std::stoi(found[1]), std::stoi(found[2]), finite_number(found[3].str()).value()};
}

template <class Model>
const Model* find_model(const std::vector<Model>& models, const std::string& name) {
  const auto found = std::find_if(models.begin(), models.end(),
                                  [&name](const Model& model) { return model.name == name; });
  return found == models.end() ? nullptr : &*found;
}

template <class Model>
Error unknown_model(const char* option, const std::vector<Model>& models, const std::string& name) {
  std::vector<std::string> names;
  for (const Model& model : models) names.push_back(model.name);
  const auto near = nearest_name(name, names);
  return {Errc::invalid, option,
          "\"" + name + "\" is no known model" + (near ? " (did you mean " + *near + "?)" : "") +
              ": give WIDTHxHEIGHT@PITCH, e.g. 1920x1080@8, or see ovws design --list"};
}

/// Checks a size and a pitch against the ranges of the configuration.
Result<Panel> in_range(const char* option, Panel panel, limits::Integers size,
                       limits::Numbers pitch) {
  const auto inside = [&size](int px) { return px >= size.min && px <= size.max; };
  if (inside(panel.width) && inside(panel.height) && panel.pitch_um >= pitch.min &&
      panel.pitch_um <= pitch.max) {
    return panel;
  }
  return fail(Errc::invalid, option,
              fmt::format("must be {} to {} pixels of {:g} to {:g} um", size.min, size.max,
                          pitch.min, pitch.max));
}

Result<void> set_slm(design::Bench& bench, const std::string& text) {
  const auto& models = known_devices().slms;
  if (const SlmModel* model = find_model(models, text)) {
    bench.slm = model->geometry;
    bench.settle_ms = model->settle_ms;
    return {};
  }
  const auto panel = parse_panel(text);
  if (!panel) return fail(unknown_model("--slm", models, text));
  const auto valid = in_range("--slm", *panel, limits::kSlmSizePx, limits::kSlmPitchUm);
  if (!valid) return fail(valid.error());
  bench.slm = {valid->width, valid->height, valid->pitch_um};
  return {};
}

/// The bench with its SLM, camera and pixel format.
Result<design::Bench> bench_of(const DesignOptions& options) {
  design::Bench bench = options.bench;
  if (auto set = set_slm(bench, options.slm); !set) return fail(set.error());
  if (auto set = set_camera(bench, options.camera); !set) return fail(set.error());
  const auto& formats = kNames<PixelFormat>();
  bench.pixel_format = PixelFormat(std::find(formats.begin(), formats.end(), options.pixel_format) -
                                   formats.begin());
  return bench;
}

int list_models(const Common& common) {
  const Devices& known = known_devices();
  if (common.json) return print_result(common, to_json(known), "");
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
    print("{}\n",
          json_text(Json{
              {"accepted", false}, {"finding", refusal.finding}, {"changes", refusal.changes}}));
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

std::string design_text(const design::Design& made) {
  Json said = made.figures;
  said["config"] = Json::parse(dump_config(made.config));
  std::string text = fill(
      "subapertures    {subapertures}, {config.sensor.subapertures_across} across, each "
      "{subaperture_mm:.3g} mm or {subaperture_px:.4g} SLM pixels\n"
      "modes           {modes}\n"
      "pupil           {pupil_mm:.4g} mm, to be covered by the beam\n"
      "spots           lambda/d {lambda_d_px:.3g} px, neighbours {neighbours:.2g} lambda/d "
      "apart\n"
      "range           {range_waves:.2g} waves over a subaperture, "
      "{range_defocus_waves:.2g} waves of defocus Z(2,0)\n"
      "gratings        period {grating_period_px:.3g} SLM pixels, the finest "
      "{finest_period_px:.2g}\n"
      "region          {config.camera.roi.width} x {config.camera.roi.height} px at "
      "({config.camera.roi.x}, {config.camera.roi.y})\n"
      "camera          its middle {zeroth_order_mm.0:.2f} mm right of and "
      "{zeroth_order_mm.1:.2f} mm below the zeroth order\n"
      "settle time     {config.slm.settle_ms:g} ms until slm.settle measures it",
      said);
  for (const design::Finding& finding : made.findings) {
    text += "\n" + fill("limited by {limit}: {reason}[help?; helps: {help}]", finding);
  }
  return text;
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
  farfield.output = options.farfield;
  return write_farfield(config, farfield);
}

/// Designs the bench, prints its figures and what limits it, and writes the requested files. A
/// bench that cannot work is an error with the changes that help.
int design_bench(const Common& common, const DesignOptions& options) {
  if (options.list) return list_models(common);
  const auto bench = bench_of(options);
  if (!bench) return report_mistake(common, bench.error());
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
  return print_result(common,
                      {{"accepted", true},
                       {"figures", made->figures},
                       {"findings", made->findings},
                       {"config", Json::parse(dump_config(made->config))}},
                      design_text(*made));
}

template <class Model>
std::string help_of(const char* what, const std::vector<Model>& models) {
  std::string names;
  for (const Model& model : models) names += (names.empty() ? "" : ", ") + model.name;
  return std::string(what) + ": a model (" + names +
         "), or WIDTHxHEIGHT@PITCH in pixels and micrometres, e.g. 1920x1080@8";
}

void add_bench_options(CLI::App& command, DesignOptions& options) {
  const Devices& known = known_devices();
  design::Bench& bench = options.bench;
  command.add_option("--slm", options.slm, help_of("SLM", known.slms));
  command.add_option("--camera", options.camera, help_of("camera sensor", known.cameras));
  command.add_option("--wavelength", bench.wavelength_nm, "wavelength of the laser, nm")
      ->check(number_from(limits::kWavelengthNm))
      ->capture_default_str();
  command.add_option("--focal-length", bench.focal_length_mm, "focal length of the lens, mm")
      ->check(number_from(limits::kFocalLengthMm))
      ->capture_default_str();
  command
      .add_option("--magnification", bench.magnification,
                  "magnification from the lens's focal plane to the camera")
      ->check(number_from(limits::kMagnification))
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

Result<void> set_camera(design::Bench& bench, const std::string& text) {
  const auto& models = known_devices().cameras;
  std::optional<Panel> panel = parse_panel(text);
  if (const CameraModel* model = find_model(models, text)) {
    panel = {model->width, model->height, model->pitch_um};
  }
  if (!panel) return fail(unknown_model("--camera", models, text));
  constexpr limits::Integers kSize{64, limits::kRoiSize.max};
  const auto valid = in_range("--camera", *panel, kSize, limits::kCameraPitchUm);
  if (!valid) return fail(valid.error());
  bench.sensor_width = valid->width;
  bench.sensor_height = valid->height;
  bench.camera_pitch_um = valid->pitch_um;
  return {};
}

void add_design(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "design",
      "design a bench: from SLM, camera, lens, wavelength and beam to a configuration, or to what "
      "makes it impossible and the changes that help; works offline",
      design_bench);
  add_bench_options(command, options);
  command.add_option("--config,-c", options.config_path,
                     "configuration file whose other keys are kept (default: every key's default)");
  command.add_option("--output,-o", options.output, "configuration file to write");
  command.add_flag("--replace", options.replace, "replace an existing configuration file");
  command.add_option("--farfield", options.farfield,
                     "PNG file to write: the camera image that is expected, with noise");
  command.add_flag("--list", options.list, "list the models of SLMs and camera sensors");
  command.parse_complete_callback([&options = options] {
    if (!options.list && (options.slm.empty() || options.camera.empty())) {
      throw CLI::RequiredError(options.slm.empty() ? "--slm" : "--camera");
    }
  });
}

}  // namespace ovws::cli
