/// Field table of the params of `slm.set`.
#pragma once

#include <optional>
#include <string>

#include "proto/tables/devices.hpp"

namespace ovws {

inline std::optional<std::string> no_output_name(const std::optional<std::string>& name) {
  return name ? no_device_name(*name) : std::nullopt;
}

/// Params of `slm.set`; what is not given stays unchanged.
struct SlmChange {
  std::optional<std::string> display;
  std::optional<bool> allow_primary;
  std::optional<double> settle_ms;
};
template <>
inline constexpr auto kTable<SlmChange> = Fields{
    "SlmChange",
    field<&SlmChange::display>("name of the output that drives the SLM; null: unchanged")
        .checked(no_output_name),
    field<&SlmChange::allow_primary>(
        "whether the only or primary output may drive the SLM; null: unchanged"),
    field<&SlmChange::settle_ms>("settle time after a new hologram, milliseconds; null: unchanged",
                                 limits::kSettleMs)};

}  // namespace ovws
