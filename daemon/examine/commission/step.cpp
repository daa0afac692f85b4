#include "daemon/examine/commission/step.hpp"

#include <algorithm>
#include <iterator>

namespace ovws::commission {

std::vector<std::string> looked_at() {
  return {"system.status",  "config.get",     "lut.get",       "registration.get", "flatness.get",
          "aberration.get", "correction.get", "reference.get", "calibration.get",  "loop.get"};
}

bool is_fixed_array(const nlohmann::json& config) {
  return config.value("modulator", "slm") == "fixed";
}

std::string needless(const Step& step, const Look& look) {
  const auto found = look.find("config.get");
  if (step.needs == Needs::light || found == look.end()) return "";
  if (is_fixed_array(found->second)) return "A fixed array of lenslets shows no hologram.";
  const bool has_two_levels = found->second.value("modulator", "slm") == "dmd";
  return step.needs == Needs::phase && has_two_levels
             ? "A DMD has two levels, so there is no look-up table."
             : "";
}

bool has_measured_reference(const Look& look) {
  const nlohmann::json& reference = look.at("reference.get");
  return reference.at("taken") == true && reference.at("source") != "model";
}

Outcome undone(Bench& bench, const Step& step, const Memory& memory) {
  Undo undo = memory.undo.value_or(Undo{});
  if (!memory.undo) undo = {{}, {{step.clear, nlohmann::json::object()}}, step.cleared};
  cli::Borrow parts(bench.settings().daemon, undo.parts, bench.restoring());
  if (!parts.restore()) return failed({Errc::refused, "", bench.not_restored()});
  for (const auto& [method, params] : undo.calls) {
    bench.call(method, params);
  }
  return passed(Severity::note, undo.text);
}

std::span<const Step> steps() {
  static const std::vector<Step> all = [] {
    std::vector<Step> made;
    for (const auto part : {device_steps(), light_steps(), slm_steps(),
                            std::span(&brightness_step(), 1), sensor_steps()}) {
      std::ranges::copy(part, std::back_inserter(made));
    }
    return made;
  }();
  return all;
}

Outcome failed(const Error& error, std::string advice) {
  Outcome outcome;
  outcome.verdict = advised(Severity::bad, text_of(error), std::move(advice));
  return outcome;
}

Outcome passed(Severity severity, std::string text, std::string advice) {
  Outcome outcome;
  outcome.passed = true;
  outcome.verdict = advised(severity, std::move(text), std::move(advice));
  return outcome;
}

}  // namespace ovws::commission
