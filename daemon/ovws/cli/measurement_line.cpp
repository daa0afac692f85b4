#include "daemon/ovws/cli/measurement_line.hpp"

#include <cmath>

#include "core/tracking/tracker.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "proto/encode.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"

namespace ovws::cli {

using nlohmann::json;

namespace {

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

}  // namespace

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
  if (measured.valid) message.rms_waves = measured.reconstruction.rms_waves;
  if (measured.reconstruction.determined) {
    message.fit_residual_px = measured.reconstruction.fit_residual_px;
  }
  message.saturated = measured.saturated;
  message.j = measurement.plan().modes_j;
  message.coefficients = measured.coefficients;
  message.sigma = measured.sigma_waves;
  message.fitted = measured.fitted;
  std::string text;
  encode(message, text);
  json line = json_of(text);
  for (const char* unknown : {"t_device_ns", "t_arrival_ns", "t_publish_ns", "latency_us"}) {
    line[unknown] = nullptr;
  }
  line["file"] = file;
  line["spots"] = spots_of(measured);
  line["torn"] = json::array();
  line["template"] = wire_name(config.tracking.templates);
  put_fields(line, template_report(config.tracking));
  line["operator"] = wire_name(config.tracking.mode_operator);
  put_fields(line, measured.mode_operator);
  return line;
}

void print_table(const json& line) {
  print("{}: {} of {} spots, {}\n", line["file"].get<std::string>(), line["tracked"].get<int>(),
        line["subapertures"].get<int>(), line["valid"].get<bool>() ? "valid" : "NOT VALID");
  if (line["template_reason"].is_string()) {
    print("{}\n", line["template_reason"].get<std::string>());
  }
  if (line["operator_reason"].is_string()) {
    print("the operator is {}: {}\n", line["operator_in_force"].get<std::string>(),
          line["operator_reason"].get<std::string>());
  }
  if (line.contains("refined") && line["refined"]["reason"].is_string()) {
    print("refined: {}\n", line["refined"]["reason"].get<std::string>());
  }
  if (!line["valid"].get<bool>()) {
    if (line["fit_residual_px"].is_number() && !line.contains("refined")) {
      print("fit residual {:.4f} px: no wavefront explains the spot positions\n",
            line["fit_residual_px"].get<double>());
    }
    return;
  }
  for (std::size_t k = 0; k < line["j"].size(); ++k) {
    const int j = line["j"][k].get<int>();
    print("{:>4} {:<32} {:+9.4f}\n", j, zernike_name(j), line["coefficients"][k].get<double>());
  }
  print("RMS {:.4f} wave without tilts", line["rms_waves"].get<double>());
  if (line["fit_residual_px"].is_number()) {
    print(", fit residual {:.4f} px", line["fit_residual_px"].get<double>());
  }
  if (line.contains("refined") && line["refined"]["chi2_per_pixel"].is_number()) {
    print(", refined: chi2 per pixel {:.3f}", line["refined"]["chi2_per_pixel"].get<double>());
  }
  print("\n");
}

void put_refined(json& line, const Measured& measured, bool amplitudes) {
  const std::vector<int> modes_j = line["j"];
  const bool valid = measured.valid && measured.refined;
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

}  // namespace ovws::cli
