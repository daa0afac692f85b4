#include "daemon/ovwsd/sensor/knowledge.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bitset>

namespace ovws {
namespace {

constexpr std::size_t kMaxImages = 8;  // mean images kept in memory: some MiB each

/// The newest that applies; null: none does.
template <class T>
std::shared_ptr<const T> newest_for(const Shared<T>& all, const BenchKey& now) {
  const auto found = std::find_if(all.rbegin(), all.rend(), [&](const auto& one) {
    return one->drawn_alike && differing(respects_of(*one), one->key, now) == 0;
  });
  return found == all.rend() ? nullptr : *found;
}

/// While the camera is unknown, references of any camera apply.
std::shared_ptr<const Reference> reference_for(const SensorState& state, const BenchKey& now,
                                               const Knowledge& knowledge,
                                               const BenchOptics& bench) {
  if (!check_array_found(state)) return nullptr;
  auto found = newest_for(knowledge.references, now);
  if (!found || found->source != ReferenceSource::model) return found;
  // Compute the positions again: a newer registration may have moved the model's spots.
  auto model = std::make_shared<Reference>(*found);
  model->positions_px = model_positions(state, bench);
  return model;
}

void drop_old_images(Shared<Calibration>&) {}
void drop_old_images(Shared<Reference>& all) {
  for (std::size_t i = 0; i + kMaxImages < all.size(); ++i) {
    if (!all[i]->picture) continue;
    auto without = std::make_shared<Reference>(*all[i]);
    without->picture.reset();
    all[i] = std::move(without);
  }
}

}  // namespace

BenchKey key_of(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench) {
  BenchKey key{state.sensor,
               state.tracking,
               state.roi,
               to_json(bench.optics),
               state.slm->identity,
               camera_json(knowledge.camera),
               bench.flatness_file,
               bench.array,
               {},
               {}};
  use_map(key, registration_of(state, bench), bench.optics, bench.slm);
  return key;
}

std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench) {
  return newest_for(knowledge.calibrations, key_of(state, knowledge, bench));
}

Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench) {
  const BenchKey now = key_of(state, knowledge, bench);
  Bound bound;
  bound.reference = reference_for(state, now, knowledge, bench);
  bound.calibration = newest_for(knowledge.calibrations, now);
  if (state.tracking.mode_operator == OperatorKind::measured) {
    if (bound.calibration) {
      bound.mode_operator = {bound.calibration, &bound.calibration->mode_operator};
    } else {
      bound.operator_reason =
          missing_calibration_reason(state, knowledge, bench) + ": run calibration.run";
    }
  }
  return bound;
}

TemplatesKey templates_key(const SensorState& state, const Bound& bound) {
  const bool shapes = bound.mode_operator && bound.mode_operator->shapes && bound.calibration;
  return {state.sensor_epoch, bound.reference ? bound.reference->t_taken_ns : 0,
          shapes ? bound.calibration->t_taken_ns : 0};
}

std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench, bool by_choice) {
  const BenchKey now = key_of(state, knowledge, bench);
  const respect::Set differ = differing(respects_of(reference), reference.key, now);
  if (!by_choice && is_by_choice(differ, reference.key, now)) return {};
  if (auto found = check_array_found(state); !found) return found.error().reason;
  return words_of(differ, reference.key, now);
}

std::string missing_reference_reason(const SensorState& state, const Knowledge& knowledge,
                                     const BenchOptics& bench) {
  const auto& all = knowledge.references;
  for (auto one = all.rbegin(); one != all.rend(); ++one) {
    const std::string why = unused_reason(**one, state, knowledge, bench, false);
    if (!why.empty()) {
      return title_of(kReferenceItems, (*one)->t_taken_ns) + " is not used: " + why;
    }
  }
  return {};
}

std::string missing_calibration_reason(const SensorState& state, const Knowledge& knowledge,
                                       const BenchOptics& bench) {
  const BenchKey now = key_of(state, knowledge, bench);
  const Calibration* closest = nullptr;
  respect::Set fewest = 0;
  const auto count = [](respect::Set set) { return std::bitset<32>(set).count(); };
  for (const auto& one : knowledge.calibrations) {
    const respect::Set differ = differing(respect::kCalibration, one->key, now);
    if (closest != nullptr && count(differ) > count(fewest)) continue;
    closest = one.get();
    fewest = differ;
  }
  if (closest == nullptr) return "there is no calibration";
  return fmt::format("{} is not used: {}", title_of(kCalibrationItems, closest->t_taken_ns),
                     words_of(fewest, closest->key, now));
}

template <class T>
void add_items(Knowledge& knowledge, const Shared<T>& more) {
  Shared<T>& all = knowledge.*kLoaded<T>;
  all.insert(all.end(), more.begin(), more.end());
  while (all.size() > ItemOf<T>::kKind.most) all.erase(all.begin());
  drop_old_images(all);
}
template void add_items(Knowledge&, const Shared<Reference>&);
template void add_items(Knowledge&, const Shared<Calibration>&);

template <class T>
Shared<T> remove_items(Knowledge& knowledge, const SensorState& state, const BenchOptics& bench) {
  const BenchKey now = key_of(state, knowledge, bench);
  Shared<T> removed;
  std::erase_if(knowledge.*kLoaded<T>, [&](const auto& one) {
    if (differing(respects_of(*one) & ~respect::kPlaces, one->key, now) != 0) return false;
    removed.push_back(one);
    return true;
  });
  return removed;
}
template Shared<Reference> remove_items(Knowledge&, const SensorState&, const BenchOptics&);
template Shared<Calibration> remove_items(Knowledge&, const SensorState&, const BenchOptics&);

}  // namespace ovws
