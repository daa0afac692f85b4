/// Camera contract: limits, settings and their refusal.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <tuple>

#include "drivers/aravis/settings_check.hpp"
#include "tests/contract/camera/camera_contract.hpp"

namespace ovws::testing {
namespace {

std::string as_text(double value) {
  std::ostringstream text;
  text.precision(10);
  text << value;
  return text.str();
}

template <class T>
void expect_sane(const Range<T>& range, const char* what) {
  EXPECT_LE(range.min, range.max) << what;
  EXPECT_GE(range.increment, T{}) << what;
  EXPECT_TRUE(std::isfinite(double(range.max)) && double(range.max) < 1e15) << what;
}

TEST_P(CameraContract, LimitsAreSane) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits) << limits.error().reason;
  expect_sane(limits->gain_raw.value_or(limits->gain_db), "gain");
  expect_sane(limits->exposure_us, "exposure");
  expect_sane(limits->frame_rate_hz, "frame rate");
  expect_sane(limits->roi_width, "width");
  expect_sane(limits->roi_height, "height");
  EXPECT_GT(limits->exposure_us.min, 0.0);
  EXPECT_GT(limits->frame_rate_hz.min, 0.0);
  EXPECT_GE(limits->roi_width.min, 1);
  EXPECT_GE(limits->roi_height.min, 1);
  EXPECT_LE(limits->roi_width.max, limits->sensor_width);
  EXPECT_LE(limits->roi_height.max, limits->sensor_height);
  EXPECT_GT(limits->roi_width.max + limits->roi_width.increment, limits->sensor_width);
  EXPECT_FALSE(limits->pixel_formats.empty());
}

TEST_P(CameraContract, TheSensorIsTheSameWhereverTheRegionIs) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  for (const Roi& roi : {Roi{0, 0, 64, 64}, Roi{64, 32, 64, 64}, Roi{512, 256, 128, 128}}) {
    CameraSettings wanted = bench_->settings();
    wanted.roi = roi;
    ASSERT_TRUE(camera->apply(wanted));
    auto now = camera->limits();
    ASSERT_TRUE(now);
    EXPECT_EQ(now->sensor_width, limits->sensor_width);
    EXPECT_EQ(now->sensor_height, limits->sensor_height);
    EXPECT_EQ(now->roi_width.max, limits->roi_width.max);
    EXPECT_EQ(now->roi_height.max, limits->roi_height.max);
  }
}

TEST_P(CameraContract, SaysWhatItIs) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  EXPECT_FALSE(camera->info().vendor.empty());
  EXPECT_FALSE(camera->info().model.empty());
  EXPECT_FALSE(camera->info().serial.empty());
  EXPECT_FALSE(camera->info().address.empty());
  EXPECT_TRUE(camera->alive());
  EXPECT_GE(camera->buffer_count(), 2);
}

TEST_P(CameraContract, ApplyReturnsWhatTheDeviceReallyHas) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench_->settings();
  wanted.*bench_->gain() = 3.0;
  wanted.exposure_us = 1500.0;
  wanted.frame_rate_hz = 125.0;
  wanted.roi = {64, 128, 160, 96};
  auto applied = camera->apply(wanted);
  ASSERT_TRUE(applied) << applied.error().reason;
  EXPECT_NEAR(*applied.*bench_->gain(), wanted.*bench_->gain(), 1e-6);
  EXPECT_NEAR(applied->exposure_us, wanted.exposure_us, 1e-6);
  EXPECT_NEAR(applied->frame_rate_hz, wanted.frame_rate_hz, 1e-6);
  EXPECT_EQ(applied->roi, wanted.roi);
  EXPECT_EQ(applied->pixel_format, wanted.pixel_format);
  if (const auto truth = bench_->truth()) {
    EXPECT_EQ(*truth, *applied);
  }
}

TEST_P(CameraContract, ApplyingTheSameAgainChangesNothing) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto first = camera->apply(bench_->settings());
  auto second = camera->apply(bench_->settings());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
}

TEST_P(CameraContract, BothEndsOfEveryRangeAreAccepted) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  CameraSettings settings = bench_->settings();
  settings.frame_rate_hz = 1.0;
  settings.exposure_us = 1000.0;
  ASSERT_TRUE(camera->apply(settings));
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  const auto accepted = [&](double& setting, double value, const char* what) {
    const double before = std::exchange(setting, value);
    auto applied = camera->apply(settings);
    EXPECT_TRUE(applied) << what << " " << value << ": " << applied.error().reason;
    setting = before;
    EXPECT_TRUE(camera->apply(settings));
  };
  const Range<double> gain = limits->gain_raw.value_or(limits->gain_db);
  accepted(settings.*bench_->gain(), gain.min, "gain");
  accepted(settings.*bench_->gain(), gain.max, "gain");
  accepted(settings.exposure_us, limits->exposure_us.min, "exposure");
  accepted(settings.exposure_us, std::min(limits->exposure_us.max, 1e6), "exposure");
  accepted(settings.frame_rate_hz, limits->frame_rate_hz.max, "frame rate");
  for (const Roi& roi : {Roi{0, 0, limits->roi_width.min, limits->roi_height.min},
                         Roi{0, 0, limits->roi_width.max, limits->roi_height.max}}) {
    settings.roi = roi;
    auto applied = camera->apply(settings);
    ASSERT_TRUE(applied) << applied.error().reason;
    EXPECT_EQ(applied->roi, roi);
  }
}

TEST_P(CameraContract, AValueBetweenTwoStepsGoesToTheNearestAndARegionBack) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  CameraSettings wanted = bench_->settings();
  const Range<double> gain = limits->gain_raw.value_or(limits->gain_db);
  wanted.*bench_->gain() = gain.min + 3.3 * gain.increment;
  wanted.exposure_us = 1000.0 + 0.4 * limits->exposure_us.increment;
  wanted.roi.width += limits->roi_width.increment - 1;
  wanted.roi.height += limits->roi_height.increment - 1;
  auto applied = camera->apply(wanted);
  ASSERT_TRUE(applied) << applied.error().reason;
  EXPECT_NEAR(*applied.*bench_->gain(), gain.min + 3.0 * gain.increment, 1e-6);
  EXPECT_NEAR(applied->exposure_us, 1000.0, 1e-6);
  EXPECT_EQ(applied->roi, bench_->settings().roi);
}

TEST_P(CameraContract, AValueOutOfRangeIsRefusedAndNothingChanges) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  const CameraSettings good = bench_->settings();
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Setting {
    double CameraSettings::*member;
    const char* field;
    Range<double> range;
  };
  const Setting settings[] = {
      {bench_->gain(), limits->gain_raw ? "camera.gain_raw" : "camera.gain_db",
       limits->gain_raw.value_or(limits->gain_db)},
      {&CameraSettings::exposure_us, "camera.exposure_us", limits->exposure_us},
      {&CameraSettings::frame_rate_hz, "camera.frame_rate_hz", limits->frame_rate_hz}};
  for (const auto& [member, field, range] : settings)
    for (double bad : {range.min - 1e-3, range.max + 1.0, -1e9, 1e12, inf, -inf, nan}) {
      if (std::isnan(bad) && member == &CameraSettings::gain_raw) continue;  // leaves the gain
      CameraSettings wanted = good;
      wanted.*member = bad;
      std::vector<std::string> words = {as_text(range.min), as_text(range.max)};
      if (range.increment > 0.0) words.push_back(as_text(range.increment));
      expect_refused(*camera, wanted, field, words);
    }
}

TEST_P(CameraContract, OneBadValueKeepsTheGoodOnesFromBeingApplied) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  CameraSettings wanted = bench_->settings();
  wanted.*bench_->gain() = 2.0;
  wanted.roi = {32, 32, 64, 64};
  // Fits the period, so that the rate's own limit is hit only after the others were written.
  wanted.exposure_us = 100.0;
  wanted.frame_rate_hz = 5000.0;
  expect_refused(*camera, wanted, "camera.frame_rate_hz", {});
}

TEST_P(CameraContract, AnExposureLongerThanTheFramePeriodIsRefused) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench_->settings();
  wanted.frame_rate_hz = 100.0;
  ASSERT_TRUE(camera->apply(wanted));
  wanted.exposure_us = 10100.0;
  expect_refused(*camera, wanted, "camera.exposure_us", {"10000", "10100"});
}

TEST_P(CameraContract, RateAndExposureMayChangeTogetherEitherWay) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench_->settings();
  for (const auto& [rate, exposure] : {std::pair{10.0, 90'000.0}, std::pair{200.0, 500.0},
                                       std::pair{50.0, 20'000.0}, std::pair{250.0, 4'000.0}}) {
    wanted.frame_rate_hz = rate;
    wanted.exposure_us = exposure;
    auto applied = camera->apply(wanted);
    ASSERT_TRUE(applied) << rate << " Hz: " << applied.error().reason;
    EXPECT_NEAR(applied->frame_rate_hz, rate, 1e-6);
    EXPECT_NEAR(applied->exposure_us, exposure, 1e-6);
  }
}

TEST_P(CameraContract, ARegionOutsideTheSensorIsRefusedWithTheSensorsSize) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  const int w = limits->sensor_width;
  const int h = limits->sensor_height;
  constexpr int kHuge = std::numeric_limits<int>::max();
  for (const Roi& roi :
       {Roi{0, 0, w + 8, 128}, Roi{0, 0, 128, h + 8}, Roi{w - 64, 0, 128, 128},
        Roi{0, h - 64, 128, 128}, Roi{-8, 0, 128, 128}, Roi{0, -8, 128, 128}, Roi{0, 0, 0, 128},
        Roi{0, 0, 128, -1}, Roi{kHuge, kHuge, 128, 128}, Roi{8, 8, kHuge, kHuge}}) {
    CameraSettings wanted = bench_->settings();
    wanted.roi = roi;
    expect_refused(*camera, wanted, "camera.roi", {std::to_string(w), std::to_string(h)});
  }
}

TEST_P(CameraContract, APixelFormatThatItLacksIsRefusedWithThoseThatItHas) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  std::vector<std::string> names;
  for (PixelFormat has : limits->pixel_formats) names.emplace_back(pixel_format_name(has));
  for (PixelFormat format : {PixelFormat::mono8, PixelFormat::mono10, PixelFormat::mono12,
                             PixelFormat::mono14, PixelFormat::mono16}) {
    if (std::count(limits->pixel_formats.begin(), limits->pixel_formats.end(), format)) continue;
    CameraSettings wanted = bench_->settings();
    wanted.pixel_format = format;
    expect_refused(*camera, wanted, "camera.pixel_format", names);
  }
}

TEST(AStreamingCamera, ChangesWhatWasAskedAndOfTimesWhatGoesWithIt) {
  const CameraSettings before{3.0, 300.0, 60.0, PixelFormat::mono12, {0, 0, 512, 480}};
  CameraSettings wanted = before;
  wanted.gain_db = 5.0;
  EXPECT_FALSE(has_unrequested_change(wanted, before, wanted));
  CameraSettings rounded = wanted;
  rounded.gain_db = 5.1;
  EXPECT_FALSE(has_unrequested_change(wanted, before, rounded));
  for (const auto change :
       {+[](CameraSettings& s) { s.exposure_us = 2000.0; },
        +[](CameraSettings& s) { s.frame_rate_hz = 100.0; },
        +[](CameraSettings& s) { s.pixel_format = PixelFormat::mono8; },
        +[](CameraSettings& s) { s.roi.height = 512; }, +[](CameraSettings& s) { s.roi.x = 8; }}) {
    CameraSettings applied = wanted;
    change(applied);
    EXPECT_TRUE(has_unrequested_change(wanted, before, applied));
  }
  CameraSettings longer = before;
  longer.exposure_us = 20'000.0;
  CameraSettings slower = longer;
  slower.frame_rate_hz = 50.0;
  EXPECT_FALSE(has_unrequested_change(longer, before, slower));
  slower.gain_db = 0.0;
  EXPECT_TRUE(has_unrequested_change(longer, before, slower));
}

TEST(PackedRows, MustEndAtAWholeByte) {
  EXPECT_TRUE(check_region_suits_format(PixelFormat::mono8, {0, 0, 511, 100}));
  EXPECT_TRUE(check_region_suits_format(PixelFormat::mono12, {0, 0, 511, 100}));
  EXPECT_TRUE(check_region_suits_format(PixelFormat::mono12p, {0, 0, 510, 99}));
  EXPECT_TRUE(check_region_suits_format(PixelFormat::mono10p, {0, 0, 508, 99}));
  for (const auto& [format, width, multiple] : {std::tuple{PixelFormat::mono12p, 511, "2"},
                                                {PixelFormat::bayer_rg12p, 511, "2"},
                                                {PixelFormat::mono12_packed, 511, "2"},
                                                {PixelFormat::mono10_packed, 511, "2"},
                                                {PixelFormat::mono10p, 510, "4"}}) {
    const auto refused = check_region_suits_format(format, {0, 0, width, 100});
    ASSERT_FALSE(refused) << pixel_format_name(format);
    EXPECT_EQ(refused.error().field, "camera.roi");
    EXPECT_NE(refused.error().reason.find(std::string("multiple of ") + multiple),
              std::string::npos);
  }
}

TEST(ColourFilters, MustBeginWithTheRegion) {
  EXPECT_TRUE(check_region_suits_format(PixelFormat::bayer_rg8, {2, 4, 128, 128}));
  EXPECT_TRUE(check_region_suits_format(PixelFormat::mono8, {1, 3, 128, 128}));
  EXPECT_FALSE(check_region_suits_format(PixelFormat::bayer_rg8, {1, 4, 128, 128}));
  EXPECT_FALSE(check_region_suits_format(PixelFormat::bayer_gb12p, {2, 3, 128, 128}));
}

}  // namespace
}  // namespace ovws::testing
