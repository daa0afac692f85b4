/// JSON encoding of the twin's results.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/fake_camera.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/judge.hpp"
#include "drivers/twin/optical_model.hpp"
#include "drivers/twin/twin_config.hpp"
#include "proto/rpc.hpp"

namespace ovws::twin {

const std::vector<std::string>& fault_names();  ///< names of FaultKind, in its order

/// Ground truth as JSON: the keys of twin.set with their current values.
Json json_of(const OpticalModel& optics, const Truth& truth);
Json json_of(const Fault& fault);
/// The mirror with the positions (pupil radii) and commands of its actuators.
Json json_of(const MirrorConfig& mirror, const std::vector<Vec2>& actuators,
             const std::vector<double>& waves);
Json json_of(const CameraStatus& camera);
Json json_of(const FrameTally& tally, const FrameCounts& frames);
Json json_of(const std::vector<FrameTruth>& frames);
Json json_of(const std::optional<Verdict>& verdict);
Json waves_of(const std::vector<Mode>& modes);  ///< array of the coefficients, waves

}  // namespace ovws::twin
