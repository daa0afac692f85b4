/// Field tables of an external corrector: a deformable mirror that a client drives.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/tables/modes.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

inline constexpr const char* kCorrectorMatrixMeaning =
    "number of the matrix: it increases with each corrector.set since the daemon's start";

/// Params of `corrector.set`; the matrix itself is the request's binary frame.
struct CorrectorSet {
  std::vector<int> shape;  ///< actuators, modes
};
template <>
inline constexpr auto kTable<CorrectorSet> =
    Fields{"CorrectorSet", field<&CorrectorSet::shape>(
                               "[actuators, modes] of the matrix: at most 4096 actuators, and the "
                               "modes that the sensor measures, modes_j of sensor.get",
                               limits::kActuators)
                               .sized(2, 2)
                               .mandatory()};

/// Result of `corrector.set`, `corrector.get` and `corrector.clear`.
struct KnownCorrector {
  std::optional<int> matrix, actuators;
  std::vector<int> modes_j;
  std::optional<std::int64_t> t_set_ns;
  std::string reason;  ///< why no commands are published; empty: they are
};
template <>
inline constexpr auto kTable<KnownCorrector> = Fields{
    "KnownCorrector",
    computed(
        "active", [](auto& known) { return known.reason.empty(); },
        "whether valid frames give commands: there is a matrix, and the sensor measures its modes"),
    computed(
        "reason", [](auto& known) { return known.reason; },
        "why frames give no commands, and what to do; null: they do")
        .or_null(),
    field<&KnownCorrector::matrix>(kCorrectorMatrixMeaning, Bounds::at_least(1)),
    field<&KnownCorrector::actuators>("number of actuators", limits::kActuators),
    field<&KnownCorrector::modes_j>("OSA/ANSI indices of the matrix's columns; empty: no matrix",
                                    {1, kMaxZernikeIndex}),
    field<&KnownCorrector::t_set_ns>("when the matrix was set, ns since the UNIX epoch, UTC")};

}  // namespace ovws
