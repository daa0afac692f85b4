/// Results of the `….set` methods: the requested and the applied values.
#pragma once

#include <cstdint>
#include <optional>

#include "proto/tables/camera.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/refine.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

inline constexpr const char* kRequestedMeaning = "the requested values";
inline constexpr const char* kAppliedMeaning = "the values now in use";

struct CameraSetReport {
  CameraSet requested;
  CameraSettings applied;              ///< every setting as read back from the camera
  std::optional<CameraLimits> limits;  ///< none: no camera is connected; applied when one connects
};
template <>
inline constexpr auto kTable<CameraSetReport> =
    Fields{"CameraSetReport", field<&CameraSetReport::requested>(kRequestedMeaning),
           field<&CameraSetReport::applied>("the camera's settings"),
           field<&CameraSetReport::limits>("current limits of the connected camera")};

struct SensorSetReport {
  SensorSet requested;
  SensorSettings applied;
  std::uint64_t hologram_id = 0;
};
template <>
inline constexpr auto kTable<SensorSetReport> =
    Fields{"SensorSetReport", field<&SensorSetReport::requested>(kRequestedMeaning),
           field<&SensorSetReport::applied>(kAppliedMeaning),
           field<&SensorSetReport::hologram_id>(kHologramIdMeaning)};

struct RefineSetReport {
  RefineSet requested;
  RefineReport applied;
};
template <>
inline constexpr auto kTable<RefineSetReport> =
    Fields{"RefineSetReport", field<&RefineSetReport::requested>(kRequestedMeaning),
           field<&RefineSetReport::applied>(kAppliedMeaning)};

}  // namespace ovws
