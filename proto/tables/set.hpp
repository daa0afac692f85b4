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
  CameraSettings applied;              ///< every setting as read back
  std::optional<CameraLimits> limits;  ///< none: no camera is connected; applied when one connects
};
template <>
struct Table<CameraSetReport> {
  using R = CameraSetReport;
  static constexpr const char* kName = "CameraSetReport";
  static constexpr auto kFields =
      Fields{field("requested", &R::requested, kRequestedMeaning),
             field("applied", &R::applied, "the camera's settings"),
             field("limits", &R::limits, "current limits of the connected camera")};
};

struct SensorSetReport {
  SensorSet requested;
  SensorSettings applied;
  std::uint64_t hologram_id = 0;
};
template <>
struct Table<SensorSetReport> {
  using R = SensorSetReport;
  static constexpr const char* kName = "SensorSetReport";
  static constexpr auto kFields = Fields{field("requested", &R::requested, kRequestedMeaning),
                                         field("applied", &R::applied, kAppliedMeaning),
                                         field("hologram_id", &R::hologram_id, kHologramIdMeaning)};
};

struct RefineSetReport {
  RefineSet requested;
  RefineReport applied;
};
template <>
struct Table<RefineSetReport> {
  using R = RefineSetReport;
  static constexpr const char* kName = "RefineSetReport";
  static constexpr auto kFields = Fields{field("requested", &R::requested, kRequestedMeaning),
                                         field("applied", &R::applied, kAppliedMeaning)};
};

}  // namespace ovws
