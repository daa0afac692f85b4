#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/sensor/reference_file.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::hologram_of;
using test::kCamera;

class KeptReferencesTest : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  /// The part of a daemon, just started with this configuration, that keeps references.
  struct Started {
    Started(const Config& config, const std::string& folder, HologramConfig hologram)
        : store({folder}, events),
          bench(config, std::move(hologram)),
          references(ReferenceKind{&bench}, store, events) {}
    StreamQueue queue;
    Events events{queue};
    DaemonStore store;
    ReferenceBench bench;
    KeptReferences references;
  };
  std::unique_ptr<Started> started(const Config& config) const {
    return std::make_unique<Started>(config, folder_, hologram_of(config));
  }

  static Reference taken(const Started& daemon, const Config& config, std::int64_t t_taken_ns = 5,
                         const std::optional<Registration>& registration = std::nullopt) {
    Reference reference;
    reference.key = reference_key(config.sensor, config.tracking, config.camera.settings.roi);
    reference.frames = 100;
    reference.t_taken_ns = t_taken_ns;
    reference.aberration = {{3, 0.05}, {4, -0.025}};
    const auto lattice = make_lattice(config.sensor, config.slm.geometry);
    for (std::size_t i = 0; i < lattice->subapertures.size(); ++i) {
      reference.positions_px.push_back({0.1 * double(i), 1.0 / 3.0});
      reference.standard_error_px.push_back({1e-3, 2e-3 / 3.0});
    }
    reference.beams = {{"b",
                        {0.5, 400.0},
                        50,
                        7,
                        {{3, 0.1}},
                        {{3, 0.1}},
                        reference.positions_px,
                        reference.standard_error_px}};
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
    const std::optional<CameraInfo> camera = kCamera;
    reference.origin = std::make_shared<const json>(daemon.bench.origin(
        {reference.key, reference.aberration, settings, camera, registration, &grey}));
    return reference;
  }

  KeptReferences::Items found(const Config& config) const {
    return started(config)->references.load();
  }

  const std::string folder_ = own_folder("reference_archive");
  const Config config_ = test::small_bench();
};

TEST_F(KeptReferencesTest, AReferenceIsFoundAgainBitForBit) {
  auto daemon = started(config_);
  Reference before = taken(*daemon, config_);
  daemon->references.keep(before, {}, [&](const std::string& sha256) { before.sha256 = sha256; });
  EXPECT_EQ(before.sha256.size(), 64U);
  const auto all = found(config_);
  ASSERT_EQ(all.size(), 1U);
  const Reference& after = *all[0];
  EXPECT_EQ(after.key, before.key);
  EXPECT_EQ(after.source, before.source);
  EXPECT_EQ(after.frames, before.frames);
  EXPECT_EQ(after.t_taken_ns, before.t_taken_ns);
  EXPECT_EQ(after.sha256, before.sha256);
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

TEST_F(KeptReferencesTest, TheOneTakenLastTakesThePlaceOfTheOneBeforeAndOneThatIsDroppedIsGone) {
  auto daemon = started(config_);
  Reference first = taken(*daemon, config_, 5), second = taken(*daemon, config_, 6);
  daemon->references.keep(first);
  daemon->references.keep(second);
  ASSERT_EQ(found(config_).size(), 1U);
  EXPECT_EQ(found(config_)[0]->t_taken_ns, 6);
  bool dropped = false;
  daemon->references.drop({identity_of(*second.origin)},
                          [&](const Result<void>& done) { dropped = done.has_value(); });
  ASSERT_TRUE(dropped);
  EXPECT_TRUE(found(config_).empty());
}

TEST_F(KeptReferencesTest, AnotherBenchDoesNotUseItAndFindsItAgainWhenItIsAsItWas) {
  auto daemon = started(config_);
  Reference reference = taken(*daemon, config_);
  daemon->references.keep(reference);
  std::vector<Config> others(5, config_);
  others[0].optics.wavelength_nm = 633.0;
  others[1].optics.centre_px = Vec2{10.0, 10.0};
  others[2].slm.geometry.width_px = 192;
  others[3].slm.geometry.pitch_um = 20.0;
  others[4].optics.focal_length_mm = 201.0;
  for (const Config& other : others) EXPECT_TRUE(found(other).empty());
  const auto daemon_with = [&](const HologramConfig& hologram, bool lut) {
    Config config = config_;
    if (lut) config.slm.lut = "lut.txt";
    return Started(config, folder_, hologram).references.load().size();
  };
  HologramConfig other = hologram_of(config_);
  other.lut[200] = 7;
  EXPECT_EQ(daemon_with(other, true), 0U) << "another LUT";
  EXPECT_EQ(daemon_with(other, false), 0U) << "the hologram is drawn otherwise";
  HologramConfig flat = hologram_of(config_);
  flat.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.0F);
  EXPECT_EQ(daemon_with(flat, false), 0U) << "another flatness";
  Config sensor = config_;
  sensor.sensor.charge = 2;
  EXPECT_EQ(found(sensor).size(), 1U) << "its key says of which sensor it is";
  EXPECT_EQ(found(config_).size(), 1U);
}

TEST_F(KeptReferencesTest, OneOfAnotherLutOrFlatnessIsFoundWhenTheyAreAsTheyWere) {
  Reference reference = taken(*started(config_), config_);
  started(config_)->references.keep(reference, {},
                                    [&](const std::string& sha256) { reference.sha256 = sha256; });
  ActiveSlm configured, other;
  configured.hologram = other.hologram = hologram_of(config_);
  configured.identity = slm_identity(configured.hologram, false);
  other.hologram.lut[200] = 7;
  other.identity = slm_identity(other.hologram, true);
  auto daemon = started(config_);
  daemon->bench.use_slm(other);
  EXPECT_TRUE(daemon->references.load().empty());
  EXPECT_TRUE(daemon->references.load_again().empty());
  daemon->bench.use_slm(configured);
  const auto again = daemon->references.load_again();
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0]->sha256, reference.sha256);
  EXPECT_TRUE(daemon->references.load_again().empty()) << "it is in use already";
  Config bench = config_;
  bench.optics.wavelength_nm = 633.0;
  daemon = started(bench);
  daemon->bench.use_slm(other);
  EXPECT_TRUE(daemon->references.load().empty());
  daemon->bench.use_slm(configured);
  EXPECT_TRUE(daemon->references.load_again().empty()) << "the optics are others, too";
}

TEST_F(KeptReferencesTest, GainExposureAndFormatOnlyMakeItStale) {
  auto daemon = started(config_);
  const Reference reference = taken(*daemon, config_);
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

TEST_F(KeptReferencesTest, ASettingThatTheFileLacksIsNotKnownAndNotStale) {
  auto daemon = started(config_);
  Reference reference = taken(*daemon, config_);
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

TEST_F(KeptReferencesTest, AnotherCameraIsReported) {
  auto daemon = started(config_);
  const Reference reference = taken(*daemon, config_);
  CameraInfo camera = kCamera;
  camera.address = "10.0.0.7";
  EXPECT_FALSE(of_other_camera(reference, camera));
  EXPECT_FALSE(of_other_camera(reference, std::nullopt));
  camera.model = "\xff";
  EXPECT_TRUE(of_other_camera(reference, camera));
  camera = kCamera;
  camera.serial = "TWIN0002";
  EXPECT_TRUE(of_other_camera(reference, camera));
}

TEST_F(KeptReferencesTest, TheMapThatItWasTakenUnderComesBack) {
  auto daemon = started(config_);
  Registration registration;
  registration.px_per_cycle = {0.0, 1900.0, -1900.0, 0.1};
  registration.base_px = {100.0, 200.0 / 3.0};
  registration.t_taken_ns = 7;
  Reference turned = taken(*daemon, config_, 8, registration);
  daemon->references.keep(turned);
  const auto all = found(config_);
  ASSERT_EQ(all.size(), 1U);
  ASSERT_TRUE(all[0]->registration);
  EXPECT_EQ(all[0]->registration->px_per_cycle, registration.px_per_cycle);
  EXPECT_EQ(all[0]->registration->base_px.y, registration.base_px.y);
  EXPECT_EQ(all[0]->registration->t_taken_ns, 7);
}

TEST_F(KeptReferencesTest, OnlySoManyAreKept) {
  auto daemon = started(config_);
  for (int n = 0; n < int(KeptReferences::kMax) + 3; ++n) {
    Config config = config_;
    config.camera.settings.roi.x = n;
    Reference reference = taken(*daemon, config, 100 + n);
    daemon->references.keep(reference);
  }
  const auto all = found(config_);
  ASSERT_EQ(all.size(), KeptReferences::kMax);
  EXPECT_EQ(all.front()->t_taken_ns, 103);
}

TEST_F(KeptReferencesTest, TheNewestIsKeptWhateverTheTimeOfDay) {
  auto daemon = started(config_);
  for (int n = 0; n <= int(KeptReferences::kMax); ++n) {
    Config config = config_;
    config.camera.settings.roi.x = n;
    const bool last = n == int(KeptReferences::kMax);
    daemon->references.keep(taken(*daemon, config, last ? 7 : 100 + n));
  }
  const auto all = found(config_);
  ASSERT_EQ(all.size(), KeptReferences::kMax);
  EXPECT_EQ(all[0]->t_taken_ns, 7);
  EXPECT_EQ(all[1]->t_taken_ns, 101);
}

TEST_F(KeptReferencesTest, ContentThatDoesNotFitTogetherIsRefused) {
  auto daemon = started(config_);
  const json right = reference_content(taken(*daemon, config_));
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

TEST_F(KeptReferencesTest, ADamagedFileIsReportedAndLeftAndACopyUnderAnotherNameIsNotUsed) {
  auto daemon = started(config_);
  Reference reference = taken(*daemon, config_);
  daemon->references.keep(reference);
  const fs::path file = fs::directory_iterator(folder_)->path();
  fs::copy(file, folder_ + "/reference.copy.json");
  EXPECT_EQ(found(config_).size(), 1U);
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_TRUE(found(config_).empty());
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(KeptReferencesTest, WithoutAFolderNothingIsKeptAndTheReasonIsSaid) {
  ::unsetenv("STATE_DIRECTORY");
  StreamQueue queue;
  Events events{queue};
  DaemonStore none({}, events);
  EXPECT_FALSE(none.report().directory);
  EXPECT_TRUE(none.report().reason);
  const auto put_in = [](DaemonStore& store) {
    bool kept = false;
    store.put("reference", "a", {}, DaemonStore::Older::stays,
              [&kept](const Result<std::string>& done) { kept = done.has_value(); });
    return kept;
  };
  EXPECT_FALSE(put_in(none));
  none.drop("reference", "a", [](const Result<void>& dropped) { EXPECT_TRUE(dropped); });
  none.load("reference", [](const StateItem&) { ADD_FAILURE(); });
  ::setenv("STATE_DIRECTORY", (folder_ + ":/elsewhere").c_str(), 1);
  DaemonStore some({}, events);
  ::unsetenv("STATE_DIRECTORY");
  EXPECT_EQ(some.report().directory, folder_);
  EXPECT_FALSE(some.report().reason);
  EXPECT_TRUE(put_in(some));
}

}  // namespace
}  // namespace ovws
