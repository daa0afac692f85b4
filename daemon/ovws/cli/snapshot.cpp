/// ovws snapshot: writes the camera image with the spots marked, and the wavefront, as PNG files.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/shared/client.hpp"
#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"
#include "proto/spot_rows.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kZoom = 2;
const cv::Scalar kFoundColour(80, 255, 80);
const cv::Scalar kReferenceColour(0, 190, 255);
const cv::Scalar kTextColour(255, 255, 255);
const cv::Scalar kWarningColour(90, 90, 255);
const cv::Scalar kBackground(40, 40, 40);
const cv::Size kPhaseImageSize(512, 512);
const cv::Rect kMapPlace(64, 72, 384, 384);

/// The newest message of each topic, by name.
using Messages = std::map<std::string, StreamMessage>;

/// Collects messages until image, phase and spots of the same frame have arrived.
class Collector {
 public:
  void add_spots(StreamMessage message) {
    const auto frame = frame_of(message);
    spots_by_frame_[frame] = std::move(message);
    if (spots_by_frame_.size() > 1000) spots_by_frame_.erase(spots_by_frame_.begin());
  }
  void add_image(StreamMessage message) { found_[message.topic] = std::move(message); }

  /// Messages image, phase and spots of one frame; none until all three have arrived.
  std::optional<Messages> of_one_frame() {
    if (!found_.contains("image") || !found_.contains("phase")) return std::nullopt;
    const auto frame = frame_of(found_["image"]);
    const auto spots = spots_by_frame_.find(frame);
    if (frame_of(found_["phase"]) != frame || spots == spots_by_frame_.end()) return std::nullopt;
    found_["spots"] = spots->second;
    return found_;
  }

 private:
  static std::uint64_t frame_of(const StreamMessage& message) {
    return json_of(message.json).at("frame_id").get<std::uint64_t>();
  }

  Messages found_;
  std::map<std::uint64_t, StreamMessage> spots_by_frame_;
};

/// Collects one frame: the first valid frame, or the last invalid one if the timeout ends first.
std::optional<Messages> collect(Subscriber& numbers, Subscriber& pictures, double timeout_s) {
  Collector collector;
  std::optional<Messages> last;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (Clock::now() < end) {
    while (auto message = numbers.receive(std::chrono::milliseconds(0))) {
      collector.add_spots(std::move(*message));
    }
    if (auto message = pictures.receive(std::chrono::milliseconds(5))) {
      collector.add_image(std::move(*message));
    }
    auto together = collector.of_one_frame();
    if (!together) continue;
    last = std::move(together);
    if (json_of(last->at("spots").json).at("valid").get<bool>()) break;
  }
  return last;
}

cv::Mat grey_image(const StreamMessage& message, const json& header) {
  const int rows = header.at("shape").at(0).get<int>();
  const int cols = header.at("shape").at(1).get<int>();
  const int bits = header.at("significant_bits").get<int>();
  cv::Mat raw(rows, cols, bits > 8 ? CV_16UC1 : CV_8UC1);
  std::memcpy(raw.data, message.binary.data(),
              std::min(message.binary.size(), raw.total() * raw.elemSize()));
  cv::Mat grey;
  raw.convertTo(grey, CV_8U, 255.0 / double((1 << bits) - 1));
  return grey;
}

/// Warning text "NOT VALID: reason"; empty for a valid frame.
std::string warning_of(const StreamMessage& spots, const json& status) {
  const json header = json_of(spots.json);
  return header.at("valid").get<bool>() ? "" : "NOT VALID: " + why_not_valid(header, status);
}

void draw_spots(cv::Mat& picture, const StreamMessage& spots) {
  const auto at = [](float x, float y) {
    return cv::Point(int(std::lround((x + 0.5F) * kZoom)), int(std::lround((y + 0.5F) * kZoom)));
  };
  for (const SpotRow& spot : spot_rows(spots.binary)) {
    if (!std::isnan(spot.ref_x)) {
      cv::drawMarker(picture, at(spot.ref_x, spot.ref_y), kReferenceColour, cv::MARKER_TILTED_CROSS,
                     10);
    }
    if (std::isnan(spot.x)) continue;
    cv::circle(picture, at(spot.x, spot.y), 6, kFoundColour, 1, cv::LINE_AA);
    if (!std::isnan(spot.ref_x)) {
      cv::line(picture, at(spot.ref_x, spot.ref_y), at(spot.x, spot.y), kFoundColour, 1,
               cv::LINE_AA);
    }
  }
}

/// Draws text with a black outline, so that it is readable on any background.
void write_text(cv::Mat& picture, cv::Point at, const std::string& text, const cv::Scalar& colour) {
  const auto font = cv::FONT_HERSHEY_SIMPLEX;
  cv::putText(picture, text, at, font, 0.5, cv::Scalar(0, 0, 0), 4, cv::LINE_AA);
  cv::putText(picture, text, at, font, 0.5, colour, 1, cv::LINE_AA);
}

void write_line(cv::Mat& picture, int line, const std::string& text,
                const cv::Scalar& colour = kTextColour) {
  write_text(picture, {8, 20 + 20 * line}, text, colour);
}

cv::Mat camera_image(const Messages& messages, const std::string& warning) {
  const json header = json_of(messages.at("image").json);
  const json spots = json_of(messages.at("spots").json);
  cv::Mat grey = grey_image(messages.at("image"), header);
  cv::Mat large;
  cv::resize(grey, large, {}, kZoom, kZoom, cv::INTER_NEAREST);
  cv::Mat picture;
  cv::cvtColor(large, picture, cv::COLOR_GRAY2BGR);
  draw_spots(picture, messages.at("spots"));
  write_line(
      picture, 0,
      fill("frame {frame_id}  charge {charge}  {tracked} of {subapertures} spots found", spots));
  write_line(picture, 1, "circle: found   cross: reference");
  write_line(picture, 2, warning, kWarningColour);
  return picture;
}

/// Draws the colour bar below the map, labelled from -scale to +scale waves.
void draw_colour_bar(cv::Mat& picture, double scale) {
  cv::Mat ramp(1, 256, CV_32FC1);
  for (int i = 0; i < ramp.cols; ++i) ramp.at<float>(0, i) = float(scale * (i / 127.5 - 1.0));
  const cv::Rect place(kMapPlace.x, kMapPlace.y + kMapPlace.height + 8, kMapPlace.width, 14);
  cv::resize(phase_colours(ramp, scale, kBackground), picture(place), place.size(), 0, 0,
             cv::INTER_NEAREST);
  const int line = place.y + place.height + 18;
  const auto label = [&](double at, const std::string& text) {
    const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width;
    const int left = place.x + int(at * place.width) - width / 2;
    write_text(picture, {std::clamp(left, 4, picture.cols - width - 4), line}, text, kTextColour);
  };
  label(0.0, fmt::format("{:+.3f} wave", -scale));
  label(0.5, "0");
  label(1.0, fmt::format("{:+.3f} wave", scale));
}

cv::Mat phase_image(const Messages& messages, const std::string& warning) {
  const StreamMessage& phase = messages.at("phase");
  const json header = json_of(phase.json);
  const json spots = json_of(messages.at("spots").json);
  cv::Mat waves(header.at("shape").at(0).get<int>(), header.at("shape").at(1).get<int>(), CV_32FC1);
  std::memcpy(waves.data, phase.binary.data(),
              std::min(phase.binary.size(), waves.total() * sizeof(float)));
  double low = 0.0;
  double high = 0.0;
  cv::minMaxLoc(waves, &low, &high, nullptr, nullptr, waves == waves);
  const double scale = std::max({std::abs(low), std::abs(high), 1e-3});
  cv::Mat picture(kPhaseImageSize, CV_8UC3, kBackground);
  cv::resize(phase_colours(waves, scale, kBackground), picture(kMapPlace), kMapPlace.size(), 0, 0,
             cv::INTER_NEAREST);
  write_line(picture, 0, fill("wavefront, frame {frame_id}", header));
  if (spots.at("rms_waves").is_number()) {
    write_line(picture, 1, fill("RMS {rms_waves:.4f} wave without tilts", spots));
    draw_colour_bar(picture, scale);
  }
  write_line(picture, 2, warning, kWarningColour);
  return picture;
}

/// File name "PREFIX-WHAT". If the prefix is a folder: "PREFIX/ovws-WHAT".
std::string file_name(const std::string& prefix, const std::string& what) {
  std::error_code ignored;
  const bool is_folder = prefix.ends_with('/') || std::filesystem::is_directory(prefix, ignored);
  return is_folder ? (std::filesystem::path(prefix) / ("ovws-" + what)).string()
                   : prefix + "-" + what;
}

int write_images(const Common& common, const Messages& messages, const std::string& warning,
                 const std::string& prefix) {
  const std::string camera = file_name(prefix, "camera.png");
  const std::string phase = file_name(prefix, "phase.png");
  auto written = write_image(camera, camera_image(messages, warning));
  if (written) written = write_image(phase, phase_image(messages, warning));
  if (!written) return report(common, written.error());
  if (!warning.empty()) fmt::print(stderr, "ovws: {}\n", warning);
  return print_result(common, {{"files", {camera, phase}}, {"valid", warning.empty()}},
                      camera + "\n" + phase);
}

int save_snapshot(const Common& common, const std::string& prefix) {
  auto numbers = needed(open_stream(common, "endpoint", {"spots"}, 1000));
  auto pictures = needed(open_stream(common, "image_endpoint", {"image", "phase"}, 10));
  const auto messages = collect(numbers, pictures, common.timeout_s);
  if (!messages) {
    return report(
        common,
        {Errc::unavailable, "",
         "no image arrived in time: see ovws status; if stream.image_rate_hz is 0, none is sent"});
  }
  const json status = needed(call(common, "system.status", json::object()));
  return write_images(common, *messages, warning_of(messages->at("spots"), status), prefix);
}

}  // namespace

void add_snapshot(CLI::App& app, const Common& common, int& status) {
  auto [command, prefix] =
      add_command(app, common, status, "snapshot",
                  "write the camera image with its spots and the wavefront as PNG; waits up to "
                  "--timeout for a valid frame",
                  save_snapshot);
  prefix = "ovws";
  command
      .add_option("--output,-o", prefix,
                  "prefix of the files PREFIX-camera.png and PREFIX-phase.png, or a folder")
      ->capture_default_str();
}

}  // namespace ovws::cli
