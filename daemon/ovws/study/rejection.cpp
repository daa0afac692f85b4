#include "daemon/ovws/study/rejection.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/control/integrator.hpp"

namespace ovws::study {
namespace {

/// First usable bin: under a Hann window, removing the mean also affects the bin before it.
constexpr std::size_t kFirstBin = 1;

double db_of(double power_ratio) {
  return 10.0 * std::log10(power_ratio);
}

/// Whether from_hz <= hz < to_hz, with a tolerance for rounding of the edges.
bool is_between(double hz, double from_hz, double to_hz) {
  constexpr double kTolerance = 1.0 - 1e-9;
  return hz >= from_hz * kTolerance && hz < to_hz * kTolerance;
}

double sum_between(const Spectrum& spectrum, double from_hz, double to_hz) {
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    if (is_between(spectrum.hz(k), from_hz, to_hz)) sum += spectrum.power_per_hz[k];
  }
  return sum;
}

/// Predicted rejection of the integrator in a band, weighted with the open loop's power, dB.
double integrator_band_db(const Spectrum& open, double from_hz, double to_hz, const LoopLaw& law) {
  double there = 0.0, left = 0.0;
  for (std::size_t k = 0; k < open.power_per_hz.size(); ++k) {
    if (!is_between(open.hz(k), from_hz, to_hz)) continue;
    there += open.power_per_hz[k];
    left += open.power_per_hz[k] * std::pow(10.0, 0.1 * integrator_db(open.hz(k), law));
  }
  return db_of(left / there);
}

using nlohmann::json;

json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

Series line_of(const std::string& name, const Spectrum& spectrum) {
  Series series{name, {}, {}, {}, Series::Style::solid};
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    series.add(spectrum.hz(k), spectrum.power_per_hz[k]);
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

double rms_waves(const ModeSeries& recording) {
  double squares = 0.0;
  for (const auto& mode : recording.modes_waves) {
    for (const double waves : mode) squares += waves * waves;
  }
  return std::sqrt(squares / double(recording.times_s.size()));
}

std::vector<RejectionPoint> rejection(const Spectrum& open, const Spectrum& closed) {
  const double half = std::exp2(1.0 / 6.0);
  const std::size_t count = std::min(open.power_per_hz.size(), closed.power_per_hz.size());
  std::vector<RejectionPoint> points;
  for (std::size_t k = kFirstBin; k < count; ++k) {
    const double hz = open.hz(k), beyond = open.hz(count);
    const double from = std::max(hz / half, open.hz(kFirstBin));
    const double to = std::min(hz * half, beyond);
    points.push_back({hz, db_of(sum_between(closed, from, to) / sum_between(open, from, to))});
  }
  return points;
}

std::optional<double> crossing_hz(const std::vector<RejectionPoint>& rejection, double level_db) {
  if (rejection.empty() || rejection.front().db > level_db) return std::nullopt;
  for (std::size_t k = 1; k < rejection.size(); ++k) {
    const RejectionPoint &a = rejection[k - 1], &b = rejection[k];
    if (!(b.db > level_db)) continue;
    return a.hz * std::pow(b.hz / a.hz, (level_db - a.db) / (b.db - a.db));
  }
  return std::nullopt;
}

double integrator_db(double hz, const LoopLaw& law) {
  if (!(hz <= 0.5 * law.steps_hz)) return std::numeric_limits<double>::quiet_NaN();
  const Integrator integrator(law.gain, law.leak, 0.0);
  return db_of(std::norm(1.0 - integrator.transfer({&hz, 1}, 1.0 / law.steps_hz).front()));
}

std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const LoopLaw& law) {
  const std::size_t count = std::min(open.power_per_hz.size(), closed.power_per_hz.size());
  if (count <= kFirstBin) return {};
  const double first = open.hz(kFirstBin), last = open.hz(count - 1);
  std::vector<RejectionBand> bands;
  double from = 0.1 * std::exp2(std::ceil(std::log2(first / 0.1) - 1e-9));
  for (; 2.0 * from <= last; from *= 2.0) {
    const double to = 2.0 * from;
    bands.push_back({from, to, db_of(sum_between(closed, from, to) / sum_between(open, from, to)),
                     integrator_band_db(open, from, to, law)});
  }
  return bands;
}

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
  Series ideal{.name = fmt::format("integrator of gain {:g} at {:.2g} steps/s without delay",
                                   found.law.gain, found.law.steps_hz),
               .style = Series::Style::line,
               .colour = 2};  // of the measured series, dashed
  for (const RejectionPoint& point : found.rejection) {
    measured.add(point.hz, point.db);
    ideal.add(point.hz, integrator_db(point.hz, found.law));
  }
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
