/// Rows of the camera contract: the Aravis driver against a GigE Vision camera in another process.
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "drivers/aravis/aravis_camera.hpp"
#include "tests/contract/camera/camera_contract.hpp"
#include "tests/contract/camera/fake_camera.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws::testing {
namespace {

/// A GenICam description and its mapping of settings to registers.
struct Description {
  const char* xml;        ///< file; "-": Aravis's built-in description
  double gain_per_count;  ///< of register 0x110
  bool gain_is_raw = false;
};

class AravisBench final : public CameraBench {
 public:
  explicit AravisBench(const Description& description) : description_(description) { plug_in(); }

  Result<std::unique_ptr<Camera>> open() override { return open_by(kFakeCameraAddress); }
  static Result<std::unique_ptr<Camera>> open_by(const std::string& id) {
    AravisConfig config;
    config.id = id;
    return open_aravis_camera(config);
  }
  CameraSettings settings() const override {
    CameraSettings settings;
    if (description_.gain_is_raw) settings.gain_db = kUnknownGain;
    settings.*gain() = 0.0;
    settings.exposure_us = 2000.0;
    settings.frame_rate_hz = 200.0;
    settings.roi = {16, 8, 192, 128};
    return settings;
  }
  double CameraSettings::*gain() const override {
    return description_.gain_is_raw ? &CameraSettings::gain_raw : &CameraSettings::gain_db;
  }
  std::optional<CameraSettings> truth() override {
    CameraSettings truth;
    if (description_.gain_is_raw) truth.gain_db = kUnknownGain;
    truth.*gain() = read(0x110) * description_.gain_per_count;
    truth.exposure_us = read(0x120);
    truth.frame_rate_hz = 1e6 / read(0x138);
    truth.roi = {int(read(0x130)), int(read(0x134)), int(read(0x100)), int(read(0x104))};
    truth.pixel_format =
        pixel_format_from_code(std::uint32_t(read(0x128))).value_or(PixelFormat::mono8);
    return truth;
  }
  std::optional<int> pixel(PixelFormat format, int x, int y) const override {
    return (x + 2 * y) & ((1 << significant_bits(format)) - 1);
  }

  void unplug() override { device_.reset(); }
  void plug_in() override { plug_in("0"); }
  void freeze() override { device_->send_signal(SIGSTOP); }
  void thaw() override { device_->send_signal(SIGCONT); }
  void crash_a_client() override {
    ChildProcess client({OVWS_ARAVIS_CLIENT, kFakeCameraAddress});
    if (client.read_line() != "streaming") throw std::runtime_error("the client does not stream");
  }
  bool lose_packets() override {
    unplug();
    plug_in("0.1");
    return true;
  }

  /// Writes text into registers, four bytes at a time, padded with 0.
  void write_text(unsigned address, std::string text) {
    text.resize((text.size() + 3) / 4 * 4);
    for (std::size_t k = 0; k < text.size(); k += 4) {
      std::uint32_t word = 0;
      for (std::size_t b = 0; b < 4; ++b) word = word << 8 | std::uint8_t(text[k + b]);
      device_->write_line("write " + std::to_string(address + k) + " " + std::to_string(word));
      (void)device_->read_line();
    }
  }

 private:
  void plug_in(const char* lost_packet_ratio) {
    device_ = start_fake_camera(description_.xml, lost_packet_ratio);
  }
  double read(unsigned address) {
    device_->write_line("read " + std::to_string(address));
    return std::stod(device_->read_line());
  }

  Description description_;
  std::unique_ptr<ChildProcess> device_;
};

std::unique_ptr<CameraBench> old_names() {
  return std::make_unique<AravisBench>(Description{"-", 1.0, true});
}
std::unique_ptr<CameraBench> todays_names() {
  return std::make_unique<AravisBench>(Description{OVWS_SFNC_CAMERA_XML, 0.1});
}

const CameraRow kOldNames{"OldNames", old_names};
const CameraRow kTodaysNames{"TodaysNames", todays_names};

std::string name_of(const ::testing::TestParamInfo<CameraRow>& row) {
  return row.param.name;
}

INSTANTIATE_TEST_SUITE_P(Aravis, CameraContract, ::testing::Values(kOldNames, kTodaysNames),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Aravis, CameraLossContract, ::testing::Values(kTodaysNames), name_of);

// Guarantees of this driver only.

TEST(AravisCamera, OpensByAddressByIdAndBySerialNumber) {
  const auto bench = todays_names();
  for (const char* id : {kFakeCameraAddress, "Aravis-Fake-OVWS7", "OVWS7"}) {
    auto camera = AravisBench::open_by(id);
    ASSERT_TRUE(camera) << id << ": " << camera.error().reason;
    EXPECT_EQ((*camera)->info().address, kFakeCameraAddress);
    EXPECT_EQ((*camera)->info().serial, "OVWS7");
  }
}

/// A description with which the camera reports an invalid pixel format at a gain of 7 dB.
std::string unreadable_at_7_db() {
  std::ifstream in(OVWS_SFNC_CAMERA_XML);
  std::string xml((std::istreambuf_iterator<char>(in)), {});
  const std::string plain = "<pValue>PixelFormatReg</pValue>";
  xml.replace(xml.find(plain), plain.size(), "<pValue>FormatConverter</pValue>");
  const std::string end = "<Port Name=";
  xml.insert(xml.find(end),
             "<IntConverter Name=\"FormatConverter\"><pVariable Name=\"GAIN\">GainReg</pVariable>"
             "<FormulaTo>FROM</FormulaTo><FormulaFrom>GAIN = 70 ? 0 : TO</FormulaFrom>"
             "<pValue>PixelFormatReg</pValue></IntConverter>\n");
  std::string path = own_folder("unreadable") + ".xml";
  std::ofstream(path) << xml;
  return path;
}

TEST(AravisCamera, GainThatIsInNoUnitIsNotGivenOutAsDb) {
  const auto bench = old_names();
  auto camera = bench->open();
  ASSERT_TRUE(camera) << camera.error().reason;
  const auto limits = (*camera)->limits();
  ASSERT_TRUE(limits && limits->gain_raw);
  EXPECT_EQ(limits->gain_raw->min, 0.0);
  EXPECT_EQ(limits->gain_raw->max, 10.0);
  CameraSettings wanted;  // the configuration's defaults
  auto applied = (*camera)->apply(wanted);
  ASSERT_TRUE(applied) << applied.error().reason;
  EXPECT_TRUE(std::isnan(applied->gain_db));
  wanted.gain_raw = 7.0;
  applied = (*camera)->apply(wanted);
  ASSERT_TRUE(applied) << applied.error().reason;
  EXPECT_TRUE(std::isnan(applied->gain_db));
  EXPECT_EQ(applied->gain_raw, 7.0);
  EXPECT_EQ(bench->truth(), *applied);
  wanted.gain_raw = kUnknownGain;  // leaves the gain unchanged
  EXPECT_EQ((*camera)->apply(wanted), *applied);
  wanted.gain_db = 6.0;
  const auto refused = (*camera)->apply(wanted);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera.gain_db");
  EXPECT_NE(refused.error().reason.find("gain_raw"), std::string::npos);
}

TEST(AravisCamera, SettingsThatCannotBeReadBackAreTakenBack) {
  const std::string xml = unreadable_at_7_db();
  AravisBench bench(Description{xml.c_str(), 0.1});
  auto camera = bench.open();
  ASSERT_TRUE(camera) << camera.error().reason;
  CameraSettings wanted = bench.settings();
  ASSERT_TRUE((*camera)->apply(wanted));
  ASSERT_TRUE((*camera)->start());
  const auto before = bench.truth();
  wanted.gain_db = 7.0;
  wanted.exposure_us = 1500.0;
  const auto refused = (*camera)->apply(wanted);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera.pixel_format");
  EXPECT_EQ(bench.truth(), before);
  EXPECT_TRUE((*camera)->alive());
  wanted.gain_db = 6.0;
  const auto taken = (*camera)->apply(wanted);
  ASSERT_TRUE(taken) << taken.error().reason;
  EXPECT_EQ(bench.truth(), *taken);
  std::filesystem::remove(xml);
}

TEST(AravisCamera, NamesHaveNoPowerOverATerminalOrAJournal) {
  AravisBench bench(Description{OVWS_SFNC_CAMERA_XML, 0.1});
  constexpr unsigned kVendor = 0x48;
  bench.write_text(kVendor, std::string("Bad\x1b[2J\n<0>name", 15) + '\0');
  auto camera = bench.open();
  ASSERT_TRUE(camera) << camera.error().reason;
  EXPECT_EQ((*camera)->info().vendor, "Bad?[2J?<0>name");
}

TEST(AravisCamera, AnUnknownIdIsUnavailableAndTheErrorListsWhatIsThere) {
  const auto bench = todays_names();
  auto camera = AravisBench::open_by("OVWS8");
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().code, Errc::unavailable);
  EXPECT_EQ(camera.error().field, "camera.id");
  EXPECT_NE(camera.error().reason.find("Aravis-Fake-OVWS7 at 127.0.0.1"), std::string::npos)
      << camera.error().reason;
}

TEST(AravisCamera, AWrongConfigurationIsInvalid) {
  const auto bench = todays_names();
  const auto refused = [](AravisConfig config, const char* field) {
    auto camera = open_aravis_camera(config);
    ASSERT_FALSE(camera) << field;
    EXPECT_EQ(camera.error().code, Errc::invalid) << camera.error().reason;
    EXPECT_EQ(camera.error().field, field) << camera.error().reason;
  };
  refused({.id = ""}, "camera.id");
  refused({.id = kFakeCameraAddress, .buffers = 1}, "camera.buffers");
  refused({.id = kFakeCameraAddress, .packet_size_bytes = 100}, "camera.packet_size_bytes");
}

}  // namespace
}  // namespace ovws::testing
