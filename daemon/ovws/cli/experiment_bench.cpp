#include "daemon/ovws/cli/experiment_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "daemon/examine/in_use.hpp"
#include "proto/json_text.hpp"
#include "proto/spot_rows.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/reference.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr std::size_t kMaxGrabBytes = 60'000'000;  // a reply may have 64 MiB
constexpr double kGrabPatienceS = 30.0;
constexpr int kSpareGrabs = 3;  // the first frames may have been exposed at the gain before
constexpr int kFramesToFind = 20;
constexpr auto kFindPatience = 10s;

/// The format of the pixels of a grab, which come unpacked.
PixelFormat unpacked(PixelFormat format) {
  const PixelFormatTraits& packed = traits_of(format);
  for (const PixelFormatTraits& one : all_pixel_formats()) {
    const bool plain = one.layout == PixelLayout::bytes || one.layout == PixelLayout::words;
    if (plain && one.bits == packed.bits && one.filter == packed.filter) return one.format;
  }
  return format;
}

/// Adds the positions of a `spots` message.
void add_spots(const StreamMessage& message, std::vector<Vec2>& sums, std::vector<int>& found) {
  const std::vector<SpotRow> rows = spot_rows(message.binary);
  sums.resize(rows.size());
  found.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (std::isnan(rows[i].x)) continue;
    sums[i] = sums[i] + Vec2{double(rows[i].x), double(rows[i].y)};
    ++found[i];
  }
}

}  // namespace

json ExperimentBench::call(const char* method, const json& params) const {
  return needed(cli::call(common_, method, params));
}

ExperimentBench::ExperimentBench(const Common& common) : common_(common) {
  auto config = parse_config(json_text(call("config.get")));
  if (!config) {
    stop({Errc::invalid, "",
          "the daemon's reply to config.get is not a configuration, so it may have another "
          "version: " +
              text_of(config.error())});
  }
  config_ = std::move(*config);
  const json limits = call("camera.get").at("limits");
  if (!limits.is_object()) stop({Errc::unavailable, "camera", "no camera is connected"});
  if (!limits.at("gain_db").is_object()) {
    stop({Errc::refused, "gain_db", "the camera has no gain in dB, which the experiment changes"});
  }
  gains_db_ = {limits.at("gain_db").at("min").get<double>(),
               limits.at("gain_db").at("max").get<double>()};
  examine::use_registration(config_, call("registration.get"));
  before_.emplace(common, needed(parts_of(common, {Part::camera, Part::sensor, Part::aberration})));
}

void ExperimentBench::show(int charge, const std::vector<Mode>& modes) {
  if (!shown_ || charge != charge_shown_) {
    call("sensor.set", {{"charge", charge},
                        {"alternate_charge", nullptr},
                        {"charges", json::array()},
                        {"tracker", "lg"},
                        {"operator", "slopes"},
                        {"mode_count", nullptr}});
    shown_ = true;
    charge_shown_ = charge;
  }
  const json shown = call("aberration.set", {{"modes", to_json(modes)}});
  hologram_id_ = shown.at("hologram_id").get<std::int64_t>();
}

void ExperimentBench::set_gain(double gain_db) {
  const json set = call("camera.set", {{"gain_db", gain_db}});
  gain_db_ = set.at("applied").at("gain_db").get<double>();
}

GrabbedImages ExperimentBench::grab(int frames) {
  const CameraSettings& camera = config_.camera.settings;
  const PixelFormat format = unpacked(camera.pixel_format);
  GrabbedImages all;
  all.gain_db = gain_db_;
  const std::size_t image_bytes = std::size_t(camera.roi.width) * std::size_t(camera.roi.height) *
                                  (traits_of(format).layout == PixelLayout::words ? 2 : 1);
  const int most = int(std::clamp<std::size_t>(kMaxGrabBytes / image_bytes, 1,
                                               std::size_t(limits::kGrabFrames.max)));
  const int most_tries = frames / most + kSpareGrabs;
  Common patient = common_;
  patient.timeout_s = kGrabPatienceS + 5.0;
  int left = frames;
  for (int tries = 0; left > 0; ++tries) {
    if (tries > most_tries) {
      stop({Errc::refused, "gain_db", "the camera's gain was changed meanwhile"});
    }
    std::vector<std::byte> pixels;
    const json reply = needed(cli::call(patient, "camera.grab",
                                        {{"frames", std::min(left, most)},
                                         {"after_hologram", hologram_id_},
                                         {"timeout_s", kGrabPatienceS}},
                                        &pixels));
    const json& shape = reply.at("shape");
    const auto count = shape.at(0).get<std::size_t>();
    const bool whole = shape.at(1) == camera.roi.height && shape.at(2) == camera.roi.width &&
                       pixels.size() == count * image_bytes;
    if (!whole) {
      stop({Errc::refused, "camera", "the camera's region or pixel format was changed meanwhile"});
    }
    for (std::size_t k = 0; k < count && left > 0; ++k) {
      // A frame whose exposure began before the gain was set.
      if (reply.at("frames")[k].at("gain_db") != gain_db_) continue;
      const auto at = pixels.begin() + std::ptrdiff_t(k * image_bytes);
      all.pixels.insert(all.pixels.end(), at, at + std::ptrdiff_t(image_bytes));
      --left;
    }
  }
  for (int k = 0; k < frames; ++k) {
    all.views.push_back({all.pixels.data() + std::size_t(k) * image_bytes, camera.roi.width,
                         camera.roi.height, std::ptrdiff_t(image_bytes) / camera.roi.height,
                         format});
  }
  return all;
}

std::vector<Vec2> ExperimentBench::find_spots() {
  auto stream = needed(open_stream(common_, "endpoint", {"spots"}, kFramesToFind));
  std::vector<Vec2> places;
  std::vector<int> found;
  int seen = 0;
  const auto end = std::chrono::steady_clock::now() + kFindPatience;
  while (seen < kFramesToFind && std::chrono::steady_clock::now() < end) {
    const auto message = stream.receive(500ms);
    if (!message) continue;
    const json header = json_of(message->json);
    if (header.at("hologram_id") != hologram_id_ || !header.at("settled").get<bool>()) continue;
    add_spots(*message, places, found);
    ++seen;
  }
  if (seen == 0) {
    stop({Errc::unavailable, "", "no settled frame came: see camera in ovws status"});
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = found[i] > 0 ? (1.0 / found[i]) * places[i] : Vec2{NAN, NAN};
  }
  return places;
}

}  // namespace ovws::cli
