/// Field tables of prepared lattices: sensors that are measured once and then used by name.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "proto/tables/files.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

constexpr std::size_t kMaxLattices = 8;  ///< each has a reference, of which 16 are stored

/// One lattice that `lattice.prepare` shall measure.
struct LatticeRequest {
  std::string name;
  SensorSet sensor;  ///< change of the sensor in use

  static Result<LatticeRequest> decode(const Json& object) {
    LatticeRequest request;
    ObjectReader reader(object, "");
    reader.require("name");
    reader.string("name", request.name);
    const Json* const change = reader.raw("sensor");
    if (!reader.failed()) {
      if (auto wrong = no_reference_name(request.name)) reader.fault("name", std::move(*wrong));
    }
    if (auto done = reader.finish(); !done) return fail(done.error());
    if (change == nullptr) return request;
    auto sensor = SensorSet::decode(*change);
    if (!sensor) {
      Error error = sensor.error();
      error.field = error.field.empty() ? "sensor" : "sensor." + error.field;
      return fail(std::move(error));
    }
    request.sensor = std::move(*sensor);
    return request;
  }
};
template <>
inline constexpr auto kTable<LatticeRequest> = Fields{
    "LatticeRequest",
    field<&LatticeRequest::name>("name: 1 to 64 small letters, digits, _ and -").mandatory(),
    field<&LatticeRequest::sensor>("keys of sensor.set: how it differs from the sensor in use")};

/// Params of `lattice.prepare`.
struct LatticePrepare {
  std::vector<LatticeRequest> lattices;
  int frames = 100;
  bool calibrate = false;
  bool find_exposure = true;
};
template <>
inline constexpr auto kTable<LatticePrepare> = Fields{
    "LatticePrepare",
    field<&LatticePrepare::lattices>("the lattices, each with its own name")
        .sized(1, kMaxLattices)
        .mandatory(),
    field<&LatticePrepare::frames>("number of frames to average for each reference",
                                   limits::kReferenceFrames),
    field<&LatticePrepare::calibrate>("true: measure the calibration of each, too, and use it"),
    field<&LatticePrepare::find_exposure>(
        "true: find the exposure of each as camera.auto_exposure; false: the present one")};

/// Params of `lattice.use` and `lattice.remove`.
struct LatticeName {
  std::string name;
};
template <>
inline constexpr auto kTable<LatticeName> =
    Fields{"LatticeName", field<&LatticeName::name>("name: 1 to 64 small letters, digits, _ and -")
                              .checked(no_reference_name)
                              .mandatory()};

/// What `lattice.use` restores. The state store keeps it.
struct PreparedLattice {
  std::string name;
  SensorSettings settings;
  double exposure_us = 0.0, gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  int subapertures = 0;
  std::int64_t t_prepared_ns = 0;
};
template <>
inline constexpr auto kTable<PreparedLattice> = Fields{
    "PreparedLattice",
    field<&PreparedLattice::name>("its name"),
    field("sensor", &PreparedLattice::settings, "settings of sensor and tracking"),
    field<&PreparedLattice::exposure_us>("exposure time, microseconds"),
    field<&PreparedLattice::gain_db>("gain, dB; null: the camera has no gain in dB").or_null(),
    field<&PreparedLattice::gain_raw>("gain in the camera's own steps, or null").or_null(),
    field<&PreparedLattice::subapertures>("number of subapertures", {0, kMaxSubapertures}),
    field<&PreparedLattice::t_prepared_ns>(kTimeMeaning)};

struct LatticeReport {
  PreparedLattice lattice;
  bool in_use = false, calibrated = false;
  std::string reason;  ///< why lattice.use would refuse it now; empty: it would not
};
template <>
inline constexpr auto kTable<LatticeReport> =
    Fields{"LatticeReport",
           inlined(&LatticeReport::lattice),
           computed(
               "t_prepared", [](const auto& one) { return utc_text(one.lattice.t_prepared_ns); },
               kTimeTextMeaning),
           field<&LatticeReport::in_use>("whether the sensor has these settings now"),
           field<&LatticeReport::calibrated>("whether a calibration applies to it"),
           computed(
               "usable", [](const auto& one) { return one.reason.empty(); },
               "whether lattice.use would accept it now"),
           field<&LatticeReport::reason>("why not; null: it is usable").or_null()};

/// Result of `lattice.list` and `lattice.remove`.
struct LatticeList {
  std::vector<LatticeReport> lattices;
};
template <>
inline constexpr auto kTable<LatticeList> =
    Fields{"LatticeList", field<&LatticeList::lattices>("the prepared lattices, by name")};

/// Result of `lattice.use`.
struct LatticeInUse {
  std::string name;
  int subapertures = 0;
  double exposure_us = 0.0;
  std::uint64_t hologram_id = 0;
};
template <>
inline constexpr auto kTable<LatticeInUse> =
    Fields{"LatticeInUse", field<&LatticeInUse::name>("name of the lattice in use"),
           field<&LatticeInUse::subapertures>("number of subapertures", Bounds::at_least(0)),
           field<&LatticeInUse::exposure_us>("exposure time in use, microseconds"),
           field<&LatticeInUse::hologram_id>(kHologramIdMeaning)};

}  // namespace ovws
