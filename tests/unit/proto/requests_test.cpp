#include "proto/requests.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "proto/tables/job.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace test {

struct Unbounded {
  int count = 0;
  std::int64_t total = 0;
  std::vector<int> counts;
  int without_key = 0;
};

}  // namespace test

template <>
inline constexpr auto kTable<test::Unbounded> = Fields{
    "Unbounded", field<&test::Unbounded::count>("a number without limits"),
    field<&test::Unbounded::total>("one of 64 bits"), field<&test::Unbounded::counts>("a list")};

namespace {

using nlohmann::json;

template <class T>
Error error_of(const Result<T>& result) {
  EXPECT_FALSE(result);
  return result ? Error{} : result.error();
}

TEST(CameraSetRequest, LeavesWhatIsAbsent) {
  const auto set = CameraSet::decode(json::parse(R"({"gain_db": 12, "pixel_format": "Mono12"})"));
  ASSERT_TRUE(set);
  CameraSettings before;
  before.exposure_us = 777;
  const CameraSettings after = set->applied_to(before);
  EXPECT_EQ(after.gain_db, 12);
  EXPECT_EQ(after.pixel_format, PixelFormat::mono12);
  EXPECT_EQ(after.exposure_us, 777);
  EXPECT_EQ(after.roi, before.roi);
  EXPECT_FALSE(set->gives(&CameraSettings::exposure_us));
}

TEST(CameraSetRequest, ReadsTheRegionWholeWithXBeforeY) {
  const auto set =
      CameraSet::decode(json::parse(R"({"roi": {"x": 1, "y": 2, "width": 30, "height": 40}})"));
  ASSERT_TRUE(set);
  EXPECT_EQ(set->applied_to({}).roi, (Roi{1, 2, 30, 40}));
  const auto part = CameraSet::decode(json::parse(R"({"roi": {"x": 1, "width": 30}})"));
  CameraSettings before;
  before.roi = {5, 6, 7, 8};
  EXPECT_EQ(part->applied_to(before).roi, (Roi{1, 6, 30, 8}));
}

TEST(CameraSetRequest, RefusesOrClampsNumbersOutOfRange) {
  EXPECT_EQ(error_of(CameraSet::decode({{"gain_db", 1000}})).field, "gain_db");
  EXPECT_EQ(error_of(CameraSet::decode({{"exposure_us", 0}})).field, "exposure_us");
  const auto clamped = CameraSet::decode({{"gain_db", 1000}, {"clamp", true}});
  ASSERT_TRUE(clamped);
  EXPECT_EQ(clamped->applied_to({}).gain_db, 100.0);
  EXPECT_TRUE(clamped->clamp());
}

TEST(CameraSetRequest, TakesAGainInOneUnitAndNullAsLeft) {
  const auto raw = CameraSet::decode({{"gain_raw", 7}, {"gain_db", nullptr}});
  ASSERT_TRUE(raw);
  const CameraSettings after = raw->applied_to({});
  EXPECT_TRUE(std::isnan(after.gain_db));
  EXPECT_EQ(after.gain_raw, 7.0);
  const auto back = CameraSet::decode({{"gain_db", 3}, {"gain_raw", nullptr}});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->applied_to(after).gain_db, 3.0);
  EXPECT_TRUE(std::isnan(back->applied_to(after).gain_raw));
  EXPECT_EQ(error_of(CameraSet::decode({{"gain_db", 3}, {"gain_raw", 7}})).field, "gain_raw");
  EXPECT_EQ(to_json(after).at("gain_db"), json());
  EXPECT_EQ(to_json(after).at("gain_raw"), 7.0);
  EXPECT_EQ(to_json(CameraSettings{}).at("gain_raw"), json());
}

TEST(CameraSetRequest, NamesTheKeyThatWasMeant) {
  EXPECT_EQ(error_of(CameraSet::decode({{"gain", 3}})).nearest, "gain_db");
  EXPECT_EQ(error_of(CameraSet::decode({{"pixel_format", "Mono11"}})).field, "pixel_format");
}

TEST(RefineSetRequest, LeavesWhatIsAbsentAndDistinguishesNullFromAbsent) {
  RefineSetup before;
  before.electrons_per_dn = 40.0;
  before.saturation_dn = 250.0;
  const auto set =
      RefineSet::decode(json::parse(R"({"enabled": true, "rate_hz": 2, "saturation_dn": null})"));
  ASSERT_TRUE(set);
  const RefineSetup after = set->applied_to(before);
  EXPECT_TRUE(after.enabled);
  EXPECT_EQ(after.rate_hz, 2.0);
  EXPECT_EQ(after.electrons_per_dn, 40.0);
  EXPECT_EQ(after.saturation_dn, std::nullopt);
  EXPECT_EQ(after.read_noise_e, before.read_noise_e);
}

TEST(RefineSetup, FollowsTheFormatWithTheFitAsItIs) {
  RefineSetup setup;
  setup.black_level_dn = 2.0;
  const RefineSetup deep = in_format(setup, PixelFormat::mono12);
  EXPECT_EQ(deep.black_level_dn, 32.0);
  RefineSetup other = deep;
  other.rate_hz = 7.0;
  EXPECT_TRUE(same_fit(deep, other));
  other.read_noise_e = 7.0;
  EXPECT_FALSE(same_fit(deep, other));
  EXPECT_FALSE(deep == other);
}

TEST(RefineSetRequest, RefusesOrClampsNumbersOutOfRange) {
  EXPECT_EQ(error_of(RefineSet::decode({{"rate_hz", 0}})).field, "rate_hz");
  EXPECT_EQ(error_of(RefineSet::decode({{"rate_hz", nullptr}})).field, "rate_hz");
  EXPECT_EQ(error_of(RefineSet::decode({{"electrons_per_dn", 0}})).field, "electrons_per_dn");
  EXPECT_EQ(error_of(RefineSet::decode({{"read_noise_e", -1}})).field, "read_noise_e");
  EXPECT_EQ(error_of(RefineSet::decode({{"enabled", "yes"}})).field, "enabled");
  EXPECT_EQ(error_of(RefineSet::decode({{"rate", 1}})).nearest, "rate_hz");
  const auto clamped =
      RefineSet::decode({{"rate_hz", 1e6}, {"saturation_dn", 4095}, {"clamp", true}});
  ASSERT_TRUE(clamped);
  EXPECT_EQ(clamped->applied_to({}).rate_hz, 100.0);
}

TEST(SensorSetRequest, ReadsEveryKey) {
  const auto set = SensorSet::decode(json::parse(
      R"({"charge": -2, "grid": "square", "subapertures_across": 7, "pupil_diameter_px": 600.5,
          "grooves": [100, -30], "spacing": 0.5, "tracker": "lg_contour",
          "operator": "measured", "mode_count": 44, "estimates": 4})"));
  ASSERT_TRUE(set);
  const SensorConfig wanted{-2, Grid::square, 7, 600.5, {100, -30}, 0.5};
  EXPECT_EQ(set->applied_to({}).sensor, wanted);
  const TrackingSettings tracking{{TrackerKind::lg_contour, 0.3}, OperatorKind::measured, 44, 4};
  EXPECT_EQ(set->applied_to({}).tracking, tracking);
  const auto nothing = SensorSet::decode(json::object());
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->applied_to({wanted, tracking}).sensor, wanted);
  EXPECT_EQ(nothing->applied_to({wanted, tracking}).tracking, tracking);
  const auto fewer = SensorSet::decode({{"mode_count", nullptr}});
  ASSERT_TRUE(fewer);
  EXPECT_FALSE(fewer->applied_to({wanted, tracking}).tracking.mode_count.has_value());
}

TEST(SensorSetRequest, RefusesWhatNoSensorHas) {
  EXPECT_EQ(error_of(SensorSet::decode({{"charge", 9}})).field, "charge");
  EXPECT_EQ(error_of(SensorSet::decode({{"charge", 0.5}})).field, "charge");
  EXPECT_EQ(error_of(SensorSet::decode({{"subapertures_across", 65}})).field,
            "subapertures_across");
  EXPECT_EQ(error_of(SensorSet::decode({{"grooves", {1, 2, 3}}})).field, "grooves");
  EXPECT_EQ(error_of(SensorSet::decode({{"grooves", {1, 1e9}}})).field, "grooves[1]");
  EXPECT_EQ(error_of(SensorSet::decode({{"tracker", "lgg"}})).nearest, "lg");
  EXPECT_EQ(error_of(SensorSet::decode({{"operator", "slope"}})).nearest, "slopes");
  EXPECT_EQ(error_of(SensorSet::decode({{"charge", 0}, {"tracker", nullptr}})).field, "tracker");
  EXPECT_EQ(error_of(SensorSet::decode({{"template", "model"}})).field, "template");
}

TEST(AberrationRequest, TakesModesByIndexOrByOrder) {
  const auto modes = ModesSet::decode(
      json::parse(R"({"modes": [{"n": 2, "m": -2, "waves": 0.5}, {"j": 4, "waves": -0.3}]})"));
  ASSERT_TRUE(modes);
  EXPECT_EQ(modes->modes, (std::vector<Mode>{{3, 0.5}, {4, -0.3}}));
}

TEST(AberrationRequest, TurnsUnitAmplitudeIntoRms) {
  // Astigmatism of amplitude 1 at the pupil's edge has RMS 1/sqrt 6, defocus 1/sqrt 3.
  const auto modes = ModesSet::decode(json::parse(
      R"({"modes": [{"n": 2, "m": 2, "waves": 1}, {"n": 2, "m": 0, "waves": 1}], "norm": "unit"})"));
  ASSERT_TRUE(modes);
  EXPECT_NEAR(modes->modes[0].waves, 1 / std::sqrt(6.0), 1e-12);
  EXPECT_NEAR(modes->modes[1].waves, 1 / std::sqrt(3.0), 1e-12);
}

TEST(AberrationRequest, RefusesWhatIsNoMode) {
  const auto field = [](const char* text) {
    return error_of(ModesSet::decode(json::parse(text))).field;
  };
  EXPECT_EQ(field(R"({})"), "modes");
  EXPECT_EQ(field(R"({"modes": {"j": 1}})"), "modes");
  EXPECT_EQ(field(R"({"modes": [3]})"), "modes[0]");
  EXPECT_EQ(field(R"({"modes": [{"j": 3}]})"), "modes[0].waves");
  EXPECT_EQ(field(R"({"modes": [{"waves": 1}]})"), "modes[0].n");
  EXPECT_EQ(field(R"({"modes": [{"n": 2, "waves": 1}]})"), "modes[0].m");
  EXPECT_EQ(field(R"({"modes": [{"n": 3, "waves": 1}]})"), "modes[0].m");
  EXPECT_EQ(field(R"({"modes": [{"n": 2, "m": 1, "waves": 1}]})"), "modes[0].n");
  EXPECT_EQ(field(R"({"modes": [{"n": 1, "m": 3, "waves": 1}]})"), "modes[0].n");
  EXPECT_EQ(field(R"({"modes": [{"n": 21, "m": 1, "waves": 1}]})"), "modes[0].n");
  EXPECT_EQ(field(R"({"modes": [{"j": 231, "waves": 1}]})"), "modes[0].j");
  EXPECT_EQ(field(R"({"modes": [{"j": 3, "n": 2, "m": -2, "waves": 1}]})"), "modes[0].j");
  EXPECT_EQ(field(R"({"modes": [{"j": 3, "waves": 1}, {"n": 2, "m": -2, "waves": 1}]})"),
            "modes[1]");
  EXPECT_EQ(field(R"({"modes": [{"j": 3, "waves": 1001}]})"), "modes[0].waves");
  EXPECT_EQ(field(R"({"modes": [], "norm": "peak"})"), "norm");
  EXPECT_TRUE(ModesSet::decode(json::parse(R"({"modes": []})")));
}

TEST(OtherRequests, AreStrict) {
  EXPECT_EQ(decode<ReferenceTake>(json::object())->frames, 100);
  EXPECT_FALSE(decode<ReferenceTake>(json::object())->allow_aberration);
  EXPECT_EQ(decode<ReferenceTake>({{"frames", 7}})->frames, 7);
  EXPECT_TRUE(decode<ReferenceTake>({{"allow_aberration", true}})->allow_aberration);
  EXPECT_EQ(decode<ReferenceTake>({{"beam", "b"}})->beam, "b");
  EXPECT_EQ(decode<ReferenceTake>(json::object())->beam, "");
  EXPECT_EQ(error_of(decode<ReferenceTake>({{"frames", 0}})).field, "frames");
  EXPECT_TRUE(decode<ReferenceSet>({{"source", "model"}}));
  EXPECT_EQ(error_of(decode<ReferenceSet>(json::object())).field, "source");
  EXPECT_EQ(error_of(decode<ReferenceSet>({{"source", "modle"}})).nearest, "model");
  EXPECT_EQ(decode<SlmShow>({{"pattern", "identify"}})->pattern, HologramKind::identify);
  EXPECT_EQ(error_of(decode<SlmShow>({{"pattern", "test"}})).field, "pattern");
  EXPECT_EQ(decode<RegistrationRun>(json::object())->frames, 5);
  const auto loop = decode<LoopSettings>(
      {{"gain", 0.3}, {"modes", {3, 5}}, {"gains", {{{"j", 5}, {"gain", 0.1}}}}});
  ASSERT_TRUE(loop);
  EXPECT_EQ(loop->modes, (std::vector<int>{3, 5}));
  EXPECT_EQ(loop->gains, (std::vector<ModeGain>{{5, 0.1}}));
  EXPECT_EQ(error_of(decode<LoopSettings>({{"modes", {3.5}}})).field, "modes");
  EXPECT_EQ(error_of(decode<LoopSettings>({{"gain", 0.0}})).field, "gain");
  EXPECT_EQ(decode<LoopOpen>({{"keep", false}})->keep, false);
  EXPECT_EQ(error_of(decode<RegistrationRun>({{"frames", 101}})).field, "frames");
  EXPECT_EQ(error_of(decode<SlmShow>(json::object())).field, "pattern");
  EXPECT_EQ(decode<FlatnessRun>(json::object())->frames, 5);
  EXPECT_EQ(error_of(decode<FlatnessRun>({{"frames", 0}})).field, "frames");
  EXPECT_EQ(decode<MapRun>(json::object())->cells, 100);
  EXPECT_EQ(error_of(decode<MapRun>({{"patterns", 3}})).field, "patterns");
  EXPECT_EQ(decode<AutoExposure>(json::object())->target, 0.7);
  EXPECT_FALSE(decode<AutoExposure>({{"max_exposure_us", nullptr}})->max_exposure_us);
  EXPECT_EQ(error_of(decode<AutoExposure>({{"target", 1.0}})).field, "target");
  EXPECT_EQ(error_of(decode<AutoExposure>({{"max_exposure_us", 0}})).field, "max_exposure_us");
  EXPECT_EQ(decode<SettleRun>(json::object())->repetitions, 20);
  EXPECT_EQ(error_of(decode<SettleRun>({{"repetitions", 2}})).field, "repetitions");
  EXPECT_EQ(error_of(decode<SettleRun>({{"watch_ms", 1}})).field, "watch_ms");
  EXPECT_EQ(decode<LutRun>(json::object())->levels, 33);
  EXPECT_EQ(error_of(decode<LutRun>({{"levels", 8}})).field, "levels");
  EXPECT_EQ(error_of(decode<LutRun>({{"frames", 0}})).field, "frames");
  const auto run = decode<CalibrationRun>(json::object());
  ASSERT_TRUE(run);
  EXPECT_FALSE(run->amplitude_waves);
  EXPECT_EQ(run->frames, 20);
  EXPECT_TRUE(run->modes_j.empty());
  EXPECT_EQ(decode<CalibrationRun>({{"modes", {5, 3}}})->modes_j, (std::vector<int>{5, 3}));
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"amplitude_waves", 0.3}})).field, "amplitude_waves");
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"frames", 1}})).field, "frames");
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"modes", json::array()}})).field, "modes");
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"modes", {0}}})).field, "modes[0]");
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"modes", {3, 3}}})).field, "modes");
  EXPECT_EQ(error_of(decode<CalibrationRun>({{"modes", {3.5}}})).field, "modes");
  EXPECT_EQ(error_of(decode<SlmShow>({{"pattern", "sensr"}})).nearest, "sensor");
  EXPECT_EQ(decode<JobNumber>({{"job", 3}})->job, 3);
  EXPECT_EQ(error_of(decode<JobNumber>(json::object())).field, "job");
  EXPECT_TRUE(decode<Nothing>(json::object()));
  EXPECT_EQ(error_of(decode<Nothing>({{"a", 1}})).field, "a");
}

TEST(Results, KeepWhatWasRequestedAndSayWhatWasApplied) {
  const json params{{"gain_db", 500}, {"clamp", true}};
  CameraSettings applied;
  applied.gain_db = 24;
  const json result = to_json(CameraSetReport{*CameraSet::decode(params), applied, std::nullopt});
  EXPECT_EQ(result.at("requested"), json({{"gain_db", 500}}));
  EXPECT_EQ(result.at("applied").at("gain_db"), 24);
  EXPECT_TRUE(result.at("limits").is_null());
  EXPECT_EQ(to_json(JobNumber{3}), json::parse(R"({"job":3})"));
}

TEST(WholeNumbers, WithoutLimitsAreThoseThatTheirTypeHolds) {
  const auto read = decode<test::Unbounded>(
      json::parse(R"({"count": -2147483648, "total": 1767225600123456789, "counts": [7, -7]})"));
  ASSERT_TRUE(read) << read.error().reason;
  EXPECT_EQ(read->count, -2147483648LL);
  EXPECT_EQ(read->total, 1767225600123456789) << "a time has all its digits";
  EXPECT_EQ(read->counts, (std::vector{7, -7}));
  for (const char* wide :
       {R"({"count": 2147483648})", R"({"total": 1e300})", R"({"counts": [1, 2147483648]})"}) {
    EXPECT_FALSE(decode<test::Unbounded>(json::parse(wide))) << wide;
  }
}

TEST(LoopModel, IsRefusedWithoutANumberOfItsLaws) {
  LoopModel model;
  model.modes.push_back({4, {{{0.5, 1.0, 0.05}}, 0.002}, 0.6, {}, {}, {}});
  const json whole = to_json(model);
  EXPECT_TRUE(decode<LoopModel>(whole));
  EXPECT_EQ(error_of(decode<LoopModel>(json::object())).field, "modes");
  for (const char* key : {"j", "noise_waves", "parts", "best_gain"}) {
    json part = whole;
    part["modes"][0].erase(key);
    EXPECT_EQ(error_of(decode<LoopModel>(part)).field, std::string("modes[0].") + key);
  }
}

TEST(Change, OfAMemberWithoutAKeyIsAFaultOfTheCaller) {
  Partial<test::Unbounded> change;
  change.put(&test::Unbounded::count, 3);
  EXPECT_TRUE(change.gives(&test::Unbounded::count));
  EXPECT_THROW(change.put(&test::Unbounded::without_key, 3), std::logic_error);
}

}  // namespace
}  // namespace ovws
