/// The twin's DMD in pattern mode on an X server and a real network, with Aravis's own client: each
/// triggered frame shows the pattern of its time, of the bits that are on the display.
#include <arv.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <vector>

#include "core/port/clock.hpp"
#include "drivers/zmq/client.hpp"

// Last, because Xlib's macros break other headers.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace ovws {
namespace {

// As on_bench.py's caller configures the twin and xorg-bench.conf the display.
constexpr int kPatterns = 8, kWidth = 1280, kHeight = 768, kDisplayX = 1920;
constexpr double kPeriodNs = 1e9 / 60.0 / kPatterns;
constexpr int kFrames = 400;

using Pixels = std::vector<std::uint32_t>;

/// An image whose bit k of green is on in columns of its own, in the middle of the DMD.
Pixels stripes(int coarsest) {
  Pixels pixels(std::size_t(kWidth) * kHeight);
  for (int y = 100; y < 668; ++y) {
    for (int x = 356; x < 924; ++x) {
      std::uint32_t green = 0;
      for (int k = 0; k < kPatterns; ++k) green |= (x / (coarsest + k) % 2 != 0 ? 1U : 0U) << k;
      pixels[std::size_t(y) * kWidth + std::size_t(x)] =
          green << 8 | 0xff00ffU;  // red and blue: on
    }
  }
  return pixels;
}

std::uint32_t crc_of(const Pixels& pixels, int pattern) {
  std::vector<unsigned char> binary;
  for (const std::uint32_t pixel : pixels)
    binary.push_back((pixel >> (8 + pattern) & 1U) != 0 ? 255 : 0);
  return std::uint32_t(::crc32(0, binary.data(), uInt(binary.size())));
}

void draw(Pixels pixels) {
  ::Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr) throw std::runtime_error("no X server");
  const Window root = DefaultRootWindow(display);
  XImage* const image =
      XCreateImage(display, DefaultVisual(display, 0), 24, ZPixmap, 0,
                   reinterpret_cast<char*>(pixels.data()), kWidth, kHeight, 32, 0);
  // By one request: XPutImage sends a large image in parts, and a reader may see some of them.
  const Pixmap whole = XCreatePixmap(display, root, kWidth, kHeight, 24);
  XPutImage(display, whole, DefaultGC(display, 0), image, 0, 0, 0, 0, kWidth, kHeight);
  XCopyArea(display, whole, root, DefaultGC(display, 0), 0, 0, kWidth, kHeight, kDisplayX, 0);
  XFreePixmap(display, whole);
  XSync(display, False);
  image->data = nullptr;
  XDestroyImage(image);
  XCloseDisplay(display);
}

struct Frame {
  int id = 0;
  std::int64_t t_ns = 0;
  std::uint32_t pixels_crc = 0;
};

/// Aravis's client of the twin's camera: 256 x 256 pixels.
class PatternsOnBench : public ::testing::Test {
 protected:
  void SetUp() override {
    call("twin.set", {{"noise", "none"}});
    camera_ = arv_camera_new("127.0.0.1", nullptr);
    ASSERT_NE(camera_, nullptr);
    arv_camera_stop_acquisition(camera_, nullptr);
    arv_camera_set_region(camera_, 128, 128, 256, 256, nullptr);
    arv_camera_set_frame_rate(camera_, 10.0, nullptr);
    arv_camera_set_exposure_time(camera_, 1000.0, nullptr);
    arv_camera_gv_set_packet_size(camera_, 9000, nullptr);
  }
  void TearDown() override {
    stop();
    g_clear_object(&camera_);
  }
  void start() {
    stream_ = arv_camera_create_stream(camera_, nullptr, nullptr, nullptr);
    ASSERT_NE(stream_, nullptr);
    for (int n = 0; n < 512; ++n)
      arv_stream_push_buffer(stream_, arv_buffer_new(256 * 256, nullptr));
    arv_camera_start_acquisition(camera_, nullptr);
  }
  void stop() {
    if (stream_ != nullptr) arv_camera_stop_acquisition(camera_, nullptr);
    g_clear_object(&stream_);
  }
  /// The next whole frame; id 0: none came.
  Frame grab(int wait_ms = 60'000) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_ms);
    Frame frame;
    while (frame.id == 0 && std::chrono::steady_clock::now() < end) {
      ArvBuffer* const buffer = arv_stream_timeout_pop_buffer(stream_, 50'000);
      if (buffer == nullptr) continue;
      size_t size = 0;
      const auto* data = static_cast<const unsigned char*>(arv_buffer_get_data(buffer, &size));
      if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS) {
        frame = {int(arv_buffer_get_frame_id(buffer)),
                 std::int64_t(arv_buffer_get_timestamp(buffer)),
                 std::uint32_t(::crc32(0, data, uInt(256 * 256)))};
      }
      arv_stream_push_buffer(stream_, buffer);
    }
    return frame;
  }
  std::vector<Frame> grab_some(int count) {
    std::vector<Frame> frames;
    for (int n = 0; n < count; ++n) {
      frames.push_back(grab());
      if (frames.back().id == 0) throw std::runtime_error("no frame came within a minute");
    }
    return frames;
  }
  void grab_until_no_fault() {
    const auto none = nlohmann::json::object();
    while (call("twin.get", none).at("fault").at("kind") != "none") grab_some(1);
  }
  nlohmann::json call(const std::string& method, const nlohmann::json& params) {
    const nlohmann::json request{
        {"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}};
    const auto reply = control_->request(request.dump(), std::chrono::seconds(60));
    return nlohmann::json::parse(reply.value()).at("result");
  }
  /// The twin's truth of all frames after this number, by number.
  std::map<int, nlohmann::json> truths_after(int id) {
    std::map<int, nlohmann::json> truths;
    for (;;) {
      const auto sent = call("twin.get", {{"sent_after", id}}).at("sent");
      if (sent.empty()) return truths;
      for (const auto& one : sent) truths[one.at("frame_id").get<int>()] = one;
      id = sent.back().at("frame_id").get<int>();
    }
  }

  Result<ControlClient> control_ = ControlClient::connect("tcp://127.0.0.1:7790");
  ArvCamera* camera_ = nullptr;
  ArvStream* stream_ = nullptr;
};

TEST_F(PatternsOnBench, EachFrameShowsThePatternOfItsTime) {
  const Pixels first = stripes(3), second = stripes(12);
  std::map<std::uint32_t, int> number_of;  // CRC-32 of a pattern to 0 … 7 (first) or 8 … 15
  for (int k = 0; k < kPatterns; ++k) {
    number_of[crc_of(first, k)] = k;
    number_of[crc_of(second, k)] = kPatterns + k;
  }
  ASSERT_EQ(number_of.size(), std::size_t(2 * kPatterns));
  draw(first);
  arv_camera_set_trigger(camera_, "Line0", nullptr);
  EXPECT_STREQ(arv_camera_get_string(camera_, "TriggerMode", nullptr), "On");
  start();
  const std::int64_t drawn_ns = utc_ns();
  Frame frame = grab();
  while (frame.id != 0 && frame.t_ns < drawn_ns + 100'000'000) frame = grab();
  ASSERT_NE(frame.id, 0);
  const int before = frame.id;
  const auto of_first = grab_some(kFrames);
  draw(second);
  const std::int64_t changed_ns = utc_ns();
  std::vector<Frame> of_both;  // frames of the first still wait if this process was stopped
  for (int newer = 0; newer < kFrames;) {
    of_both.push_back(grab_some(1).front());
    if (of_both.back().t_ns > changed_ns) ++newer;
  }
  const auto truths = truths_after(before);
  std::map<int, std::set<std::uint32_t>> seen;     // pixels of each pattern
  std::map<std::int64_t, std::set<int>> in_cycle;  // images in each cycle
  std::vector<Frame> frames = of_first;
  frames.insert(frames.end(), of_both.begin(), of_both.end());
  for (const Frame& one : frames) {
    ASSERT_EQ(truths.count(one.id), 1U) << one.id;
    const auto& truth = truths.at(one.id);
    ASSERT_EQ(truth.at("t_ns").get<std::int64_t>(), one.t_ns);
    const std::int64_t pulse = std::llround(double(one.t_ns) / kPeriodNs);
    const auto number = number_of.find(truth.at("crc32").get<std::uint32_t>());
    ASSERT_NE(number, number_of.end()) << one.id;
    EXPECT_EQ(truth.at("slot").get<int>(), pulse % kPatterns);
    EXPECT_EQ(number->second % kPatterns, pulse % kPatterns);
    seen[number->second].insert(one.pixels_crc);
    in_cycle[pulse / kPatterns].insert(number->second / kPatterns);
    const bool must_be_second = one.t_ns > changed_ns + 2 * kPatterns * std::int64_t(kPeriodNs);
    EXPECT_TRUE(!must_be_second || number->second >= kPatterns) << one.id;
  }
  std::set<std::uint32_t> all;
  ASSERT_EQ(seen.size(), std::size_t(2 * kPatterns));
  for (const auto& [number, pixels] : seen) {
    EXPECT_EQ(pixels.size(), 1U) << number;
    all.insert(pixels.begin(), pixels.end());
  }
  EXPECT_EQ(all.size(), std::size_t(2 * kPatterns));
  for (const auto& [cycle, images] : in_cycle) EXPECT_EQ(images.size(), 1U) << cycle;
}

TEST_F(PatternsOnBench, AnExposureOfTwoPatternsMissesEverySecondPulse) {
  draw(stripes(3));
  arv_camera_set_exposure_time(camera_, 3000.0, nullptr);
  arv_camera_set_trigger(camera_, "Line0", nullptr);
  start();
  ASSERT_NE(grab().id, 0);
  const Frame start_frame = grab();
  int steps_of_two = 0;
  std::int64_t last = std::llround(double(start_frame.t_ns) / kPeriodNs);
  for (int n = 0; n < 200 || (steps_of_two <= 20 && n < 10'000); ++n) {
    const std::int64_t pulse = std::llround(double(grab().t_ns) / kPeriodNs);
    EXPECT_GE(pulse - last, 2);
    steps_of_two += pulse - last == 2 ? 1 : 0;
    last = pulse;
  }
  EXPECT_GT(steps_of_two, 20);
  for (const auto& [id, truth] : truths_after(start_frame.id))
    EXPECT_TRUE(truth.at("slot").is_null());
}

TEST_F(PatternsOnBench, ALostFrameTakesItsPatternWithIt) {
  draw(stripes(3));
  arv_camera_set_trigger(camera_, "Line0", nullptr);
  start();
  Frame last = grab();
  ASSERT_NE(last.id, 0);
  call("twin.fault", {{"kind", "drop"}, {"frames", 3}});
  bool missing = false;
  for (int n = 0; n < 2000 && !missing; ++n) {
    const Frame frame = grab();
    ASSERT_NE(frame.id, 0);
    const int ids = (frame.id - last.id + 65535) % 65535;
    const std::int64_t pulses = std::llround(double(frame.t_ns - last.t_ns) / kPeriodNs);
    EXPECT_GE(pulses, ids);
    missing = ids >= 4;
    last = frame;
  }
  EXPECT_TRUE(missing);
}

TEST_F(PatternsOnBench, FaultsKeepTheTimesOfTheFrames) {
  draw(stripes(3));
  arv_camera_set_trigger(camera_, "Line0", nullptr);
  start();
  const Frame before = grab();
  ASSERT_NE(before.id, 0);
  for (const char* kind : {"duplicate", "reorder", "incomplete"}) {
    call("twin.fault", {{"kind", kind}, {"frames", 3}});
    grab_until_no_fault();
  }
  call("twin.fault", {{"kind", "freeze"}, {"seconds", 0.2}});
  grab_until_no_fault();
  grab_some(120);
  const auto truths = truths_after(before.id);
  EXPECT_GT(truths.size(), 100U);
  for (const auto& [id, truth] : truths) {
    const std::int64_t pulse =
        std::llround(double(truth.at("t_ns").get<std::int64_t>()) / kPeriodNs);
    EXPECT_EQ(truth.at("slot").get<int>(), pulse % kPatterns) << id;
  }
  const auto frames = call("twin.get", nlohmann::json::object()).at("frames");
  for (const char* count : {"duplicated", "reordered", "incomplete"})
    EXPECT_EQ(frames.at(count), 3);
}

TEST_F(PatternsOnBench, WithoutTriggerTheCameraRunsFreely) {
  draw(stripes(3));
  arv_camera_clear_triggers(camera_, nullptr);
  arv_camera_set_frame_rate(camera_, 50.0, nullptr);
  arv_camera_set_exposure_time(camera_, 20'000.0, nullptr);  // all patterns
  start();
  grab_some(5);
  const auto frames = grab_some(20);
  // Its own period, not that of the patterns.
  const auto periods = double(frames.back().id - frames.front().id);
  EXPECT_GT(double(frames.back().t_ns - frames.front().t_ns) / periods, 15e6);
  EXPECT_EQ(frames.at(frames.size() - 2).pixels_crc, frames.back().pixels_crc);
}

}  // namespace
}  // namespace ovws
