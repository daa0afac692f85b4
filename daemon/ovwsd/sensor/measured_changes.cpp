/// Sensor changes that activate or delete measured data: references, calibrations, LUTs and so on.
#include <algorithm>
#include <memory>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/branch_check.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"

namespace ovws {
namespace {

constexpr double kSameMap = 7.0;  // residuals. Noise makes 0.2 % of the maps differ by more.

Result<void> check_epoch(const SensorEdit& edit, std::uint64_t sensor_epoch) {
  if (edit.state.sensor_epoch == sensor_epoch) return {};
  return fail(Errc::refused, "camera",
              "the camera, its region or its pixel format changed during the job; start it again");
}

/// The present bench, with the tracking settings that the measurement depends on, and the
/// provenance record of a measurement made on it. `grey`: the hologram shown; null: none is
/// recorded.
BenchKey key_of(const SensorEdit& edit) {
  return key_of(edit.state, edit.knowledge, edit.bench.optics);
}
std::shared_ptr<const nlohmann::json> origin_of(const SensorEdit& edit, const BenchKey& key,
                                                const std::vector<Mode>& shown,
                                                const Image<std::uint8_t>* grey,
                                                std::vector<Mode> introduced = {}) {
  return std::make_shared<const nlohmann::json>(
      make_origin({key, shown, edit.bench.camera, registration_of(edit.state, edit.bench.optics),
                   grey, std::move(introduced)}));
}

template <class T>
std::vector<std::string> names_of(const Shared<T>& all) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(ItemOf<T>::name(*one));
  return names;
}

/// Schedules writing the item to its file, and removing the files of `replaced`.
template <class T>
void schedule_write(SensorEdit& edit, std::shared_ptr<const T> item,
                    const Shared<T>& replaced = {}) {
  std::vector<std::string> names = names_of(replaced);
  std::erase(names, ItemOf<T>::name(*item));  // this file is overwritten, not removed
  edit.stored = [item = std::move(item), names = std::move(names)] {
    Library::Item stored = item_of(*item);
    stored.replaces = names;
    return stored;
  };
}

/// A new reference whose spot positions are still empty.
Reference new_reference(const SensorEdit& edit, ReferenceSource source) {
  const SensorState& state = edit.state;
  const bool measured = source == ReferenceSource::measured;
  Reference reference;
  reference.key = key_of(edit);
  reference.key.tracking = position_tracking(state.tracking);
  reference.source = source;
  reference.t_taken_ns = utc_ns();
  reference.registration = registration_of(state, edit.bench.optics);
  if (measured) reference.aberration = shown_modes(state);
  if (measured && rms_waves(state.aberration) > 0.0) reference.introduced = state.aberration;
  reference.origin = origin_of(edit, reference.key, reference.aberration,
                               measured ? edit.bench.levels.get() : nullptr, reference.introduced);
  return reference;
}

/// Makes a reference or a calibration active, in place of those that it replaces.
template <class T>
void keep(SensorEdit& edit, T measured) {
  const auto replaced = remove_items<T>(edit.knowledge, edit.state, edit.bench.optics);
  const auto item = std::make_shared<const T>(std::move(measured));
  add_items<T>(edit.knowledge, {item});
  schedule_write(edit, item, replaced);
}

/// Deletes the references or the calibrations that apply.
template <class T>
Result<void> forget(SensorEdit& edit) {
  const auto items = remove_items<T>(edit.knowledge, edit.state, edit.bench.optics);
  edit.removed = {&ItemOf<T>::kKind, names_of(items), [items](SensorEdit& now) {
                    const std::vector<std::string> present = names_of(now.knowledge.*kLoaded<T>);
                    Shared<T> missing = items;
                    std::erase_if(missing, [&](const auto& one) {
                      return std::ranges::find(present, ItemOf<T>::name(*one)) != present.end();
                    });
                    add_items(now.knowledge, missing);
                  }};
  return {};
}

/// The member for the LUT or for the flatness.
template <class T>
using SlmPart = std::shared_ptr<const T> ActiveSlm::*;

/// Switches the SLM to another LUT or flatness, which changes all holograms. Does nothing if it is
/// already active.
template <class T>
void switch_slm(SensorEdit& edit, SlmPart<T> part, std::shared_ptr<const T> item) {
  ActiveSlm next = *edit.state.slm;
  if (next.*part == item) return;
  next.*part = std::move(item);
  edit.state.slm = active_slm(edit.bench.config, edit.bench.hologram, next.lut, next.flatness);
}

/// Makes a measured LUT or flatness active.
template <class T>
Result<void> use_slm(SensorEdit& edit, SlmPart<T> part, T measured) {
  measured.key = key_of(edit);
  measured.key.tracking = position_tracking(measured.key.tracking);
  measured.origin = origin_of(edit, measured.key, shown_modes(edit.state), nullptr);
  const auto item = std::make_shared<const T>(std::move(measured));
  switch_slm(edit, part, item);
  schedule_write(edit, item);
  return {};
}

/// Deletes the LUT or the flatness.
template <class T>
Result<void> forget_slm(SensorEdit& edit, SlmPart<T> part) {
  const auto before = edit.state.slm;
  switch_slm(edit, part, {});
  edit.files_only = edit.state.slm == before;
  edit.removed = {&ItemOf<T>::kKind, {ItemOf<T>::name({})}, [part, before](SensorEdit& now) {
                    if (!((*now.state.slm).*part)) switch_slm(now, part, (*before).*part);
                  }};
  return {};
}

/// Whether the registration in use is of the present camera and settings.
bool is_of_this_bench(const SensorEdit& edit) {
  using namespace respect;
  const auto& now = edit.state.registration;
  return now && differing(kRegistration | kRegistrationSettings, now->key, key_of(edit)) == 0;
}

/// Keeps the present lenslets, and the pupil about them, if the same are found again on the same
/// bench: references stay in use. A lattice alone does not tell: it looks the same after a quarter
/// turn. False: they are others.
bool keep_if_alike(Registration& found, const SensorEdit& edit) {
  if (edit.state.sensor.lenslets.empty() && found.array.empty()) return true;
  if (!is_of_this_bench(edit)) return false;
  const FoundArray& now = edit.state.registration->array;
  const auto shift = shift_if_same(now, found.array);
  if (!shift) return false;
  const int lit = found.array.lit;
  found.array = now;
  found.array.lit = lit;
  found.px_per_cycle = edit.state.registration->px_per_cycle;
  found.base_px = found.base_px - found.px_per_cycle.seen(*shift);  // of the pupil that stays
  return true;
}

/// Whether the map found is the present one: spots are expected within its noise of where they are
/// expected now. A present map with more noise is replaced.
bool is_same_map(const Registration& found, const SensorEdit& edit) {
  if (!is_of_this_bench(edit)) return false;
  const BenchKey now = key_of(edit);
  BenchKey next = now;
  use_map(next, rebased(found, base_grating_cpp(now.sensor, edit.bench.optics.slm)),
          edit.bench.optics.optics, edit.bench.optics.slm);
  const auto [farthest_px, lambda_d_px] = displacement(next, now);
  return farthest_px <= std::min(kSameMap * found.residual_px, kPositionTolerance * lambda_d_px);
}

/// Keeps plates that array.fit has measured, if they were seen in the same direction.
void keep_fitted_plate(Registration& found, const SensorState& state) {
  if (!state.registration || !state.registration->array.plate_fitted) return;
  const PxPerCycle now = state.registration->px_per_cycle.scaled_to(1.0),
                   next = found.px_per_cycle.scaled_to(1.0);
  if (norm({now.xx - next.xx, now.yx - next.yx}) > 1e-3 ||
      norm({now.xy - next.xy, now.yy - next.yy}) > 1e-3) {
    return;
  }
  found.array.plate_fitted = true;
  found.array.lenslets.plate = state.registration->array.lenslets.plate;
}

void keep_registration(SensorEdit& edit, const MeasuredRegistration& registration) {
  edit.state.registration = registration;
  schedule_write(edit, std::make_shared<const MeasuredRegistration>(registration));
}

/// The same for another map than the present one.
void use_new_registration(SensorEdit& edit, const MeasuredRegistration& registration) {
  registration.array.use_in(edit.state.sensor);
  if (edit.before_job) registration.array.use_in(edit.before_job->sensor);
  ++edit.state.sensor_epoch;  // previous spot positions are useless as start points
  keep_registration(edit, registration);
}

/// Checks that a client's positions lie in the region, and in the order of the lattice.
Result<void> check_given(const SpotAverage& given, const std::vector<Vec2>& model, const Roi& roi) {
  for (std::size_t i = 0; i < given.mean_px.size(); ++i) {
    const Vec2 at = given.mean_px[i];
    if (given.found[i] == 0) continue;
    if (at.x >= 0.0 && at.y >= 0.0 && at.x < roi.width && at.y < roi.height) continue;
    return fail(Errc::invalid, "positions",
                fmt::format("spot {} is at ({:.1f}, {:.1f}), outside of the region of interest", i,
                            at.x, at.y));
  }
  return check_order(given, model);
}

/// Adds the spots to a reference, with places for those that were lost. `modes`: those to be
/// measured; null: the model's. Errors: those of judge_spots and check_branch_points.
Result<ReferenceSpots> use_spots(const SensorEdit& edit, const SpotAverage& spots,
                                 const ModeOperator* modes, Reference& reference) {
  const SensorState& state = edit.state;
  const BenchOptics& optics = edit.bench.optics;
  auto judged = judge_spots(
      spots, modes != nullptr
                 ? *modes
                 : slope_operator(state.renderer->lattice(), state.sensor, state.tracking,
                                  px_per_cycle(optics_of(state, optics), optics.slm)));
  if (!judged) return judged;
  if (auto smooth = check_branch_points(spots, state, optics); !smooth) {
    return fail(smooth.error());
  }
  reference.frames = spots.frames;
  reference.positions_px = spots.mean_px;
  reference.standard_error_px = spots.standard_error_px;
  place_lost(judged->lost, model_positions(state, optics), reference);
  return judged;
}

/// The same for spots that were averaged on the bench. Errors: also those of check_average.
Result<ReferenceSpots> use_average(const SensorEdit& edit, const Bound& bound,
                                   const SpotAverage& average, Reference& reference) {
  const double lambda_d_px = lambda_d_of(edit.state, edit.bench.optics);
  if (auto still = check_average(average, kMaxMotion * lambda_d_px); !still) {
    return fail(still.error());
  }
  return use_spots(edit, average, bound.mode_operator.get(), reference);
}

/// The reference with the main source's part: as taken, or the present one.
Result<Reference> main_reference(const SensorEdit& edit, const Bound& bound,
                                 const TakenReference& taken, std::vector<ReferenceSpots>& spots) {
  if (!taken.only.empty() && taken.only != kMainBeam) {
    if (bound.reference && bound.reference->source == ReferenceSource::measured) {
      return *bound.reference;
    }
    return fail(Errc::refused, "beam",
                "the main source has no measured reference: take that first, without \"beam\"");
  }
  Reference reference = new_reference(edit, ReferenceSource::measured);
  reference.picture = taken.picture;
  auto judged = use_average(edit, bound, taken.average, reference);
  if (!judged) return fail(judged.error());
  spots.push_back(std::move(*judged));
  return reference;
}

/// Replaces the parts of the further sources in `reference` by the taken ones; those that were not
/// taken are the present ones.
Result<void> add_beams(const SensorEdit& edit, const Bound& bound, const TakenReference& taken,
                       std::vector<ReferenceSpots>& spots, Reference& reference) {
  const std::vector<BeamConfig>& configured = edit.bench.optics.beams;
  std::vector<BeamReference> beams;
  for (std::size_t k = 0; k < configured.size(); ++k) {
    const auto& [name, offset_px] = configured[k];
    if (taken.only.empty() || taken.only == name) {
      Reference own = new_reference(edit, ReferenceSource::measured);
      auto used = use_average(edit, bound, taken.beams.at(k), own);
      if (!used) {
        return fail(used.error().code, used.error().field,
                    "of the source " + name + ": " + used.error().reason);
      }
      spots.push_back(std::move(*used));
      beams.push_back({static_cast<SourceReference&>(own), name, offset_px});
    } else if (bound.reference) {
      for (const BeamReference& one : bound.reference->beams) {
        if (one.beam == name && one.offset_px == offset_px) beams.push_back(one);
      }
    }
  }
  reference.beams = std::move(beams);
  return {};
}

}  // namespace

SensorChange use_reference(std::uint64_t sensor_epoch, TakenReference taken,
                           std::shared_ptr<std::vector<ReferenceSpots>> spots) {
  return [sensor_epoch, taken = std::move(taken),
          spots = std::move(spots)](SensorEdit& edit) -> Result<void> {
    if (auto same = check_epoch(edit, sensor_epoch); !same) return same;
    if (auto found = check_array_found(edit.state); !found) return found;
    if (edit.bench.camera && !(*edit.bench.camera == taken.settings)) {
      return fail(Errc::refused, "camera",
                  "the camera's settings changed during the job; start it again");
    }
    const Bound bound = bind(edit.state, edit.knowledge, edit.bench.optics);
    auto reference = main_reference(edit, bound, taken, *spots);
    if (!reference) return fail(reference.error());
    if (auto added = add_beams(edit, bound, taken, *spots, *reference); !added) return added;
    keep(edit, std::move(*reference));
    return {};
  };
}

SensorChange use_model_reference() {
  return [](SensorEdit& edit) -> Result<void> {
    if (auto found = check_array_found(edit.state); !found) return found;
    Reference model = new_reference(edit, ReferenceSource::model);
    model.positions_px = model_positions(edit.state, edit.bench.optics);
    model.standard_error_px.assign(model.positions_px.size(), Vec2{});
    keep(edit, std::move(model));
    return {};
  };
}

SensorChange use_given_reference(SpotAverage given) {
  return [given = std::move(given)](SensorEdit& edit) -> Result<void> {
    if (auto found = check_array_found(edit.state); !found) return found;
    if (edit.state.tracking.tracker == TrackerKind::fit) {
      return fail(Errc::refused, "tracker",
                  "the tracker fit needs the image of a reference, and positions are not one: "
                  "choose a tracker of positions with sensor.set, such as lg");
    }
    const std::vector<Vec2> model = model_positions(edit.state, edit.bench.optics);
    if (given.mean_px.size() != model.size()) {
      return fail(Errc::invalid, "positions",
                  fmt::format("the binary frame holds {} spots, but the sensor has {}: send 2 x N "
                              "x 2 float32",
                              given.mean_px.size(), model.size()));
    }
    if (auto right = check_given(given, model, edit.state.roi); !right) return right;
    Reference reference = new_reference(edit, ReferenceSource::measured);
    const auto judged = use_spots(edit, given, nullptr, reference);
    if (!judged) return fail(judged.error().code, "positions", judged.error().reason);
    if (const auto before = bind(edit.state, edit.knowledge, edit.bench.optics).reference) {
      reference.beams = before->beams;
    }
    keep(edit, std::move(reference));
    return {};
  };
}

SensorChange use_saved_reference(Reference reference) {
  return [reference = std::move(reference)](SensorEdit& edit) -> Result<void> {
    std::string why = unused_reason(reference, edit.state, edit.knowledge, edit.bench.optics, true);
    if (why.empty()) {
      why = drawing_obstacle(*reference.origin, reference.key, reference.positions_px.size(),
                             edit.state.slm->hologram, edit.bench.config.sensor.masks);
    }
    if (!why.empty()) {
      return fail(Errc::refused, "name", "the reference does not fit the present sensor: " + why);
    }
    keep(edit, reference);
    return {};
  };
}

SensorChange forget_reference() {
  return forget<Reference>;
}

SensorChange use_registration(Registration registration) {
  return [registration](SensorEdit& edit) mutable -> Result<void> {
    const bool alike = keep_if_alike(registration, edit);
    if (alike && is_same_map(registration, edit)) {
      MeasuredRegistration confirmed = *edit.state.registration;
      confirmed.t_taken_ns = registration.t_taken_ns;
      confirmed.array.lit = registration.array.lit;
      confirmed.sights = registration.sights;
      keep_registration(edit, confirmed);
      return {};
    }
    keep_fitted_plate(registration, edit.state);
    use_new_registration(edit, {registration, key_of(edit)});
    return {};
  };
}

SensorChange use_plate(std::uint64_t sensor_epoch, const SpiralPlate& plate) {
  return [sensor_epoch, plate](SensorEdit& edit) -> Result<void> {
    if (auto same = check_epoch(edit, sensor_epoch); !same) return same;
    if (!edit.state.registration) return fail(Errc::refused, "", "the registration was cleared");
    MeasuredRegistration registration = *edit.state.registration;
    registration.array.plate_fitted = true;
    registration.array.lenslets.plate = plate;
    use_new_registration(edit, registration);
    return {};
  };
}

SensorChange forget_registration() {
  return [](SensorEdit& edit) -> Result<void> {
    const auto put_back = [before = edit.state.registration](SensorEdit& now) {
      if (!before || now.state.registration) return;
      now.state.registration = before;
      before->array.use_in(now.state.sensor);
      ++now.state.sensor_epoch;
    };
    edit.removed = {&kRegistrationItems, {ItemOf<MeasuredRegistration>::name({})}, put_back};
    drop_registration(edit.state, edit.bench.config.sensor);
    return {};
  };
}

SensorChange use_calibration(std::uint64_t sensor_epoch, MeasuredCalibration measured) {
  return [sensor_epoch, measured = std::move(measured)](SensorEdit& edit) -> Result<void> {
    if (auto same = check_epoch(edit, sensor_epoch); !same) return same;
    Calibration calibration{measured, key_of(edit), {}, nullptr};
    calibration.key.tracking = calibrated_tracking(edit.state.tracking);
    calibration.mode_operator = mode_operator_of(calibration);
    calibration.origin =
        origin_of(edit, calibration.key, shown_modes(edit.state), edit.bench.levels.get());
    keep(edit, std::move(calibration));
    const bool stays = edit.before_job && edit.before_job->sensor == edit.state.sensor &&
                       edit.before_job->tracking == edit.state.tracking;
    edit.state.tracking.mode_operator = OperatorKind::measured;
    if (stays) edit.before_job->tracking.mode_operator = OperatorKind::measured;
    return {};
  };
}

SensorChange forget_calibration() {
  return forget<Calibration>;
}

SensorChange use_lut(MeasuredLut lut) {
  return [lut = std::move(lut)](SensorEdit& edit) { return use_slm(edit, &ActiveSlm::lut, lut); };
}

SensorChange use_flatness(std::uint64_t sensor_epoch, MeasuredFlatness flatness) {
  return [sensor_epoch, flatness = std::move(flatness)](SensorEdit& edit) -> Result<void> {
    if (auto same = check_epoch(edit, sensor_epoch); !same) return same;
    return use_slm(edit, &ActiveSlm::flatness, flatness);
  };
}

SensorChange forget_lut() {
  return [](SensorEdit& edit) { return forget_slm(edit, &ActiveSlm::lut); };
}

SensorChange forget_flatness() {
  return [](SensorEdit& edit) { return forget_slm(edit, &ActiveSlm::flatness); };
}

}  // namespace ovws
