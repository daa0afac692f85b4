#include "daemon/shared/slm_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

namespace ovws {
namespace {

class SlmFiles : public testing::Test {
 protected:
  SlmFiles() {
    folder_ = testing::TempDir() + "slm_files_" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  ~SlmFiles() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& text) const {
    const std::string path = folder_ + "/file.txt";
    std::ofstream(path) << text;
    return path;
  }
  std::string folder_;
};

std::string levels(int count) {
  std::string text = "# grey levels\n";
  for (int i = 0; i < count; ++i) text += std::to_string(i / 2) + (i % 16 == 15 ? "\n" : ", ");
  return text;
}

TEST_F(SlmFiles, ALutIs256GreyLevels) {
  const auto lut = load_lut(write(levels(256)));
  ASSERT_TRUE(lut);
  EXPECT_EQ((*lut)[0], 0);
  EXPECT_EQ((*lut)[255], 127);
}

TEST_F(SlmFiles, TablesMayBeginWithAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  std::string numbers;
  for (int i = 0; i < 256; ++i) numbers += std::to_string(i) + "\n";
  const auto lut = load_lut(write(mark + numbers));
  ASSERT_TRUE(lut) << lut.error().reason;
  EXPECT_EQ((*lut)[255], 255);
  const auto flatness = load_flatness(write(mark + "0.5,0\n0,0.25\n"), 2, 2);
  ASSERT_TRUE(flatness) << flatness.error().reason;
  EXPECT_FLOAT_EQ((*flatness)->at(0, 0), 0.5F);
  const auto later = load_lut(write("1\n" + mark + "2\n"));
  EXPECT_NE(later.error().reason.find("not a finite number"), std::string::npos);
}

TEST_F(SlmFiles, AWrongLutNamesWhatIsWrong) {
  EXPECT_NE(load_lut(write(levels(255))).error().reason.find("255"), std::string::npos);
  EXPECT_NE(load_lut(write(levels(255) + " 256")).error().reason.find("256"), std::string::npos);
  EXPECT_NE(load_lut(write(levels(255) + " 1.5")).error().reason.find("1.5"), std::string::npos);
  EXPECT_NE(load_lut(write(levels(255) + " x1")).error().reason.find("x1"), std::string::npos);
  EXPECT_EQ(load_lut(folder_ + "/none").error().field, "slm.lut");
}

TEST_F(SlmFiles, ALutGoesThroughTheGreyLevelsOnce) {
  const auto table = [this](auto grey) {
    std::string text;
    for (int k = 0; k < 256; ++k) text += std::to_string(grey(k)) + "\n";
    return load_lut(write(text));
  };
  EXPECT_TRUE(table([](int k) { return 255 - k; }));
  EXPECT_TRUE(table([](int k) { return k < 245 ? k : 0; }));  // the last levels are clipped to 0
  EXPECT_TRUE(table([](int k) { return (k + 100) % 256; }));  // may start at any phase
  const auto damaged = table([](int k) { return k == 40 || k == 90 ? 0 : k; });
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().field, "slm.lut");
  EXPECT_NE(damaged.error().reason.find("entry 39 is 39, entry 40 is 0"), std::string::npos)
      << damaged.error().reason;
}

TEST_F(SlmFiles, AWrongFlatnessNamesWhatIsWrong) {
  const auto reason = [this](const std::string& text) {
    const auto map = load_flatness(write(text), 3, 2);
    return map ? "" : map.error().reason;
  };
  EXPECT_NE(reason("0 0\n0 0\n0 0\n").find("is 2 x 3 pixels, the SLM 3 x 2"), std::string::npos);
  EXPECT_NE(reason("0 0 0\n0 0\n").find("row 2 has 2 numbers, the first row 3"), std::string::npos);
  EXPECT_NE(reason("0 0 0\n0 nan 0\n").find("\"nan\" is not a finite"), std::string::npos);
  EXPECT_NE(reason("0 0 0\n0 inf 0\n").find("\"inf\" is not a finite"), std::string::npos);
  EXPECT_NE(reason("").find("is 0 x 0 pixels"), std::string::npos);
}

TEST_F(SlmFiles, FlatnessInNumbersKeepsRowsAndColumns) {
  const auto map = load_flatness(write("0 0.25 0.5\n0.75, 1.0, -1.25\n"), 3, 2);
  ASSERT_TRUE(map);
  EXPECT_FLOAT_EQ((*map)->at(1, 0), 0.25F);
  EXPECT_FLOAT_EQ((*map)->at(2, 1), -1.25F);
}

TEST_F(SlmFiles, FlatnessAsAPictureCounts65536AsOneWave) {
  const std::string path = folder_ + "/map.png";
  cv::Mat picture(2, 3, CV_16UC1, cv::Scalar(0));
  picture.at<std::uint16_t>(1, 2) = 16384;
  cv::imwrite(path, picture);
  const auto map = load_flatness(path, 3, 2);
  ASSERT_TRUE(map);
  EXPECT_FLOAT_EQ((*map)->at(2, 1), 0.25F);
  EXPECT_NE(load_flatness(path, 2, 3).error().reason.find("is 3 x 2 pixels, not 2 x 3"),
            std::string::npos);
}

TEST_F(SlmFiles, AFlatnessFileThatIsNoPngIsAnError) {
  const std::string path = folder_ + "/map.png";
  std::ofstream(path) << "not a picture";
  EXPECT_EQ(load_flatness(path, 3, 2).error().field, "slm.flatness");
}

}  // namespace
}  // namespace ovws
