#include "daemon/examine/commission/commissioning.hpp"

#include <algorithm>

#include "daemon/examine/commission/conductor.hpp"
#include "drivers/png/grey_png.hpp"
#include "proto/reader.hpp"

namespace ovws::commission {
namespace {

Error unknown(const char* field, std::string_view name, const std::vector<std::string>& known) {
  const auto near = nearest_name(name, known);
  std::string all;
  for (const std::string& one : known) all += (all.empty() ? "" : ", ") + one;
  return {Errc::invalid, field,
          "there is no " + std::string(name) +
              (near ? "; did you mean " + *near + "?" : ": give one of " + all)};
}

Result<const Step*> step_of(std::string_view name) {
  const auto all = steps();
  const auto found = std::ranges::find_if(all, [&](const Step& s) { return name == s.name; });
  if (found == all.end()) return fail(unknown("step", name, step_names()));
  return &*found;
}

}  // namespace

struct Commissioning::Impl {
  Conductor conductor;
};

Commissioning::Commissioning(Settings settings) : impl_(new Impl{Conductor(std::move(settings))}) {}
Commissioning::~Commissioning() = default;

Report Commissioning::report() const {
  return impl_->conductor.report();
}

Result<void> Commissioning::look() {
  return impl_->conductor.look();
}

Result<void> Commissioning::run(std::string_view name) {
  const auto step = step_of(name);
  return step ? impl_->conductor.run(**step) : fail(step.error());
}

Result<void> Commissioning::skip(std::string_view name) {
  const auto step = step_of(name);
  return step ? impl_->conductor.skip(**step) : fail(step.error());
}

Result<void> Commissioning::undo(std::string_view name) {
  const auto step = step_of(name);
  return step ? impl_->conductor.undo(**step) : fail(step.error());
}

Result<void> Commissioning::take(std::string_view name, std::string_view offer) {
  const auto step = step_of(name);
  if (!step) return fail(step.error());
  std::vector<std::string> known;
  for (const Way& way : impl_->conductor.ways(**step)) {
    if (way.offer.name == offer) return impl_->conductor.take(**step, way);
    known.push_back(way.offer.name);
  }
  if (!known.empty()) return fail(unknown("offer", offer, known));
  return fail(Errc::refused, "offer", std::string(name) + " offers nothing at present");
}

void Commissioning::cancel() {
  impl_->conductor.cancel();
}

Result<void> Commissioning::act(std::string_view action, std::string_view step,
                                std::string_view offer) {
  if (action == "run") return run(step);
  if (action == "skip") return skip(step);
  if (action == "undo") return undo(step);
  if (action == "offer") return take(step, offer);
  if (action == "look") return look();
  if (action != "cancel") {
    return fail(unknown("action", action, {"run", "skip", "undo", "offer", "cancel", "look"}));
  }
  cancel();
  return {};
}

Image<std::uint8_t> Commissioning::picture(std::string_view name) const {
  const auto step = step_of(name);
  return step ? impl_->conductor.picture(**step) : Image<std::uint8_t>();
}

Result<std::string> Commissioning::picture_png(std::string_view name) const {
  const auto image = picture(name);
  if (image.width > 0) return encode_grey8_png(image);
  return fail(Errc::unavailable, "step", std::string(name) + " has no picture");
}

const StepReport* next_step(const Report& report) {
  const auto found = std::ranges::find_if(report.steps, [](const StepReport& step) {
    return step.state == State::open || step.state == State::failed;
  });
  return found == report.steps.end() ? nullptr : &*found;
}

std::vector<std::string> step_names() {
  std::vector<std::string> names;
  for (const Step& step : steps()) names.emplace_back(step.name);
  return names;
}

}  // namespace ovws::commission
