/// The procedure of `experiment.gain_sweep`, and the bench settings that its results depend on.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/procedures/experiment_archive.hpp"

namespace ovws {

/// Field `bench` of experiment.get: all settings that the sweep itself does not change. `optics`:
/// the configured optics.
nlohmann::json sweep_bench(const SensorSnapshot& sensor, const CameraSnapshot& camera,
                           nlohmann::json optics);

/// Compares the bench settings `before` with `now`. Errc::refused: settings have changed; the
/// message names them. A disconnected camera counts as unchanged.
Result<void> check_same_bench(const nlohmann::json& before, const nlohmann::json& now);

/// Measures the missing references and cells of `run` and stores them in the archive: first the
/// reference of each arm, without an aberration, then the cells. Modes are reconstructed with the
/// tracker's slopes. A run that already has references continues only if the spots have not moved
/// since one of the references was taken (check_unmoved). Errors: those of Bench, of show_request
/// and of the camera; Errc::refused: the bench has changed, a reference is saturated, or its spots
/// are lost or have moved.
Result<void> measure_gain_sweep(Bench& bench, const SlmGeometry& slm, const ExperimentRun& run,
                                ExperimentArchive& archive);

}  // namespace ovws
