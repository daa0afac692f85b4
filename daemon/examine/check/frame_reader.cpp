#include "daemon/examine/check/frame_reader.hpp"

#include "core/pipeline/frame_rules.hpp"
#include "proto/json_text.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kWait{100};
constexpr int kQueue = 10000;

Frame frame_of(const json& message) {
  Frame frame;
  frame.t_s = 1e-9 * double(message.at("t_arrival_ns").get<std::int64_t>() % 1'000'000'000'000'000);
  frame.valid = message.at("valid").get<bool>();
  frame.saturated = message.at("saturated").get<double>();
  if (!frame.valid) return frame;
  frame.waves = message.at("coefficients").get<std::vector<double>>();
  const json& sigma = message.at("sigma");
  if (!sigma.empty() && sigma.front().is_number()) {
    frame.sigmas = sigma.get<std::vector<double>>();
  }
  return frame;
}

}  // namespace

tl::expected<FrameReader, cli::CallFailure> FrameReader::open(const cli::Common& common,
                                                              std::function<bool()> interrupted) {
  auto stream = cli::open_stream(common, "endpoint", {"wavefront", "spots"}, kQueue);
  if (!stream) return tl::make_unexpected(stream.error());
  return FrameReader(std::move(*stream), std::move(interrupted));
}

std::optional<json> FrameReader::next() {
  const auto message = stream_.receive(kWait);
  if (!message) return std::nullopt;
  if (message->topic != "spots") return json_of(message->json);
  spots_.add(*message);
  return std::nullopt;
}

Shown FrameReader::shown(std::uint64_t hologram_id, const Wanted& wanted) {
  Shown shown;
  std::optional<Frame> first;
  std::vector<Frame> plain, exact;
  double longest_s = wanted.longest_s;
  const auto begin = Clock::now();
  for (double passed_s = 0.0; passed_s < longest_s && !interrupted_();
       passed_s = std::chrono::duration<double>(Clock::now() - begin).count()) {
    const auto message = next();
    if (!message || message->at("hologram_id").get<std::uint64_t>() != hologram_id ||
        !message->at("settled").get<bool>()) {
      continue;
    }
    ++shown.settled;
    shown.valid += message->at("valid").get<bool>() ? 1 : 0;
    const int tracked = message->at("tracked").get<int>();
    const int lost = message->at("subapertures").get<int>() - tracked;
    if (!first && !too_many_lost({.used = tracked, .lost = lost})) longest_s = wanted.templates_s;
    if (message->at("j").get<std::vector<int>>() != wanted.modes_j) continue;
    Frame frame = frame_of(*message);
    if (!frame.valid) continue;
    if (!first) {
      first = frame;
      longest_s = passed_s + wanted.longest_s;
    }
    const bool is_exact =
        !frame.sigmas.empty() && study::root_sum_square(frame.sigmas) <= wanted.most_sigma_waves;
    (is_exact ? exact : plain).push_back(std::move(frame));
    if (passed_s < wanted.least_s) continue;
    const bool waits = message->at("tracker") == "fit" && wanted.most_sigma_waves > 0.0;
    if (int(exact.size()) >= wanted.count) break;
    if (!waits && int(plain.size()) >= 2 * wanted.count) break;
  }
  std::vector<Frame>& rest = int(exact.size()) < wanted.count ? plain : exact;
  if (!first || int(rest.size()) < wanted.count) return shown;
  rest.erase(rest.begin(), rest.end() - wanted.count);
  shown.first = std::move(*first);
  shown.rest = std::move(rest);
  return shown;
}

Record FrameReader::record(double seconds, const std::function<void(double)>& tick) {
  Record record;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  auto next_tick = Clock::now();
  for (auto now = Clock::now(); now < end && !interrupted_(); now = Clock::now()) {
    if (now >= next_tick) {
      tick(std::chrono::duration<double>(end - now).count());
      next_tick = now + std::chrono::milliseconds(500);
    }
    const auto message = next();
    if (!message) continue;
    ++record.received;
    if (!message->at("settled").get<bool>()) continue;
    const auto modes_j = message->at("j").get<std::vector<int>>();
    if (modes_j != record.modes_j) record = {modes_j, {}, record.received};
    record.frames.push_back(frame_of(*message));
  }
  record.spots = spots_;
  return record;
}

}  // namespace ovws::examine
