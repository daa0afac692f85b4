/// Stored measurements: which of them the sensor uses, at the start and with another LUT.
#include <spdlog/fmt/fmt.h>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {
namespace {

template <class T>
std::shared_ptr<const T> newest(const Shared<T>& all) {
  return all.empty() ? nullptr : all.back();
}

std::size_t spots_of(const Reference& reference) {
  return reference.positions_px.size();
}
std::size_t spots_of(const Calibration& calibration) {
  return std::size_t(calibration.matrix.spots());
}

/// Why the measurement cannot be used with this LUT and flatness, with which it was made.
template <class T>
std::string drawing_obstacle(const T& one, const ActiveSlm& slm, const Config& config) {
  return drawing_obstacle(*one.origin, one.key, spots_of(one), slm.hologram, config.sensor.masks);
}

void complete(Reference&, const SensorBench&) {}
/// Compares a calibration's matrix with the model, which its file does not hold.
void complete(Calibration& calibration, const SensorBench& bench) {
  const BenchKey& key = calibration.key;
  const SlmGeometry& slm = bench.config.slm.geometry;
  const auto lattice = make_lattice(key.sensor, slm);
  if (!lattice) return;
  ModeOperator model = slope_operator(*lattice, key.sensor, key.tracking, key.px_per_cycle);
  if (calibration.shapes) {
    auto made = displacement_operator(key.sensor, slm, optics_of(key, bench.config.optics), key.roi,
                                      calibration.shapes->lit(), model.modes_j);
    if (made) model = std::move(*made);
  }
  calibration.comparison = compare(calibration.matrix, model);
}

/// Judges stored items of one type by the bench as it is now, in the respects that do not change
/// while the daemon runs, and by LUT and flatness.
template <class T>
std::function<Judgement(T&)> judge(const BenchKey& now, const SensorState& state,
                                   const SensorBench& bench) {
  return [&](T& one) -> Judgement {
    constexpr respect::Set kStored = respect::kFixed | respect::kLevels;
    const respect::Set differ = differing(respects_of(one) & kStored, one.key, now);
    const std::string why = words_of(differ, one.key, now);
    one.drawn_alike = differ == 0;
    if (!one.drawn_alike) return {why, (differ & respect::kFixed) == 0};
    complete(one, bench);
    return {drawing_obstacle(one, *state.slm, bench.config)};
  };
}
template <class T>
std::function<Judgement(T&)> judge(respect::Set respects, const BenchKey& now) {
  return [respects, &now](T& one) -> Judgement {
    const respect::Set differ = differing(respects & respect::kFixed, one.key, now);
    return {words_of(differ, one.key, now)};
  };
}

/// Checks those that have waited for this LUT and flatness: each is used from now on, or dropped.
/// Whether there were any.
template <class T>
bool use_waiting(Shared<T>& all, const BenchKey& now, const ActiveSlm& slm,
                 const SensorBench& bench) {
  bool found = false;
  for (std::shared_ptr<const T>& one : all) {
    const bool waits = !one->drawn_alike;
    if (!waits || differing(respects_of(*one) & respect::kLevels, one->key, now) != 0) continue;
    auto checked = std::make_shared<T>(*one);
    checked->drawn_alike = true;
    complete(*checked, bench);
    const std::string obstacle = drawing_obstacle(*checked, slm, bench.config);
    bench.library.publish_loaded(ItemOf<T>::kKind, ItemOf<T>::name(*one), one->t_taken_ns,
                                 obstacle);
    found = true;
    one = obstacle.empty() ? std::move(checked) : nullptr;
  }
  std::erase(all, nullptr);
  return found;
}

/// Warns if plates that array.fit has measured, in `kept`, are not used.
void warn_of_plates(const FoundArray& kept, const FoundArray& used, Events& events) {
  if (!kept.plate_fitted || used.plate_fitted || used.empty()) return;
  events.emit("registration", Severity::warning,
              fmt::format("the plates that array.fit measured are not used: array.plate.levels was "
                          "{}, and is {}; run array.fit again",
                          kept.lenslets.plate.levels, used.lenslets.plate.levels),
              {{"used", false}});
}

}  // namespace

/// Loads LUT, flatness and registration.
void SensorKeeper::load_slm(SensorState& state) {
  Library& library = bench_.library;
  state.slm = active_slm(bench_.config, bench_.hologram, nullptr, nullptr);
  const BenchKey now = key_of(state, {}, bench_.optics);
  const auto lut = newest(load_items(library, judge<MeasuredLut>(respect::kLut, now)));
  const auto flatness =
      newest(load_items(library, judge<MeasuredFlatness>(respect::kFlatness, now)));
  state.slm = active_slm(bench_.config, bench_.hologram, lut, flatness);
  const auto kept =
      newest(load_items(library, judge<MeasuredRegistration>(respect::kRegistration, now)));
  if (!kept) return;
  state.registration = array_by(bench_.config, *kept);
  state.registration->array.use_in(state.sensor);
  warn_of_plates(kept->array, state.registration->array, deps_.events);
}

void SensorKeeper::load_measured(SensorEdit& edit) {
  const BenchKey now = key_of(edit.state, edit.knowledge, bench_.optics);
  add_items(edit.knowledge, load_items(bench_.library, judge<Reference>(now, edit.state, bench_)));
  add_items(edit.knowledge,
            load_items(bench_.library, judge<Calibration>(now, edit.state, bench_)));
}

/// Uses the references and calibrations that have waited for this LUT and flatness. Whether there
/// are any.
bool SensorKeeper::use_waiting(SensorEdit& edit) {
  const BenchKey now = key_of(edit.state, edit.knowledge, bench_.optics);
  const ActiveSlm& slm = *edit.state.slm;
  const bool references = ovws::use_waiting(edit.knowledge.references, now, slm, bench_);
  return ovws::use_waiting(edit.knowledge.calibrations, now, slm, bench_) || references;
}

}  // namespace ovws
