#include "daemon/ovwsd/sensor/knowledge.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/sensor/calibration_file.hpp"
#include "daemon/ovwsd/sensor/reference_file.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxImages = 8;  // mean images kept in memory: some MiB each
constexpr std::size_t kMaxCalibrations = 16;

template <class T>
void sort_by_age(std::vector<std::shared_ptr<const T>>& all) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a->t_taken_ns < b->t_taken_ns; });
}

template <class T, class Belongs>
std::vector<std::shared_ptr<const T>> take_if(std::vector<std::shared_ptr<const T>>& all,
                                              const Belongs& belongs) {
  std::vector<std::shared_ptr<const T>> taken;
  std::erase_if(all, [&](const auto& one) {
    if (!belongs(*one)) return false;
    taken.push_back(one);
    return true;
  });
  return taken;
}

void limit_images(Knowledge& knowledge) {
  auto& all = knowledge.references;
  for (std::size_t i = 0; i + kMaxImages < all.size(); ++i) {
    if (!all[i]->picture) continue;
    auto without = std::make_shared<Reference>(*all[i]);
    without->picture.reset();
    all[i] = std::move(without);
  }
}

/// Why a reference with another key cannot be used; empty: its sensor or tracking is another by
/// choice. A camera's region and the lenslets of an array may change without being chosen.
std::string other_key_reason(const ReferenceKey& then, const ReferenceKey& now) {
  const bool array = !then.sensor.lenslets.empty() && !now.sensor.lenslets.empty();
  if (!(then.tracking == now.tracking)) return {};
  if (!array && !(then.sensor == now.sensor)) return {};
  if (then.roi == now.roi) return "the lenslets have been measured elsewhere since it was taken";
  const Roi& roi = then.roi;
  return fmt::format(
      "it was taken with another region of the camera (x {}, y {}, width {}, height {})", roi.x,
      roi.y, roi.width, roi.height);
}

/// Whether the SLM's LUT and flatness are those of the reference. A model reference does not depend
/// on them, because its positions are computed.
bool has_same_slm(const Reference& reference, const SensorState& state) {
  return reference.source == ReferenceSource::model ||
         (*reference.origin)["slm"] == state.slm->identity;
}

/// Whether the reference's registration and the active registration predict equal spot positions,
/// within kPositionTolerance. Trackers start at the predicted positions.
bool predicts_same_positions(const Reference& reference, const SensorState& state,
                             const BenchOptics& bench) {
  if (reference.source == ReferenceSource::model) return true;
  if (!reference.registration && !state.registration) return true;
  SensorState then = state;
  then.registration.reset();
  if (reference.registration) {
    then.registration = MeasuredRegistration{*reference.registration, {}, ""};
    // The registration counts from the base grating of the reference's sensor. The state has the
    // same sensor (is_for).
    then.registration->base_cpp = base_grating_cpp(state.sensor, bench.slm);
  }
  return farthest_px(then, state, bench) <= kPositionTolerance * lambda_d_of(state, bench);
}

/// The latest reference that applies to the state. While the camera is unknown, references of any
/// camera apply.
std::shared_ptr<const Reference> find_reference(const SensorState& state,
                                                const Knowledge& knowledge,
                                                const BenchOptics& bench) {
  if (!check_array_found(state)) return nullptr;
  const auto& all = knowledge.references;
  const auto found = std::find_if(all.rbegin(), all.rend(), [&](const auto& one) {
    return is_for(*one, state, knowledge) && predicts_same_positions(*one, state, bench);
  });
  if (found == all.rend()) return nullptr;
  if ((*found)->source != ReferenceSource::model) return *found;
  // Compute the positions again: a newer registration may have moved the model's spots.
  auto model = std::make_shared<Reference>(**found);
  model->positions_px = model_positions(state, bench);
  return model;
}

}  // namespace

ReferenceKey reference_key(const SensorState& state) {
  return reference_key(state.sensor, state.tracking, state.roi);
}

CalibrationKey calibration_key(const SensorState& state, const Knowledge& knowledge,
                               const BenchOptics& bench) {
  CalibrationKey key =
      calibration_key(calibrated_sensor(state.sensor, state.tracking, state.roi), bench.optics,
                      bench.slm, registration_of(state, bench), camera_json(knowledge.camera));
  key.slm = state.slm->identity;
  return key;
}

std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench) {
  const CalibrationKey key = calibration_key(state, knowledge, bench);
  const auto& all = knowledge.calibrations;
  const auto found = std::find_if(all.rbegin(), all.rend(), [&](const auto& one) {
    return differences(one->key, key).empty();
  });
  return found == all.rend() ? nullptr : *found;
}

Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench) {
  Bound bound;
  bound.reference = find_reference(state, knowledge, bench);
  bound.calibration = calibration_for(state, knowledge, bench);
  if (state.tracking.mode_operator == OperatorKind::measured) {
    if (bound.calibration) {
      bound.mode_operator = {bound.calibration, &bound.calibration->mode_operator};
    } else {
      bound.operator_reason =
          missing_calibration_reason(state, knowledge, bench) + ": run calibration.run";
    }
  }
  if (state.tracking.mode_operator == OperatorKind::diffractive) {
    const auto made = knowledge.diffractive->of(
        operator_key(state.sensor, state.tracking, optics_of(state, bench), state.roi), bench.slm);
    if (*made) {
      bound.mode_operator = {made, &**made};
    } else {
      bound.operator_reason = made->error().reason;
    }
  }
  return bound;
}

bool is_for(const Reference& reference, const SensorState& state, const Knowledge& knowledge) {
  return reference.key == reference_key(state) && !of_other_camera(reference, knowledge.camera) &&
         has_same_slm(reference, state);
}

std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench) {
  if (!(reference.key == reference_key(state)))
    return other_key_reason(reference.key, reference_key(state));
  if (auto found = check_array_found(state); !found) return found.error().reason;
  if (of_other_camera(reference, knowledge.camera)) return "it was taken with another camera";
  if (!has_same_slm(reference, state)) {
    return "it was taken with another look-up table or flatness";
  }
  if (!predicts_same_positions(reference, state, bench)) {
    return "the expected spot positions have changed since it was taken";
  }
  return {};
}

std::string missing_reference_reason(const SensorState& state, const Knowledge& knowledge,
                                     const BenchOptics& bench) {
  const auto& all = knowledge.references;
  for (auto one = all.rbegin(); one != all.rend(); ++one) {
    const std::string why = unused_reason(**one, state, knowledge, bench);
    if (!why.empty()) return title_of<ReferenceKind>(**one) + " is not used: " + why;
  }
  return {};
}

std::string missing_calibration_reason(const SensorState& state, const Knowledge& knowledge,
                                       const BenchOptics& bench) {
  const CalibrationKey key = calibration_key(state, knowledge, bench);
  const Calibration* closest = nullptr;
  std::vector<std::string> closest_differences;
  for (const auto& candidate : knowledge.calibrations) {
    std::vector<std::string> other = differences(candidate->key, key);
    if (closest != nullptr && other.size() > closest_differences.size()) continue;
    closest = candidate.get();
    closest_differences = std::move(other);
  }
  if (closest == nullptr) return "there is no calibration";
  return fmt::format("{} was measured with another {}", title_of<CalibrationKind>(*closest),
                     fmt::join(closest_differences, ", "));
}

std::vector<std::shared_ptr<const Reference>> remove_references(Knowledge& knowledge,
                                                                const SensorState& state) {
  return take_if(knowledge.references,
                 [&](const Reference& one) { return is_for(one, state, knowledge); });
}

std::vector<std::shared_ptr<const Reference>> replace_reference(Knowledge& knowledge,
                                                                const SensorState& state,
                                                                Reference reference) {
  auto replaced = remove_references(knowledge, state);
  knowledge.references.push_back(std::make_shared<const Reference>(std::move(reference)));
  limit_images(knowledge);
  return replaced;
}

void add_references(Knowledge& knowledge, std::vector<std::shared_ptr<const Reference>> more) {
  auto& all = knowledge.references;
  all.insert(all.end(), more.begin(), more.end());
  sort_by_age(all);
  limit_images(knowledge);
}

std::vector<std::shared_ptr<const Calibration>> remove_calibrations(Knowledge& knowledge,
                                                                    const CalibrationKey& key) {
  return take_if(knowledge.calibrations,
                 [&](const Calibration& one) { return differences(one.key, key).empty(); });
}

std::vector<std::shared_ptr<const Calibration>> replace_calibration(Knowledge& knowledge,
                                                                    Calibration calibration) {
  auto replaced = remove_calibrations(knowledge, calibration.key);
  auto& all = knowledge.calibrations;
  all.push_back(std::make_shared<const Calibration>(std::move(calibration)));
  if (all.size() > kMaxCalibrations) all.erase(all.begin());
  return replaced;
}

void add_calibrations(Knowledge& knowledge, std::vector<std::shared_ptr<const Calibration>> more) {
  auto& all = knowledge.calibrations;
  all.insert(all.end(), more.begin(), more.end());
  sort_by_age(all);
}

}  // namespace ovws
