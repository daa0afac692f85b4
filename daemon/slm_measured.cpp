#include "daemon/slm_measured.hpp"

#include <span>

#include "core/optics/circle_columns.hpp"
#include "core/optics/wavefront_rows.hpp"
#include "daemon/store/encoding.hpp"

namespace ovws {
namespace {

/// The map with the error taken out.
std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              const MeasuredFlatness& measured) {
  const SlmGeometry& slm = configured.slm;
  auto map = configured.flatness_waves
                 ? std::make_shared<Image<float>>(*configured.flatness_waves)
                 : std::make_shared<Image<float>>(slm.width_px, slm.height_px);
  const Vec2 centre{0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
  const WavefrontRows error(measured.modes, centre, measured.pupil_diameter_px);
  std::vector<double> waves(std::size_t(slm.width_px));
  for (int y = 0; y < slm.height_px; ++y) {
    const Columns pupil = columns_in_circle(centre, measured.pupil_diameter_px, y, slm.width_px);
    const std::span<double> row(waves.data(), std::size_t(pupil.end - pupil.begin));
    error.waves(y, pupil.begin, row);
    for (int x = pupil.begin; x < pupil.end; ++x) {
      map->at(x, y) -= float(row[std::size_t(x - pupil.begin)]);
    }
  }
  return map;
}

}  // namespace

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
  if (flatness) slm->hologram.flatness_waves = flattened(configured, *flatness);
  slm->identity = slm_identity(slm->hologram, lut || config.slm.lut);
  slm->lut = std::move(lut);
  slm->flatness = std::move(flatness);
  return slm;
}

}  // namespace ovws
