/// Recordings on a disk whose writes fail.
#include "drivers/record/record_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "daemon/ovwsd/record/frame_store.hpp"
#include "drivers/replay/recording_reader.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

constexpr int kSide = 64;

RecordingHeader small_header() {
  RecordingHeader header;
  header.width = header.height = kSide;
  return header;
}

Result<void> add_one(RecordFile& file, int number) {
  const std::vector<std::byte> pixels(kSide * kSide, std::byte(number));
  RecordedFrame frame;
  frame.frame_id = std::uint64_t(number);
  const auto picture = file.add_image(pixels, false);
  if (!picture) return fail(picture.error());
  frame.picture = *picture;
  file.add_frame(frame, std::vector<RecordedSpot>(7), std::vector<float>(5),
                 std::vector<float>(5, 0.25F));
  return file.flush({});
}

/// Checks that all flushed frames can be read, with all their parts.
void expect_readable(const std::string& path, int flushed) {
  auto reader = RecordingReader::open(path);
  ASSERT_TRUE(reader) << reader.error().reason;
  EXPECT_GE((*reader)->frames().size(), std::size_t(flushed));
  EXPECT_LE((*reader)->frames().size(), std::size_t(flushed) + 1);
  std::vector<std::byte> pixels((*reader)->image_bytes());
  for (int i = 0; i < flushed; ++i) {
    const RecordedFrame& frame = (*reader)->frames()[std::size_t(i)];
    EXPECT_EQ(frame.frame_id, std::uint64_t(i + 1));
    EXPECT_TRUE((*reader)->spots(frame));
    EXPECT_TRUE((*reader)->coefficients(frame));
    EXPECT_EQ((*reader)->sigma_waves(frame).value(), std::vector<float>(5, 0.25F));
    ASSERT_TRUE((*reader)->picture(frame, pixels));
    EXPECT_EQ(pixels[0], std::byte(i + 1));
  }
}

/// File size limits at which different writes fail, bytes.
class RecordFileLimit : public ::testing::TestWithParam<int> {};

std::size_t open_descriptors() {
  using Folder = std::filesystem::directory_iterator;
  return std::size_t(std::distance(Folder("/proc/self/fd"), Folder()));
}

TEST_P(RecordFileLimit, AfterAWriteThatFailedNothingIsAddedAndAllBeforeCanBeRead) {
  const std::string path = own_folder("record_file") + std::to_string(GetParam()) + ".h5";
  std::filesystem::remove(path);
  int flushed = 0;
  const std::size_t descriptors = open_descriptors();
  {
    auto file = RecordFile::create(path, small_header());
    ASSERT_TRUE(file) << file.error().reason;
    const test::FileLimit limit((*file)->bytes() + rlim_t(GetParam()));
    while (flushed < 100 && add_one(**file, flushed + 1)) ++flushed;
    ASSERT_LT(flushed, 100);
    EXPECT_FALSE((*file)->add_document("plan", std::string(64, 'a'), "{}"));
    const auto picture = (*file)->add_image(std::vector<std::byte>(kSide * kSide), true);
    ASSERT_FALSE(picture);
    EXPECT_EQ(picture.error().code, Errc::unavailable);
    EXPECT_EQ(picture.error().field, "path");
    EXPECT_FALSE((*file)->flush({}));
    EXPECT_FALSE((*file)->close({}));
  }
  EXPECT_EQ(open_descriptors(), descriptors);
  expect_readable(path, flushed);
  std::filesystem::remove(path);
}

INSTANTIATE_TEST_SUITE_P(Bytes, RecordFileLimit,
                         ::testing::Values(1'000, 5'000, 20'000, 33'333, 77'000, 100'001));

TEST(RecordFile, FramesWithDifferentNumbersOfSpotsAndModesAreReadAsTheyWere) {
  const std::string path = own_folder("record_file_width") + ".h5";
  std::filesystem::remove(path);
  const std::vector<std::size_t> widths{7, 7, 0, 37, 5, 5, 40};
  auto file = RecordFile::create(path, small_header(), {.spots = 7, .modes = 5});
  ASSERT_TRUE(file) << file.error().reason;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    std::vector<RecordedSpot> spots(widths[i]);
    for (std::size_t k = 0; k < widths[i]; ++k) spots[k].x = float(100 * i + k);
    const std::vector<float> waves(widths[i], float(i));
    (*file)->add_frame({}, spots, waves, waves);
    if (i % 3 != 1) continue;
    ASSERT_TRUE((*file)->flush({}));
  }
  ASSERT_TRUE((*file)->close({}));
  auto reader = RecordingReader::open(path);
  ASSERT_TRUE(reader) << reader.error().reason;
  ASSERT_EQ((*reader)->frames().size(), widths.size());
  for (std::size_t i = 0; i < widths.size(); ++i) {
    const RecordedFrame& frame = (*reader)->frames()[i];
    const auto spots = (*reader)->spots(frame).value();
    ASSERT_EQ(spots.size(), widths[i]);
    for (std::size_t k = 0; k < widths[i]; ++k) EXPECT_EQ(spots[k].x, float(100 * i + k));
    EXPECT_EQ((*reader)->coefficients(frame).value(), std::vector<float>(widths[i], float(i)));
    EXPECT_EQ((*reader)->sigma_waves(frame).value(), std::vector<float>(widths[i], float(i)));
  }
  std::filesystem::remove(path);
}

TEST(RecordFile, OneThatCannotBeBegunLeavesNothing) {
  const std::string path = own_folder("record_file_begin") + ".h5";
  std::filesystem::remove(path);
  {
    const test::FileLimit limit(500);
    const auto file = RecordFile::create(path, small_header());
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().field, "path");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  std::filesystem::remove(path);
}

TEST(RecordFile, AnotherFileOfThatNameStaysAsItIs) {
  const std::string path = own_folder("record_file_there") + ".h5";
  std::filesystem::remove(path);
  ASSERT_TRUE((*RecordFile::create(path, small_header()))->close({}));
  EXPECT_FALSE(RecordFile::create(path, small_header()));
  EXPECT_TRUE(RecordingReader::open(path));
  std::filesystem::remove(path);
}

TEST(RecordFile, ThatCannotBeOpenedSaysWhy) {
  const auto reason = [](const std::string& path) {
    const auto reader = RecordingReader::open(path);
    return reader ? "" : reader.error().reason;
  };
  const std::string path = own_folder("record_file_closed") + ".h5";
  EXPECT_EQ(reason(path), path + ": No such file or directory");
  std::ofstream(path) << "no HDF5";
  EXPECT_NE(reason(path).find("cannot be opened as HDF5"), std::string::npos);
  if (::geteuid() == 0) {
    std::filesystem::permissions(path, std::filesystem::perms(0600));
    ASSERT_EQ(::seteuid(65534), 0);
    const std::string refused = reason(path);
    ASSERT_EQ(::seteuid(0), 0);
    EXPECT_EQ(refused.find(path + ": Permission denied; "), 0U) << refused;
    EXPECT_NE(refused.find("ovws-data"), std::string::npos);
  }
  std::filesystem::remove(path);
}

TEST(FrameStore, FramesThatFindNoRoomAreLeftOutAndCounted) {
  MeasurementPlan plan;
  FrameRecord record;
  record.plan = &plan;
  FrameStore store(0, 0);
  EXPECT_EQ(store.taken_after(0), 0U);
  constexpr std::uint64_t kFirst = 11, kCame = 5000;
  for (record.number = kFirst; record.number < kFirst + kCame; ++record.number) {
    store.take(record, false);
  }
  EXPECT_EQ(store.taken_after(0), kCame);
  std::uint64_t last = kFirst - 1;
  while (TakenFrame* const frame = store.next(0)) {
    EXPECT_EQ(frame->number, last + 1);
    last = frame->number;
    store.give_back(frame);
  }
  EXPECT_LT(last, kFirst + kCame - 1);
  EXPECT_EQ(store.taken_after(last), kFirst + kCame - 1 - last);
}

TEST(FrameStore, AnImageThatFindsNoRoomIsDroppedAndItsFrameSaysSo) {
  constexpr int kPictures = 4;
  const std::vector<std::byte> pixels(kSide * kSide, std::byte(7));
  MeasurementPlan plan;
  FrameRecord record;
  record.plan = &plan;
  record.frame.image = {pixels.data(), kSide, kSide, kSide, PixelFormat::mono8};
  FrameStore store(kPictures, pixels.size());
  for (record.number = 1; record.number <= kPictures + 1; ++record.number) store.take(record, true);
  EXPECT_TRUE(store.behind());
  for (int i = 0; i <= kPictures; ++i) {
    TakenFrame* const frame = store.next(0);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->row.picture_dropped, i == kPictures ? 1 : 0);
    EXPECT_EQ(frame->pixels.size(), i == kPictures ? 0 : pixels.size());
    store.give_back(frame);
  }
  EXPECT_FALSE(store.behind());
}

}  // namespace
}  // namespace ovws
