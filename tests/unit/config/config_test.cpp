#include "config/config.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "proto/limits.hpp"
#include "proto/tables/sensor.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

Error error_of(const std::string& text) {
  const auto config = parse_config(text);
  EXPECT_FALSE(config) << text;
  return config ? Error{} : config.error();
}

std::string shipped_file() {
  std::ifstream file(OVWS_SOURCE_DIR "/config/ovwsd.json");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Values all over their ranges.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double number(limits::Numbers r) {
    return std::uniform_real_distribution<double>(r.min, r.max)(random_);
  }
  int integer(limits::Integers r) {
    return std::uniform_int_distribution<int>(r.min, r.max)(random_);
  }
  bool coin() { return integer({0, 1}) == 1; }
  std::string text() {
    std::string out = "ä\"\\/\n";
    for (int k = integer({1, 9}); k > 0; --k) out += char(integer({32, 126}));
    return out;
  }

 private:
  std::mt19937 random_;
};

Config random_config(unsigned seed) {
  Dice dice(seed);
  Config c;
  c.camera.driver = dice.text();
  c.camera.id = dice.text();
  c.camera.settings = {dice.number(limits::kGainDb),
                       dice.number(limits::kExposureUs),
                       dice.number(limits::kFrameRateHz),
                       PixelFormat(dice.integer({0, 4})),
                       {dice.integer(limits::kRoiOffset), dice.integer(limits::kRoiOffset),
                        dice.integer(limits::kRoiSize), dice.integer(limits::kRoiSize)}};
  c.camera.packet_size_bytes = dice.integer(limits::kPacketSizeBytes);
  c.camera.transfer_ms = dice.number(limits::kTransferMs);
  c.slm.driver = dice.text();
  c.slm.display = dice.text();
  c.slm.geometry = {dice.integer(limits::kSlmSizePx), dice.integer(limits::kSlmSizePx),
                    dice.number(limits::kSlmPitchUm)};
  if (dice.coin()) c.slm.lut = dice.text();
  if (dice.coin()) c.slm.flatness = dice.text();
  c.slm.settle_ms = dice.number(limits::kSettleMs);
  c.slm.allow_primary = dice.coin();
  c.optics.wavelength_nm = dice.number(limits::kWavelengthNm);
  c.optics.focal_length_mm = dice.number(limits::kFocalLengthMm);
  c.optics.magnification = dice.number(limits::kMagnification);
  c.optics.camera_pitch_um = dice.number(limits::kCameraPitchUm);
  if (dice.coin()) {
    c.optics.centre_px = Vec2{dice.number(limits::kCentrePx), dice.number(limits::kCentrePx)};
    c.optics.registered = PxPerCycle{dice.number({1.0, 1e7}), dice.number({-1e7, 0.0}),
                                     dice.number({1.0, 1e7}), dice.number({1.0, 1e7})};
  }
  c.sensor = {dice.integer(limits::kCharge),
              Grid(dice.integer({0, 1})),
              dice.integer(limits::kSubaperturesAcross),
              dice.number(limits::kPupilDiameterPx),
              {dice.number(limits::kGrooves), dice.number(limits::kGrooves)},
              dice.number(limits::kSpacing)};
  c.tracking =
      TrackingSettings{{TrackerKind(dice.integer({0, 5})), dice.number(limits::kKernelRadius)},
                       OperatorKind(dice.integer({0, 1}))};
  c.refine.format = c.camera.settings.pixel_format;
  c.refine.rate_hz = dice.number(limits::kRefineRateHz);
  if (dice.coin()) c.refine.electrons_per_dn = dice.number(limits::kElectronsPerDn);
  c.refine.enabled = c.refine.electrons_per_dn && dice.coin();
  c.refine.read_noise_e = dice.number(limits::kReadNoiseE);
  c.refine.black_level_dn = dice.number({0.0, 100.0});
  if (dice.coin()) c.refine.saturation_dn = dice.number({101.0, 255.0});
  if (dice.coin()) c.security = {dice.text(), dice.text()};
  c.stream = {"tcp://*:1", "ipc:///tmp/" + std::to_string(seed), dice.number(limits::kImageRateHz)};
  c.control.endpoint = "tcp://[::1]:2";
  if (dice.coin()) c.state.directory = dice.text();
  if (dice.coin()) c.record.directory = dice.text();
  c.record.buffer_mib = dice.integer(limits::kRecordBufferMib);
  c.realtime = dice.coin() ? RealtimePolicy::enforce : RealtimePolicy::ignore;
  c.pipeline = {{dice.integer(limits::kWorkers), 1 << dice.integer({3, 12})}, {}};
  if (dice.coin()) c.pipeline.cpus = {3, dice.integer({4, limits::kCpu.max})};
  c.log.level = dice.coin() ? LogLevel::debug : LogLevel::error;
  return c;
}

void expect_same(const Config& a, const Config& b) {
  EXPECT_EQ(a.state.directory, b.state.directory);
  EXPECT_EQ(a.record.directory, b.record.directory);
  EXPECT_EQ(a.record.buffer_mib, b.record.buffer_mib);
  EXPECT_EQ(a.camera.driver, b.camera.driver);
  EXPECT_EQ(a.camera.id, b.camera.id);
  EXPECT_EQ(a.camera.settings, b.camera.settings);
  EXPECT_EQ(a.camera.packet_size_bytes, b.camera.packet_size_bytes);
  EXPECT_EQ(a.camera.transfer_ms, b.camera.transfer_ms);
  EXPECT_EQ(a.slm.driver, b.slm.driver);
  EXPECT_EQ(a.slm.display, b.slm.display);
  EXPECT_EQ(a.slm.geometry.width_px, b.slm.geometry.width_px);
  EXPECT_EQ(a.slm.geometry.height_px, b.slm.geometry.height_px);
  EXPECT_EQ(a.slm.geometry.pitch_um, b.slm.geometry.pitch_um);
  EXPECT_EQ(a.slm.lut, b.slm.lut);
  EXPECT_EQ(a.slm.flatness, b.slm.flatness);
  EXPECT_EQ(a.slm.settle_ms, b.slm.settle_ms);
  EXPECT_EQ(a.slm.allow_primary, b.slm.allow_primary);
  EXPECT_EQ(a.optics.wavelength_nm, b.optics.wavelength_nm);
  EXPECT_EQ(a.optics.focal_length_mm, b.optics.focal_length_mm);
  EXPECT_EQ(a.optics.magnification, b.optics.magnification);
  EXPECT_EQ(a.optics.camera_pitch_um, b.optics.camera_pitch_um);
  EXPECT_EQ(a.optics.centre_px, b.optics.centre_px);
  EXPECT_EQ(a.optics.registered, b.optics.registered);
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.tracking, b.tracking);
  EXPECT_EQ(a.refine, b.refine);
  EXPECT_EQ(a.stream.endpoint, b.stream.endpoint);
  EXPECT_EQ(a.stream.image_endpoint, b.stream.image_endpoint);
  EXPECT_EQ(a.stream.image_rate_hz, b.stream.image_rate_hz);
  EXPECT_EQ(a.control.endpoint, b.control.endpoint);
  EXPECT_EQ(a.security.secret_key, b.security.secret_key);
  EXPECT_EQ(a.security.clients, b.security.clients);
  EXPECT_EQ(a.realtime, b.realtime);
  EXPECT_EQ(a.pipeline.workers, b.pipeline.workers);
  EXPECT_EQ(a.pipeline.records, b.pipeline.records);
  EXPECT_EQ(a.pipeline.cpus, b.pipeline.cpus);
  EXPECT_EQ(a.log.level, b.log.level);
}

TEST(ParseConfig, AnEmptyObjectIsTheDefault) {
  const auto config = parse_config("{}");
  ASSERT_TRUE(config);
  expect_same(*config, Config{});
}

TEST(ParseConfig, TheShippedFileIsTheDefaultAndHoldsEveryKey) {
  const auto config = parse_config(shipped_file());
  ASSERT_TRUE(config) << config.error().field << ": " << config.error().reason;
  expect_same(*config, Config{});
  std::string squeezed;
  for (const char c : shipped_file()) squeezed += c == ' ' ? "" : std::string(1, c);
  std::istringstream dumped(dump_config(Config{}));
  for (std::string line; std::getline(dumped, line);) {
    const auto begin = line.find('"');
    const auto end = line.find("\":");
    if (end == std::string::npos) continue;
    EXPECT_NE(squeezed.find(line.substr(begin, end + 2 - begin)), std::string::npos) << line;
  }
}

TEST(ParseConfig, ReadsTheKeysThatTheWireDocumentPromises) {
  const auto config = parse_config(R"({
  "camera":  { "driver": "aravis", "id": "127.0.0.1", "pixel_format": "Mono8", "exposure_us": 2000, "gain_db": 0.0,
               "frame_rate_hz": 100.0, "roi": { "x": 0, "y": 0, "width": 512, "height": 512 } },
  "slm":     { "driver": "sdl", "display": "DUMMY1", "width": 1280, "height": 768, "pitch_um": 19.0,
               "lut": null, "flatness": null, "settle_ms": 20 },
  "optics":  { "wavelength_nm": 632.0, "focal_length_mm": 200.0, "magnification": 1.0, "camera_pitch_um": 3.45, "centre_px": null },
  "sensor":  { "charge": 1, "grid": "hexagonal", "subapertures_across": 5, "pupil_diameter_px": 768,
               "grooves": [200, 20], "spacing": 0.25 },
  "tracking": { "tracker": "lg", "kernel_radius": 0.4 },
  "stream":  { "endpoint": "tcp://127.0.0.1:7701", "image_endpoint": "tcp://127.0.0.1:7703", "image_rate_hz": 10 },
  "control": { "endpoint": "tcp://127.0.0.1:7702" } })");
  ASSERT_TRUE(config) << config.error().field << ": " << config.error().reason;
  Config written;
  written.tracking.tracker = TrackerKind::lg;
  written.tracking.kernel_radius = 0.4;
  expect_same(*config, written);
}

TEST(ParseConfig, GivesBackWhatWasDumped) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Config config = random_config(seed);
    const auto again = parse_config(dump_config(config));
    ASSERT_TRUE(again) << again.error().field << ": " << again.error().reason;
    expect_same(*again, config);
    EXPECT_EQ(dump_config(*again), dump_config(config));
  }
}

TEST(ParseConfig, NamesTheKeyThatWasMeant) {
  const Error error = error_of(R"({"camera": {"exposure_su": 100}})");
  EXPECT_EQ(error.field, "camera.exposure_su");
  EXPECT_EQ(error.reason, "unknown key; did you mean \"exposure_us\"?");
  EXPECT_EQ(error_of(R"({"camra": {}})").nearest, "camera");
  EXPECT_EQ(error_of(R"({"slm": {"flat": "x"}})").nearest, "flatness");
  EXPECT_EQ(error_of(R"({"camera": {"roi": {"widht": 5}}})").field, "camera.roi.widht");
}

TEST(ParseConfig, RefusesWrongTypesAndRanges) {
  EXPECT_EQ(error_of(R"({"camera": {"gain_db": "0"}})").field, "camera.gain_db");
  EXPECT_EQ(error_of(R"({"camera": {"roi": {"width": 0}}})").field, "camera.roi.width");
  EXPECT_EQ(error_of(R"({"camera": {"pixel_format": "RGB8"}})").field, "camera.pixel_format");
  EXPECT_EQ(error_of(R"({"camera": {"driver": ""}})").field, "camera.driver");
  EXPECT_EQ(error_of(R"({"slm": {"lut": 5}})").field, "slm.lut");
  EXPECT_EQ(error_of(R"({"optics": {"centre_px": [1]}})").field, "optics.centre_px");
  EXPECT_EQ(error_of(R"({"optics": {"px_per_cycle": [1, 2, 3]}})").field, "optics.px_per_cycle");
  EXPECT_EQ(error_of(R"({"optics": {"px_per_cycle": [9, 6, 6, 4]}})").field, "optics.px_per_cycle");
  EXPECT_EQ(error_of(R"({"optics": {"wavelength_nm": 0.632}})").field, "optics.wavelength_nm");
  EXPECT_EQ(error_of(R"({"sensor": {"charge": 1.5}})").field, "sensor.charge");
  EXPECT_EQ(error_of(R"({"tracking": {"tracker": "lgs"}})").nearest, "lg");
  EXPECT_EQ(error_of(R"({"tracking": {"operator": "measure"}})").nearest, "measured");
  EXPECT_EQ(error_of(R"({"realtime": "maybe"})").field, "realtime");
  EXPECT_EQ(error_of(R"({"pipeline": {"records": 65}})").field, "pipeline.records");
  EXPECT_EQ(error_of(R"({"pipeline": {"cpus": 2}})").field, "pipeline.cpus");
  EXPECT_EQ(error_of(R"({"pipeline": {"cpus": [2, 1024]}})").field, "pipeline.cpus[1]");
  EXPECT_EQ(error_of(R"({"pipeline": {"cpus": [0.5]}})").field, "pipeline.cpus");
  EXPECT_EQ(error_of(R"({"pipeline": {"cpus": [2, 2]}})").field, "pipeline.cpus");
  EXPECT_EQ(error_of(R"({"stream": {"endpoint": "7701"}})").field, "stream.endpoint");
  EXPECT_EQ(error_of(R"({"stream": {"endpoint": "tcp://127.0.0.1:99999"}})").field,
            "stream.endpoint");
  EXPECT_NE(error_of(R"({"control": {"endpoint": "tcp://localhost:7702"}})")
                .reason.find("give the address, tcp://127.0.0.1:7702"),
            std::string::npos);
  EXPECT_EQ(error_of(R"({"control": {"endpoint": "tcp://127.0.0.1:7701"}})").field,
            "control.endpoint");
  EXPECT_EQ(error_of(R"({"log": {"level": "loud"}})").field, "log.level");
  EXPECT_EQ(error_of("[]").code, Errc::invalid);
}

TEST(ParseConfig, RefusesInvalidSettingsOfTheRefinement) {
  EXPECT_EQ(error_of(R"({"refine": {"enabled": true}})").field, "refine.electrons_per_dn");
  EXPECT_EQ(error_of(R"({"refine": {"rate_hz": 0}})").field, "refine.rate_hz");
  EXPECT_EQ(error_of(R"({"refine": {"electrons_per_dn": "39"}})").field, "refine.electrons_per_dn");
  EXPECT_EQ(error_of(R"({"refine": {"electron_per_dn": 39}})").nearest, "electrons_per_dn");
  EXPECT_EQ(error_of(R"({"refine": {"saturation_dn": 256}})").field, "refine.saturation_dn");
  const auto deep =
      parse_config(R"({"refine": {"saturation_dn": 4000}, "camera": {"pixel_format": "Mono12"}})");
  ASSERT_TRUE(deep) << deep.error().reason;
  EXPECT_EQ(deep->refine.format, PixelFormat::mono12);
}

TEST(ParseConfig, LensletsFillTheirGrid) {
  const auto shape = [](const std::string& grid, const std::string& array = "{}") {
    const auto config = parse_config(R"({"modulator": "fixed", "sensor": {"grid": ")" + grid +
                                     R"("}, "array": )" + array + "}");
    return config ? std::string(kNames<LensletShape>()[std::size_t(config->sensor.lenslets.shape)])
                  : config.error().field;
  };
  EXPECT_EQ(shape("hexagonal"), "hexagon");
  EXPECT_EQ(shape("square"), "square");
  for (const std::string grid : {"hexagonal", "square"}) {
    EXPECT_EQ(shape(grid, R"({"shape": "circle"})"), "circle");
    EXPECT_EQ(shape(grid, R"({"shape": null})"), shape(grid));
  }
  EXPECT_EQ(shape("hexagonal", R"({"shape": "square"})"), "array.shape");
  EXPECT_EQ(shape("square", R"({"shape": "hexagon"})"), "array.shape");
  EXPECT_TRUE(parse_config(R"({"array": {"shape": "square"}})"));  // of an SLM it has no effect
}

TEST(ParseConfig, AnArrayIsSeenMirroredAndTurnedByQuartersOnly) {
  const auto refusal = [](const std::string& matrix, const std::string& modulator = "fixed") {
    const auto config = parse_config(R"({"modulator": ")" + modulator +
                                     R"(", "optics": {"px_per_cycle": )" + matrix + "}}");
    return config ? std::string() : config.error().field;
  };
  for (const char* const allowed :
       {"[9, 0, 0, 9]", "[-9, 0, 0, 9]", "[9, 0, 0, -9]", "[0, 9, 9, 0]", "[0, -9, 9, 0]",
        "[0, -9, -9, 0]", "[9, 0.01, -0.01, 9]"}) {
    EXPECT_EQ(refusal(allowed), "") << allowed;
  }
  for (const char* const other :
       {"[996, -87, 87, 996]", "[7, 7, -7, 7]", "[9, 0, 0, 8]", "[9, 1, 0, 9]"}) {
    EXPECT_EQ(refusal(other), "optics.px_per_cycle") << other;
    EXPECT_EQ(refusal(other, "slm"), "") << other;
  }
}

TEST(ParseConfig, OfTheMatrixOfAnArrayOnlyTheDirectionCounts) {
  const auto array = parse_config(R"({"modulator": "fixed"})");
  const auto mirrored =
      parse_config(R"({"modulator": "fixed", "optics": {"px_per_cycle": [-9, 0, 0, 9]}})");
  ASSERT_TRUE(array && mirrored);
  const double scale = px_per_cycle(array->optics, array->slm.geometry).scale();
  const PxPerCycle seen = px_per_cycle(mirrored->optics, mirrored->slm.geometry);
  EXPECT_NEAR(seen.xx, -scale, 1e-9 * scale);
  EXPECT_NEAR(seen.yy, scale, 1e-9 * scale);
}

TEST(ParseConfig, ReadsAPairAsXThenY) {
  const auto config = parse_config(
      R"({"optics": {"centre_px": [10, 20.5]}, "sensor": {"grooves": [100, 30]},
          "camera": {"roi": {"x": 3, "y": 4}}})");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->optics.centre_px, (Vec2{10, 20.5}));
  EXPECT_EQ(config->sensor.grooves, (std::array<double, 2>{100, 30}));
  EXPECT_EQ(config->camera.settings.roi, (Roi{3, 4, 512, 512}));
}

TEST(ParseConfig, AllowsCommentsAndSaysWhereTheTextIsWrong) {
  EXPECT_TRUE(parse_config("/* all */ { // none\n }"));
  EXPECT_NE(error_of("{\"camera\": }").reason.find("line 1, column 12"), std::string::npos);
  EXPECT_FALSE(parse_config(""));
  EXPECT_FALSE(parse_config("{\"log\": {}, \"log\": {}}"));
  EXPECT_FALSE(parse_config(std::string(100000, '[')));
  EXPECT_FALSE(parse_config("{\"camera\": {\"id\": \"\xff\"}}"));
}

TEST(LoadConfig, NamesTheFile) {
  const auto absent = load_config("/nonexistent/ovwsd.json");
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, Errc::unavailable);
  EXPECT_NE(absent.error().reason.find("/nonexistent/ovwsd.json"), std::string::npos);
  EXPECT_FALSE(load_config("/"));
  EXPECT_FALSE(load_config("/dev/zero"));
  EXPECT_TRUE(load_config(OVWS_SOURCE_DIR "/config/ovwsd.json"));
}

class LoadPaths : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directory(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<Config> loaded(const std::string& text) {
    std::ofstream(folder_ + "/ovwsd.json") << text;
    return load_config(folder_ + "/ovwsd.json");
  }
  const std::string folder_ = own_folder("load_paths");
};

/// config/README.md lists the others; see ConfigReadme.
TEST_F(LoadPaths, StartFromTheFolderOfTheFile) {
  const auto config = loaded(R"({"sensor": {"mask": [{"file": "a.csv"}, {"file": "/b.csv"}]},
    "camera": {"driver": "replay", "id": "../run.h5"}, "slm": {"lut": ""},
    "stream": {"endpoint": "ipc://numbers", "image_endpoint": "ipc:///run/images"},
    "control": {"endpoint": "ipc://@name"}})");
  ASSERT_TRUE(config) << config.error().reason;
  EXPECT_EQ(config->sensor.masks[0].file, folder_ + "/a.csv");
  EXPECT_EQ(config->sensor.masks[1].file, "/b.csv");
  EXPECT_EQ(config->camera.id, folder_ + "/../run.h5");
  EXPECT_EQ(config->slm.lut, "");
  EXPECT_EQ(config->stream.endpoint, "ipc://" + folder_ + "/numbers");
  EXPECT_EQ(config->stream.image_endpoint, "ipc:///run/images");
  EXPECT_EQ(config->control.endpoint, "ipc://@name");
  EXPECT_EQ(loaded(R"({"camera": {"id": "a/b"}})")->camera.id, "a/b") << "of a GenICam camera";
}

TEST_F(LoadPaths, StartFromTheFolderOfAFileThatIsNamedWithoutOne) {
  ASSERT_TRUE(loaded(R"({"state": {"directory": "state"}})"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
  const auto config = load_config("ovwsd.json");
  std::filesystem::current_path(before);
  ASSERT_TRUE(config) << config.error().reason;
  EXPECT_EQ(config->state.directory, folder_ + "/state");
}

TEST_F(LoadPaths, OfSocketsAreRefusedIfTheyAreTooLong) {
  const auto refused =
      loaded(R"({"control": {"endpoint": "ipc://)" + std::string(100, 'a') + "\"}}");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "control.endpoint");
}

}  // namespace
}  // namespace ovws
