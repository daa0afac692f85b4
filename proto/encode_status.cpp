/// The rare messages: refined, status and event.
#include <cmath>

#include "proto/encode.hpp"
#include "proto/tables/status.hpp"

namespace ovws {
namespace {

using nlohmann::json;

std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json or_null(double number) {
  return std::isnan(number) ? json() : json(number);
}

/// Root sum square without piston and tilts.
double rms_waves(const RefinedMessage& message) {
  double squares = 0.0;
  for (std::size_t k = 0; k < message.j.size(); ++k) {
    if (message.j[k] > 2) squares += message.coefficients[k] * message.coefficients[k];
  }
  return std::sqrt(squares);
}

std::string_view severity_name(Severity severity) {
  switch (severity) {
    case Severity::info:
      return "info";
    case Severity::warning:
      return "warning";
    case Severity::error:
      return "error";
  }
  return "error";
}

}  // namespace

std::string encode(const RefinedMessage& message) {
  const json unknown = std::vector<json>(message.j.size());
  const auto& fit = message.fit;
  return text_of({{"schema", "ovws.refined/1"},
                  {"seq", message.seq},
                  {"frame_id", message.frame_id},
                  {"t_arrival_ns", message.t_arrival_ns},
                  {"t_publish_ns", message.t_publish_ns},
                  {"hologram_id", message.hologram_id},
                  {"charge", message.charge},
                  {"valid", message.valid},
                  {"reason", message.valid ? json() : json(message.reason)},
                  {"against", message.against_reference ? "reference" : "model"},
                  {"unit", "wave"},
                  {"wavelength_nm", message.wavelength_nm},
                  {"basis", "zernike-osa-rms"},
                  {"orientation", "x-right-y-down"},
                  {"rms_waves", message.valid ? json(rms_waves(message)) : json()},
                  {"gain_db", or_null(message.gain_db)},
                  {"gain_raw", or_null(message.gain_raw)},
                  {"exposure_us", message.exposure_us},
                  {"j", message.j},
                  {"coefficients", message.valid ? json(message.coefficients) : unknown},
                  {"sigma", message.valid ? json(message.sigma) : unknown},
                  {"chi2_per_pixel", fit ? json(fit->chi2_per_pixel) : json()},
                  {"peak_e", fit ? json(fit->peak_e) : json()},
                  {"background_e", fit ? json(fit->background_e) : json()},
                  {"iterations", fit ? json(fit->iterations) : json()},
                  {"duration_ms", message.duration_ms}});
}

std::string encode(const StatusMessage& message) {
  json out = to_json(message);
  out["schema"] = "ovws.status/1";
  out["seq"] = message.seq;
  return text_of(out);
}

std::string encode(const EventMessage& message, const json& data) {
  return text_of({{"schema", "ovws.event/1"},
                  {"seq", message.seq},
                  {"t_ns", message.t_ns},
                  {"kind", message.kind},
                  {"severity", severity_name(message.severity)},
                  {"text", message.text},
                  {"data", data}});
}

}  // namespace ovws
