#include "daemon/ovws/study/rejection.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/control/loop_laws.hpp"
#include "proto/tables/loop.hpp"

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

Spectrum expected_spectrum(const ModeSeries& open, double segment_s,
                           std::span<const std::unique_ptr<ModeLaw>> laws, double steps_hz) {
  Spectrum all;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Spectrum one = spectrum({open.times_s, {open.modes_waves[i]}}, segment_s);
    if (all.power_per_hz.empty()) all = {one.step_hz, std::vector(one.power_per_hz.size(), 0.0)};
    std::vector<double> hz;
    for (std::size_t k = 0; k < one.power_per_hz.size(); ++k) hz.push_back(one.hz(k));
    const auto passed = laws[i]->transfer(hz, {1.0 / steps_hz, 1.0 / steps_hz});
    for (std::size_t k = 0; k < hz.size(); ++k) {
      all.power_per_hz[k] += hz[k] <= 0.5 * steps_hz
                                 ? std::norm(1.0 - passed[k]) * one.power_per_hz[k]
                                 : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return all;
}

std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const Spectrum& expected) {
  const std::size_t count = std::min(open.power_per_hz.size(), closed.power_per_hz.size());
  if (count <= kFirstBin) return {};
  const double first = open.hz(kFirstBin), last = open.hz(count - 1);
  std::vector<RejectionBand> bands;
  double from = 0.1 * std::exp2(std::ceil(std::log2(first / 0.1) - 1e-9));
  for (; 2.0 * from <= last; from *= 2.0) {
    const double to = 2.0 * from, there = sum_between(open, from, to);
    bands.push_back({from, to, db_of(sum_between(closed, from, to) / there),
                     db_of(sum_between(expected, from, to) / there)});
  }
  return bands;
}

namespace {

FoundLaw found_of(const MeasuredLaw& law, const Spectrum& open, const RejectionMeasured& measured) {
  const auto make = laws_of(law.settings, measured.model);
  std::vector<std::unique_ptr<ModeLaw>> laws;
  for (const int j : measured.modes_j) laws.push_back(make(j, 0.0));
  FoundLaw found;
  found.name = wire_name(law.settings.law);
  found.steps_hz = law.steps_hz;
  found.closed = spectrum(law.closed.recording, measured.segment_s);
  found.expected =
      expected_spectrum(measured.open.recording, measured.segment_s, laws, law.steps_hz);
  found.rejection = rejection(open, found.closed);
  found.expected_rejection = rejection(open, found.expected);
  found.bands = octave_bands(open, found.closed, found.expected);
  return found;
}

Series line_of(const std::string& name, const std::vector<RejectionPoint>& points) {
  Series series{.name = name, .style = Series::Style::solid};
  for (const RejectionPoint& point : points) series.add(point.hz, point.db);
  return series;
}

json crossing(const FoundLaw& law, double level_db) {
  const auto hz = crossing_hz(law.rejection, level_db);
  return hz ? json(*hz) : json(nullptr);
}

json law_summary(const MeasuredLaw& measured, const FoundLaw& found) {
  json bands = json::array();
  for (const RejectionBand& band : found.bands) {
    bands.push_back({{"from_hz", band.from_hz},
                     {"to_hz", band.to_hz},
                     {"rejection_db", number_or_null(band.db)},
                     {"expected_db", number_or_null(band.expected_db)}});
  }
  return {{"law", found.name},
          {"loop", measured.loop},
          {"steps_hz", measured.steps_hz},
          {"closed", summary_of(measured.closed)},
          {"from_hz", found.rejection.front().hz},
          {"to_hz", found.rejection.back().hz},
          {"crossing_0_db_hz", crossing(found, 0.0)},
          {"bandwidth_3_db_hz", crossing(found, -3.0)},
          {"bands", std::move(bands)}};
}

std::string law_text(const json& law) {
  std::string text = recorded_text(law["law"].get<std::string>().c_str(), law["closed"]);
  return text + fmt::format("  {:.2f} steps/s; ", law["steps_hz"].get<double>()) +
         crossing_text(law, "bandwidth_3_db_hz", "-3 dB") + "; " +
         crossing_text(law, "crossing_0_db_hz", "0 dB") + "\n";
}

std::string db_text(const json& db) {
  return db.is_number() ? fmt::format("{:.1f}", db.get<double>()) : "-";
}

/// Bands of all laws side by side: measured, and expected in brackets.
std::string bands_text(const json& laws) {
  std::string text = fmt::format("{:>17}", "Hz");
  for (const json& law : laws) text += fmt::format("  {:>20}", law["law"].get<std::string>());
  for (std::size_t k = 0; k < laws.front()["bands"].size(); ++k) {
    const json& first = laws.front()["bands"][k];
    text += fmt::format("\n{:>7.4g} to {:>6.4g}", first["from_hz"].get<double>(),
                        first["to_hz"].get<double>());
    for (const json& law : laws) {
      if (k >= law["bands"].size()) continue;
      const json& band = law["bands"][k];
      text += fmt::format("  {:>11} ({:>6})", db_text(band["rejection_db"]),
                          db_text(band["expected_db"]));
    }
  }
  return text + "\ndB, expected without further delay in brackets\n";
}

}  // namespace

RejectionFound find_rejection(const RejectionMeasured& measured) {
  RejectionFound found;
  found.open = spectrum(measured.open.recording, measured.segment_s);
  for (const MeasuredLaw& law : measured.laws) {
    found.laws.push_back(found_of(law, found.open, measured));
  }
  return found;
}

std::vector<Figure> rejection_figures(const RejectionFound& found) {
  Figure spectra{"rejection-spectra", "power spectra with the loop open and closed",
                 "frequency (Hz)", "power of all modes (wave^2/Hz)"};
  spectra.log_x = spectra.log_y = true;
  spectra.series = {line_of("loop open", found.open)};
  Figure rejected{"rejection", "disturbance rejection of the closed loop", "frequency (Hz)",
                  "power, closed loop / open loop (dB)"};
  rejected.log_x = true;
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    const FoundLaw& law = found.laws[k];
    spectra.series.push_back(line_of(law.name, law.closed));
    rejected.series.push_back(
        line_of(fmt::format("{}, {:.2g} steps/s", law.name, law.steps_hz), law.rejection));
    rejected.series.back().colour = int(k) + 1;
  }
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    Series expected = line_of("expected without further delay", found.laws[k].expected_rejection);
    expected.style = Series::Style::line;
    expected.colour = int(k) + 1;
    expected.in_legend = k == 0;
    rejected.series.push_back(std::move(expected));
  }
  return {std::move(spectra), std::move(rejected)};
}

json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found) {
  json laws = json::array();
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    laws.push_back(law_summary(measured.laws[k], found.laws[k]));
  }
  return {{"study", "rejection"},
          {"modes_j", measured.modes_j},
          {"open", summary_of(measured.open)},
          {"segment_s", measured.segment_s},
          {"laws", std::move(laws)}};
}

std::string rejection_text(const json& summary) {
  std::string text = recorded_text("open", summary["open"]);
  for (const json& law : summary["laws"]) text += law_text(law);
  return text + "\n" + bands_text(summary["laws"]);
}

}  // namespace ovws::study
