#include "daemon/ovwsd/slm/slm_measured.hpp"

#include <span>

#include "core/optics/flatness.hpp"
#include "daemon/shared/encoding.hpp"

namespace ovws {

nlohmann::json flatness_sha256(const HologramConfig& hologram) {
  if (!hologram.flatness_waves) return nullptr;
  return sha256_of(std::span<const float>(hologram.flatness_waves->pixels));
}

nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut) {
  nlohmann::json slm{{"width", hologram.slm.width_px},
                     {"height", hologram.slm.height_px},
                     {"pitch_um", hologram.slm.pitch_um},
                     {"lut_sha256", nullptr},
                     {"flatness_sha256", flatness_sha256(hologram)}};
  if (has_lut) slm["lut_sha256"] = sha256_of(std::span<const std::uint8_t>(hologram.lut));
  return slm;
}

std::shared_ptr<const SlmInForce> slm_in_force(const Config& config,
                                               const HologramConfig& configured,
                                               std::shared_ptr<const MeasuredLut> lut,
                                               std::shared_ptr<const MeasuredFlatness> flatness) {
  auto slm = std::make_shared<SlmInForce>();
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
