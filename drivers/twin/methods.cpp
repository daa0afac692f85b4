#include "drivers/twin/methods.hpp"

#include <chrono>
#include <limits>

#include "drivers/twin/glib_hooks.hpp"
#include "drivers/twin/methods_json.hpp"
#include "proto/reader.hpp"

namespace ovws::twin {
namespace {

const std::vector<std::string> kMethods{"twin.get", "twin.set", "twin.mirror", "twin.fault"};
const std::vector<std::string> kPatterns{"sensor", "grating"};  // in the order of Pattern

/// Reads `at_ns` as an integer, because a double has too few digits for nanoseconds.
void read_moment(ObjectReader& reader, std::int64_t& t_ns) {
  const Json* at = reader.raw("at_ns");
  if (at == nullptr) return;
  if (!at->is_number_integer() || *at < 0 || *at > std::numeric_limits<std::int64_t>::max()) {
    return reader.fault("at_ns", "must be a whole number of nanoseconds, UTC, 0 or more");
  }
  t_ns = at->get<std::int64_t>();
}

RpcAnswer failed(const Error& error) {
  return tl::make_unexpected(rpc_failure(error));
}

}  // namespace

Methods::Methods(const Config& config, const Deps& deps)
    : config_(config),
      deps_(deps),
      actuators_(config.mirror ? actuator_positions(*config.mirror) : std::vector<Vec2>()) {}

RpcAnswer Methods::call(const std::string& method, const Json& params) {
  if (method == "twin.get") return get(params);
  if (method == "twin.set") return set(params);
  if (method == "twin.mirror") return mirror(params);
  if (method == "twin.fault") return fault(params);
  Json data{{"reason", "there is no method " + method}};
  if (const auto near = nearest_name(method, kMethods)) data["nearest"] = *near;
  return tl::make_unexpected(RpcFailure{RpcCode::method, "method not found", data});
}

const Turbulence& Methods::turbulence(const TurbulenceConfig& config) {
  if (!turbulence_ || turbulence_->config() != config) turbulence_.emplace(config);
  return *turbulence_;
}

void Methods::add_verdict(Pattern pattern, const Truth& truth, std::int64_t t_ns, Json& result) {
  deps_.screen.catch_up(std::chrono::steady_clock::now() + kDisplayTime, {});
  const auto shown = deps_.bench.shown();
  const auto verdict =
      judge_->judge(pattern, shown->front(), truth,
                    truth.turbulence ? &turbulence(*truth.turbulence) : nullptr, t_ns);
  result["wavefront"] = json_of(verdict);
  result["wavefront"]["pattern"] = kPatterns[std::size_t(pattern)];
  result["wavefront"]["t_ns"] = t_ns;
  const auto flatness = judge_->flatness_modes();
  result["flatness_modes"] = flatness ? waves_of(*flatness) : Json(nullptr);
  result["lut_waves"] = Judge::lut_waves(config_.slm);
}

RpcAnswer Methods::get(const Json& params) {
  std::int64_t t_ns = twin_ns();
  ObjectReader reader(params, "");
  int pattern = 0, sent_after = 0;
  read_moment(reader, t_ns);
  reader.choice("judge", pattern, kPatterns);
  reader.integer("sent_after", sent_after, 1, 65535);
  if (reader.has("judge") && !judge_) judge_ = deps_.bench.optics().make_judge();
  if (reader.has("judge") && !judge_) {
    reader.fault("judge", "a fixed array has no SLM whose image could be judged; leave it out");
  }
  if (auto done = reader.finish(); !done) return failed(done.error());
  const Truth truth = deps_.bench.truth();
  const CameraStatus camera = deps_.camera.status();
  const BenchStatus bench = deps_.bench.status();
  const ScreenStatus screen = deps_.screen.status();

  Json result = json_of(deps_.bench.optics(), truth);
  if (truth.turbulence) {
    result["turbulence"]["t_ns"] = t_ns;
    result["turbulence"]["modes"] = turbulence(*truth.turbulence).modes(t_ns);
  }
  result["sent"] = json_of(deps_.bench.frame_truths(
      reader.has("sent_after") ? std::optional(sent_after) : std::nullopt));
  Json spots = Json::array();
  for (const Vec2& spot : deps_.bench.optics().true_spots_px(truth)) {
    spots.push_back({{"i", spots.size()},
                     {"x", spot.x - camera.settings.roi.x},
                     {"y", spot.y - camera.settings.roi.y}});
  }
  result["spots"] = std::move(spots);
  result["mirror"] =
      config_.mirror ? json_of(*config_.mirror, actuators_, truth.mirror_waves) : Json(nullptr);
  result["charge"] = config_.sensor.charge;
  result["camera"] = json_of(camera);
  result["frames"] = json_of(deps_.camera.tally(), deps_.frames.counts());
  result["display"] = {{"output", config_.slm.display},
                       {"shown", screen.shown},
                       {"text", screen.text},
                       {"grabs", screen.grabs},
                       {"connects", screen.connects}};
  result["bench"] = {{"changes", bench.changes},
                     {"far_fields", bench.far_fields},
                     {"far_field_ms", bench.far_field_ms}};
  if (reader.has("judge")) add_verdict(Pattern(pattern), truth, t_ns, result);
  result["fault"] = json_of(deps_.faults.active());
  return result;
}

RpcAnswer Methods::set(const Json& params) {
  Truth truth = deps_.bench.truth();
  ObjectReader reader(params, "");
  double photons = -1.0;
  read_aberration(reader, truth.aberration);
  read_shades(reader, truth);
  read_branch_points(reader, truth);
  read_sources(reader, truth);
  read_detector(reader, truth);
  read_noise(reader, truth);
  read_geometry(reader, truth.geometry);
  read_turbulence(reader, truth.turbulence);
  read_scintillation(reader, truth.scintillation);
  reader.number("peak_electrons", truth.peak_electrons, 0.0, 1e9);
  reader.number("photons", photons, 0.0, 1e15);
  if (reader.has("photons") && reader.has("peak_electrons")) {
    reader.fault("photons", "give either photons or peak_electrons, not both");
  }
  if (auto done = reader.finish(); !done) return failed(done.error());
  if (reader.has("photons"))
    truth.peak_electrons = deps_.bench.optics().peak_electrons_for(truth, photons);
  deps_.bench.set_truth(truth);
  const Json now = json_of(deps_.bench.optics(), truth);
  Json applied = Json::object();
  for (const auto& [key, value] : params.items()) applied[key] = now.at(key);
  return Json{{"requested", params}, {"applied", std::move(applied)}};
}

RpcAnswer Methods::mirror(const Json& params) {
  constexpr double kMaxWaves = 100.0;
  ObjectReader reader(params, "");
  std::vector<double> waves;
  reader.require("waves");
  reader.numbers("waves", waves, actuators_.size(), actuators_.size(), -kMaxWaves, kMaxWaves);
  if (actuators_.empty()) {
    return failed({Errc::refused, "mirror",
                   "the bench has no deformable mirror; set mirror in the twin's configuration"});
  }
  if (auto done = reader.finish(); !done) return failed(done.error());
  deps_.bench.set_mirror(waves);
  return Json{{"actuators", waves.size()}, {"t_ns", twin_ns()}};
}

RpcAnswer Methods::fault(const Json& params) {
  ObjectReader reader(params, "");
  Fault fault;
  int kind = 0;
  reader.require("kind");
  reader.choice("kind", kind, fault_names());
  reader.integer("frames", fault.frames, 1, 1'000'000);
  reader.number("seconds", fault.seconds, 0.001, 3600.0);
  reader.number("delay_ms", fault.delay_ms, 0.0, 1000.0);
  fault.kind = FaultKind(kind);
  const bool timed_only = fault.kind == FaultKind::freeze || fault.kind == FaultKind::unplug ||
                          fault.kind == FaultKind::slow_registers;
  if (fault.kind != FaultKind::none && reader.has("frames") == reader.has("seconds")) {
    reader.fault("seconds", "give either seconds or frames");
  }
  if (timed_only && reader.has("frames")) reader.fault("frames", "give seconds for this fault");
  if (reader.has("delay_ms") != takes_delay(fault.kind)) {
    reader.fault("delay_ms",
                 "must be given for the faults delay and slow_registers, and only for them");
  }
  if (auto done = reader.finish(); !done) return failed(done.error());
  deps_.faults.order(fault);
  return json_of(deps_.faults.active());
}

}  // namespace ovws::twin
