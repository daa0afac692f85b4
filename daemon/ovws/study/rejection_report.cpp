#include "daemon/ovws/study/rejection_report.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace ovws::study {
namespace {

using nlohmann::json;

json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

Series line_of(const std::string& name, const Spectrum& spectrum) {
  Series series{name, {}, {}, {}, Series::Style::solid};
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    series.x.push_back(spectrum.hz(k));
    series.y.push_back(spectrum.power_per_hz[k]);
  }
  return series;
}

json summary_of(const RecordedLoop& loop) {
  const auto& times = loop.recording.times_s;
  const int all = loop.received + loop.lost;
  return {{"rms_waves", rms_waves(loop.recording)},
          {"frames", times.size()},
          {"frames_hz", double(times.size() - 1) / (times.back() - times.front())},
          {"interval_ms", 1e3 * median_interval_s(times)},
          {"missing_share", 1.0 - double(times.size()) / all},
          {"lost_share", double(loop.lost) / all},
          {"clock", loop.device_clock ? "device" : "arrival"}};
}

std::string recorded_text(const char* name, const json& recorded) {
  return fmt::format(
      "{}: {:.4f} wave RMS, {:.2f} usable frames/s; {:.0f} % of the frames are missing ({:.0f} % "
      "lost, the others not settled or not valid)\n",
      name, recorded["rms_waves"].get<double>(), recorded["frames_hz"].get<double>(),
      100.0 * recorded["missing_share"].get<double>(),
      100.0 * recorded["lost_share"].get<double>());
}

std::string crossing_text(const json& summary, const char* key, const char* level) {
  const json& hz = summary[key];
  if (hz.is_number()) return fmt::format("{} at {:.3g} Hz", level, hz.get<double>());
  return fmt::format("{} is not reached between {:.3g} and {:.3g} Hz", level,
                     summary["from_hz"].get<double>(), summary["to_hz"].get<double>());
}

}  // namespace

RejectionFound find_rejection(const RejectionMeasured& measured) {
  RejectionFound found;
  found.open = spectrum(measured.open.recording, measured.segment_s);
  found.closed = spectrum(measured.closed.recording, measured.segment_s);
  found.law = {measured.loop["gain"].get<double>(), measured.loop["leak"].get<double>(),
               measured.steps_hz};
  found.rejection = rejection(found.open, found.closed);
  found.bands = octave_bands(found.open, found.closed, found.law);
  return found;
}

std::vector<Figure> rejection_figures(const RejectionFound& found) {
  Figure spectra{"rejection-spectra", "power spectra with the loop open and closed",
                 "frequency (Hz)", "power of all modes (wave^2/Hz)"};
  spectra.log_x = spectra.log_y = true;
  spectra.series = {line_of("loop open", found.open), line_of("loop closed", found.closed)};
  Figure rejected{"rejection", "disturbance rejection of the closed loop", "frequency (Hz)",
                  "power, closed loop / open loop (dB)"};
  rejected.log_x = true;
  Series measured{"measured, in bands of a third of an octave", {}, {}, {}, Series::Style::solid};
  Series ideal{fmt::format("integrator of gain {:g} at {:.2g} steps/s without delay",
                           found.law.gain, found.law.steps_hz),
               {},
               {},
               {},
               Series::Style::line};
  for (const RejectionPoint& point : found.rejection) {
    measured.x.push_back(point.hz);
    measured.y.push_back(point.db);
    ideal.x.push_back(point.hz);
    ideal.y.push_back(integrator_db(point.hz, found.law));
  }
  ideal.colour = 2;  // colour of the measured series, dashed
  rejected.series = {std::move(measured), std::move(ideal)};
  return {std::move(spectra), std::move(rejected)};
}

json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found) {
  json summary{{"study", "rejection"},
               {"modes_j", measured.modes_j},
               {"loop", measured.loop},
               {"steps_hz", measured.steps_hz},
               {"open", summary_of(measured.open)},
               {"closed", summary_of(measured.closed)},
               {"segment_s", measured.segment_s},
               {"from_hz", found.rejection.front().hz},
               {"to_hz", found.rejection.back().hz},
               {"bands", json::array()}};
  const auto zero = crossing_hz(found.rejection, 0.0), half = crossing_hz(found.rejection, -3.0);
  summary["crossing_0_db_hz"] = zero ? json(*zero) : json(nullptr);
  summary["bandwidth_3_db_hz"] = half ? json(*half) : json(nullptr);
  for (const RejectionBand& band : found.bands) {
    summary["bands"].push_back({{"from_hz", band.from_hz},
                                {"to_hz", band.to_hz},
                                {"rejection_db", number_or_null(band.db)},
                                {"integrator_db", number_or_null(band.integrator_db)}});
  }
  return summary;
}

std::string rejection_text(const json& summary) {
  std::string text = recorded_text("open", summary["open"]);
  text += recorded_text("closed", summary["closed"]);
  text += fmt::format("{:.2f} steps/s of gain {:g}\n\n{:>17}  {:>9}  {:>10}\n",
                      summary["steps_hz"].get<double>(), summary["loop"]["gain"].get<double>(),
                      "Hz", "dB", "integrator");
  for (const json& band : summary["bands"]) {
    const json& ideal = band["integrator_db"];
    text += fmt::format("{:>7.4g} to {:>6.4g}  {:>9.1f}  {:>10}\n", band["from_hz"].get<double>(),
                        band["to_hz"].get<double>(), band["rejection_db"].get<double>(),
                        ideal.is_number() ? fmt::format("{:.1f}", ideal.get<double>()) : "-");
  }
  return text + "\n" + crossing_text(summary, "bandwidth_3_db_hz", "-3 dB") + "; " +
         crossing_text(summary, "crossing_0_db_hz", "0 dB") + "\n";
}

}  // namespace ovws::study
