#include "daemon/shared/borrow.hpp"

#include <fmt/core.h>

#include <array>
#include <chrono>
#include <thread>

#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kRestorePatience_s = 15.0;  ///< with devices that are gone
constexpr std::chrono::milliseconds kRestoreInterval{100};

json only(const json& object, std::initializer_list<const char*> keys) {
  json part;
  for (const char* key : keys) part[key] = object.at(key);
  return part;
}

json modes_of(const json& shown) {
  json modes = json::array();
  for (const json& mode : shown.at("modes")) modes.push_back(only(mode, {"j", "waves"}));
  return {{"modes", std::move(modes)}};
}

json pattern_of(const json& status) {
  return only(status.at("slm"), {"pattern"});
}

json light_of(const json& camera) {
  const json& settings = camera.at("settings");
  return only(settings,
              {"exposure_us", settings.at("gain_raw").is_null() ? "gain_db" : "gain_raw"});
}

json sensor_of(const json& sensor) {
  return only(sensor,
              {"charge", "alternate_charge", "charges", "tracker", "operator", "mode_count"});
}

json loop_of(const json& loop) {
  if (loop.at("closed") == false) return {{"closed", false}};
  json params;
  for (const char* key :
       {"law", "gain", "leak", "modes", "gains", "offsets", "limit_waves", "patience_s"}) {
    if (!loop.at(key).is_null()) params[key] = loop.at(key);
  }
  return {{"closed", true}, {"paused", loop.at("paused")}, {"params", std::move(params)}};
}

/// How a part is read, as the params that restore it, and the method that takes them.
struct PartRow {
  Part part;
  const char* get;
  json (*params)(const json&);
  const char* set;
};
constexpr std::array kParts{
    PartRow{Part::pattern, "system.status", pattern_of, "slm.show"},
    PartRow{Part::camera, "camera.get", light_of, "camera.set"},
    PartRow{Part::sensor, "sensor.get", sensor_of, "sensor.set"},
    PartRow{Part::lut, "lut.get", [](const json& lut) { return only(lut, {"measured"}); },
            "lut.clear"},
    PartRow{Part::aberration, "aberration.get", modes_of, "aberration.set"},
    PartRow{Part::correction, "correction.get", modes_of, "correction.set"},
    PartRow{Part::loop, "loop.get", loop_of, "loop.close"}};

const PartRow& row_of(Part part) {
  return kParts[std::size_t(part)];
}

Answer now(const Common& common, Part part) {
  const auto found = call(common, row_of(part).get, json::object());
  if (!found) return found;
  if (part == Part::aberration && !found->value("patterns", json::array()).empty()) {
    return tl::make_unexpected(
        failure("the DMD shows a sequence of patterns: end it with ovws call aberration.clear "
                "first"));
  }
  return row_of(part).params(*found);
}

/// The calls that restore `before` of a bench that is as `present`; null: a part is not known.
Calls calls_between(const Parts& present, const Parts& before) {
  Calls calls;
  const auto loop = before.find(Part::loop);
  const bool has_loop = loop != before.end();
  const json state = has_loop ? present.at(Part::loop) : json();
  const bool has_loop_changed = has_loop && state != loop->second;
  const bool may_be_closed = has_loop && (state.is_null() || state.at("closed") == true);
  if (has_loop_changed && may_be_closed) calls.emplace_back("loop.open", json{{"keep", true}});
  for (const auto& [part, params] : before) {
    // Until it is open, the loop may change the correction that was read.
    const bool may_step = part == Part::correction && may_be_closed && has_loop_changed;
    if (part == Part::loop || (present.at(part) == params && !may_step)) continue;
    const bool is_of_loop = part == Part::correction && may_be_closed && !has_loop_changed;
    const bool is_kept = part == Part::lut && params.at("measured") == true;
    if (is_of_loop || is_kept) continue;
    calls.emplace_back(row_of(part).set, part == Part::lut ? json::object() : params);
  }
  if (has_loop_changed && loop->second.at("closed") == true) {
    calls.emplace_back("loop.close", loop->second.at("params"));
    if (loop->second.at("paused") == true) calls.emplace_back("loop.pause", json::object());
  }
  return calls;
}

/// Restores what it can. Returns why it could not restore the rest, and how to do it.
Answer restore_now(const Common& common, const Parts& before) {
  Answer all = json();
  Parts present;
  for (const auto& [part, params] : before) {
    const bool is_silent = !all && !all.error().answered;
    auto found = is_silent ? all : now(common, part);
    present[part] = found ? std::move(*found) : json();
    if (!found) all = found;
  }
  const bool is_silent = !all && !all.error().answered;
  all = is_silent ? all : json();
  std::string rest;
  for (const auto& [method, params] : calls_between(present, before)) {
    const Answer done = is_silent ? all : call(common, method, params);
    if (done) continue;
    rest += fmt::format("{}ovws call {} '{}' ({})", rest.empty() ? "" : ", then ", method,
                        json_text(params), message_of(done.error()));
    if (!is_silent) all = done;
  }
  if (rest.empty()) return json();
  const std::string message = "not everything could be restored; do so by: " + rest;
  return tl::make_unexpected(CallFailure{all.error().answered, {{"message", message}}});
}

}  // namespace

tl::expected<Parts, CallFailure> parts_of(const Common& common, std::initializer_list<Part> parts) {
  Parts found;
  for (const Part part : parts) {
    auto present = now(common, part);
    if (!present) return tl::make_unexpected(present.error());
    found[part] = std::move(*present);
  }
  return found;
}

/// Also if the daemon was replaced by another version, whose replies have another form.
Answer Borrow::try_restore() const try {
  return restore_now(common_, before_);
} catch (const json::exception& error) {
  const std::string why = "unexpected reply of the daemon: ";
  return tl::make_unexpected(failure(why + error.what()));
}

Answer Borrow::restore() {
  if (std::exchange(is_over_, true)) return json();
  const auto end = Clock::now() + std::chrono::duration<double>(kRestorePatience_s);
  for (;;) {
    auto done = try_restore();
    if (done) return done;
    if (Clock::now() > end) {
      if (hooks_.failed) hooks_.failed(message_of(done.error()));
      return done;
    }
    if (hooks_.waiting) hooks_.waiting();
    std::this_thread::sleep_for(kRestoreInterval);
  }
}

}  // namespace ovws::cli
