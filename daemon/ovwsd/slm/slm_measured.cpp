#include "daemon/ovwsd/slm/slm_measured.hpp"

#include <span>

#include "core/optics/flatness.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/origin.hpp"

namespace ovws {

nlohmann::json flatness_sha256(const HologramConfig& hologram) {
  if (!hologram.flatness_waves) return nullptr;
  return sha256_of(std::span<const float>(hologram.flatness_waves->pixels));
}

nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut) {
  SlmIdentity slm{hologram.slm, std::nullopt, std::nullopt};
  if (has_lut) slm.lut_sha256 = sha256_of(std::span<const std::uint8_t>(hologram.lut));
  if (const auto sum = flatness_sha256(hologram); !sum.is_null()) slm.flatness_sha256 = sum;
  return to_json(slm);
}

std::shared_ptr<const ActiveSlm> active_slm(const Config& config, const HologramConfig& configured,
                                            std::shared_ptr<const MeasuredLut> lut,
                                            std::shared_ptr<const MeasuredFlatness> flatness) {
  auto slm = std::make_shared<ActiveSlm>();
  slm->hologram = configured;
  if (lut) slm->hologram.lut = lut->table.lut;
  if (flatness)
    slm->hologram.flatness_waves =
        flattened(configured, flatness->modes, flatness->pupil_diameter_px);
  slm->identity = slm_identity(slm->hologram, lut || config.slm.lut);
  slm->lut = std::move(lut);
  slm->flatness = std::move(flatness);
  return slm;
}

}  // namespace ovws
