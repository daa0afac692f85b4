#include "proto/encode.hpp"
#include "proto/tables/slm.hpp"
#include "proto/tables/status.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace ovws {
namespace {

using nlohmann::json;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

float float_at(std::span<const std::byte> bytes, std::size_t index) {
  float value = 0;
  std::memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
  return value;
}

TEST(EncodeWavefront, SaysAllThatItHolds) {
  const std::array<int, 3> j{1, 2, 3};
  const std::array<float, 3> coefficients{0.1F, -2e-7F, 0.5F};
  WavefrontMessage m;
  m.seq = 18446744073709551615u;
  m.t_arrival_ns = 1767225600123456789;
  m.tracker = "lg";
  m.valid = true;
  m.rms_waves = 0.5;
  m.j = j;
  m.coefficients = coefficients;
  std::string text = "left over from before";
  encode(m, text);
  const json out = json::parse(text);
  EXPECT_EQ(out.at("schema"), "ovws.wavefront/1");
  EXPECT_EQ(out.at("seq").get<std::uint64_t>(), 18446744073709551615u);
  EXPECT_EQ(out.at("t_arrival_ns").get<std::int64_t>(), 1767225600123456789);
  EXPECT_EQ(out.at("j"), json({1, 2, 3}));
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(out.at("coefficients")[k].get<float>(), coefficients[k]);
  }
  EXPECT_EQ(out.at("rms_waves"), 0.5);
  EXPECT_EQ(out.at("gain_db"), json());
  EXPECT_EQ(out.at("gain_raw"), json());
  EXPECT_EQ(out.at("unit"), "wave");
  EXPECT_EQ(out.at("basis"), "zernike-osa-rms");
  EXPECT_EQ(out.at("orientation"), "x-right-y-down");
  EXPECT_EQ(out.at("loop"), "open");
  EXPECT_EQ(out.at("verdict"), "changing");
}

TEST(EncodeWavefront, AGainThatIsNotInDbIsNullAndGivenRaw) {
  WavefrontMessage m;
  m.gain_db = kUnknownGain;
  m.gain_raw = 7.0;
  m.exposure_us = 2000.0;
  std::string text;
  encode(m, text);
  const json out = json::parse(text);
  EXPECT_EQ(out.at("gain_db"), json());
  EXPECT_EQ(out.at("gain_raw"), 7.0);
  EXPECT_EQ(out.at("exposure_us"), 2000.0);
}

TEST(EncodeWavefront, IsNullThroughoutIfNotValid) {
  const std::array<int, 2> j{1, 2};
  const std::array<float, 2> coefficients{0.1F, 0.2F};
  WavefrontMessage m;
  m.rms_waves = 0.3;
  m.j = j;
  m.coefficients = coefficients;
  std::string text;
  encode(m, text);
  EXPECT_EQ(json::parse(text).at("coefficients"), json::parse("[null,null]"));
  EXPECT_EQ(json::parse(text).at("rms_waves"), json());
}

TEST(EncodeWavefront, LetsNeitherNanNorInfinityOut) {
  const std::array<int, 3> j{1, 2, 3};
  const std::array<float, 3> coefficients{kNan, std::numeric_limits<float>::infinity(), 1.0F};
  WavefrontMessage m;
  m.valid = true;
  m.latency_us = std::nan("");
  m.saturated = -std::numeric_limits<double>::infinity();
  m.fit_residual_px = std::nan("");
  m.j = j;
  m.coefficients = coefficients;
  std::string text;
  encode(m, text);
  const json out = json::parse(text);  // strict JSON has no NaN
  EXPECT_EQ(out.at("coefficients"), json::parse("[null,null,1.0]"));
  EXPECT_EQ(out.at("latency_us"), json());
  EXPECT_EQ(out.at("fit_residual_px"), json());
}

TEST(EncodeCorrector, HasOneFloatForEachActuatorOrNone) {
  const std::array<float, 3> commands{1.5F, -2.0F, 0.25F};
  CorrectorMessage m;
  m.valid = true;
  m.matrix = 7;
  m.commands = commands;
  std::string text;
  const auto binary = encode(m, text);
  json out = json::parse(text);
  EXPECT_EQ(out.at("schema"), "ovws.corrector/1");
  EXPECT_EQ(out.at("matrix"), 7);
  EXPECT_EQ(out.at("shape"), json({3}));
  ASSERT_EQ(binary.size(), 3 * sizeof(float));
  EXPECT_EQ(float_at(binary, 1), -2.0F);

  m.valid = false;
  m.commands = {};
  EXPECT_TRUE(encode(m, text).empty());
  out = json::parse(text);
  EXPECT_EQ(out.at("valid"), false);
  EXPECT_EQ(out.at("shape"), json({0}));
}

TEST(EncodeRefined, SaysAllThatItHolds) {
  RefinedMessage m;
  m.frame_id = 1041;
  m.valid = true;
  m.against_reference = true;
  m.j = {1, 3, 4};
  m.coefficients = {5.0, 0.3, -0.4};
  m.sigma = {0.1, 0.001, std::nan("")};
  m.fit = RefinedMessage::Fit{1.25, 700.0, -0.5, 9};
  const json out = json::parse(encode(m));
  EXPECT_EQ(out.at("schema"), "ovws.refined/1");
  EXPECT_EQ(out.at("against"), "reference");
  EXPECT_EQ(out.at("reason"), json());
  EXPECT_DOUBLE_EQ(out.at("rms_waves"), 0.5);  // tilts are excluded
  EXPECT_EQ(out.at("coefficients"), json({5.0, 0.3, -0.4}));
  EXPECT_EQ(out.at("sigma"), json::parse("[0.1,0.001,null]"));
  EXPECT_EQ(out.at("chi2_per_pixel"), 1.25);
  EXPECT_EQ(out.at("iterations"), 9);
}

TEST(EncodeRefined, IsNullIfNotValidAndSaysWhy) {
  RefinedMessage m;
  m.reason = "too \"dark\"";
  m.j = {1, 2};
  const json unfitted = json::parse(encode(m));
  EXPECT_EQ(unfitted.at("reason"), "too \"dark\"");
  EXPECT_EQ(unfitted.at("against"), "model");
  EXPECT_EQ(unfitted.at("coefficients"), json::parse("[null,null]"));
  EXPECT_EQ(unfitted.at("sigma"), json::parse("[null,null]"));
  EXPECT_EQ(unfitted.at("chi2_per_pixel"), json());
  m.coefficients = m.sigma = {1.0, 2.0};
  m.fit = RefinedMessage::Fit{9.0, 700.0, 0.0, 9};
  const json doubted = json::parse(encode(m));
  EXPECT_EQ(doubted.at("coefficients"), json::parse("[null,null]"));
  EXPECT_EQ(doubted.at("rms_waves"), json());
  EXPECT_EQ(doubted.at("chi2_per_pixel"), 9.0);
}

TEST(EncodeSpots, WritesSixFloatsASpotInTheOrderOfTheColumns) {
  std::array<SpotFix, 2> spots;
  spots[0] = {10.25F, 20.5F, 200.0F, 0.75F};
  const std::array<Vec2, 2> reference{Vec2{1.5, 2.5}, Vec2{3.5, 4.5}};
  SpotsMessage m;
  m.spots = spots;
  m.reference_px = reference;
  std::string text;
  std::vector<std::byte> scratch;
  const auto bytes = encode(m, text, scratch);
  const json out = json::parse(text);
  EXPECT_EQ(out.at("shape"), json({2, 6}));
  EXPECT_EQ(out.at("dtype"), "<f4");
  EXPECT_EQ(out.at("columns"), json({"x", "y", "ref_x", "ref_y", "peak", "quality"}));
  ASSERT_EQ(bytes.size(), 2u * 6 * 4);
  const std::array<float, 6> first{10.25F, 20.5F, 1.5F, 2.5F, 200.0F, 0.75F};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(float_at(bytes, k), first[k]);
  EXPECT_TRUE(std::isnan(float_at(bytes, 6)));  // lost
  EXPECT_EQ(float_at(bytes, 8), 3.5F);
  EXPECT_EQ(float_at(bytes, 11), 0.0F);

  m.reference_px = {};
  EXPECT_TRUE(std::isnan(float_at(encode(m, text, scratch), 2)));
}

TEST(EncodeSpots, SaysOfTheFrameWhatTheWavefrontSays) {
  WavefrontMessage w;
  SpotsMessage s;
  std::string text;
  std::vector<std::byte> scratch;
  encode(w, text);
  json wavefront = json::parse(text);
  encode(s, text, scratch);
  const json spots = json::parse(text);
  for (const char* key : {"schema", "j", "coefficients", "sigma", "branch_points"})
    wavefront.erase(key);
  for (const auto& [key, value] : wavefront.items()) {
    EXPECT_TRUE(spots.contains(key)) << key;
  }
}

TEST(EncodeImage, LeavesPaddingOut) {
  const std::array<std::uint8_t, 8> padded{1, 2, 3, 0, 4, 5, 6, 0};
  ImageMessage m;
  m.image = {reinterpret_cast<const std::byte*>(padded.data()), 3, 2, 4, PixelFormat::mono8};
  std::string text;
  std::vector<std::byte> scratch;
  const auto bytes = encode(m, text, scratch);
  ASSERT_EQ(bytes.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(int(bytes[k]), int(k) + 1);
  EXPECT_EQ(json::parse(text).at("shape"), json({2, 3}));  // rows, then columns
  EXPECT_EQ(json::parse(text).at("dtype"), "<u1");
}

TEST(EncodeImage, SendsDeepPixelsInPlace) {
  Image<std::uint16_t> image(3, 2, 0x0123);
  ImageMessage m;
  m.image = view_of(image, PixelFormat::mono12);
  std::string text;
  std::vector<std::byte> scratch;
  const auto bytes = encode(m, text, scratch);
  EXPECT_EQ(bytes.data(), reinterpret_cast<const std::byte*>(image.pixels.data()));
  EXPECT_EQ(bytes.size(), 12u);
  EXPECT_EQ(int(bytes[0]), 0x23);
  const json out = json::parse(text);
  EXPECT_EQ(out.at("dtype"), "<u2");
  EXPECT_EQ(out.at("pixel_format"), "Mono12");
  EXPECT_EQ(out.at("significant_bits"), 12);
}

TEST(EncodePhase, SendsTheRowsAsTheyAre) {
  Image<float> waves(4, 2, kNan);
  waves.at(1, 0) = 0.25F;
  PhaseMessage m;
  m.waves = &waves;
  std::string text;
  const auto bytes = encode(m, text);
  EXPECT_EQ(json::parse(text).at("shape"), json({2, 4}));
  EXPECT_TRUE(std::isnan(float_at(bytes, 0)));
  EXPECT_EQ(float_at(bytes, 1), 0.25F);
}

TEST(EncodeStatus, IsTheBodyOfSystemStatusAndSchemaAndSeq) {
  StatusMessage m;
  m.seq = 5;
  m.state = "run\xffning";
  m.counters = {{"frames_grabbed", 12}};
  m.latency = {{"tracked", LatencySummary{3, 1.0, 2.0, std::nan(""), 4.0}}};
  json out = json::parse(encode(m));
  EXPECT_EQ(out.at("state"), "run\xef\xbf\xbdning");
  EXPECT_EQ(out.at("counters").at("frames_grabbed"), 12);
  EXPECT_EQ(out.at("latency").at("tracked").at("p999_us"), json());
  const json& totals = out.at("latency").at("tracked").at("since_start");
  EXPECT_EQ(totals.at("edges_us").size(), totals.at("below").size());
  EXPECT_EQ(out.at("camera").at("info"), json());
  EXPECT_EQ(out.at("seq"), 5);
  EXPECT_EQ(out.at("failed_job"), json());
  EXPECT_EQ(out.at("schema"), "ovws.status/1");
  EXPECT_FALSE(to_json(m).contains("seq"));
}

TEST(SettleResult, SaysWhatIsWrongWithTheSettingAndThatOutliersMayNotBeTheMachines) {
  SettleTime time;
  time.max_ms = 22.8;
  time.worst_ms = 41.0;
  time.outliers = 2;
  time.proposed_ms = 28.0;
  const auto reason = [&](double configured_ms) {
    return to_json(SettleReport{time, 5, configured_ms}).at("reason");
  };
  EXPECT_NE(reason(22.2).get<std::string>().find("22.2 ms"), std::string::npos);
  EXPECT_NE(reason(22.2).get<std::string>().find("set slm.settle_ms to 28"), std::string::npos);
  EXPECT_FALSE(to_json(SettleReport{time, 5, 22.2}).at("long_enough"));
  EXPECT_NE(reason(30.0).get<std::string>().find("2 changes took up to 41.0 ms"),
            std::string::npos);
  EXPECT_TRUE(to_json(SettleReport{time, 5, 30.0}).at("long_enough"));
  EXPECT_TRUE(reason(41.0).is_null());
}

}  // namespace
}  // namespace ovws
