#include "daemon/examine/commission/report.hpp"

#include <array>
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
          {"picture", step.picture.empty() ? json() : json(step.picture)}};
}

}  // namespace

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
