#include "daemon/ovws/check/borrowed.hpp"

#include <spdlog/fmt/fmt.h>

#include "proto/json_text.hpp"

namespace ovws::check {
namespace {

using nlohmann::json;

constexpr int kTries = 3;  // a signal may interrupt a call

/// Params of aberration.set or correction.set that show the modes of such a result.
json modes_of(const json& shown) {
  json modes = json::array();
  for (const json& mode : shown.at("modes")) {
    modes.push_back({{"j", mode.at("j")}, {"waves", mode.at("waves")}});
  }
  return {{"modes", std::move(modes)}};
}

}  // namespace

Answer Borrowed::remember() {
  for (const auto& [method, answer] : {std::pair{"aberration.get", &aberration_},
                                       {"correction.get", &correction_},
                                       {"loop.get", &loop_}}) {
    auto now = cli::call(common_, method, json::object());
    if (!now) return now;
    *answer = std::move(*now);
  }
  if (!aberration_.value("patterns", json::array()).empty()) {
    return tl::make_unexpected(
        failure("the DMD shows a sequence of patterns: end it with ovws call "
                "aberration.clear first"));
  }
  aberration_ = modes_of(aberration_);
  correction_ = modes_of(correction_);
  return json();
}

json Borrowed::loop_params() const {
  json params;
  for (const char* key :
       {"law", "gain", "leak", "modes", "gains", "offsets", "limit_waves", "patience_s"}) {
    if (!loop_.at(key).is_null()) params[key] = loop_.at(key);
  }
  return params;
}

Answer Borrowed::poke(int j, double waves) {
  json params = aberration_;
  bool added = false;
  for (json& mode : params["modes"]) {
    if (mode.at("j") != j) continue;
    mode["waves"] = mode["waves"].get<double>() + waves;
    added = true;
  }
  if (!added) params["modes"].push_back({{"j", j}, {"waves", waves}});
  poked_ = true;
  return cli::call(common_, "aberration.set", params);
}

Answer Borrowed::unpoke() {
  auto shown = again("aberration.set", aberration_);
  if (shown) poked_ = false;
  return shown;
}

Answer Borrowed::open_loop() {
  auto opened = again("loop.open", {{"keep", true}});
  if (opened) loop_closed_ = false;
  loop_changed_ = true;
  return opened;
}

Answer Borrowed::close_loop() {
  loop_changed_ = loop_closed_ = true;
  return cli::call(common_, "loop.close", loop_was_closed() ? loop_params() : json::object());
}

Answer Borrowed::clear_lut() {
  auto cleared = again("lut.clear", json::object());
  if (cleared) lut_changed_ = false;
  return cleared;
}

Answer Borrowed::again(const char* method, const json& params) {
  Answer answer = cli::call(common_, method, params);
  for (int tries = 1; !answer && !answer.error().answered && tries < kTries; ++tries) {
    answer = cli::call(common_, method, params);
  }
  return answer;
}

Answer Borrowed::restore() {
  std::string failed;
  const auto restore_one = [&](const char* method, const json& params) {
    const Answer done = again(method, params);
    if (done) return;
    failed += fmt::format("{}ovws call {} '{}' ({})", failed.empty() ? "" : ", then ", method,
                          json_text(params), done.error().error.value("message", "unknown error"));
  };
  if (loop_closed_) restore_one("loop.open", {{"keep", true}});
  if (lut_changed_) restore_one("lut.clear", json::object());
  if (poked_) restore_one("aberration.set", aberration_);
  if (loop_changed_) restore_one("correction.set", correction_);
  if (loop_changed_ && loop_was_closed()) {
    restore_one("loop.close", loop_params());
    if (loop_.at("paused") == true) restore_one("loop.pause", json::object());
  }
  poked_ = loop_closed_ = loop_changed_ = lut_changed_ = false;
  if (failed.empty()) return json();
  return tl::make_unexpected(failure("not everything could be restored; do so by: " + failed));
}

}  // namespace ovws::check
