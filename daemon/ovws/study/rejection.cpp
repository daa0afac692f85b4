#include "daemon/ovws/study/rejection.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/median.hpp"
#include "core/control/forecast.hpp"
#include "core/control/loop_laws.hpp"
#include "daemon/ovws/text/fill.hpp"
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

Series line_of(const std::string& name, const Spectrum& spectrum) {
  Series series{name, {}, {}, {}, Series::Style::solid};
  for (std::size_t k = 0; k < spectrum.power_per_hz.size(); ++k) {
    series.add(spectrum.hz(k), spectrum.power_per_hz[k]);
  }
  return series;
}

json loop_summary(const RecordedLoop& loop) {
  const auto& times = loop.recording.times_s;
  const int all = loop.received + loop.lost;
  return {{"rms_waves", rms_waves(loop.recording)},
          {"frames", times.size()},
          {"frames_hz", double(times.size() - 1) / (times.back() - times.front())},
          {"interval_ms", 1e3 * median_interval_s(times)},
          {"uncorrected_waves", loop.uncorrected_waves},
          {"fit_residual_px", loop.fit_residual_px},
          {"missing_share", 1.0 - double(times.size()) / all},
          {"lost_share", double(loop.lost) / all},
          {"clock", loop.device_clock ? "device" : "arrival"}};
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

double noise_floor_per_hz(const Spectrum& spectrum) {
  const auto& power = spectrum.power_per_hz;
  return median(std::vector(power.end() - std::ptrdiff_t((power.size() + 3) / 4), power.end()));
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
                           std::span<const std::unique_ptr<ModeLaw>> laws,
                           const LoopTiming& timing) {
  Spectrum all;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Spectrum one = spectrum({open.times_s, {open.modes_waves[i]}}, segment_s);
    if (all.power_per_hz.empty()) all = {one.step_hz, std::vector(one.power_per_hz.size(), 0.0)};
    std::vector<double> hz;
    for (std::size_t k = 0; k < one.power_per_hz.size(); ++k) hz.push_back(one.hz(k));
    const auto passed = laws[i]->transfer(hz, timing);
    for (std::size_t k = 0; k < hz.size(); ++k) {
      all.power_per_hz[k] += hz[k] * timing.step_s <= 0.5
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

/// RMS noise of each mode in one frame, from the noise floors of the open loop's spectra.
std::vector<double> frame_noise(const ModeSeries& open, double segment_s) {
  const double highest_hz = 0.5 / median_interval_s(open.times_s);
  std::vector<double> all;
  for (const auto& mode : open.modes_waves) {
    const double floor = noise_floor_per_hz(spectrum({open.times_s, {mode}}, segment_s));
    all.push_back(std::sqrt(floor * highest_hz));
  }
  return all;
}

/// Noise that the laws pass on to the correction, root sum square.
double passed_noise(std::span<const std::unique_ptr<ModeLaw>> laws,
                    std::span<const double> noise_waves, const LoopTiming& timing) {
  std::vector<double> passed;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    passed.push_back(forecast(*laws[k], {{}, noise_waves[k]}, timing).residual_waves);
  }
  return root_sum_square(passed);
}

FoundLaw found_of(const MeasuredLaw& law, const Spectrum& open, const RejectionMeasured& measured,
                  std::span<const double> noise_waves) {
  const auto make = laws_of(law.settings, measured.model);
  std::vector<std::unique_ptr<ModeLaw>> laws;
  for (const int j : measured.modes_j) laws.push_back(make(j, 0.0));
  FoundLaw found;
  found.name = wire_name(law.settings.law);
  found.timing = law.timing;
  found.noise_passed_waves = passed_noise(laws, noise_waves, law.timing);
  // The noise of a frame, and that of earlier frames in the correction, are independent.
  found.noise_limit_waves = std::hypot(root_sum_square(noise_waves), found.noise_passed_waves);
  found.closed = spectrum(law.closed.recording, measured.segment_s);
  found.expected = expected_spectrum(measured.open.recording, measured.segment_s, laws, law.timing);
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
          {"steps_hz", 1.0 / found.timing.step_s},
          {"delay_ms", 1e3 * found.timing.delay_s},
          {"noise_limit_waves", found.noise_limit_waves},
          {"noise_passed_waves", found.noise_passed_waves},
          {"closed", loop_summary(measured.closed)},
          {"from_hz", found.rejection.front().hz},
          {"to_hz", found.rejection.back().hz},
          {"crossing_0_db_hz", crossing(found, 0.0)},
          {"bandwidth_3_db_hz", crossing(found, -3.0)},
          {"bands", std::move(bands)}};
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
  return text + "\ndB, expected with the measured step and delay in brackets\n";
}

}  // namespace

RejectionFound find_rejection(const RejectionMeasured& measured) {
  RejectionFound found;
  found.open = spectrum(measured.open.recording, measured.segment_s);
  const auto noise_waves = frame_noise(measured.open.recording, measured.segment_s);
  found.noise_waves = root_sum_square(noise_waves);
  found.noise_per_hz =
      2.0 * median_interval_s(measured.open.recording.times_s) * std::pow(found.noise_waves, 2);
  for (const MeasuredLaw& law : measured.laws) {
    found.laws.push_back(found_of(law, found.open, measured, noise_waves));
  }
  return found;
}

namespace {

/// Marks a line as what is expected of the law number `k`, with the colour of what was measured.
Series expected(Series line, std::size_t k, int colour) {
  line.style = Series::Style::line;
  line.colour = colour;
  line.in_legend = k == 0;
  return line;
}

constexpr const char* kExpected = "expected with the measured delay";

Figure spectra_figure(const RejectionFound& found) {
  Figure spectra{"rejection-spectra", "power spectra with the loop open and closed",
                 "frequency (Hz)", "power of all modes (wave^2/Hz)"};
  spectra.log_x = spectra.log_y = true;
  spectra.series = {line_of("loop open", found.open)};
  for (const FoundLaw& law : found.laws) spectra.series.push_back(line_of(law.name, law.closed));
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    spectra.series.push_back(expected(line_of(kExpected, found.laws[k].expected), k, int(k) + 2));
  }
  Series noise{.name = "noise floor, loop open", .style = Series::Style::line};
  for (const double hz : spectra.series.front().x) noise.add(hz, found.noise_per_hz);
  spectra.series.push_back(std::move(noise));
  return spectra;
}

Figure rejected_figure(const RejectionFound& found) {
  Figure rejected{"rejection", "disturbance rejection of the closed loop", "frequency (Hz)",
                  "power, closed loop / open loop (dB)"};
  rejected.log_x = true;
  for (const FoundLaw& law : found.laws) {
    rejected.series.push_back(
        line_of(fmt::format("{}, {:.2g} steps/s, delay {:.0f} ms", law.name,
                            1.0 / law.timing.step_s, 1e3 * law.timing.delay_s),
                law.rejection));
    rejected.series.back().colour = int(rejected.series.size());
  }
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    rejected.series.push_back(
        expected(line_of(kExpected, found.laws[k].expected_rejection), k, int(k) + 1));
  }
  return rejected;
}

}  // namespace

std::vector<Figure> rejection_figures(const RejectionFound& found) {
  return {spectra_figure(found), rejected_figure(found)};
}

json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found) {
  json laws = json::array();
  for (std::size_t k = 0; k < found.laws.size(); ++k) {
    laws.push_back(law_summary(measured.laws[k], found.laws[k]));
  }
  return {{"study", "rejection"},
          {"modes_j", measured.modes_j},
          {"open", loop_summary(measured.open)},
          {"uncorrected_modes_j", measured.open.uncorrected_j},
          {"noise_waves", found.noise_waves},
          {"segment_s", measured.segment_s},
          {"laws", std::move(laws)}};
}

std::string rejection_text(const json& summary) {
  constexpr const char* kText =
      "open: {open.rms_waves:.4f} wave RMS, {open.frames_hz:.2f} usable frames/s; "
      "{open.missing_share*100:.0f} % of the frames are missing ({open.lost_share*100:.0f} % lost, "
      "the others not settled or not valid)\n"
      "  {open.uncorrected_waves:.4f} wave RMS in measured modes that are not corrected; "
      "{open.fit_residual_px:.3f} px RMS of the displacements that no measured mode explains\n"
      "[laws*{law}: {closed.rms_waves:.4f} wave RMS, {closed.frames_hz:.2f} usable frames/s; "
      "{closed.missing_share*100:.0f} % of the frames are missing ({closed.lost_share*100:.0f} % "
      "lost, the others not settled or not valid)\n"
      "  {steps_hz:.2f} steps/s, delay {delay_ms:.1f} ms; "
      "-3 dB [bandwidth_3_db_hz?at {bandwidth_3_db_hz:.3g} Hz]"
      "[!bandwidth_3_db_hz?is not reached between {from_hz:.3g} and {to_hz:.3g} Hz]; "
      "0 dB [crossing_0_db_hz?at {crossing_0_db_hz:.3g} Hz]"
      "[!crossing_0_db_hz?is not reached between {from_hz:.3g} and {to_hz:.3g} Hz]\n"
      "  noise alone would leave {noise_limit_waves:.4f} wave RMS; the correction has "
      "{noise_passed_waves:.4f} of it\n]";
  return cli::fill(kText, summary) + "\n\n" + bands_text(summary["laws"]);
}

}  // namespace ovws::study
