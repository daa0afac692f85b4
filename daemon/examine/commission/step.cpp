#include "daemon/examine/commission/step.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace ovws::commission {
namespace {

using nlohmann::json;

json json_of(const StepReport& step) {
  json offers = json::array();
  for (const Offer& offer : step.offers) {
    offers.push_back({{"name", offer.name}, {"text", offer.text}});
  }
  json verdict;
  if (step.verdict) {
    verdict = {{"wellness", examine::names_of(step.verdict->severity).name},
               {"text", step.verdict->text},
               {"advice", step.verdict->advice}};
  }
  return {{"name", step.name},
          {"title", step.title},
          {"purpose", step.purpose},
          {"state", name_of(step.state)},
          {"verdict", std::move(verdict)},
          {"offers", std::move(offers)},
          {"can_undo", step.can_undo},
          {"picture", text_or_null(step.picture)}};
}

}  // namespace

std::vector<std::string> looked_at() {
  return {"system.status",  "config.get",     "lut.get",       "registration.get", "flatness.get",
          "aberration.get", "correction.get", "reference.get", "calibration.get",  "loop.get"};
}

bool is_fixed_array(const json& config) {
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

bool is_true(const Look& look, const char* method, const char* key) {
  return look.at(method).at(key) == true;
}

bool has_measured_reference(const Look& look) {
  const json& reference = look.at("reference.get");
  return reference.at("taken") == true && reference.at("source") != "model";
}

std::optional<bool> done_if(bool must) {
  return must ? std::optional(true) : std::nullopt;
}

Outcome undone(Bench& bench, const Step& step, const Memory& memory) {
  Undo undo = memory.undo.value_or(Undo{});
  if (!memory.undo) undo = {{}, {{step.clear, json::object()}}, step.cleared};
  cli::Borrow parts(bench.settings().daemon, undo.parts, bench.restoring());
  if (!parts.restore()) return failed(bench.not_restored());
  for (const auto& [method, params] : undo.calls) {
    bench.call(method, params);
  }
  auto outcome = passed(undo.text);
  outcome.verdict.severity = Severity::note;
  return outcome;
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

Outcome failed(std::string text, std::string advice, std::vector<Offer> offers) {
  return {false, advised(Severity::bad, std::move(text), std::move(advice)), std::move(offers)};
}

Outcome failed(const Error& error, std::string advice, std::vector<Offer> offers) {
  return failed(text_of(error), std::move(advice), std::move(offers));
}

Outcome passed(std::string text) {
  return {true, examine::good(std::move(text))};
}

std::vector<Offer> other_first(const Memory& memory, const char* step, const char* text) {
  if (memory.tried.contains(step)) return {};
  return {{step, text, {}, step}};
}

const char* name_of(State state) {
  constexpr std::array kNames{"open", "done", "skipped", "failed"};
  return kNames[std::size_t(state)];
}

json to_json(const Report& report) {
  json running;
  if (report.running) {
    running = {{"step", report.running->step},
               {"progress", report.running->progress},
               {"text", report.running->text}};
  }
  json steps = json::array();
  for (const StepReport& step : report.steps) steps.push_back(json_of(step));
  return {{"schema", "ovws.commission/1"},
          {"running", std::move(running)},
          {"steps", std::move(steps)}};
}

}  // namespace ovws::commission
