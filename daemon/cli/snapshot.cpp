/// ovws snapshot: the camera's image with what was found in it, and the wavefront, as two PNG
/// files.
#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "daemon/cli/client.hpp"
#include "daemon/cli/commands.hpp"
#include "drivers/zmq/client.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kZoom = 2;
const cv::Scalar kFoundColour(80, 255, 80);
const cv::Scalar kReferenceColour(0, 190, 255);
const cv::Scalar kTextColour(255, 255, 255);

/// The newest message of each topic, by name.
using Messages = std::map<std::string, StreamMessage>;

/// Collects messages until an image and the spots of the same frame are there, and a phase map.
std::optional<Messages> collect(Subscriber& numbers, Subscriber& pictures, double timeout_s) {
  Messages found;
  std::map<std::uint64_t, StreamMessage> spots_by_frame;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (Clock::now() < end) {
    while (auto message = numbers.receive(std::chrono::milliseconds(0))) {
      const auto frame = json::parse(message->json)["frame_id"].get<std::uint64_t>();
      spots_by_frame[frame] = std::move(*message);
      if (spots_by_frame.size() > 1000) spots_by_frame.erase(spots_by_frame.begin());
    }
    if (auto message = pictures.receive(std::chrono::milliseconds(5))) {
      found[message->topic] = std::move(*message);
    }
    if (!found.contains("image") || !found.contains("phase")) continue;
    const auto frame = json::parse(found["image"].json)["frame_id"].get<std::uint64_t>();
    if (json::parse(found["phase"].json)["frame_id"].get<std::uint64_t>() != frame) continue;
    if (const auto spots = spots_by_frame.find(frame); spots != spots_by_frame.end()) {
      found["spots"] = spots->second;
      return found;
    }
  }
  return std::nullopt;
}

cv::Mat grey_picture(const StreamMessage& message, const json& header) {
  const int rows = header["shape"][0].get<int>();
  const int cols = header["shape"][1].get<int>();
  const int bits = header["significant_bits"].get<int>();
  cv::Mat raw(rows, cols, bits > 8 ? CV_16UC1 : CV_8UC1);
  std::memcpy(raw.data, message.binary.data(),
              std::min(message.binary.size(), raw.total() * raw.elemSize()));
  cv::Mat grey;
  raw.convertTo(grey, CV_8U, 255.0 / double((1 << bits) - 1));
  return grey;
}

void draw_spots(cv::Mat& picture, const StreamMessage& spots) {
  constexpr std::size_t kColumns = 6;
  std::vector<float> values(spots.binary.size() / sizeof(float));
  std::memcpy(values.data(), spots.binary.data(), values.size() * sizeof(float));
  const auto at = [](float x, float y) {
    return cv::Point(int(std::lround((x + 0.5F) * kZoom)), int(std::lround((y + 0.5F) * kZoom)));
  };
  for (std::size_t i = 0; i + kColumns <= values.size(); i += kColumns) {
    const float* spot = &values[i];
    if (!std::isnan(spot[2])) {
      cv::drawMarker(picture, at(spot[2], spot[3]), kReferenceColour, cv::MARKER_TILTED_CROSS, 10);
    }
    if (std::isnan(spot[0])) continue;
    cv::circle(picture, at(spot[0], spot[1]), 6, kFoundColour, 1, cv::LINE_AA);
    if (!std::isnan(spot[2])) {
      cv::line(picture, at(spot[2], spot[3]), at(spot[0], spot[1]), kFoundColour, 1, cv::LINE_AA);
    }
  }
}

void write_line(cv::Mat& picture, int line, const std::string& text) {
  cv::putText(picture, text, {8, 20 + 20 * line}, cv::FONT_HERSHEY_SIMPLEX, 0.5, kTextColour, 1,
              cv::LINE_AA);
}

cv::Mat camera_picture(const Messages& messages) {
  const json header = json::parse(messages.at("image").json);
  const json spots = json::parse(messages.at("spots").json);
  cv::Mat grey = grey_picture(messages.at("image"), header);
  cv::Mat large;
  cv::resize(grey, large, {}, kZoom, kZoom, cv::INTER_NEAREST);
  cv::Mat picture;
  cv::cvtColor(large, picture, cv::COLOR_GRAY2BGR);
  draw_spots(picture, messages.at("spots"));
  write_line(picture, 0,
             fmt::format("frame {}  charge {}  {} of {} spots",
                         spots["frame_id"].get<std::uint64_t>(), spots["charge"].get<int>(),
                         spots["tracked"].get<int>(), spots["subapertures"].get<int>()));
  write_line(picture, 1, "circle: found   cross: reference");
  return picture;
}

cv::Mat phase_picture(const Messages& messages) {
  const json header = json::parse(messages.at("phase").json);
  const int rows = header["shape"][0].get<int>();
  const int cols = header["shape"][1].get<int>();
  cv::Mat waves(rows, cols, CV_32FC1);
  std::memcpy(waves.data, messages.at("phase").binary.data(),
              std::min(messages.at("phase").binary.size(), waves.total() * sizeof(float)));
  cv::Mat inside = waves == waves;  // NaN is not equal to itself
  double low = 0.0;
  double high = 0.0;
  cv::minMaxLoc(waves, &low, &high, nullptr, nullptr, inside);
  const double scale = std::max({std::abs(low), std::abs(high), 1e-3});
  cv::Mat scaled;
  waves.convertTo(scaled, CV_8U, 127.5 / scale, 127.5);
  cv::Mat coloured;
  cv::applyColorMap(scaled, coloured, cv::COLORMAP_VIRIDIS);
  cv::Mat picture(rows, cols, CV_8UC3, cv::Scalar(40, 40, 40));
  coloured.copyTo(picture, inside);
  cv::resize(picture, picture, {512, 512}, 0, 0, cv::INTER_NEAREST);
  write_line(picture, 0,
             fmt::format("wavefront, frame {}", header["frame_id"].get<std::uint64_t>()));
  write_line(picture, 1, fmt::format("colours {:+.3f} to {:+.3f} wave", -scale, scale));
  return picture;
}

int snapshot(const Common& common, const std::string& prefix) {
  const auto endpoint = stream_endpoint(common, "endpoint");
  if (!endpoint) return report_failure(common, endpoint.error());
  const auto image_endpoint = stream_endpoint(common, "image_endpoint");
  if (!image_endpoint) return report_failure(common, image_endpoint.error());
  auto numbers = Subscriber::connect(*endpoint, {"spots"}, 1000);
  auto pictures = Subscriber::connect(*image_endpoint, {"image", "phase"}, 10);
  if (!numbers) return report(common, numbers.error());
  if (!pictures) return report(common, pictures.error());
  const auto messages = collect(*numbers, *pictures, common.timeout_s);
  if (!messages) {
    return report(common, {Errc::unavailable, "", "no image came in time: see ovws status"});
  }
  const std::string camera = prefix + "-camera.png";
  const std::string phase = prefix + "-phase.png";
  if (!cv::imwrite(camera, camera_picture(*messages)) ||
      !cv::imwrite(phase, phase_picture(*messages))) {
    return report(common, {Errc::unavailable, "output", prefix + "-….png cannot be written"});
  }
  fmt::print("{}\n{}\n", camera, phase);
  return kOk;
}

}  // namespace

void add_snapshot(CLI::App& app, const Common& common, int& status) {
  auto* command =
      app.add_subcommand("snapshot", "write the annotated camera image and the wavefront as PNG");
  auto prefix = std::make_shared<std::string>("ovws");
  command->add_option("--output,-o", *prefix, "files are PREFIX-camera.png and PREFIX-phase.png")
      ->capture_default_str();
  command->callback([&common, &status, prefix] { status = snapshot(common, *prefix); });
}

}  // namespace ovws::cli
