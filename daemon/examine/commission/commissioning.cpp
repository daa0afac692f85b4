#include "daemon/examine/commission/commissioning.hpp"

#include <algorithm>
#include <exception>

#include "daemon/examine/commission/drawing.hpp"
#include "drivers/png/grey_png.hpp"
#include "proto/reader.hpp"

namespace ovws::commission {
namespace {

Outcome unexpected(const std::exception& error) {
  return failed(std::string("a reply of the daemon has an unknown format: ") + error.what(),
                "Check that ovws and ovwsd have the same version.");
}

/// Runs `act`, and turns an unexpected reply of the daemon into a failed outcome.
template <class Act>
Outcome guarded(const Act& act) {
  try {
    return act();
  } catch (const StepFailed& failure) {
    return failed(failure.error);
  } catch (const std::exception& error) {
    return unexpected(error);
  }
}

/// The camera's image as it is; empty: none came.
Image<std::uint8_t> present_picture(Bench& bench) {
  return guarded([&] {
           Outcome outcome;
           outcome.picture = grey_of(bench.image());
           return outcome;
         })
      .picture;
}

/// Whether the step's result is in use; none also if the daemon's replies have an unknown format.
std::optional<bool> is_done(const Step& step, const Look& seen) try {
  return step.is_done(seen);
} catch (const std::exception&) {
  return std::nullopt;
}

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

Commissioning::Commissioning(Settings settings)
    : settings_(std::move(settings)),
      running_(Running{"", 0.0, "looking"}),
      records_(steps().size()),
      worker_([this] { work(); }) {}

Commissioning::~Commissioning() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  cancelled_ = true;
  wake_.notify_all();
  worker_.join();
}

void Commissioning::work() {
  look_now();
  for (;;) {
    std::function<void()> action;
    {
      std::unique_lock lock(mutex_);
      running_.reset();
      wake_.wait(lock, [&] { return ending_ || next_; });
      if (ending_) return;
      action = std::exchange(next_, nullptr);
    }
    action();
    look_now();
  }
}

Result<void> Commissioning::begin(const Step* step, std::string text,
                                  std::function<void()> action) {
  {
    const std::lock_guard lock(mutex_);
    if (running_) {
      return fail(Errc::refused, "step",
                  "wait until " + (running_->step.empty() ? "the look" : running_->step) +
                      " has ended, or cancel it");
    }
    running_ = Running{step == nullptr ? "" : step->name, 0.0, std::move(text)};
    next_ = [this, step, action = std::move(action)] {
      try {
        action();
      } catch (const std::exception& error) {
        if (step != nullptr) keep(*step, unexpected(error));
      }
    };
    cancelled_ = false;
  }
  wake_.notify_all();
  return {};
}

Result<void> Commissioning::act(std::string_view action, std::string_view name,
                                std::string_view offer) {
  const std::vector<std::string> known{"run", "skip", "undo", "offer", "cancel", "look"};
  if (std::ranges::find(known, action) == known.end()) {
    return fail(unknown("action", action, known));
  }
  if (action == "look") return begin(nullptr, "looking", [] {});
  if (action == "cancel") {
    cancel();
    return {};
  }
  const auto found = step_of(name);
  if (!found) return fail(found.error());
  const Step& step = **found;
  if (action == "run") return begin(&step, step.title, [this, &step] { run_now(step); });
  if (action == "skip") {
    return begin(&step, "skipping", [this, &step] {
      const std::lock_guard lock(mutex_);
      record(step).skipped = true;
      record(step).last.offers.clear();
    });
  }
  if (action == "undo") {
    std::unique_lock lock(mutex_);
    const bool can = can_undo(step);
    lock.unlock();
    if (can) return begin(&step, "undoing", [this, &step] { undo_now(step); });
    return fail(Errc::refused, "step", std::string(name) + " has nothing to undo");
  }
  return take(step, offer);
}

Result<void> Commissioning::take(const Step& step, std::string_view name) {
  std::unique_lock lock(mutex_);
  const std::vector<Offer> offers = record(step).last.offers;
  lock.unlock();
  std::vector<std::string> known;
  for (const Offer& offer : offers) {
    if (offer.name == name) {
      return begin(&step, offer.text, [this, &step, offer] { take_now(step, offer); });
    }
    known.push_back(offer.name);
  }
  if (!known.empty()) return fail(unknown("offer", name, known));
  return fail(Errc::refused, "offer", std::string(step.name) + " offers nothing at present");
}

void Commissioning::cancel() {
  const std::lock_guard lock(mutex_);
  if (running_) cancelled_ = true;
}

Bench Commissioning::bench() {
  return {settings_, cancelled_, [this](double done, const std::string& text) {
            const std::lock_guard lock(mutex_);
            if (!running_) return;
            running_->progress = done;
            running_->text = text;
          }};
}

void Commissioning::look_now() try {
  const auto methods = looked_at();
  auto results = cli::call_all(settings_.daemon, methods);
  Look found;
  for (std::size_t k = 0; results && k < methods.size(); ++k) {
    found[methods[k]] = std::move((*results)[k]);
  }
  const std::lock_guard lock(mutex_);
  seen_ = std::move(found);
} catch (const std::exception&) {
  // A reply of unknown format: what was seen before stays.
}

/// Keeps what an action of the step found.
void Commissioning::keep(const Step& step, Outcome outcome) {
  const std::lock_guard lock(mutex_);
  Record& kept = record(step);
  kept.skipped = false;
  kept.failed = !outcome.passed;
  kept.is_judged = true;
  const bool is_pictured = outcome.picture.width > 0;
  if (is_pictured) ++kept.pictures;
  if (!is_pictured) outcome.picture = std::move(kept.last.picture);
  kept.last = std::move(outcome);
}

void Commissioning::run_now(const Step& step) {
  Memory memory;
  {
    const std::lock_guard lock(mutex_);
    running_ = Running{step.name, 0.0, step.title};
    memory = record(step).memory;
  }
  Bench on = bench();
  Outcome outcome = guarded([&] { return step.run(on, memory); });
  if (!on.not_restored().empty()) {
    outcome.passed = false;
    outcome.verdict.severity = Severity::bad;
    outcome.verdict.text += " Afterwards " + on.not_restored() + ".";
  }
  if (outcome.picture.width == 0 && !cancelled_) outcome.picture = present_picture(on);
  keep(step, std::move(outcome));
  const std::lock_guard lock(mutex_);
  record(step).memory = std::move(memory);
}

void Commissioning::take_now(const Step& step, const Offer& offer) {
  {
    const std::lock_guard lock(mutex_);
    record(step).memory.tried.insert(offer.name);
  }
  Bench on = bench();
  for (const auto& [method, params] : offer.calls) {
    if (const auto done = on.try_call(method, params); !done) {
      return keep(step, failed(done.error()));
    }
  }
  if (offer.after == After::stay) return;
  if (offer.after == After::conclude) {
    return keep(step, passed(offer.text + ": done."));
  }
  if (!offer.first.empty()) {
    run_now(
        *std::ranges::find_if(steps(), [&](const Step& one) { return offer.first == one.name; }));
  }
  if (!cancelled_) run_now(step);
}

void Commissioning::undo_now(const Step& step) {
  Memory memory;
  {
    const std::lock_guard lock(mutex_);
    memory = record(step).memory;
  }
  Bench on = bench();
  Outcome outcome = guarded([&] { return undone(on, step, memory); });
  const bool undone = outcome.passed;
  keep(step, std::move(outcome));
  if (!undone) return;
  const std::lock_guard lock(mutex_);
  record(step).last.passed = false;
  record(step).memory = {};
}

State Commissioning::state_of(const Step& step) const {
  const Record& kept = record(step);
  if (kept.skipped) return State::skipped;
  if (kept.failed) return State::failed;
  if (!needless(step, seen_).empty()) return State::skipped;
  const auto done = seen_.empty() ? std::optional(false) : is_done(step, seen_);
  return done.value_or(kept.last.passed) ? State::done : State::open;
}

bool Commissioning::can_undo(const Step& step) const {
  const Record& kept = record(step);
  const bool is_measured = !seen_.empty() && is_done(step, seen_) == true;
  return kept.memory.undo || (step.clear != nullptr && (is_measured || kept.last.passed));
}

StepReport Commissioning::report_of(const Step& step) const {
  const Record& kept = record(step);
  StepReport report{step, state_of(step)};
  report.is_recorded = report.state != State::open || seen_.empty() || kept.is_judged ||
                       is_done(step, seen_).has_value();
  if (kept.is_judged) report.verdict = kept.last.verdict;
  if (const auto why = needless(step, seen_); !report.verdict && !why.empty()) {
    report.verdict = examine::note("Not needed: " + why, "");
  }
  report.commands = kept.last.commands;
  report.can_undo = can_undo(step);
  report.offers = kept.last.offers;
  if (kept.pictures > 0) {
    report.picture = std::string(step.name) + "-" + std::to_string(kept.pictures);
  }
  return report;
}

Report Commissioning::report() const {
  const std::lock_guard lock(mutex_);
  Report report{running_, {}};
  for (const Step& step : steps()) report.steps.push_back(report_of(step));
  return report;
}

Image<std::uint8_t> Commissioning::picture(std::string_view name) const {
  const auto step = step_of(name);
  if (!step) return {};
  const std::lock_guard lock(mutex_);
  return record(**step).last.picture;
}

Result<std::string> Commissioning::picture_png(std::string_view name) const {
  const auto image = picture(name);
  if (image.width > 0) return encode_grey8_png(image);
  return fail(Errc::unavailable, "step", std::string(name) + " has no picture");
}

std::vector<std::string> step_names() {
  std::vector<std::string> names;
  for (const Step& step : steps()) names.emplace_back(step.name);
  return names;
}

}  // namespace ovws::commission
