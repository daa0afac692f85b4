/// What was measured of the SLM, as files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "config/config.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// The look-up table of an SLM of this size and pitch at this wavelength. See Kept.
struct LutKind {
  using Item = MeasuredLut;
  static constexpr const char *kKind = "lut", *kEvent = "slm";
  Config config;

  std::string title(const Item& lut) const;
  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& lut) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& lut) const;
  bool needs_other_slm(const Item&) const { return false; }
  bool fits_slm(const Item&) const { return false; }
};

/// Its flatness, of the same optics, and added to the same file's map. See Kept.
struct FlatnessKind {
  using Item = MeasuredFlatness;
  static constexpr const char *kKind = "flatness", *kEvent = "slm";
  Config config;
  nlohmann::json configured_sha256;  ///< of the file's map; null: there is none

  std::string title(const Item& flatness) const;
  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& flatness) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& flatness) const;
  bool needs_other_slm(const Item&) const { return false; }
  bool fits_slm(const Item&) const { return false; }
};

}  // namespace ovws
