/// Stored measurements of the SLM: its look-up table (LUT) and its flatness, as kinds of Kept.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "config/config.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// A measured LUT. It can be used with an SLM of the same size and pitch at the same wavelength.
struct LutKind {
  using Item = MeasuredLut;
  static constexpr const char *kKind = "lut", *kEvent = "slm", *kMethod = "lut.run";
  Config config;

  std::string title(const Item& lut) const;
  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& lut) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& lut) const;
  bool needs_other_slm(const Item&) const { return false; }
  bool fits_slm(const Item&) const { return false; }
};

/// A measured flatness. It can be used with the same SLM and optics, and with the same configured
/// flatness map, to which it is added.
struct FlatnessKind {
  using Item = MeasuredFlatness;
  static constexpr const char *kKind = "flatness", *kEvent = "slm", *kMethod = "flatness.run";
  Config config;
  nlohmann::json configured_sha256;  ///< of the map of slm.flatness; null: there is none

  std::string title(const Item& flatness) const;
  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& flatness) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& flatness) const;
  bool needs_other_slm(const Item&) const { return false; }
  bool fits_slm(const Item&) const { return false; }
};

}  // namespace ovws
