/// Rows of the camera contract: a replayed recording.
#include <filesystem>

#include "drivers/record/record_file.hpp"
#include "drivers/replay/replay_camera.hpp"
#include "tests/contract/camera/camera_contract.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws::testing {
namespace {

constexpr int kPictures = 64;
constexpr int kLeftOut = 20;  // frame missing in the recording, in the test of gaps only

int pixel_at(int x, int y) {
  return (x + 2 * y) & 0xFF;
}

/// Writes a recording. `skipped`: number of a missing frame; -1: none. `anew`: frame at which the
/// frame numbers restart at 1.
std::string make_recording(const std::string& name, int skipped, bool with_images = true,
                           int anew = kPictures) {
  const std::string path = own_folder(name) + ".h5";
  std::filesystem::remove(path);
  RecordingHeader header;
  header.vendor = "Vendor";
  header.model = "Model";
  header.serial = "S1";
  header.frame_rate_hz = 200.0;
  header.x = 16;
  header.y = 8;
  header.width = 192;
  header.height = 128;
  auto file = RecordFile::create(path, header);
  EXPECT_TRUE(file);
  std::vector<std::byte> pixels;
  for (int y = 0; y < header.height; ++y) {
    for (int x = 0; x < header.width; ++x) {
      pixels.push_back(std::byte(pixel_at(header.x + x, header.y + y)));
    }
  }
  for (int i = 0; i < kPictures; ++i) {
    if (i == skipped) continue;
    RecordedFrame frame;
    frame.frame_id = std::uint64_t(i < anew ? 100 + i : 1 + i - anew);
    frame.exposure_us = 2000.0;
    if (with_images) frame.picture = *(*file)->add_image(pixels, i % 2 == 0);
    (*file)->add_frame(frame, {}, {}, {});
  }
  EXPECT_TRUE((*file)->close({}));
  return path;
}

class ReplayBench final : public CameraBench {
 public:
  Result<std::unique_ptr<Camera>> open() override { return open_replay_camera(path_); }
  CameraSettings settings() const override {
    CameraSettings settings;
    settings.frame_rate_hz = 200.0;
    settings.roi = {16, 8, 192, 128};
    return settings;
  }
  std::optional<int> pixel(PixelFormat, int x, int y) const override { return pixel_at(x, y); }
  ~ReplayBench() override { std::filesystem::remove(path_); }

 private:
  const std::string path_ = make_recording("replay", -1);
};

INSTANTIATE_TEST_SUITE_P(Replay, CameraContract,
                         ::testing::Values(CameraRow{"Recording",
                                                     []() -> std::unique_ptr<CameraBench> {
                                                       return std::make_unique<ReplayBench>();
                                                     }}),
                         [](const auto& row) { return row.param.name; });

// Guarantees of this driver only.

/// Expects frame numbers from 100 on over three rounds; `skipped`: the frame missing in each, -1:
/// none.
void expect_rising_numbers(const std::string& path, int skipped) {
  auto camera = open_replay_camera(path);
  ASSERT_TRUE(camera) << camera.error().reason;
  CameraSettings settings = ReplayBench().settings();
  settings.frame_rate_hz = 10'000.0;
  ASSERT_TRUE((*camera)->apply(settings));
  ASSERT_TRUE((*camera)->start());
  for (int k = 0; k < 3 * kPictures; ++k) {
    if (k % kPictures == skipped) continue;
    GrabbedFrame frame;
    while ((*camera)->grab(frame, kPatience) != GrabStatus::frame) {
    }
    ASSERT_EQ(frame.frame_id, std::uint64_t(100 + k));
    (*camera)->release(frame.slot);
  }
  std::filesystem::remove(path);
}

TEST(ReplayCamera, AFrameThatTheRecordingLacksIsAGapAndTheNumbersGoOnOverTheEnd) {
  const std::string path = make_recording("gap", kLeftOut);
  expect_rising_numbers(path, kLeftOut);
}

TEST(ReplayCamera, NumbersGoOnWhereTheCameraOfThenBeganAnew) {
  constexpr int kAnew = 40;
  const std::string path = make_recording("anew", -1, true, kAnew);
  expect_rising_numbers(path, -1);
}

TEST(ReplayCamera, AFasterPaceCountsAtOnce) {
  ReplayBench bench;
  auto camera = bench.open();
  ASSERT_TRUE(camera);
  CameraSettings settings = bench.settings();
  settings.frame_rate_hz = 0.01;
  ASSERT_TRUE((*camera)->apply(settings));
  ASSERT_TRUE((*camera)->start());
  GrabbedFrame frame;
  ASSERT_EQ((*camera)->grab(frame, kPatience), GrabStatus::frame);
  (*camera)->release(frame.slot);
  ASSERT_EQ((*camera)->grab(frame, std::chrono::milliseconds(10)), GrabStatus::timeout);
  settings.frame_rate_hz = 100.0;
  ASSERT_TRUE((*camera)->apply(settings));
  ASSERT_EQ((*camera)->grab(frame, kPatience), GrabStatus::frame);
}

TEST(ReplayCamera, OtherRegionsAndFormatsAreRefused) {
  ReplayBench bench;
  auto camera = bench.open();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench.settings();
  wanted.roi.width = 128;
  EXPECT_EQ((*camera)->apply(wanted).error().field, "camera.roi");
  wanted = bench.settings();
  wanted.pixel_format = PixelFormat::mono12;
  EXPECT_EQ((*camera)->apply(wanted).error().field, "camera.pixel_format");
  wanted = bench.settings();
  wanted.gain_db = 5.0;
  EXPECT_EQ((*camera)->apply(wanted)->gain_db, 0.0);
}

TEST(ReplayCamera, AFileThatCannotBePlayedIsRefusedWithItsPath) {
  const std::string path = make_recording("bare", -1, false);
  for (const std::string& file : {path, std::string("/nowhere.h5"), std::string("/dev/null")}) {
    auto camera = open_replay_camera(file);
    ASSERT_FALSE(camera);
    EXPECT_EQ(camera.error().field, "camera.id");
    EXPECT_NE(camera.error().reason.find(file), std::string::npos) << camera.error().reason;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace ovws::testing
