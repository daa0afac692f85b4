/// `ovws check` without a bench: responses, noise and drift of made frames, verdicts, the report.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "daemon/examine/check/judge.hpp"
#include "daemon/examine/check/measured.hpp"
#include "daemon/examine/check/report.hpp"
#include "daemon/shared/lost_spots.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

const std::vector<int> kModes{1, 2, 3, 4, 5};

Shown shown_with(std::vector<double> waves, double first_off = 0.0) {
  Frame frame{0.0, true, 0.0, waves, std::vector<double>(waves.size(), 1e-4)};
  Frame first = frame;
  first.waves[0] += first_off;
  return {first, {frame, frame}};
}

/// A record at 100 frames/s: white noise, a straight drift and a vibration of j = 4.
Record record_with(double noise, double drift, double vibration, double hz = 7.0) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  Record record{kModes, {}, 0};
  for (int i = 0; i < 2000; ++i) {
    Frame frame{0.01 * i, true, 0.0, {}, std::vector<double>(kModes.size(), 1e-3)};
    for (std::size_t k = 0; k < kModes.size(); ++k) frame.waves.push_back(noise * normal(engine));
    frame.waves[2] += drift * i / 2000.0;
    frame.waves[3] +=
        vibration * std::sqrt(2.0) * std::sin(2.0 * std::numbers::pi * hz * frame.t_s);
    record.frames.push_back(frame);
  }
  return record;
}

json levels(double depth) {
  json phases = json::array();
  for (int g = 0; g < 256; ++g) phases.push_back(2.0 * std::numbers::pi * depth * g / 256.0);
  return phases;
}

json linear() {
  json grey = json::array();
  for (int g = 0; g < 256; ++g) grey.push_back(g);
  return grey;
}

/// A bench without a fault, as the daemon reports it.
Measured good_bench() {
  Measured measured;
  measured.version = "test";
  measured.t_ns = 1'800'000'000'000'000'000;
  const std::int64_t now = measured.t_ns - 60'000'000'000;
  const json info{{"vendor", "v"}, {"model", "<m>"}, {"serial", "s"}};
  const json settings{{"exposure_us", 2000.0},
                      {"gain_db", 0.0},
                      {"frame_rate_hz", 100.0},
                      {"pixel_format", "Mono8"}};
  measured.status = {{"counters", {{"frames_grabbed", 0}}},
                     {"camera", {{"info", info}, {"settings", settings}}},
                     {"slm", {{"info", {{"output", "o"}, {"width", 1280}, {"height", 768}}}}}};
  measured.counters_after = {{"frames_grabbed", 2000}};
  measured.sensor = {{"tracker", "fit"},
                     {"subapertures_across", 5},
                     {"pupil_diameter_px", 768.0},
                     {"operator_reason", json()},
                     {"charge", 1},
                     {"subapertures", 19},
                     {"modes_j", kModes},
                     {"operator_in_force", "slopes"}};
  measured.config = {{"slm", {{"settle_ms", 20.0}, {"pitch_um", 19.0}}},
                     {"optics",
                      {{"wavelength_nm", 632.0},
                       {"focal_length_mm", 200.0},
                       {"magnification", 1.0},
                       {"camera_pitch_um", 3.45}}}};
  measured.reference = {{"source", "measured"},
                        {"frames", 100},
                        {"t_taken_ns", now},
                        {"stale", json::array()},
                        {"introduced_rms_waves", 0.0}};
  measured.registration = {
      {"registered", true},  {"t_taken_ns", now},
      {"residual_px", 0.02}, {"scale_px_per_cycle", 632.0 * 200.0 / (19.0 * 3.45)},
      {"rotation_deg", 0.1}, {"mirrored", false}};
  measured.lut = {
      {"measured", true},         {"t_taken_ns", now},
      {"source", "measured"},     {"grey_levels", linear()},
      {"phase_rad", levels(1.0)}, {"depth_rad", 2.0 * std::numbers::pi * 255.0 / 256.0}};
  measured.flatness = {{"measured", true},
                       {"t_taken_ns", now},
                       {"rms_waves", 0.2},
                       {"residual_rms_waves", 0.003},
                       {"path", json()}};
  measured.calibration = {{"calibrated", false}};
  measured.settle.result = {{"max_ms", 12.5}, {"proposed_settle_ms", 15.0}, {"long_enough", true}};
  measured.response.modes_j = kModes;
  for (const int j : kModes) {
    std::vector<double> plus(kModes.size(), 0.0);
    plus[std::size_t(j - 1)] = kPokeWaves;
    std::vector<double> minus(kModes.size(), 0.0);
    minus[std::size_t(j - 1)] = -kPokeWaves;
    measured.response.pokes.push_back(
        poke_of(j, {shown_with(plus), shown_with(minus), shown_with(minus), shown_with(plus)}));
  }
  measured.open = record_with(1e-3, 0.0, 0.0);
  measured.loop.record = record_with(1e-3, 0.0, 0.0);
  measured.loop.loop = {{"step", {{"p50_ms", 50.0}, {"delay_ms", 60.0}}}};
  return measured;
}

const Finding& of(const Findings& findings, const std::string& name) {
  return *std::ranges::find(findings, name, &Finding::name);
}

TEST(Response, SlopeAndCrosstalkOfAPoke) {
  const Poke poke =
      poke_of(4, {shown_with({0, 0, 0.001, 0.097, 0}), shown_with({0, 0, 0, -0.097, 0}),
                  shown_with({0, 0, 0, -0.097, 0}), shown_with({0, 0, 0.001, 0.097, 0})});
  ASSERT_TRUE(poke.read);
  EXPECT_NEAR(slope_of(poke, kModes).value, 0.97, 1e-9);
  EXPECT_NEAR(crosstalk_of(poke, kModes), 0.005, 1e-9);
  EXPECT_NEAR(error_waves(poke, kModes), std::hypot(0.003, 0.0005), 1e-9);
}

TEST(Response, ADriftCancels) {
  const Poke poke =
      poke_of(4, {shown_with({0, 0, 0.000, 0.100, 0}), shown_with({0, 0, 0.001, -0.100, 0}),
                  shown_with({0, 0, 0.002, -0.100, 0}), shown_with({0, 0, 0.003, 0.100, 0})});
  EXPECT_NEAR(poke.gain[2].value, 0.0, 1e-9);
  EXPECT_GT(poke.gain[2].standard_error, 0.004);  // the pairs differ
}

TEST(Response, TheFirstFrameShowsATooShortSettleTime) {
  const Shown late = shown_with({0, 0, 0, 0.1, 0}, 0.2), fine = shown_with({0, 0, 0, -0.1, 0});
  EXPECT_NEAR(poke_of(4, {late, fine, fine, late}).first_error_waves, 0.1, 1e-9);
  EXPECT_FALSE(poke_of(4, {late, Shown{}, fine, late}).read);
}

TEST(Stability, TellsNoiseDriftAndVibrationApart) {
  const Stability found = stability_of(record_with(1e-3, 0.02, 0.01));
  ASSERT_TRUE(found.usable);
  EXPECT_NEAR(found.noise, 1e-3 * std::sqrt(5.0), 3e-4);
  EXPECT_NEAR(found.drift, 0.02, 1e-3);
  EXPECT_NEAR(found.motion, 0.01, 1e-3);
  EXPECT_NEAR(found.frequency_hz, 7.0, 0.3);
  EXPECT_EQ(found.strongest_j, 4);
  EXPECT_EQ(stability_of(record_with(1e-3, 0.0, 0.0)).frequency_hz, 0.0);
  EXPECT_FALSE(stability_of(Record{}).usable);
}

TEST(Stability, MeansOfASecondAndAllanDeviation) {
  const Record record = record_with(1e-3, 0.0, 0.0);
  EXPECT_EQ(seconds_of(record).times_s.size(), 20U);
  const AllanCurve curve = allan_of(record);
  EXPECT_NEAR(curve.waves.front(), 1e-3 * std::sqrt(5.0), 1e-4);
  EXPECT_NEAR(curve.waves[4] / curve.waves[0], 0.25, 0.05);  // white noise: 1/sqrt(16)
}

TEST(Judge, AGoodBenchIsGood) {
  const Findings findings = answers(good_bench());
  for (const Finding& one : findings)
    EXPECT_EQ(one.severity, Severity::good) << one.name << one.text;
  EXPECT_TRUE(improve_first(findings).empty());
}

TEST(Judge, AShallowTableCostsItsErrorOverRootTwelve) {
  EXPECT_NEAR(table_error_waves(linear(), levels(0.95)), 0.05 / std::sqrt(12.0), 1e-4);
  EXPECT_NEAR(table_error_waves(linear(), levels(1.0)), 0.0, 1e-9);
  EXPECT_NEAR(table_error_waves(linear(), levels(-1.0)), 0.0, 1e-9) << "the phase falls";
  std::vector<int> falling{0};
  for (int step = 1; step < 256; ++step) falling.push_back(256 - step);
  EXPECT_NEAR(table_error_waves(falling, levels(-1.0)), 0.0, 1e-9) << "and the table repairs it";
  Measured measured = good_bench();
  measured.lut["measured"] = false;
  measured.lut["source"] = "linear";
  measured.lut_run.result = {{"phase_rad", levels(0.95)}, {"depth_rad", 5.94}};
  const Findings first = improve_first(answers(measured));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].name, "lut");
  EXPECT_EQ(first[0].severity, Severity::warning);
}

TEST(Judge, WhatCostsMostComesFirst) {
  Measured measured = good_bench();
  measured.open = record_with(1e-3, 0.0, 0.03);
  measured.lut["phase_rad"] = levels(0.9);
  measured.flatness["measured"] = false;
  const Findings first = improve_first(answers(measured));
  ASSERT_EQ(first.size(), 3U);
  EXPECT_EQ(first[0].name, "motion");
  EXPECT_NE(first[0].text.find("7.0 Hz"), std::string::npos) << first[0].text;
  EXPECT_EQ(first[1].name, "lut");
  EXPECT_EQ(first[2].name, "flatness");  // its cost is not known
}

TEST(Judge, SaturationExplainsAWrongResponse) {
  Measured measured = good_bench();
  for (Frame& frame : measured.open.frames) frame.saturated = 0.5;
  measured.response.pokes[3].gain[3].value = 0.9;
  const Findings findings = answers(measured);
  EXPECT_EQ(of(findings, "saturation").severity, Severity::bad);
  EXPECT_NEAR(of(findings, "saturation").cost_waves, 0.01, 1e-6);
  EXPECT_EQ(of(findings, "response").cause, "saturation");
  EXPECT_EQ(improve_first(findings).at(0).name, "saturation");
}

/// The message of 5 spots, of which these are found.
StreamMessage spots_message(const std::vector<int>& found, bool settled = true) {
  std::vector<float> rows(5 * 6, NAN);
  for (const int spot : found) rows[std::size_t(spot) * 6] = 10.0F;
  const auto* bytes = reinterpret_cast<const std::byte*>(rows.data());
  return {"spots",
          json{{"settled", settled}, {"shape", {5, 6}}}.dump(),
          {bytes, bytes + rows.size() * sizeof(float)}};
}

/// The reference of 5 spots of which spot 1 was lost.
void set_lost_reference(Measured& measured) {
  measured.reference["positions_px"] = {{84, 528}, {123, 395}, {10, 20}, {30, 40}, {50, 60}};
  const json known{0.01, 0.01};
  measured.reference["standard_error_px"] = {known, nullptr, known, known, known};
}

TEST(LostSpots, AreCountedInSettledFramesAndNamedWithTheirPlaces) {
  cli::SpotCounts counts;
  for (int k = 0; k < 9; ++k) counts.add(spots_message({0, 1, 2, 3, 4}));
  counts.add(spots_message({0, 1, 2, 3}));
  counts.add(spots_message({}, false));
  EXPECT_EQ(counts.frames, 10);
  EXPECT_TRUE(counts.lost(0.9).empty());
  for (int k = 0; k < 5; ++k) counts.add(spots_message({0, 2, 3}));
  EXPECT_EQ(counts.lost(0.9), (std::vector<int>{1, 4}));
  EXPECT_EQ(counts.lost(0.65), std::vector<int>{4});
  Measured measured = good_bench();
  EXPECT_EQ(cli::placed_spots({1}, measured.reference), "1") << "no places are known";
  set_lost_reference(measured);
  EXPECT_EQ(cli::lost_in_reference(measured.reference), std::vector<int>{1});
  EXPECT_EQ(cli::placed_spots({0, 1}, measured.reference), "0 at (84, 528) px, 1 at (123, 395) px");
}

TEST(Judge, LostSpotsAreNamedAndTheExposureIsNotAdvised) {
  Measured measured = good_bench();
  set_lost_reference(measured);
  measured.calibration = {{"calibrated", false}, {"lost_spots", {0}}};
  for (int k = 0; k < 10; ++k) measured.open.spots.add(spots_message({0, 1, 2, 4}));
  for (Frame& frame : measured.open.frames) frame.saturated = 0.1;
  measured.response.pokes[3].read = false;
  measured.response.pokes[3].settled = 60;
  measured.response.pokes[3].valid = 2;
  measured.response.reason = "4 of 5 spots are found";
  const Findings findings = answers(measured);
  const Finding& spots = of(findings, "spots");
  EXPECT_EQ(spots.severity, Severity::warning);
  for (const char* part : {"in the reference: 1 at (123, 395) px", "in the calibration: 0 at (84, ",
                           "in more than a tenth of the frames: 3 at (30, 40) px"}) {
    EXPECT_NE(spots.text.find(part), std::string::npos) << spots.text;
  }
  EXPECT_EQ(of(findings, "saturation").cause, "spots");
  EXPECT_EQ(of(findings, "response").cause, "spots");
  EXPECT_NE(of(findings, "response").text.find("2 of 60 settled frames are valid: 4 of 5 spots"),
            std::string::npos)
      << of(findings, "response").text;
  for (const Finding& one : improve_first(findings)) {
    EXPECT_EQ(one.fix.find("exposure"), std::string::npos) << one.name;
  }
}

TEST(Judge, SpotsThatSaturationLosesAreExplainedByIt) {
  Measured measured = good_bench();
  set_lost_reference(measured);
  for (Frame& frame : measured.open.frames) frame.saturated = 0.8;
  const Findings findings = answers(measured);
  EXPECT_EQ(of(findings, "spots").cause, "saturation");
  EXPECT_EQ(improve_first(findings).at(0).name, "saturation");
}

TEST(Judge, SideOrdersOfTheZerothOrderExplainLostSpots) {
  Measured measured = good_bench();
  set_lost_reference(measured);
  measured.config["sensor"] = {{"grooves", {130.0, 20.0}}};
  const Finding spots = of(answers(measured), "spots");
  EXPECT_NE(spots.text.find("zeroth order"), std::string::npos) << spots.text;
  EXPECT_EQ(spots.fix, "ovws doctor");
}

TEST(Judge, AShortSettleTimeIsBad) {
  Measured measured = good_bench();
  measured.settle.result = {{"proposed_settle_ms", 120.0}, {"long_enough", false}};
  for (Poke& poke : measured.response.pokes) poke.first_error_waves = 0.19;
  const Findings first = improve_first(answers(measured));
  EXPECT_EQ(first.at(0).name, "settle");
  EXPECT_EQ(first.at(0).severity, Severity::bad);
  EXPECT_EQ(first.at(0).fix, "ovws call slm.set settle_ms=120");
}

TEST(Judge, WhatWasNotMeasuredIsNotGood) {
  Measured dark = good_bench();
  for (Record* record : {&dark.open, &dark.loop.record}) {
    for (Frame& frame : record->frames) frame.valid = false;
  }
  for (Poke& poke : dark.response.pokes) poke.read = false;
  dark.settle = {json(), "no light"};
  const Findings findings = answers(dark);
  for (const char* name : {"noise", "motion", "drift", "settle"}) {
    EXPECT_EQ(of(findings, name).severity, Severity::note) << name;
    EXPECT_NE(of(findings, name).text.find("not measured"), std::string::npos) << name;
  }
  EXPECT_EQ(of(findings, "loop").severity, Severity::bad);
  EXPECT_EQ(of(findings, "loop").text.find("nan"), std::string::npos);
}

TEST(Judge, ASettleTimeThatIsLongEnoughIsGoodAlthoughMoreIsProposed) {
  Measured measured = good_bench();
  measured.settle.result = {{"max_ms", 17.5}, {"proposed_settle_ms", 22.0}, {"long_enough", true}};
  const Finding settle = of(answers(measured), "settle");
  EXPECT_EQ(settle.severity, Severity::good);
  EXPECT_NE(settle.text.find("long enough: a change takes 17.5 ms at most; with the usual "
                             "margin: 22 ms"),
            std::string::npos)
      << settle.text;
}

TEST(Judge, AgesAndChangesOfTheReference) {
  Measured measured = good_bench();
  measured.reference["t_taken_ns"] = measured.t_ns - 20LL * 3600 * 1'000'000'000;
  EXPECT_EQ(of(answers(measured), "reference").severity, Severity::note);
  measured.reference["stale"] = {{{"field", "gain_db"}, {"then", 0}, {"now", 6}}};
  EXPECT_EQ(of(answers(measured), "reference").severity, Severity::warning);
}

TEST(Report, IsOnePageThatEscapesWhatTheBenchReports) {
  const Measured measured = good_bench();
  const std::string page = report_html(measured, answers(measured));
  EXPECT_NE(page.find("&lt;m&gt;"), std::string::npos);
  EXPECT_EQ(page.find("<m>"), std::string::npos);
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org"));  // loads nothing
  EXPECT_NE(page.find("class=\"matrix\""), std::string::npos);
  const json all = report_json(measured, answers(measured));
  EXPECT_EQ(all.at("verdict"), "good");
  EXPECT_EQ(all.at("response").at("modes").size(), kModes.size());
}

}  // namespace
}  // namespace ovws::examine
