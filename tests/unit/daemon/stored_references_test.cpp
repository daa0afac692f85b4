#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/library/items.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using test::hologram_of;
using test::kCamera;

class StoredReferences : public testing::Test {
 protected:
  static Reference taken(const Config& config, std::int64_t t_taken_ns = 5,
                         const std::optional<Registration>& registration = std::nullopt) {
    Reference reference;
    reference.key = test::key_of(config, registration);
    reference.key.tracking = position_tracking(config.tracking);
    reference.frames = 100;
    reference.t_taken_ns = t_taken_ns;
    reference.aberration = {{3, 0.05}, {4, -0.025}};
    const auto lattice = make_lattice(config.sensor, config.slm.geometry);
    for (std::size_t i = 0; i < lattice->subapertures.size(); ++i) {
      reference.positions_px.push_back({0.1 * double(i), 1.0 / 3.0});
      reference.standard_error_px.push_back({1e-3, 2e-3 / 3.0});
    }
    reference.beams = {
        {{50, 7, {{3, 0.1}}, {{3, 0.1}}, reference.positions_px, reference.standard_error_px},
         "b",
         {0.5, 400.0}}};
    reference.beams[0].standard_error_px[1] = {NAN, NAN};
    auto picture = std::make_shared<ReferenceImage>();
    picture->frames = 8;
    picture->gain_db = 16.0;
    picture->format = PixelFormat::mono12;
    picture->mean_dn = Image<float>(32, 24, 1.0F / 3.0F);
    picture->mean_dn.at(3, 2) = std::nanf("");
    reference.picture = picture;
    const auto renderer = HologramRenderer::make(hologram_of(config));
    Image<std::uint8_t> grey;
    renderer->render(HologramKind::sensor, reference.aberration, grey);
    const std::optional<CameraSettings> settings = config.camera.settings;
    reference.origin = std::make_shared<const json>(
        make_origin({reference.key, reference.aberration, settings, registration, &grey}));
    return reference;
  }

  const Config config_ = test::small_bench();
};

TEST_F(StoredReferences, AReferenceIsFoundAgainBitForBit) {
  const Reference before = taken(config_);
  const auto read = reference_from(reference_content(before));
  ASSERT_TRUE(read) << read.error().reason;
  const Reference& after = *read;
  EXPECT_EQ(differing(respect::kReference, after.key, before.key), 0U);
  EXPECT_EQ(after.source, before.source);
  EXPECT_EQ(after.frames, before.frames);
  EXPECT_EQ(after.t_taken_ns, before.t_taken_ns);
  EXPECT_EQ(after.aberration, before.aberration);
  EXPECT_EQ(*after.origin, *before.origin);
  ASSERT_EQ(after.beams.size(), before.beams.size());
  for (std::size_t k = 0; k < after.beams.size(); ++k) {
    const BeamReference &is = after.beams[k], &was = before.beams[k];
    EXPECT_EQ(is.beam, was.beam);
    EXPECT_EQ(is.offset_px, was.offset_px);
    EXPECT_EQ(is.frames, was.frames);
    EXPECT_EQ(is.t_taken_ns, was.t_taken_ns);
    EXPECT_EQ(is.aberration, was.aberration);
    EXPECT_EQ(is.introduced, was.introduced);
    EXPECT_EQ(is.positions_px, was.positions_px);
    EXPECT_TRUE(std::isnan(is.standard_error_px.at(1).x));
    EXPECT_EQ(is.standard_error_px.at(0), was.standard_error_px.at(0));
  }
  ASSERT_EQ(after.positions_px.size(), before.positions_px.size());
  for (std::size_t i = 0; i < after.positions_px.size(); ++i) {
    EXPECT_EQ(after.positions_px[i].x, before.positions_px[i].x);
    EXPECT_EQ(after.positions_px[i].y, before.positions_px[i].y);
    EXPECT_EQ(after.standard_error_px[i].y, before.standard_error_px[i].y);
  }
  ASSERT_TRUE(after.picture);
  EXPECT_EQ(after.picture->frames, 8);
  EXPECT_EQ(after.picture->gain_db, 16.0);
  EXPECT_EQ(after.picture->format, PixelFormat::mono12);
  const auto& a = after.picture->mean_dn.pixels;
  const auto& b = before.picture->mean_dn.pixels;
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
}

TEST_F(StoredReferences, AnotherBenchDoesNotUseItAndSaysWhy) {
  const Reference reference = taken(config_);
  const auto why = [&](const Config& config, const HologramConfig& hologram) {
    BenchKey now = test::key_of(config);
    now.slm = slm_identity(hologram, false);
    return words_of(differing(respect::kReference, reference.key, now), reference.key, now);
  };
  const HologramConfig hologram = hologram_of(config_);
  EXPECT_EQ(why(config_, hologram), "");
  Config other = config_;
  other.optics.wavelength_nm = 633.0;
  EXPECT_EQ(why(other, hologram), "optics.wavelength_nm was 632.0, and is 633.0");
  other = config_;
  other.optics.centre_px = Vec2{10.0, 10.0};
  EXPECT_EQ(why(other, hologram), "optics.centre_px was null, and is [10.0,10.0]");
  other = config_;
  other.slm.geometry.width_px = 192;
  EXPECT_EQ(why(other, hologram_of(other)).find("slm.width was 160, and is 192"), 0U);
  other = config_;
  other.sensor.charge = 2;
  EXPECT_EQ(why(other, hologram), "sensor.charge was 1, and is 2");
  HologramConfig changed = hologram;
  changed.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.0F);
  EXPECT_EQ(why(config_, changed), "it was taken with another look-up table or flatness");
}

TEST_F(StoredReferences, AHologramThatIsDrawnOtherwiseIsNoticed) {
  const Reference reference = taken(config_);
  const auto obstacle = [&](const HologramConfig& hologram, std::size_t spots) {
    return drawing_obstacle(*reference.origin, reference.key, spots, hologram, {});
  };
  const std::size_t spots = reference.positions_px.size();
  HologramConfig hologram = hologram_of(config_);
  EXPECT_EQ(obstacle(hologram, spots), "");
  EXPECT_NE(obstacle(hologram, spots + 1), "");
  hologram.lut[200] = 7;
  EXPECT_NE(obstacle(hologram, spots), "");
}

TEST_F(StoredReferences, GainExposureAndFormatOnlyMakeItStale) {
  const Reference reference = taken(config_);
  CameraSettings now = config_.camera.settings;
  EXPECT_TRUE(stale_fields(reference, now).empty());
  EXPECT_TRUE(stale_fields(reference, std::nullopt).empty());
  now.frame_rate_hz = 7.0;
  EXPECT_TRUE(stale_fields(reference, now).empty());
  now.gain_db = 20.0;
  now.exposure_us = 1.0;
  now.pixel_format = PixelFormat::mono12;
  const auto stale = stale_fields(reference, now);
  ASSERT_EQ(stale.size(), 3U);
  EXPECT_EQ(stale[1].field, "gain_db");
  EXPECT_EQ(stale[1].then, 0.0);
  EXPECT_EQ(stale[1].now, 20.0);
  CameraSettings raw = config_.camera.settings;
  raw.gain_db = kUnknownGain;
  raw.gain_raw = 7.0;
  const auto other_unit = stale_fields(reference, raw);
  ASSERT_EQ(other_unit.size(), 1U);
  EXPECT_EQ(other_unit[0].field, "gain_db");
  EXPECT_EQ(other_unit[0].now, nlohmann::json());
  Reference model = reference;
  model.source = ReferenceSource::model;
  EXPECT_TRUE(stale_fields(model, now).empty());
}

TEST_F(StoredReferences, ASettingThatTheFileLacksIsNotKnownAndNotStale) {
  Reference reference = taken(config_);
  json origin = *reference.origin;
  origin["settings"].erase("gain_db");
  reference.origin = std::make_shared<const json>(std::move(origin));
  CameraSettings now = config_.camera.settings;
  now.gain_db = 20.0;
  EXPECT_TRUE(stale_fields(reference, now).empty());
  now.exposure_us = 1.0;
  ASSERT_EQ(stale_fields(reference, now).size(), 1U);
  EXPECT_EQ(stale_fields(reference, now)[0].field, "exposure_us");
}

TEST_F(StoredReferences, AnotherCameraIsReported) {
  const Reference reference = taken(config_);
  const auto differs = [&](const std::optional<CameraInfo>& camera) {
    BenchKey now = test::key_of(config_);
    now.camera = camera_json(camera);
    return differing(respect::kReference, reference.key, now) == respect::kCamera;
  };
  CameraInfo camera = kCamera;
  camera.address = "10.0.0.7";
  EXPECT_FALSE(differs(camera));
  EXPECT_FALSE(differs(std::nullopt));
  camera.model = "\xff";
  EXPECT_TRUE(differs(camera));
  camera = kCamera;
  camera.serial = "TWIN0002";
  EXPECT_TRUE(differs(camera));
}

TEST_F(StoredReferences, TheMapThatItWasTakenUnderComesBack) {
  Registration registration;
  registration.px_per_cycle = {0.0, 1900.0, -1900.0, 0.1};
  registration.base_px = {100.0, 200.0 / 3.0};
  registration.t_taken_ns = 7;
  const auto read = reference_from(reference_content(taken(config_, 8, registration)));
  ASSERT_TRUE(read);
  ASSERT_TRUE(read->registration);
  EXPECT_EQ(read->registration->px_per_cycle, registration.px_per_cycle);
  EXPECT_EQ(read->registration->base_px.y, registration.base_px.y);
  EXPECT_EQ(read->registration->t_taken_ns, 7);
  EXPECT_EQ(read->key.px_per_cycle, registration.px_per_cycle);
}

TEST_F(StoredReferences, ContentThatDoesNotFitTogetherIsRefused) {
  const json right = reference_content(taken(config_));
  ASSERT_TRUE(reference_from(right));
  std::vector<std::pair<std::string, json>> changes{
      {"/frames", "many"},
      {"/source", "guessed"},
      {"/t_taken_ns", 1.5},
      {"/positions_px", json::array()},
      {"/positions_px/0", json::array({1})},
      {"/positions_px/0/0", nullptr},
      {"/standard_error_px", json::array({json::array({0, 0})})},
      {"/origin", nullptr},
      {"/origin/sensor/charge", 99},
      {"/origin/sensor/charme", 1},
      {"/origin/roi/width", 33},
      {"/origin/aberration", "none"},
      {"/origin/registration", json::object()},
      {"/picture/width", 31},
      {"/picture/height", 1 << 20},
      {"/picture/pixel_format", "Mono9"},
      {"/picture/mean_dn", "AAAA"},
      {"/picture", 7},
      {"/beams/0/positions_px", json::array()},
      {"/beams/0/frames", "many"},
      {"/beams/0/t_taken_ns", 1.5},
      {"/beams/0/aberration", 7},
      {"/more", 1}};
  for (const auto& [path, value] : changes) {
    json wrong = right;
    wrong[json::json_pointer(path)] = value;
    const auto read = reference_from(wrong);
    ASSERT_FALSE(read) << path;
    EXPECT_FALSE(read.error().reason.empty()) << path;
  }
  for (const auto& item : right.items()) {
    json wrong = right;
    wrong.erase(item.key());
    const bool optional = item.key() == "t_taken" || item.key() == "beams";
    EXPECT_EQ(bool(reference_from(wrong)), optional) << item.key();
  }
  for (const json& wrong : {json(), json(3), json::array(), json("x")}) {
    EXPECT_FALSE(reference_from(wrong));
  }
}

}  // namespace
}  // namespace ovws
